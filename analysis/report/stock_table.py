"""The engines' own contact models beside the paper's laws, as a table."""

from __future__ import annotations

import pandas as pd

from analysis.report.labels import READING_NAMES, short_name
from analysis.report.style import CODE_NAMES
from analysis.report.tables import Column, Table, number, quantity_name


def stock_table(rows: pd.DataFrame) -> Table | None:
    """Runs with each code's own contact models, and how far packed beds scatter in the same quantity."""
    if rows.empty:
        return None
    table = Table(
        "Each code's own contact model in place of the paper's law, from the same packed bed",
        [
            Column("scenario"),
            Column("load"),
            Column("code"),
            Column("quantity"),
            Column("cycle", True),
            Column("the paper's law", True),
            Column("the code's own", True),
            Column("change, %", True),
            Column("scatter between beds, %", True),
        ],
    )
    for r in rows.itertuples():
        label, factor, _ = quantity_name(r.quantity, "m")
        table.rows.append(
            [
                short_name(r.scenario),
                READING_NAMES[r.reading],
                CODE_NAMES[r.code],
                label,
                str(r.cycle),
                number(r.paper_law, 3, factor),
                number(r.stock, 3, factor),
                number(r.change_ratio, 2, 100),
                number(r.scatter_ratio, 2, 100),
            ]
        )
    table.note = (
        "LIGGGHTS: hooke/stiffness or hertz with tangential history. YADE: FrictMat or Mindlin. What they do otherwise "
        "stands in docs/method.md. A change smaller than the scatter between packed beds does not matter here."
    )
    return table
