"""Lateral profiles of the two codes against each other, as a tidy frame; see also findings/agreement.py."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from analysis.comparison import run_quantities
from analysis.formats import file_columns


def last_common_cycle(runs: Iterable) -> int:
    """The last cycle that all `runs` have finished; 0 without."""
    return min((int(run.cycles["cycle"].max()) if len(run.cycles) else 0 for run in runs), default=0)


def lateral_agreement(runs: Iterable, cycles: Sequence[int] = run_quantities.CYCLES_SHOWN) -> pd.DataFrame:
    """Shape of the lateral profiles of both codes: profile, scenario, cycle, rms_m, ratio, correlation.

    rms_m         rms difference of the plates' displacements (means over seeds)
    ratio         LIGGGHTS over YADE, of the displacement averaged over the plates
    correlation   of the five displacements
    """
    runs = list(runs)
    rows = []
    for profile, scenario in dict.fromkeys((run.profile, run.scenario_name) for run in runs):
        found = {
            code: [r for r in runs if (r.profile, r.scenario_name, r.code) == (profile, scenario, code)]
            for code in file_columns.CODES
        }
        last = last_common_cycle(found["yade"] + found["liggghts"])
        if not all(found.values()) or not last:
            continue
        for n in [*(n for n in cycles if n < last), last]:
            yade, liggghts = (_mean_profile(found[code], n) for code in ("yade", "liggghts"))
            if yade is not None and liggghts is not None:
                rows.append((profile, scenario, n, *_alike(yade, liggghts)))
    return pd.DataFrame(rows, columns=["profile", "scenario", "cycle", "rms_m", "ratio", "correlation"])


def _mean_profile(runs: Iterable, cycle: int) -> np.ndarray | None:
    """Displacements of the five plates (m) after `cycle`, mean over the runs that have all five; None without any."""
    profiles = [run_quantities.lateral_profile(run, [cycle])["lateral_m"].to_numpy(dtype=float) for run in runs]
    profiles = [p for p in profiles if len(p) == 5 and np.isfinite(p).all()]
    return np.mean(profiles, axis=0) if profiles else None


def _alike(yade: np.ndarray, liggghts: np.ndarray) -> tuple[float, float, float]:
    """rms difference, ratio of the means and correlation of two profiles."""
    spread = np.std(yade) * np.std(liggghts)
    covariance = np.mean((yade - yade.mean()) * (liggghts - liggghts.mean()))
    return (
        float(np.sqrt(np.mean((liggghts - yade) ** 2))),
        float(liggghts.mean() / yade.mean()) if yade.mean() else math.nan,
        float(covariance / spread) if spread else math.nan,
    )
