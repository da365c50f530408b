"""The demo's runs: both codes on one bed, and the demo bed beside the full one."""

from __future__ import annotations

import math
from collections.abc import Iterable

import pandas as pd

from analysis.formats.quantities import CODES, QUANTITIES
from analysis.report.demo_outcome import ALIKE_FACTOR, Beside, DemoOutcome
from analysis.report.tables.table_html import Chip, Shown, Table, frame_table, number

SETTLEMENT = QUANTITIES["settlement_m"]


def outcome_table(made: Iterable[DemoOutcome]) -> Table | None:
    """Settlement of both codes from one bed, and of the full bed, after the same cycle."""
    rows = [
        {"scenario": o.scenario, "reading": o.reading, "cycle": o.cycle}
        | {f"{code}_m": o.settlement_m.get(code, math.nan) for code in CODES}
        | {"difference_ratio": o.difference_ratio, "full_m": o.full_m}
        for o in made
    ]
    return frame_table(
        pd.DataFrame(rows),
        "Both codes on the demo bed, and LIGGGHTS on the full bed, after the same cycle",
        [
            "scenario",
            "reading",
            "cycle",
            Shown("liggghts_m", f"{SETTLEMENT.label}: LIGGGHTS"),
            Shown("yade_m", "YADE"),
            Shown("difference_ratio", digits=2),
            Shown("full_m", "full bed"),
        ],
    )


def beside_table(rows: Iterable[Beside]) -> Table | None:
    """How the demo bed settles beside the full one, over the packed beds of both."""
    fields = ("scenario", "reading", "cycle", "demo_m", "full_m", "demo_plates_m", "full_plates_m", "ratio", "alike")
    return frame_table(
        pd.DataFrame([{name: getattr(row, name) for name in fields} for row in rows]),
        f"The demo bed beside the full bed, LIGGGHTS: {SETTLEMENT.label}",
        [
            "scenario",
            "reading",
            "cycle",
            Shown("demo_m", "demo bed", text=lambda row: over_beds(row.demo_m)),
            Shown("full_m", "full bed", text=lambda row: over_beds(row.full_m)),
            Shown("ratio", "demo over full"),
            Shown("alike", f"within a factor of {ALIKE_FACTOR:g}", text=alike_chip, number=False),
            Shown("demo_plates_m", "plates outward, demo", digits=2),
            Shown("full_plates_m", "full", digits=2),
        ],
    )


def alike_chip(row) -> Chip:
    """Whether the demo bed settles as the full bed within the aim."""
    return Chip("yes", "good") if row.alike else Chip("no", "bad")


def over_beds(values: tuple[float, ...]) -> str:
    """Mean over packed beds, with the least and the most of them, in the shown unit."""
    mean, low, high = (number(f(values), 3, SETTLEMENT.factor) for f in (lambda v: sum(v) / len(v), min, max))
    return f"{mean} (1 bed)" if len(values) == 1 else f"{mean} ({low} to {high}, {len(values)} beds)"
