"""The first page: the answer, the test, one figure, and tiles that lead to the evidence."""

from __future__ import annotations

from analysis.report import data_archive, tiles
from analysis.report.answer import answer
from analysis.report.citation import citation
from analysis.report.figures.bed_figures import full_bed_figure, moving_picture
from analysis.report.figures.overview_figures import full_settlement_figure, sketch_figure
from analysis.report.report_data import KEY_SCENARIOS, ReportData, known_scenarios
from analysis.report.sentences import lines
from analysis.scenarios.scenario import load_scenario

PROFILE = "full"
MOVING = "bed.webp"


def overview(data: ReportData) -> dict:
    """Everything on the first page is of the full bed; the demo has a page of its own."""
    found = data.findings
    key = KEY_SCENARIOS[0] if KEY_SCENARIOS and KEY_SCENARIOS[0] in known_scenarios() else None
    pending = found.pending.to_dict("records")
    return {
        "answer": lines("answer.txt", **answer(found, KEY_SCENARIOS, PROFILE)),
        "sketch": sketch_figure(data.gallery, load_scenario(key, PROFILE)) if key else None,
        "settlement": full_settlement_figure(data.gallery, found.members, KEY_SCENARIOS),
        "tiles": tiles.tiles(data, PROFILE),
        "pending": lines("pending.txt", pending=pending),
        "picture": full_bed_figure(data),
        "demo": any(run.profile == "demo" for run in data.runs),
        "results": data.results,
        "runs": len(data.runs),
        "problems": data.problems,
        "moving": moving_picture(data.kept / MOVING),
        "turnable": data.turnable,
        "archive": data_archive.NAME,
        "citation": citation(),
        "versions": engine_versions(data),
    }


def engine_versions(data: ReportData) -> list[str]:
    """The engines that made the runs, with their versions."""
    found = {run.info.get("versions", {}).get("engine", "") for run in (*data.runs, *data.variants)}
    return sorted(found - {""})
