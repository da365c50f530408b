"""The calibration of the packing: which beds it tries, and what it reads from them."""

import math

import pytest
from synthetic import write_run

from analysis.driver import calibrate
from analysis.normalised.readers import Run
from analysis.scenarios import lattice
from analysis.scenarios.scenario import load_scenario


def test_every_number_of_sites_is_tried_once():
    scenario = load_scenario("linear-mu0.8", "full")
    gaps = calibrate.distinct_gaps(scenario, 0.0133, 0.0150)
    sites = [lattice.site_count(scenario.replace("packing.lattice_gap", gap)) for gap in gaps]
    assert len(set(sites)) == len(sites) > 2
    assert lattice.site_count(scenario) == min(sites, key=lambda count: abs(count - calibrate.REPORTED_CLUMPS))


def test_a_bed_is_read_with_its_choice_and_its_settlement(tmp_path):
    scenario = load_scenario("linear-mu0.8", "demo", cycles=3)
    folder = write_run(tmp_path, "demo", "linear-mu0.8", "liggghts", cycles=3)
    row = calibrate.row(scenario, Run(folder))
    assert row["aspect"] == scenario["clump.aspect"] and row["cycles"] == 3
    assert row["clumps_over_reported"] == pytest.approx(row["clumps"] / (4583 * 0.12))
    assert row["preload_settlement_m"] == 4e-4 and row["settlement_m"] == Run(folder).cycles["settlement_m"].iloc[-1]


def test_a_bed_without_results_has_empty_cells(tmp_path):
    scenario = load_scenario("linear-mu0.8", "demo", cycles=3)
    folder = write_run(tmp_path, "demo", "linear-mu0.8", "liggghts", cycles=3)
    for name in ("stages.json", "cycles.csv"):
        (folder / name).unlink()
    row = calibrate.row(scenario, Run(folder))
    assert row["cycles"] == 0 and math.isnan(row["clumps"]) and math.isnan(row["settlement_m"])
