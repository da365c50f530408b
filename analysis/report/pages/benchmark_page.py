"""The benchmark: ours against the commit before it was made fast, and against stock."""

from __future__ import annotations

from analysis.report.figures.benchmark_figures import sizes_figure
from analysis.report.report_data import ReportData
from analysis.report.tables.benchmark_tables import profile_table, sizes_table, speeds_table


def benchmark_page(data: ReportData) -> dict | None:
    """What `make bench PROFILE=full` measured; None without its table."""
    found = data.findings
    if found.benchmark.empty:
        return None
    return {
        "speeds": speeds_table(found.benchmark),
        "sizes": sizes_table(found.benchmark_sizes),
        "figure_": sizes_figure(data.gallery, found.benchmark_sizes),
        "profile": profile_table(found.benchmark_profile),
    }
