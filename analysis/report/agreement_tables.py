"""Tables of how the two codes agree, from the findings."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pandas as pd

from analysis.comparison.findings.agreement import AGREES, COMPARED, DIFFERS
from analysis.formats.numbers import plural
from analysis.report.labels import READING_NAMES, short_name
from analysis.report.tables import Chip, Column, Table, number, quantity_name

SHOWN = (
    "settlement_m",
    "lateral_mean_m",
    "resilient_stroke_m",
    "secant_stiffness_N_m",
    "porosity_1",
    "porosity_2",
    "porosity_3",
    "coordination_number",
)


def agreement_table(rows: pd.DataFrame, quantities: Sequence[str] = SHOWN, all_cycles: bool = False) -> Table | None:
    """Both codes after the last cycle that a run of each has reached, or after each compared cycle."""
    rows = rows[rows["quantity"].isin(quantities)]
    if not all_cycles and len(rows):
        last = rows.groupby(["scenario", "reading"])["cycle"].transform("max")
        rows = rows[rows["cycle"] == last]
    if rows.empty:
        return None
    order = {name: n for n, name in enumerate(COMPARED)}
    rows = rows.sort_values(
        ["scenario", "reading", "quantity", "cycle"], key=lambda c: c.map(order) if c.name == "quantity" else c
    )
    table = Table(
        "LIGGGHTS and YADE, each from beds of its own, after the same cycle",
        [
            Column("scenario"),
            Column("load"),
            Column("quantity"),
            Column("cycle", True),
            Column("LIGGGHTS", True),
            Column("YADE", True),
            Column("beds", True),
            Column("difference, %", True),
            Column("95 % interval, %", True),
            Column("verdict"),
        ],
    )
    for r in rows.itertuples():
        label, factor, _ = quantity_name(r.quantity, r.unit)
        interval = "–"
        if math.isfinite(r.low_ratio):
            interval = f"{number(r.low_ratio, 2, 100)} to {number(r.high_ratio, 2, 100)}"
        table.rows.append(
            [
                short_name(r.scenario),
                READING_NAMES[r.reading],
                label,
                str(r.cycle),
                number(r.liggghts_mean, 3, factor),
                number(r.yade_mean, 3, factor),
                f"{r.liggghts_beds}, {r.yade_beds}",
                number(r.difference_ratio, 2, 100),
                interval,
                state_chip(r.state, r.within_ratio, r.beds_needed),
            ]
        )
    table.note = (
        "Difference: LIGGGHTS minus YADE over the mean of both. The interval comes from the scatter between packed "
        "beds, "
        "pooled over the scenarios of a model; a code with one bed is taken to scatter as the other. Agrees: the whole "
        "interval is within 25 %. Cannot tell: it is wider, and as many beds per code would narrow it. Quantities that "
        "change sign have no ratio; what is equal by construction is not listed."
    )
    return table


def state_chip(state: str, within: float, needed: float) -> Chip:
    """The state of a comparison as a coloured word: colour says agrees (green), differs (red), cannot tell (grey)."""
    if state == AGREES:
        return Chip(f"agrees within {number(within, 2, 100)} %", "good")
    if state == DIFFERS:
        return Chip("differs", "bad")
    wanted = f", needs {plural(int(needed), 'bed')} per code" if math.isfinite(needed) and needed <= 99 else ""
    return Chip(f"cannot tell yet{wanted}", "calm")


def same_bed_table(verdicts: pd.DataFrame) -> Table | None:
    """Whether the codes differ, from one bed, by no more than the time step and rounding change."""
    if verdicts.empty:
        return None
    table = Table(
        "Both codes from one packed bed: is the difference of their settlement within what half a time step and "
        "rounding alone change?",
        [
            Column("scenario"),
            Column("load"),
            Column("bed"),
            Column("cycles", True),
            Column("largest difference of the codes, %", True),
            Column("of time step and rounding, %", True),
            Column("pairs", True),
            Column("verdict"),
        ],
    )
    words = {AGREES: Chip("yes, within", "good"), DIFFERS: Chip("no, beyond", "bad")}
    for r in verdicts.itertuples():
        table.rows.append(
            [
                short_name(r.scenario),
                READING_NAMES[r.reading],
                r.bed,
                str(r.cycles),
                number(r.codes_ratio, 2, 100),
                number(r.band_ratio, 2, 100),
                str(r.band_pairs),
                words.get(r.state, Chip("no band yet", "calm")),
            ]
        )
    table.note = (
        "Over preload and the first cycles; later ones are not compared, because rounding alone drives two runs of "
        "one bed apart."
    )
    return table
