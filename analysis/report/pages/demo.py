"""The demo's own page: a small bed that shows that the whole chain works."""

from __future__ import annotations

from analysis.report.agreement_tables import agreement_table
from analysis.report.answer import answer, only
from analysis.report.figures.beds import bed_figure
from analysis.report.figures.lateral import lateral_figure
from analysis.report.figures.load import tracking_figure
from analysis.report.figures.overview import both_readings_figure
from analysis.report.figures.porosity import porosity_figure
from analysis.report.pages.runs import runs_table
from analysis.report.report_data import KEY_SCENARIOS, ReportData
from analysis.report.sentences import lines

PROFILE = "demo"


def demo_page(data: ReportData) -> dict | None:
    """What the demo's runs say; None without one."""
    runs = data.of(PROFILE)
    if not runs:
        return None
    g, members = data.gallery, [m for m in data.findings.members if m.run.profile == PROFILE]
    pictured = [run for run in runs if (run.folder / "bed_after.csv").exists()][:1]
    return {
        "answer": lines("answer.txt", **answer(data.findings, KEY_SCENARIOS, PROFILE)),
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
            lateral_figure(g, runs, "lateral-demo", "Lateral displacement of the plates", "Outward, at minimum load."),
            porosity_figure(
                g, runs, "porosity-demo", "Porosity in the measurement spheres", "Cycle 0 is the end of preload."
            ),
            tracking_figure(
                g, runs, "tracking-demo", "Load tracking", "rms error over each cycle, and the extremes of each cycle."
            ),
        ],
        "agreement": agreement_table(only(data.findings.agreement, profile=PROFILE)),
        "runs_table": runs_table(runs),
    }
