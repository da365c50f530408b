"""How the two codes agree: from beds of their own, from one bed, over the plates."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pandas as pd

from analysis.comparison import same_bed
from analysis.comparison.findings.agreement import AGREES, DIFFERS, OTHER_DASHPOT
from analysis.formats.numbers import plural
from analysis.report.style import CODE_NAMES
from analysis.report.tables.table_html import Chip, Shown, Table, between, frame_table, label_of_column, number, shown

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
    order = {name: n for n, name in enumerate(quantities)}
    rows = rows.sort_values(
        ["scenario", "reading", "quantity", "cycle"], key=lambda c: c.map(order) if c.name == "quantity" else c
    )
    return frame_table(
        rows,
        "LIGGGHTS and YADE, each from beds of its own, after the same cycle",
        [
            "scenario",
            "reading",
            Shown("quantity", wide=True),
            "cycle",
            Shown("liggghts_mean", in_unit="quantity"),
            Shown("yade_mean", in_unit="quantity"),
            Shown("liggghts_beds", "beds", text=lambda row: f"{row.liggghts_beds}, {row.yade_beds}"),
            Shown("difference_ratio", digits=2),
            between("low_ratio", "high_ratio", "95 % interval", digits=2),
            Shown("state", "verdict", text=state_chip, number=False),
        ],
    )


def state_chip(row) -> Chip:
    """The state of a comparison as a coloured word: colour says agrees (green), differs (red), cannot tell (grey)."""
    if row.state == AGREES:
        return Chip(f"agrees within {number(row.within_ratio, 2, 100)} %", "good")
    if row.state == DIFFERS:
        return Chip("differs", "bad")
    needed = max(row.beds_needed, 1 + min(row.liggghts_beds, row.yade_beds))
    wanted = f", needs {plural(int(needed), 'bed')}" if math.isfinite(needed) and needed <= 99 else ""
    return Chip(f"cannot tell{wanted}" if wanted else "cannot tell yet", "calm")


WITHIN = {
    AGREES: Chip("yes, within", "good"),
    DIFFERS: Chip("no, beyond", "bad"),
    OTHER_DASHPOT: Chip(OTHER_DASHPOT, "calm"),
}


def within_chip(row) -> Chip:
    """Whether the codes differ by no more than time step and rounding do."""
    return WITHIN.get(row.state, Chip("too few pairs", "calm"))


def same_bed_table(verdicts: pd.DataFrame) -> Table | None:
    """Whether the codes differ, from one bed, by no more than the time step and rounding change."""
    return frame_table(
        verdicts,
        "Both codes from one packed bed: is the difference of their settlement within what half a time step and "
        "rounding alone change?",
        [
            "scenario",
            "reading",
            "bed",
            "cycles",
            Shown("codes_ratio", digits=2),
            Shown("band_ratio", digits=2),
            "band_pairs",
            Shown("state", "verdict", text=within_chip, number=False),
            "late_cycle",
            Shown("codes_late_ratio", digits=2),
            Shown("band_late_ratio", digits=2),
        ],
    )


def lateral_table(rows: pd.DataFrame) -> Table | None:
    """How alike the lateral profiles of both codes are."""
    return frame_table(
        rows,
        "Profiles over the five plates, LIGGGHTS against YADE",
        [
            "scenario",
            "cycle",
            Shown("rms_m", "rms difference"),
            Shown("ratio", "ratio of means"),
            "correlation",
        ],
    )


def pair_names(pair: same_bed.Pair) -> tuple[str, str]:
    """What tells the two runs of a pair apart: their codes, time steps or ranks."""
    what = {
        same_bed.CODE: lambda run: "",
        same_bed.CODE_AND_DASHPOT: lambda run: "",
        "time.step": lambda run: f" {shown(1e6 * run.scenario['time.step'])} µs",
        "ranks": lambda run: f" {plural(same_bed.ranks(run), 'rank')}",
    }[pair.differs]
    return tuple(CODE_NAMES.get(run.code, run.code) + what(run) for run in (pair.one, pair.other))


def pairs_table(found: Sequence[same_bed.Pair], title: str) -> Table | None:
    """Settlement of pairs from one bed, a row per cycle, the pairs beside each other."""
    beside = pd.concat(
        [same_bed.settlements(pair).set_index("cycle").add_suffix(f"_{n}") for n, pair in enumerate(found)], axis=1
    )
    columns = [Shown("cycle", "settlement", text=when, number=False)]
    for n, pair in enumerate(found):
        one, other = pair_names(pair)
        columns += [
            Shown(f"one_m_{n}", one, like="settlement_m", bare=True),
            Shown(f"other_m_{n}", other, like="settlement_m", bare=True),
            Shown(f"difference_ratio_{n}", like="difference_ratio", digits=2),
        ]
    _, unit, _ = label_of_column("settlement_m")
    return frame_table(
        beside.sort_index().reset_index(),
        f"Settlement from the same bed, {unit}: {title}",
        columns,
        "Runs: " + "; ".join(f"{pair.one.id} and {pair.other.id}" for pair in found) + ".",
    )


def when(row) -> str:
    """The row of a cycle, or of preload."""
    return f"after {plural(int(row.cycle), 'cycle')}" if row.cycle else "in preload"
