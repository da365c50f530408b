"""How fast scenarios settle, the beds that they settle in, and what computing it costs."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from analysis.comparison import quantities
from analysis.comparison.findings.members import SERVO
from analysis.normalised.readers import Run
from analysis.report.labels import READING_NAMES, short_name
from analysis.report.report_data import name_of
from analysis.report.style import CODE_NAMES
from analysis.report.tables.base import Chip, Column, Shown, Table, frame_table, label_of_column, number, unbroken

TREND_KIND = {"slowing": "good", "steady": "open", "growing": "bad"}
RATE_FACTOR = 1e6
"""Rates are told in µm per cycle."""

PREPARED = (
    ("clumps", "packing"),
    ("porosity_mean", "packing"),
    ("coordination_number", "packing"),
    ("overlap_mean_m", "packing"),
    ("overlap_max_ratio", "packing"),
    ("porosity_1", "preload"),
    ("porosity_2", "preload"),
    ("porosity_3", "preload"),
    ("coordination_number", "preload"),
    ("preload_settlement_m", "preload"),
)
"""Quantities of stages.json and the stage after which they are told."""
STAGE_WORDS = {"packing": "packed", "preload": "preloaded"}


def rates_table(rates: pd.DataFrame) -> Table | None:
    """How fast scenarios settle, span by span of cycles, and how fast plates and cribs go with it in the last span; the
    trend also at the last span that every code has, so that codes are compared at equal cycles.

    rates   of one run per scenario, reading and code
    """
    ends = [b for b in quantities.RATE_EDGES[1:] if b in set(rates["last_cycle"])]
    if len(ends) < 3:
        return None
    starts = dict(zip(quantities.RATE_EDGES[1:], quantities.RATE_EDGES, strict=False))
    shared = rates.groupby(["scenario", "reading", "run"])["last_cycle"].max().groupby(["scenario", "reading"]).min()
    head = [Column("scenario"), Column("load"), Column("code"), *(Column(f"{starts[b]} to {b}", True) for b in ends)]
    tail = [Column("plates", True), Column("heave of cribs", True), Column("trend"), Column("at equal cycles")]
    rows = [
        [unbroken(short_name(scenario)), unbroken(READING_NAMES[reading]), CODE_NAMES.get(code, code)]
        + rate_cells(spans, ends, shared[scenario, reading])
        for (scenario, reading, code), spans in rates.groupby(["scenario", "reading", "code"], sort=False)
    ]
    title = "Settlement at minimum load per cycle, µm, in spans of cycles; first packed bed of each code"
    return Table(title, [*head, *tail], rows)


def rate_cells(spans: pd.DataFrame, ends: list[int], common: float) -> list[str | Chip]:
    """The cells of one run: its rates in the spans that end at `ends`, and its trend, also at the cycle `common`."""
    by_end, last = spans.set_index("last_cycle"), spans.iloc[-1]
    trend = Chip("too short", "calm")
    if last["trend"]:
        trend = Chip(f"{last['trend']} to {last['last_cycle']:.0f}", TREND_KIND[last["trend"]])
    return [
        *(number(by_end["settlement_rate_m"].get(b, np.nan), 3, RATE_FACTOR) for b in ends),
        *(number(last[f"{what}_rate_m"], 3, RATE_FACTOR) for what in ("lateral", "crib_heave")),
        trend,
        f"{by_end['trend'].get(common, '') or 'too short'} to {common:.0f}",
    ]


def beds_table(runs: Iterable[Run]) -> Table | None:
    """Packed and preloaded beds of all runs, and their spread where a code has several seeds."""
    runs = [run for run in runs if run.stages]
    if not runs:
        return None
    columns = []
    for name, stage in PREPARED:
        label, unit, _ = label_of_column(name)
        when = "" if name.startswith(stage) else STAGE_WORDS[stage]
        columns.append(Column(", ".join(filter(None, (label, when, unit))), True))
    table = Table("Packed and preloaded beds", [Column("run"), *columns])
    groups: dict[tuple, list[list[float]]] = {}
    for run in runs:
        values = [
            label_of_column(name)[2] * run.stages.get(stage, {}).get(name.removeprefix(f"{stage}_"), np.nan)
            for name, stage in PREPARED
        ]
        table.rows.append([name_of(run), *(number(value, 4) for value in values)])
        groups.setdefault((run.scenario_name, run.code), []).append(values)
    for (scenario, code), values in groups.items():
        if len(values) > 1:
            mean, spread = np.mean(values, axis=0), np.std(values, axis=0, ddof=1)
            name = f"{short_name(scenario)}, {CODE_NAMES.get(code, code)}: mean ± standard deviation of"
            cells = (f"{number(m, 4)} ± {number(d, 2)}" for m, d in zip(mean, spread, strict=True))
            table.rows.append([f"{name} {len(values)} seeds", *cells])
    return table


def cost_table(rows: pd.DataFrame) -> Table | None:
    """Cost of cyclic loading by scenario, reading and code, of the fastest run: other work can only slow one."""
    rows = rows[rows["variant"].isin(["", SERVO])]
    names = ["steps_per_cycle", "steps_per_s", "seconds_per_cycle", "hours_per_1000_cycles"]
    best = rows.sort_values("seconds_per_cycle").groupby(["scenario", "reading", "code", "step_s"], sort=True)
    return frame_table(
        best[names].first().reset_index(),
        "Computing time of cyclic loading on one core, of the fastest run",
        ["scenario", "reading", "code", "step_s", Shown("steps_per_cycle", digits=5), *names[1:]],
    )
