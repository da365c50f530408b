"""Tables with a row per run: how far it got, how fast it settles, the bed it began from, how its load was met, its
cost.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import pandas as pd

from analysis.comparison import run_quantities
from analysis.comparison.findings.members import IDENTITY, SERVO, Member
from analysis.comparison.run_quantities import last_cycle
from analysis.scenarios import derived

TRACKING_AIM = {"linear": 0.01, "hysteretic": 0.02}
"""rms of the load error over the largest stress that a run under the true load is held to."""

COVERAGE = ("bed", "state", "cycles", "cycles_wanted", "clumps", "settlement_m", "lateral_mean_m", "step_s")
LOAD = ("cycles", "stress_min_Pa", "stress_max_Pa", "tracking_worst_ratio", "tracking_last_ratio", "worst_cycle")
COST = ("step_s", "steps_per_cycle", "steps_per_s", "seconds_per_cycle", "hours_per_1000_cycles")
STAGES = ("clumps", "porosity_1", "porosity_2", "porosity_3", "porosity_mean", "coordination_number", "overlap_mean_m")
STAGES += ("overlap_max_ratio",)


def _frame(rows: list[dict], columns: tuple[str, ...]) -> pd.DataFrame:
    return pd.DataFrame(rows, columns=[*IDENTITY, *columns])


def coverage_table(found: Iterable[Member]) -> pd.DataFrame:
    """What ran and how far: columns IDENTITY and COVERAGE."""
    rows = []
    for m in found:
        last = m.run.cycles.iloc[-1]
        rows.append(
            m.identity
            | {
                "bed": m.bed[:8],
                "state": m.run.info.get("state", "unknown"),
                "cycles": last_cycle(m.run),
                "cycles_wanted": m.run.scenario["loading.cycles"] if m.run.scenario is not None else math.nan,
                "clumps": last["clumps"],
                "settlement_m": last["settlement_m"],
                "lateral_mean_m": run_quantities.lateral_mean(m.run.cycles).iloc[-1],
                "step_s": derived.time_grid(m.run.scenario).step_s if m.run.scenario is not None else math.nan,
            }
        )
    return _frame(rows, COVERAGE)


def rates_table(found: Iterable[Member]) -> pd.DataFrame:
    """Settlement, lateral displacement and heave of the cribs per cycle in spans of cycles, and the trend of settling
    up to the end of each span, so that runs are compared at equal cycles: IDENTITY, run_quantities.RATES and `trend`.
    """
    rows = []
    for m in found:
        spans = run_quantities.settling_rates(m.run)
        for n, span in enumerate(spans.to_dict("records")):
            rows.append(m.identity | span | {"trend": run_quantities.trend_of(spans["settlement_rate_m"][: n + 1])})
    return _frame(rows, (*run_quantities.RATES, "trend"))


def packed_beds_table(found: Iterable[Member]) -> pd.DataFrame:
    """The bed after packing and after preload (STAGES with `packed_` and `preloaded_` before them), the settlement in
    preload and the bed's checksum.
    """
    rows = []
    for m in found:
        stages = {"packed": m.run.stages.get("packing", {}), "preloaded": m.run.stages.get("preload", {})}
        row = {f"{stage}_{name}": table.get(name, math.nan) for stage, table in stages.items() for name in STAGES}
        row |= {"bed": m.bed[:8], "preload_settlement_m": stages["preloaded"].get("settlement_m", math.nan)}
        rows.append(m.identity | row)
    columns = ("bed", *(f"{s}_{name}" for s in ("packed", "preloaded") for name in STAGES), "preload_settlement_m")
    return _frame(rows, columns)


def load_table(found: Iterable[Member]) -> pd.DataFrame:
    """How the load was met: IDENTITY, LOAD (extremes of the last cycle, tracking error as a share of the largest
    stress),
    the aim (nan by the servo, whose error is a result) and whether it was met.
    """
    rows = []
    for m in found:
        if m.run.scenario is None:
            continue
        error = m.run.cycles["tracking_rms_Pa"] / m.run.scenario["loading.stress_max"]
        last = m.run.cycles.iloc[-1]
        aim = math.nan if m.reading == SERVO else TRACKING_AIM[m.run.scenario["contact.model"]]
        worst = error.idxmax() if error.notna().any() else None
        rows.append(
            m.identity
            | {
                "cycles": last_cycle(m.run),
                "stress_min_Pa": last["sleeper_stress_min_Pa"],
                "stress_max_Pa": last["sleeper_stress_max_Pa"],
                "tracking_worst_ratio": error.max(),
                "tracking_last_ratio": error.iloc[-1],
                "worst_cycle": math.nan if worst is None else m.run.cycles.at[worst, "cycle"],
                "aim_ratio": aim,
                "met": "" if math.isnan(aim) else "yes" if error.max() <= aim else "no",
            }
        )
    return _frame(rows, (*LOAD, "aim_ratio", "met"))


def computing_time_table(found: Iterable[Member]) -> pd.DataFrame:
    """Cost of cyclic loading of each run whose speed is known: IDENTITY and COST."""
    rows = []
    for m in found:
        speed = run_quantities.steps_per_second(m.run)
        if m.run.scenario is None or math.isnan(speed):
            continue
        grid = derived.time_grid(m.run.scenario)
        seconds = grid.steps_per_cycle / speed
        rows.append(
            m.identity
            | {
                "step_s": grid.step_s,
                "steps_per_cycle": grid.steps_per_cycle,
                "steps_per_s": speed,
                "seconds_per_cycle": seconds,
                "hours_per_1000_cycles": seconds / 3.6,
            }
        )
    return _frame(rows, COST)
