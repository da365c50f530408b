"""The stress on the plates in each cycle, of history.csv."""

from __future__ import annotations

import numpy as np
import pandas as pd

from analysis.formats.file_columns import PLATE_STRESSES, PLATES
from analysis.formats.quantities import row_of


def of_history(history: pd.DataFrame) -> pd.DataFrame:
    """Columns PLATE_STRESSES (Pa), a row per cycle of history.csv: mean of each plate's rows, and the extremes of all
    plates.
    """
    stresses = [f"plate_{k}_stress_Pa" for k in PLATES]
    rows = history[history["cycle"] > 0].dropna(subset=stresses)
    of_cycle = rows.groupby(np.ceil(rows["cycle"] - 1e-9).astype(int))[stresses]
    means = of_cycle.mean().set_axis(list(row_of("plate_{}_stress_mean_Pa")), axis=1)
    extremes = {"plate_stress_min_Pa": of_cycle.min().min(axis=1), "plate_stress_max_Pa": of_cycle.max().max(axis=1)}
    return means.assign(**extremes).rename_axis("cycle").reset_index()[list(PLATE_STRESSES)]
