"""What the paper leaves out: one thing changed at a time."""

from __future__ import annotations

import pandas as pd

from analysis.report.figures.influence import influence_figure
from analysis.report.labels import MM, READING_NAMES, short_name, variant_name
from analysis.report.report_data import ReportData
from analysis.report.tables import Chip, Column, Table, number

QUANTITIES = {"settlement_m": "settlement", "lateral_mean_m": "lateral displacement"}


def influence_page(data: ReportData) -> dict | None:
    """Ranked influences; None without a varied run."""
    table = data.findings.influence
    table = table[table["profile"] == "full"]
    if table.empty:
        return None
    settled = table[(table["quantity"] == "settlement_m") & table["change_ratio"].notna()]
    return {
        "largest": settled.iloc[settled["change_ratio"].abs().argmax()].to_dict() if len(settled) else {},
        "inside": int((settled["scatters"] < 1).sum()),
        "count": len(settled),
        "figures": [influence_figure(data.gallery, table, name, what) for name, what in QUANTITIES.items()],
        "table_": influence_table(table),
    }


def influence_table(table: pd.DataFrame) -> Table:
    """All of them, with the numbers."""
    made = Table(
        "One thing changed at a time",
        [
            Column("changed"),
            Column("scenario"),
            Column("load"),
            Column("quantity"),
            Column("cycle", True),
            Column("as it is, mm", True),
            Column("changed, mm", True),
            Column("change, %", True),
            Column("in scatters of a bed", True),
            Column("verdict"),
        ],
    )
    for r in table.itertuples():
        seen = Chip("influence", "bad") if r.scatters >= 2 else Chip("within beds", "calm")
        made.rows.append(
            [
                variant_name(r.variant),
                short_name(r.scenario),
                READING_NAMES[r.reading],
                QUANTITIES[r.quantity],
                str(r.cycle),
                number(r.base, 3, MM),
                number(r.changed, 3, MM),
                number(r.change_ratio, 2, 100),
                number(r.scatters, 2),
                seen if r.scatters == r.scatters else Chip("scatter unknown", "calm"),
            ]
        )
    made.note = (
        "Scatter of a bed: standard deviation between packed beds of one recipe, pooled over the scenarios of the "
        "model. An influence is called one where the change is at least twice that."
    )
    return made
