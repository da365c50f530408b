"""Work of the sleeper on the bed, cycle by cycle, from history.csv."""

from __future__ import annotations

import math

import numpy as np

from analysis.scenarios import derived

LEAST_LOOP_ROWS = 16
"""A loop of fewer rows is too coarse for its area."""


def sleeper_work(run) -> dict[int, float]:
    """Work (J) that the sleeper does on the bed in each cycle whose history is whole: {cycle: work}.

    The integral of measured stress x area over settlement, from minimum load to minimum load. It counts the permanent
    part of the settlement, too; where the loop closes it is the loop's area.
    """
    history = run.history[["cycle", "sleeper_stress_Pa", "settlement_m"]].dropna()
    if run.scenario is None or len(history) < LEAST_LOOP_ROWS:
        return {}
    area = derived.apparatus(run.scenario).sleeper_area_m2
    at, stress, down = history.to_numpy(dtype=float).T
    spacing = np.median(np.diff(at))
    work = np.r_[0, np.cumsum(area * (stress[1:] + stress[:-1]) / 2 * np.diff(down))]
    energies = {}
    for n in range(max(1, math.ceil(at[0] + 1 - 1e-6)), math.floor(at[-1] + 1e-6) + 1):
        first, last = np.searchsorted(at, [n - 1 - 1e-6, n - 1e-6])
        steps = np.diff(at[first : last + 1])
        whole = last < len(at) and abs(at[first] - n + 1) < 1e-6 and abs(at[last] - n) < 1e-6
        if whole and last - first >= LEAST_LOOP_ROWS and steps.max() < 1.5 * spacing:
            energies[n] = float(work[last] - work[first])
    return energies
