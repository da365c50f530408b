"""One thing changed at a time, with the numbers."""

from __future__ import annotations

import pandas as pd

from analysis.comparison.findings.influence import LEAST_INFLUENCE
from analysis.report.tables.table_html import Chip, Shown, Table, frame_table


def influence_table(table: pd.DataFrame) -> Table | None:
    """Every changed run beside the run without the change."""
    return frame_table(
        table,
        "One thing changed at a time",
        [
            "variant",
            "scenario",
            "reading",
            "quantity",
            "cycle",
            Shown("base", in_unit="quantity"),
            Shown("changed", in_unit="quantity"),
            Shown("change_ratio", digits=2),
            Shown("scatters", digits=2),
            Shown("scatters", "verdict", text=verdict, number=False),
        ],
    )


def verdict(row) -> Chip:
    """Whether a change is larger than packed beds differ."""
    if row.scatters != row.scatters:
        return Chip("scatter unknown", "calm")
    return Chip("influence", "bad") if row.scatters >= LEAST_INFLUENCE else Chip("within beds", "calm")
