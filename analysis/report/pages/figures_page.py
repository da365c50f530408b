"""The paper's figures remade, with the tables that belong to them."""

from __future__ import annotations

from analysis.report.figures import remade_figures
from analysis.report.figures.porosity_figures import sphere_figure
from analysis.report.figures.restitution_figures import restitution_figure
from analysis.report.pages.bonded_page import bonded_group
from analysis.report.report_data import KEY_SCENARIOS, ReportData, key_runs
from analysis.report.sections import in_readings, key_runs_of_both, section, tests_note, with_what_is_there
from analysis.report.tables import reference_tables
from analysis.scenarios.scenario import load_scenario

BED_WAITS = "It needs a run whose beds are on this machine, or a bed in reference_data/runs/beds."


def paper_figures(data: ReportData) -> dict:
    """Figures 5, 6 and 9 to 13 remade, from full-size runs where there are any; 10 to 13 in both readings."""
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
    laws = data.findings.settlement_laws
    laws = laws[laws["profile"] == profile]
    spheres = [sphere_figure(g, load_scenario(KEY_SCENARIOS[0], "full"))] if KEY_SCENARIOS else []
    return [
        section("Figure 5: the bed", remade_figures.figure5(g, first or list(runs)[:2], data.kept), missing=BED_WAITS),
        section("Figure 6: the load", [remade_figures.figure6(g, first)]),
        section("Figure 9: the damping modes", [restitution_figure(g)], tables=[reference_tables.restitution_rows()]),
        in_readings("Figure 10: the linear model", data, runs, remade_figures.figure10),
        bonded_group(data, profile),
        in_readings("Figure 11: settlement, nonlinear model", data, runs, remade_figures.figure11),
        in_readings("Figure 12: lateral displacement, nonlinear model", data, runs, remade_figures.figure12),
        in_readings("Figure 13: porosity", data, runs, remade_figures.figure13, spheres),
        in_readings("The shape of settlement", data, key_runs_of_both(data, profile), remade_figures.shape_figures)
        | {"folded": [reference_tables.law_table(laws)], "note": tests_note()},
        section("Reference curves", tables=reference_tables.reference_tables(runs, data.references)),
    ]
