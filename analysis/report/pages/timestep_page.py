"""How large the time step may be: runs from one bed at several, beside packing seeds and rounding."""

from __future__ import annotations

from analysis.report.figures.timestep_figures import timestep_figure
from analysis.report.report_data import ReportData
from analysis.report.tables.timestep_tables import runs_table, shares_table, spread_table


def timestep_page(data: ReportData) -> dict | None:
    """What `make timestep` found; None without its table."""
    table = data.findings.timestep
    if table.empty:
        return None
    done = table[(table["state"] == "done") & (table["cycle"] == table["cycle"].max())]
    return {
        "spread": spread_table(data.findings.timestep_spread),
        "spreads": data.findings.timestep_spread.to_dict("records"),
        "shares": shares_table(table),
        "done": len(done),
        "wanted": len(table[["scenario", "case"]].drop_duplicates()),
        "figure_": timestep_figure(data.gallery, table),
        "table_": runs_table(table),
    }
