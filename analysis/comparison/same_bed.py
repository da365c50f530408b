"""Pairs of runs that differ in one thing, and by how much their settlement then differs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from analysis.normalised.readers import Run
from analysis.scenarios.deviations import restitution_equivalent
from analysis.scenarios.schema import KEYS

CODE, CODE_AND_DASHPOT = "code", "code and dashpot"
"""How the two codes of a pair differ: in the code alone, or also in the dashpot, where YADE has not the paper's."""

JUDGED_CYCLES = 5
"""Later ones are shown and not judged: rounding alone drives two runs of one bed apart."""
SHARED_CYCLES = (*range(1, JUDGED_CYCLES + 1), 10, 20)
"""After these two runs of one bed are compared."""


def changed_keys(one: Run, other: Run) -> list[str]:
    """Parameters in which two runs differ, but for those that only say how long a run goes on and what it writes,
    and where both started from one packed bed, how it was packed.
    """
    keys = one.scenario.changed_keys(other.scenario)
    if _bed(one) is not None and _bed(one) == _bed(other):
        keys = [key for key in keys if KEYS[key].matters("preload", "loading")]
    return keys


def _bed(run: Run) -> str | None:
    """Checksum of the packed bed."""
    return run.stages.get("packing", {}).get("bed_sha256")


def ranks(run: Run) -> int:
    """MPI ranks or threads of a run; one where run.json does not say."""
    return max(run.info.get("ranks", 1), run.info.get("threads", 1))


def _codes(one: Run, other: Run) -> list[str]:
    """What two codes differ in: the code, and the contact law where each takes its own or YADE has not the paper's."""
    if one.code == other.code:
        return []
    if one.scenario["contact.origin"] == "engine":
        return [CODE, "contact.origin"]
    return [CODE_AND_DASHPOT if restitution_equivalent(one.scenario) else CODE]


@dataclass(frozen=True)
class Pair:
    """Two runs from the very same packed bed; `differs` is CODE, CODE_AND_DASHPOT, `time.step` or `ranks`."""

    differs: str
    one: Run
    other: Run


def same_bed_pairs(runs: Iterable[Run]) -> list[Pair]:
    """All pairs from one bed that differ in the code alone (or CODE_AND_DASHPOT), in the time step alone (the longer
    one comes first), or in the number of ranks alone (fewer come first): another order of sums, so another rounding,
    and nothing else.

    A bed is known by the checksum of its positions and orientations in stages.json.
    """
    runs = [run for run in runs if len(run.cycles) and run.scenario is not None]
    runs.sort(key=lambda run: (ranks(run), run.scenario_name, -run.scenario["time.step"], run.code))
    beds = [_bed(run) for run in runs]
    found = []
    for n, one in enumerate(runs):
        for m, other in enumerate(runs[n + 1 :], start=n + 1):
            if beds[n] is None or beds[n] != beds[m]:
                continue
            differs = changed_keys(one, other) + _codes(one, other)
            differs += ["ranks"] * (ranks(one) != ranks(other))
            if len(differs) == 1 and differs[0] in (CODE, CODE_AND_DASHPOT, "time.step", "ranks"):
                found.append(Pair(differs[0], one, other))
    return found


def settlements(pair: Pair) -> pd.DataFrame:
    """Settlement of a pair, a row for preload (cycle 0, from its start) and one for each of SHARED_CYCLES (from
    its end).

    Columns: cycle, one_m, other_m, difference_m, difference_ratio (over the mean of the two). Without a value in either
    run there is no row.
    """
    rows = [(0, *(run.stages.get("preload", {}).get("settlement_m") for run in (pair.one, pair.other)))]
    one, other = (run.cycles.set_index("cycle")["settlement_m"] for run in (pair.one, pair.other))
    rows += [(cycle, one.get(cycle), other.get(cycle)) for cycle in SHARED_CYCLES]
    table = pd.DataFrame(rows, columns=["cycle", "one_m", "other_m"])
    table = table.astype({"one_m": float, "other_m": float}).dropna()
    table["difference_m"] = table["other_m"] - table["one_m"]
    mean = 0.5 * (table["one_m"] + table["other_m"])
    table["difference_ratio"] = table["difference_m"] / mean.where(mean != 0, np.nan)
    return table.reset_index(drop=True)
