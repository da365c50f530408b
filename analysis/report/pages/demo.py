"""The demo's own page: the end of the bed next to the plates, loaded by both codes."""

from __future__ import annotations

from analysis.formats.quantities import SPHERES
from analysis.report.answer import answer, only
from analysis.report.demo_outcome import PROFILE, beside_full, of_the_demo, outcomes
from analysis.report.figures.beds import bed_figure
from analysis.report.figures.lateral import lateral_figure
from analysis.report.figures.load import tracking_figure
from analysis.report.figures.overview import both_readings_figure
from analysis.report.figures.porosity import porosity_figure
from analysis.report.report_data import KEY_SCENARIOS, ReportData
from analysis.report.sentences import lines
from analysis.report.tables.agreement import agreement_table
from analysis.report.tables.demo import beside_table, outcome_table
from analysis.report.tables.runs import runs_table
from analysis.scenarios import derived


def demo_page(data: ReportData) -> dict | None:
    """What the demo's runs say; None without one."""
    members = of_the_demo(data.findings.members)
    runs = [m.run for m in members]
    if not runs:
        return None
    g, box = data.gallery, next((derived.apparatus(run.scenario) for run in runs if run.scenario), None)
    measured = any(run.cycles[f"porosity_{k}"].notna().any() for run in runs for k in SPHERES)
    pictured = [run for run in runs if (run.folder / "bed_after.csv").exists()][:1]
    return {
        "box": box,
        "left_out": [k for k, inside in zip(SPHERES, box.measurement_fits, strict=True) if not inside] if box else [],
        "answer": lines("answer.txt", **answer(data.findings, KEY_SCENARIOS, PROFILE) | {"same_bed": []}),
        "figures": [
            both_readings_figure(
                g,
                members,
                dict.fromkeys(m.scenario for m in members),
                "settlement-demo",
                "Settlement of the sleeper on the demo bed",
                "At minimum load, zero at the end of preload.",
            ),
            bed_figure(g, pictured, "bed-demo", "after", "The demo bed after loading", "Coloured by displacement."),
            lateral_figure(
                g,
                runs,
                "lateral-demo",
                "Lateral displacement of the plates",
                "Outward, at minimum load.",
                references=False,
            ),
            porosity_figure(
                g, runs, "porosity-demo", "Porosity in the measurement spheres", "Cycle 0 is the end of preload."
            )
            if measured
            else None,
            tracking_figure(g, runs, "tracking-demo", "Load tracking"),
        ],
        "outcomes": outcome_table(outcomes(data.findings)),
        "beside": beside_table(beside_full(data.findings.members)),
        "agreement": agreement_table(only(data.findings.agreement, profile=PROFILE)),
        "runs_table": runs_table(runs),
    }
