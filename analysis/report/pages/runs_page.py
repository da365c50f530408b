"""Where the numbers come from: every run with its state, versions and command."""

from __future__ import annotations

from analysis.comparison.findings.members import TRUE_LOAD, member
from analysis.report.figures.load_figures import tracking_figure
from analysis.report.report_data import ReportData, key_runs
from analysis.report.run_account import run_entry
from analysis.report.tables.run_tables import left_out_table, provenance_table, runs_table


def runs_page(data: ReportData) -> dict:
    """Every run with where it comes from."""
    runs = [*data.runs, *data.variants]
    tracking = [
        tracking_figure(
            data.gallery,
            [run for run in key_runs(data, profile) if member(run).reading == TRUE_LOAD],
            f"tracking-all-{profile}",
            f"Load tracking under the true load, {profile} bed",
        )
        for profile in data.profiles
    ]
    return {
        "all_runs": runs_table(data.findings, runs),
        "summary": provenance_table(runs),
        "runs": [run_entry(run) for run in runs],
        "tables": [left_out_table(data.left_out)],
        "figures": tracking,
        "results": data.results,
        "problems": data.problems,
    }
