"""What the paper leaves out: one thing changed at a time."""

from __future__ import annotations

import math

import pandas as pd

from analysis.comparison.findings.influence import LEAST_INFLUENCE
from analysis.comparison.findings.members import TRUE_LOAD
from analysis.report.answer import influences, only
from analysis.report.figures.influence_figures import influence_figure
from analysis.report.report_data import KEY_SCENARIOS, ReportData
from analysis.report.tables.influence_tables import influence_table
from analysis.scenarios.scenario import ScenarioError, join_id, load_scenario, variant_names

QUANTITIES = {"settlement_m": "settlement", "lateral_mean_m": "lateral displacement"}


def influence_page(data: ReportData) -> dict | None:
    """Ranked influences, those on the key scenarios first; None without a varied run."""
    table = data.findings.influence
    table = table[table["profile"] == "full"]
    table = table.sort_values("scenario", key=lambda names: ~names.isin(KEY_SCENARIOS), kind="stable")
    if table.empty:
        return None
    settled = influences(data.findings, KEY_SCENARIOS, "full")
    return {
        "largest": settled.iloc[-1].to_dict() if len(settled) else {},
        "inside": int((settled["scatters"] < LEAST_INFLUENCE).sum()),
        "count": len(settled),
        "beds": beds_of(data.findings.coverage, table),
        "restless": restless_beds(data.findings.calibration, table),
        "figures": [influence_figure(data.gallery, table, name, what) for name, what in QUANTITIES.items()],
        "table_": influence_table(table),
    }


def beds_of(coverage: pd.DataFrame, table: pd.DataFrame) -> list[dict]:
    """Number of clumps of the unchanged bed and of each variant that packs another number (variant, clumps), fewest
    first; [] where none does.
    """
    of_key = only(coverage, profile="full", reading=TRUE_LOAD)
    of_key = of_key[of_key["scenario"].isin(KEY_SCENARIOS) & of_key["run"].isin([*table["run"], *table["base_run"]])]
    beds = of_key.sort_values(["clumps", "variant"]).drop_duplicates("clumps")
    return beds[["variant", "clumps"]].astype({"clumps": int}).to_dict("records") if len(beds) > 1 else []


def restless_beds(calibration: pd.DataFrame, table: pd.DataFrame) -> list[dict]:
    """Changed beds of the key scenarios that have no run in `table` because they did not come to rest in preload
    (scenario, variant), see `make calibrate`.
    """
    if calibration.empty:
        return []
    failed = calibration[(calibration["state"] == "failed") & (calibration["cycles"] == 0)]
    tried = set(zip(failed["scenario"], failed["aspect"], failed["lattice_gap_m"], strict=True))
    tried -= {(name, *recipe_of(name)) for name in KEY_SCENARIOS}
    compared = set(zip(table["scenario"], table["variant"], strict=True))
    return [
        {"scenario": name, "variant": variant}
        for name in KEY_SCENARIOS
        for variant in variant_names()
        if (name, variant) not in compared and (name, *recipe_of(name, variant)) in tried
    ]


def recipe_of(name: str, *variants: str) -> tuple[float, float]:
    """Aspect of the clumps and gap of the lattice, m, of a scenario with these variants; nan where they do not fit."""
    try:
        scenario = load_scenario(join_id(name, variants), "full")
    except ScenarioError:
        return math.nan, math.nan
    return scenario["clump.aspect"], scenario["packing.lattice_gap"]
