"""How fast scenarios settle, the beds that they settle in, and what computing it costs."""

from __future__ import annotations

import functools
import math

import pandas as pd

from analysis.comparison import run_quantities
from analysis.comparison.findings.members import SERVO
from analysis.formats.numbers import plural
from analysis.report.tables.table_html import (
    Chip,
    Shown,
    Table,
    frame_table,
    heading_of,
    label_of_column,
    number,
    run_of,
)

TREND_KIND = {"slowing": "good", "steady": "open", "growing": "bad"}
BED = (
    "packed_clumps",
    "packed_porosity_mean",
    "packed_coordination_number",
    "packed_overlap_mean_m",
    "packed_overlap_max_ratio",
    "preloaded_porosity_1",
    "preloaded_porosity_2",
    "preloaded_porosity_3",
    "preloaded_coordination_number",
    "preload_settlement_m",
)
"""What is told of a bed."""


def rates_table(rates: pd.DataFrame) -> Table | None:
    """How fast scenarios settle, span by span of cycles, and how fast plates and cribs go with it in the last span; the
    trend also at the last span that every code has, so that codes are compared at equal cycles.

    rates   of one run per scenario, reading and code
    """
    ends = [b for b in run_quantities.RATE_EDGES[1:] if b in set(rates["last_cycle"])]
    if len(ends) < 3:
        return None
    starts = dict(zip(run_quantities.RATE_EDGES[1:], run_quantities.RATE_EDGES, strict=False))
    spans = [Shown(f"to_{end}", f"{starts[end]} to {end}", like="settlement_rate_m", bare=True) for end in ends]
    return frame_table(
        last_spans(rates),
        f"{heading_of('settlement_rate_m').capitalize()}, in spans of cycles; first packed bed of each code",
        [
            "scenario",
            "reading",
            "code",
            *spans,
            Shown("lateral_rate_m", "plates", bare=True),
            Shown("crib_heave_rate_m", "heave of cribs", bare=True),
            Shown("trend", text=trend_chip, number=False),
            Shown("common_trend", "at equal cycles", text=common_trend, number=False),
        ],
    )


def last_spans(rates: pd.DataFrame) -> pd.DataFrame:
    """The last span of each run with its rates in all spans (`to_` their last cycle), and the trend at the last span
    that every run of the scenario and reading has.
    """
    keys = ["scenario", "reading", "code"]
    last = rates.groupby(keys, sort=False).tail(1)
    common = rates.groupby([*keys[:2], "run"])["last_cycle"].max().groupby(keys[:2]).min().rename("common")
    wide = rates.pivot(index=keys, columns="last_cycle", values="settlement_rate_m").add_prefix("to_")
    trends = rates[[*keys, "last_cycle", "trend"]].rename(columns={"last_cycle": "common", "trend": "common_trend"})
    return last.join(common, on=keys[:2]).join(wide, on=keys).merge(trends, on=[*keys, "common"], how="left")


def trend_chip(row) -> Chip:
    """Whether settling slows down, up to the last span."""
    return (
        Chip(f"{row.trend} to {row.last_cycle:.0f}", TREND_KIND[row.trend]) if row.trend else Chip("too short", "calm")
    )


def common_trend(row) -> str:
    """The trend up to the last span that every code has."""
    known = isinstance(row.common_trend, str) and row.common_trend
    return f"{known or 'too short'} to {row.common:.0f}"


def beds_table(beds: pd.DataFrame) -> Table | None:
    """Packed and preloaded beds, and their spread where a code has several seeds.

    beds   `Findings.packed_beds`
    """
    if beds.empty:
        return None
    groups = beds.groupby(["profile", "scenario", "variant", "code"], sort=False)
    means = groups[list(BED)].mean().assign(count_=groups.size()).join(groups[list(BED)].std().add_suffix("_deviation"))
    several = means[means["count_"] > 1].reset_index().assign(seed=1)
    return frame_table(
        pd.concat([beds, several], ignore_index=True),
        "Packed and preloaded beds",
        [
            Shown("run", "run", text=bed_or_mean, number=False),
            *(Shown(name, text=functools.partial(with_deviation, name)) for name in BED),
        ],
    )


def bed_or_mean(row) -> str:
    """The run of a row, or what its mean is over."""
    if row.run == row.run:
        return run_of(row)
    return f"{run_of(row)}: mean ± standard deviation of {plural(int(row.count_), 'seed')}"


def with_deviation(name: str, row) -> str:
    """The value of a quantity in a row, with its standard deviation where the row is a mean."""
    factor, deviation = label_of_column(name)[2], getattr(row, f"{name}_deviation", math.nan)
    text = number(getattr(row, name), 4, factor)
    return text if deviation != deviation else f"{text} ± {number(deviation, 2, factor)}"


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
