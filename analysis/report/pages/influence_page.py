"""What the paper leaves out: one thing changed at a time."""

from __future__ import annotations

from analysis.comparison.findings.influence import LEAST_INFLUENCE
from analysis.report.answer import influences
from analysis.report.figures.influence_figures import influence_figure
from analysis.report.report_data import KEY_SCENARIOS, ReportData
from analysis.report.tables.influence_tables import influence_table

QUANTITIES = {"settlement_m": "settlement", "lateral_mean_m": "lateral displacement"}


def influence_page(data: ReportData) -> dict | None:
    """Ranked influences, those on the key scenarios first; None without a varied run."""
    table = data.findings.influence
    table = table[table["profile"] == "full"]
    table = table.sort_values("scenario", key=lambda names: ~names.isin(KEY_SCENARIOS), kind="stable")
    if table.empty:
        return None
    settled = influences(data.findings, KEY_SCENARIOS, "full")
    return {
        "largest": settled.iloc[-1].to_dict() if len(settled) else {},
        "inside": int((settled["scatters"] < LEAST_INFLUENCE).sum()),
        "count": len(settled),
        "figures": [influence_figure(data.gallery, table, name, what) for name, what in QUANTITIES.items()],
        "table_": influence_table(table),
    }
