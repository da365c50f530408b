"""What the paper leaves out: one thing changed at a time."""

from __future__ import annotations

from analysis.report.figures.influence_figures import influence_figure
from analysis.report.report_data import ReportData
from analysis.report.tables.influence_tables import influence_table

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
