"""Every parameter with its status and source, and what runs say about the assumed ones."""

from __future__ import annotations

import numpy as np

from analysis.report.figures.calibration_figures import calibration_figure
from analysis.report.figures.plate_figures import plate_figures
from analysis.report.report_data import KEY_SCENARIOS, ReportData, known_scenarios
from analysis.report.tables.calibration_tables import calibration_table, plate_table
from analysis.report.tables.parameter_tables import (
    STATUS_KIND,
    derived_table,
    difference_table,
    parameter_groups,
    sensitivity_table,
)
from analysis.scenarios.scenario import Scenario, load_scenario
from analysis.scenarios.schema import STATUSES


def assumptions(data: ReportData) -> dict:
    """Every parameter with status and source, and what runs say about the assumed ones."""
    scenarios = {name: load_scenario(name, "full") for name in known_scenarios()}
    base = scenarios.get(next(iter(KEY_SCENARIOS), "")) or next(iter(scenarios.values()), None)
    parameters = base.parameters if base else {}
    counts = {s: sum(p.status == s for p in parameters.values()) for s in STATUSES}
    return {
        "statuses": [{"name": s, "kind": STATUS_KIND[s], "count": counts[s]} for s in STATUSES],
        "groups": parameter_groups(parameters),
        "derived": derived_table(base) if base else None,
        "differences": difference_table(scenarios),
        "base": base.name if base else "",
        "influence": (data.findings.influence["profile"] == "full").any(),
        "sensitivity": sensitivity_table((*data.runs, *data.variants)),
        "calibration": calibration(data, base),
        "plates": plate_laws(data),
    }


def calibration(data: ReportData, base: Scenario | None) -> dict:
    """Table and figure of the beds that `make calibrate` tried, the chosen one marked; {} where there are none."""
    beds = data.findings.calibration
    if beds.empty:
        return {}
    chosen = (base["clump.aspect"], base["packing.lattice_gap"]) if base else (np.nan, np.nan)
    return {
        "table": calibration_table(beds, chosen),
        "figure": calibration_figure(data.gallery, beds, chosen),
    }


def plate_laws(data: ReportData) -> list[dict]:
    """A table and figures per profile and scenario: what the law that holds the plates decides."""
    parts = []
    for (profile, scenario), rows in data.findings.plate_laws.groupby(["profile", "scenario"], sort=False):
        runs = [m.run for m in data.findings.members if m.run.id in set(rows["run"])]
        figures = plate_figures(data.gallery, runs, scenario, profile, int(rows["cycle"].iloc[0]))
        parts += [{"table": plate_table(rows)}, *({"figure": figure} for figure in figures)]
    return parts
