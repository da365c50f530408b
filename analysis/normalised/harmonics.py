"""The first harmonic of load and settlement in each cycle: how stiff the bed is at the load's frequency, and how lossy.

A quantity q of a cycle is q_1 cos(2 pi cycle - lag) and what repeats faster; q_1 and lag are those of the target
for q the target itself, and so on. Stress over settlement, both complex, is the dynamic stiffness of the bed per area.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
import pandas as pd

from analysis.formats import file_columns

OF = {"target": "sleeper_target_Pa", "stress": "sleeper_stress_Pa", "settlement": "settlement_m"}
LEAST_ROWS = 16


def of_history(history: pd.DataFrame) -> pd.DataFrame:
    """Columns file_columns.HARMONICS, a row per whole cycle of history.csv.

    Amplitudes in the unit of the quantity; lags in rad behind the target, 0 to 2 pi.
    """
    whole = history[["cycle", *OF.values()]].dropna()
    number = np.ceil(whole["cycle"] - 1e-9).astype(int)
    rows = []
    for cycle, part in whole.groupby(number):
        if cycle < 1 or len(part) < LEAST_ROWS:
            continue
        wave = np.exp(-2j * math.pi * part["cycle"].to_numpy())
        found = {name: 2 * np.mean(part[column].to_numpy() * wave) for name, column in OF.items()}
        late = {name: _behind(found["target"], found[name]) for name in ("stress", "settlement")}
        rows.append(
            {
                "cycle": cycle,
                "target_amplitude_Pa": abs(found["target"]),
                "stress_amplitude_Pa": abs(found["stress"]),
                "stress_lag_rad": late["stress"],
                "settlement_amplitude_m": abs(found["settlement"]),
                "settlement_lag_rad": late["settlement"],
            }
        )
    return pd.DataFrame(rows, columns=list(file_columns.HARMONICS))


def _behind(target: complex, found: complex) -> float:
    return (cmath.phase(target) - cmath.phase(found)) % (2 * math.pi)
