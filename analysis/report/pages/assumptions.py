"""Every parameter with its status and source, and what runs say about the assumed ones."""

from __future__ import annotations

import numpy as np

from analysis.comparison import codes
from analysis.report.figures.calibration import calibration_figure
from analysis.report.figures.plates import plate_figures
from analysis.report.report_data import KEY_SCENARIOS, ReportData, known_scenarios
from analysis.report.tables.base import shown
from analysis.report.tables.calibration import calibration_table, plate_table
from analysis.report.tables.parameters import derived_table, difference_table, sensitivity_table
from analysis.scenarios.scenario import Scenario, join_id, load_scenario
from analysis.scenarios.schema import STATUSES

PLATE_VARIANTS = ("plates-fixed", "plates-pfc")
"""Variants of the law that holds the plates."""
STATUS_KIND = {"reported": "good", "derived": "calm", "assumed": "open", "calibrated": "bad"}


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


def parameter_groups(parameters: dict) -> list[dict]:
    """The parameters by their section of the scenario file."""
    groups: dict[str, list[dict]] = {}
    for key, p in parameters.items():
        told = {"key": key, "value": shown(p.value), "unit": p.unit if p.unit != "-" else "", "status": p.status}
        groups.setdefault(key.rpartition(".")[0], []).append(told | {"kind": STATUS_KIND[p.status], "source": p.source})
    return [{"name": name, "parameters": entries} for name, entries in groups.items()]


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
    """A table and figures per profile and contact model: what the law that holds the plates decides."""
    parts = []
    runs = [r for r in (*data.runs, *data.variants) if len(r.cycles) and r.scenario is not None and r.seed == 1]
    for profile in data.profiles:
        for base in KEY_SCENARIOS:
            laws = [base, *(join_id(base, [variant]) for variant in PLATE_VARIANTS)]
            members = [run for run in runs if run.profile == profile and run.scenario_name in laws]
            varied = {run.code for run in members if run.scenario_name != base}
            members = [run for run in members if run.code in varied]
            if not members:
                continue
            shared = codes.last_common_cycle(members)
            figures = plate_figures(data.gallery, members, base, profile, shared)
            parts += [{"table": plate_table(members, shared)}, *({"figure": figure} for figure in figures)]
    return parts
