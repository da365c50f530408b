"""Every parameter with its status and source, and what runs say about the assumed ones."""

from __future__ import annotations

import numpy as np

from analysis.report.figures.calibration_figures import calibration_figure
from analysis.report.figures.plate_figures import plate_figures
from analysis.report.report_data import KEY_SCENARIOS, ReportData, known_scenarios
from analysis.report.tables import parameter_tables
from analysis.report.tables.calibration_tables import calibration_table, plate_table
from analysis.scenarios.scenario import Scenario, load_scenario


def assumptions(data: ReportData) -> dict:
    """Every parameter with status and source, and what runs say about the assumed ones."""
    scenarios = {name: load_scenario(name, "full") for name in known_scenarios()}
    base = scenarios.get(next(iter(KEY_SCENARIOS), "")) or next(iter(scenarios.values()), None)
    parameters = base.parameters if base else {}
    return {
        "statuses": parameter_tables.status_counts(parameters),
        "groups": parameter_tables.parameter_groups(parameters),
        "derived": parameter_tables.derived_table(base) if base else None,
        "differences": parameter_tables.difference_table(scenarios),
        "base": base.name if base else "",
        "influence": (data.findings.influence["profile"] == "full").any(),
        "sensitivity": parameter_tables.sensitivity_table((*data.runs, *data.variants)),
        "calibration": calibration(data, base),
        "plates": plate_laws(data),
    }


def calibration(data: ReportData, base: Scenario | None) -> dict:
    """Table and figure of the beds that `make calibrate` tried, the chosen one marked; {} where there are none."""
    beds = data.findings.calibration
    if beds.empty:
        return {}
    chosen = (base["clump.aspect"], base["packing.lattice_gap"]) if base else (np.nan, np.nan)
    return {"table": calibration_table(beds, chosen), "figure": calibration_figure(data.gallery, beds, chosen)}


def plate_laws(data: ReportData) -> list[dict]:
    """A table and figures per profile and scenario: what the law that holds the plates decides."""
    parts = []
    for _, rows in data.findings.plate_laws.groupby(["profile", "scenario"], sort=False):
        parts += [{"table": plate_table(rows)}]
        parts += [{"figure": figure} for figure in plate_figures(data.gallery, data.findings.members, rows)]
    return parts
