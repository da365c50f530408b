"""The first page: the answer, the test, one figure, and tiles that lead to the evidence."""

from __future__ import annotations

import base64
import re
from pathlib import Path

from analysis.comparison.quantities import last_cycle
from analysis.files import ROOT
from analysis.report import data_archive, tiles
from analysis.report.answer import answer
from analysis.report.figures.beds import bed_figure
from analysis.report.figures.overview import both_readings_figure, sketch_figure
from analysis.report.report_data import KEY_SCENARIOS, ReportData, known_scenarios
from analysis.report.sentences import lines
from analysis.scenarios.scenario import load_scenario

PROFILE = "full"
MOVING = "bed.webp"


def overview(data: ReportData) -> dict:
    """Everything on the first page is of the full bed; the demo has a page of its own."""
    found = data.findings
    members = [m for m in found.members if m.run.profile == PROFILE and m.plain]
    key = KEY_SCENARIOS[0] if KEY_SCENARIOS and KEY_SCENARIOS[0] in known_scenarios() else None
    pending = found.pending.to_dict("records")
    return {
        "answer": lines("answer.txt", **answer(found, KEY_SCENARIOS, PROFILE)),
        "sketch": sketch_figure(data.gallery, load_scenario(key, PROFILE)) if key else None,
        "settlement": both_readings_figure(
            data.gallery,
            members,
            KEY_SCENARIOS,
            "settlement-full",
            "Settlement of the sleeper on the full bed",
            "At minimum load, zero at the end of preload; cycles on a logarithmic axis, each model on a scale of "
            "its own. Thin lines are single packed beds, "
            "the thick line is their mean as far as all of them reach.",
        ),
        "tiles": tiles.tiles(data, PROFILE),
        "pending": lines("pending.txt", pending=pending),
        "picture": bed_picture(data),
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


def moving_picture(path: Path) -> str:
    """The moving picture kept in the repository as a data URI; empty where it is not there."""
    return "data:image/webp;base64," + base64.b64encode(path.read_bytes()).decode() if path.exists() else ""


def citation() -> str:
    """Authors and title of CITATION.cff."""
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    title = re.search(r'^title: "(.*)"$', text, re.M)
    author = re.search(r"^ {2}- name: (.*)$", text, re.M)
    return ". ".join(found.group(1) for found in (author, title) if found) + "."


def engine_versions(data: ReportData) -> list[str]:
    """The engines that made the runs, with their versions."""
    found = {run.info.get("versions", {}).get("engine", "") for run in (*data.runs, *data.variants)}
    return sorted(found - {""})


def bed_picture(data: ReportData):
    """The bed after loading of the longest run whose bed is on this machine; None without one."""
    runs = [run for run in data.of(PROFILE) if (run.folder / "bed_after.csv").exists()]
    runs.sort(key=lambda run: (run.base_name == KEY_SCENARIOS[-1], run.code == "liggghts", last_cycle(run)))
    return bed_figure(
        data.gallery,
        runs[-1:],
        "bed-full",
        "after",
        "The bed after loading",
        "Clumps of two spheres, coloured by how far they moved since the end of preload; sleeper and plates as "
        "glass, where "
        "they stand at the end. The bed is cut open along the middle of the sleeper.",
    )
