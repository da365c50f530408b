"""The engines' own contact models beside the paper's laws, as a table."""

from __future__ import annotations

import pandas as pd

from analysis.report.tables.table_html import Shown, Table, frame_table


def stock_table(rows: pd.DataFrame, all_rows: bool = False) -> Table | None:
    """Runs with each code's own contact models, and how far packed beds scatter in the same quantity: the settlement
    after the last compared cycle, or every quantity after all of them.
    """
    if not all_rows and len(rows):
        last = rows.groupby(["scenario", "reading", "code"])["cycle"].transform("max")
        rows = rows[(rows["cycle"] == last) & (rows["quantity"] == "settlement_m")]
    return frame_table(
        rows,
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
