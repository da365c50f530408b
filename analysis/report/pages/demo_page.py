"""The demo's own page: the end of the bed next to the plates, loaded by both codes."""

from __future__ import annotations

from analysis.formats.quantities import SPHERES
from analysis.report.answer import answer, only
from analysis.report.demo_outcome import PROFILE, beside_full, of_the_demo, outcomes
from analysis.report.figures.demo_figures import demo_figures
from analysis.report.report_data import KEY_SCENARIOS, ReportData
from analysis.report.sentences import lines
from analysis.report.tables.agreement_tables import agreement_table
from analysis.report.tables.demo_tables import beside_table, outcome_table
from analysis.report.tables.run_tables import runs_table
from analysis.scenarios import derived


def demo_page(data: ReportData) -> dict | None:
    """What the demo's runs say; None without one."""
    members = of_the_demo(data.findings.members)
    runs = [m.run for m in members]
    if not runs:
        return None
    box = next((derived.apparatus(run.scenario) for run in runs if run.scenario), None)
    return {
        "box": box,
        "left_out": [k for k, inside in zip(SPHERES, box.measurement_fits, strict=True) if not inside] if box else [],
        "answer": lines("answer.txt", **answer(data.findings, KEY_SCENARIOS, PROFILE) | {"same_bed": {}}),
        "figures": demo_figures(data.gallery, members),
        "outcomes": outcome_table(outcomes(data.findings)),
        "beside": beside_table(beside_full(data.findings.members)),
        "agreement": agreement_table(only(data.findings.agreement, profile=PROFILE)),
        "runs_table": runs_table(data.findings, runs),
    }
