"""PFC's servo explained: a first-order filter, predicted and measured, and what it leaves of the settlement."""

from __future__ import annotations

from analysis.report.figures.servo_figures import filter_figure, stress_range_figure
from analysis.report.report_data import KEY_SCENARIOS, ReportData
from analysis.report.tables.servo_tables import elastic_table, servo_table


def servo_page(data: ReportData) -> dict | None:
    """What the servo makes of the load; None without a run by it."""
    table = data.findings.servo
    if table.empty:
        return None
    key = table[(table["scenario"] == (KEY_SCENARIOS or ("",))[-1]) & (table["variant"] == "servo")]
    return {
        "key": key.iloc[0].to_dict() if len(key) else {},
        "filter": filter_figure(data.gallery, table),
        "range": stress_range_figure(data.gallery, table),
        "runs": servo_table(table),
        "elastic": elastic_table(data.findings.elastic),
    }
