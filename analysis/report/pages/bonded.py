"""Chen et al.'s bonded model, our own run of it, beside the paper's two models."""

from __future__ import annotations

from analysis.comparison.findings.members import READINGS, member
from analysis.normalised.readers import Runs
from analysis.report.figures.bonds import bonds_figure, broken_bonds_figure
from analysis.report.figures.lateral import lateral_figure
from analysis.report.figures.settlement import settlement_figure
from analysis.report.labels import READING_NAMES
from analysis.report.report_data import CHEN_SCENARIOS, KEY_SCENARIOS, ReportData
from analysis.report.sentences import slug
from analysis.report.tables.base import Table
from analysis.report.tables.bonds import bonds_table
from analysis.scenarios.scenario import load_scenario

TITLE = "Chen et al.: the bonded model, our own run"
WAITS = "It appears as soon as a run of the bonded model has finished a cycle (make liggghts-chen2015)."
OF_CHEN = (
    "Chen et al. (2015) is run here from the parameters of Table 3, with parallel bonds between the particles that "
    "touch at the end of packing (assumed). It is not their published curve, which is pending."
)

AS_ABOVE = "Chen et al.'s model as in the figure before."


def bonded_group(data: ReportData, profile: str) -> dict:
    """Settlement and lateral displacement of the three models in each reading; bonds made, broken, and where."""
    g, runs = data.gallery, data.of(profile)
    figures = []
    for reading in READINGS:
        mine = Runs(run for run in runs if member(run).reading == reading)
        if not any(run.base_name in CHEN_SCENARIOS for run in mine):
            continue
        mine = Runs(run for run in mine if run.base_name in (*KEY_SCENARIOS, *CHEN_SCENARIOS))
        name, where = slug(reading), READING_NAMES[reading]
        stiff = Runs(run for run in mine if run.base_name != KEY_SCENARIOS[-1])  # the nonlinear model hides both
        figures += [
            settlement_figure(
                g, stiff, f"bonded-linear-{name}", f"Bonded and linear model, {where}: settlement", OF_CHEN
            ),
            settlement_figure(g, mine, f"bonded-settlement-{name}", f"Three models, {where}: settlement", AS_ABOVE),
            lateral_figure(g, mine, f"bonded-lateral-{name}", f"Three models, {where}: lateral displacement", AS_ABOVE),
        ]
    bonded = bonded_runs(data, profile)
    figures += [
        bonds_figure(
            g, bonded, "bonds", "Bonds broken", "Of bonds made at the end of packing; cycle 0 is the end of preload."
        ),
        broken_bonds_figure(
            g,
            bonded,
            "broken-bonds",
            "Where bonds broke",
            "Each dot is a bond, at its place when it broke; all of the bed's depth is seen. Grey: sleeper and plates.",
        ),
    ]
    return {"title": TITLE, "missing": WAITS, "figures": figures, "tables": [bonds_of(data, profile)]}


def bonded_runs(data: ReportData, profile: str) -> Runs:
    """Runs with bonds, variants included."""
    there = [run for run in (*data.of(profile), *data.variants) if run.profile == profile]
    return Runs(run for run in there if len(run.bonds) and len(run.cycles))


def bonds_of(data: ReportData, profile: str) -> Table | None:
    """Bonds made and broken by cycle."""
    rows = data.findings.bonds
    if rows.empty:
        return None
    return bonds_table(rows[rows["profile"] == profile], load_scenario(CHEN_SCENARIOS[0], "full"))
