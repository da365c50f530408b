"""The paper's figures remade, with the tables that belong to them."""

from __future__ import annotations

from collections.abc import Callable

from analysis.comparison import against_published
from analysis.comparison.findings.members import READINGS, member
from analysis.normalised.readers import Run, Runs
from analysis.reference.settlement_shapes import settlement_shapes
from analysis.report.figures import remade
from analysis.report.figures.porosity import sphere_figure
from analysis.report.figures.restitution import restitution_figure
from analysis.report.pages.bonded import bonded_group
from analysis.report.report_data import KEY_SCENARIOS, ReportData, key_runs
from analysis.report.tables import reference
from analysis.scenarios.scenario import load_scenario

WAITS = "It appears as soon as a run of one of its scenarios has finished a cycle."
BED_WAITS = "It needs a run whose beds are on this machine, or a bed in reference_data/runs/beds."


def paper_figures(data: ReportData) -> dict:
    """Figures 5, 6 and 9 to 13 remade, from full-size runs where there are any, 10 to 13 in both readings of the
    load.
    """
    profile = data.profiles[0] if data.profiles else "full"
    groups = [with_what_is_there(part) for part in all_groups(data, profile)]
    return {
        "profile": profile,
        "runs": len(data.of(profile)),
        "groups": [part for part in groups if part["figures"] or part["tables"] or part["missing"]],
        "pending": len(data.references.pending),
        "reference_problems": data.references.problems,
    }


def all_groups(data: ReportData, profile: str) -> list[dict]:
    """The sections of the page in its order."""
    g, runs, key = data.gallery, data.of(profile), key_runs(data, profile)
    first = [run for run in key if run.seed == 1]
    spheres = [sphere_figure(g, load_scenario(KEY_SCENARIOS[0], "full"))] if KEY_SCENARIOS else []
    return [
        section("Figure 5: the bed", remade.figure5(g, first or list(runs)[:2], data.kept), missing=BED_WAITS),
        section("Figure 6: the load", [remade.figure6(g, first)]),
        section("Figure 9: the damping modes", [restitution_figure(g)], tables=[reference.restitution_rows()]),
        in_readings("Figure 10: the linear model", data, runs, remade.figure10),
        bonded_group(data, profile),
        in_readings("Figure 11: settlement, nonlinear model", data, runs, remade.figure11),
        in_readings("Figure 12: lateral displacement, nonlinear model", data, runs, remade.figure12),
        in_readings("Figure 13: porosity", data, runs, remade.figure13, spheres),
        in_readings("The shape of settlement", data, key_runs_of_both(data, profile), remade.shape_figures)
        | {"folded": [reference.law_table(run for run in runs if run.seed == 1)], "note": tests_note()},
        section("Reference curves", tables=reference_tables(data, profile)),
        section("Scenarios that are not the paper's", remade.further_figures(g, runs)),
    ]


def tests_note() -> str:
    """What the triaxial tests decide, and what they cannot."""
    known = settlement_shapes()
    return (
        f"The triaxial tests: {known.provenance}. They decide {known.decides}. They cannot decide "
        f"{known.cannot_decide}. Their weakness: {known.weakness}."
    )


def section(title: str, figures: list | None = None, tables: list | None = None, missing: str = "") -> dict:
    """One section; `missing` says what it waits for where it has no figure."""
    return {"title": title, "figures": figures or [], "tables": tables or [], "folded": [], "missing": missing}


def with_what_is_there(part: dict) -> dict:
    """A section without the figures and tables for which there is nothing."""
    return part | {kind: [one for one in part.get(kind, ()) if one] for kind in ("figures", "tables", "folded")}


def in_readings(title: str, data: ReportData, runs: Runs, draw: Callable, before: list | None = None) -> dict:
    """Figures that are drawn for every reading that has runs."""
    figures = list(before or [])
    for reading in READINGS:
        mine = Runs(run for run in runs if member(run).reading == reading)
        figures += draw(data.gallery, mine, reading) if mine else []
    return section(title, figures, missing=WAITS)


def key_runs_of_both(data: ReportData, profile: str) -> Runs:
    """The runs of the key scenarios in every reading that has runs."""
    found: list[Run] = []
    for reading in READINGS:
        if any(member(run).reading == reading for run in data.of(profile)):
            found += key_runs(data, profile, reading)
    return Runs(found)


def reference_tables(data: ReportData, profile: str) -> list:
    """Where the reference curves come from, and how runs compare with them."""
    runs, references = data.of(profile), data.references
    return [
        reference.sources_table(references.sources),
        reference.reference_scores(against_published.reference_table(runs, references)),
        reference.lateral_scores(against_published.lateral_reference_table(runs, references)),
    ]
