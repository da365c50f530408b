"""Figures at the end of a page, under a heading of their own: each is one function here, which nothing else names.

A function gets the report's data and returns its figures, each made by `data.gallery.finish(...)` with name, title and
caption; None, or an empty list, where the runs have nothing to show.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from analysis.normalised.readers import Runs
from analysis.report.figure import Figure
from analysis.report.figures.lateral_figures import lateral_figure
from analysis.report.figures.settlement_figures import settlement_figure
from analysis.report.report_data import CHEN_SCENARIOS, PAPER_SCENARIOS, ReportData

Draw = Callable[[ReportData], list[Figure | None]]


@dataclass(frozen=True)
class Section:
    """A heading and its figures."""

    title: str
    figures: list[Figure]


_SECTIONS: dict[str, list[tuple[str, Draw]]] = {}


def at_end_of(page: str, title: str) -> Callable[[Draw], Draw]:
    """The function's figures stand at the end of `page`, the file of a page, below the heading `title`."""

    def register(draw: Draw) -> Draw:
        _SECTIONS.setdefault(page, []).append((title, draw))
        return draw

    return register


def further_sections(page: str, data: ReportData) -> list[Section]:
    """The sections of a page that have a figure, in the order of this module."""
    drawn = ((title, [figure for figure in draw(data) if figure]) for title, draw in _SECTIONS.get(page, ()))
    return [Section(title, figures) for title, figures in drawn if figures]


@at_end_of("figures.html", "Scenarios that are not the paper's")
def own_scenarios(data: ReportData) -> list[Figure | None]:
    """Settlement and lateral displacement of scenarios that were added to the scenario file."""
    runs = data.of(data.profiles[0]) if data.profiles else Runs()
    own = Runs(run for run in runs if run.base_name not in (*PAPER_SCENARIOS, *CHEN_SCENARIOS))
    return [
        settlement_figure(
            data.gallery, own, "own-settlement", "Settlement, further scenarios", "Scenarios added to scenarios.toml."
        ),
        lateral_figure(
            data.gallery, own, "own-lateral", "Lateral displacement, further scenarios", "Over depth below the sleeper."
        ),
    ]
