"""The engines' own contact models beside the paper's laws, as a table."""

from __future__ import annotations

import pandas as pd

from analysis.report.tables.table_html import Shown, Table, frame_table


def stock_table(rows: pd.DataFrame) -> Table | None:
    """Runs with each code's own contact models after their last compared cycle, and how far packed beds scatter in the
    same quantity.
    """
    last = rows.groupby(["scenario", "reading", "code"])["cycle"].transform("max") if len(rows) else rows["cycle"]
    return frame_table(
        rows[rows["cycle"] == last],
        "Each code's own contact model in place of the paper's law, from the same packed bed",
        [
            "scenario",
            "reading",
            "code",
            "quantity",
            "cycle",
            Shown("paper_law", in_unit="quantity"),
            Shown("stock", in_unit="quantity"),
            Shown("change_ratio", digits=2),
            Shown("scatter_ratio", digits=2),
        ],
    )
