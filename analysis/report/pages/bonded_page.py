"""Chen et al.'s bonded model, our own run of it, beside the paper's two models."""

from __future__ import annotations

from analysis.comparison.findings.members import READINGS, member
from analysis.normalised.readers import Runs
from analysis.report.figures.bond_figures import bond_figures
from analysis.report.figures.remade_figures import three_models_figures
from analysis.report.report_data import CHEN_SCENARIOS, KEY_SCENARIOS, ReportData
from analysis.report.tables.bond_tables import bonds_table
from analysis.report.tables.table_html import Table
from analysis.scenarios.scenario import load_scenario

TITLE = "Chen et al.: the bonded model, our own run"
WAITS = "It appears as soon as a run of the bonded model has finished a cycle (make liggghts-chen2015)."


def bonded_group(data: ReportData, profile: str) -> dict:
    """Settlement and lateral displacement of the three models in each reading; bonds made, broken, and where."""
    models = Runs(run for run in data.of(profile) if run.base_name in (*KEY_SCENARIOS, *CHEN_SCENARIOS))
    figures = []
    for reading in READINGS:
        mine = Runs(run for run in models if member(run).reading == reading)
        if any(run.base_name in CHEN_SCENARIOS for run in mine):
            figures += three_models_figures(data.gallery, mine, reading)
    figures += bond_figures(data.gallery, bonded_runs(data, profile))
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
