"""The calibration of the packing: which beds it tries, and what it reads from them."""

import math
import shutil

import pandas as pd
import pytest
from bare_run import bare_record
from synthetic import write_run

from analysis.__main__ import main as ballast
from analysis.driver import calibrate
from analysis.driver.liggghts import Liggghts
from analysis.driver.settings import RunSettings
from analysis.driver.supervise import StopRequest
from analysis.formats import kept_tables
from analysis.formats.errors import InputError
from analysis.normalised.readers import Run, load_runs
from analysis.reference.reported import reported
from analysis.scenarios import lattice
from analysis.scenarios.scenario import load_scenario


def test_every_number_of_sites_is_tried_once():
    scenario = load_scenario("linear-mu0.8", "full")
    gaps = calibrate.distinct_gaps(scenario, 0.0133, 0.0150)
    sites = [lattice.site_count(scenario.with_values({"packing.lattice_gap": gap})) for gap in gaps]
    assert len(set(sites)) == len(sites) > 2
    assert lattice.site_count(scenario) == min(sites, key=lambda count: abs(count - reported().clumps))


def test_a_bed_is_read_with_its_choice_and_its_settlement(tmp_path):
    scenario = load_scenario("linear-mu0.8", "demo", cycles=3)
    folder = write_run(tmp_path, "demo", "linear-mu0.8", "liggghts", cycles=3)
    row = calibrate.row(scenario, Run(folder))
    assert row["aspect"] == scenario["clump.aspect"] and row["cycles"] == 3
    assert row["clumps_over_reported"] == pytest.approx(row["clumps"] / (4583 * 0.275 / 0.8))
    assert row["preload_settlement_m"] == 4e-4 and row["settlement_m"] == Run(folder).cycles["settlement_m"].iloc[-1]


def test_a_bed_without_results_has_empty_cells(tmp_path):
    scenario = load_scenario("linear-mu0.8", "demo", cycles=3)
    folder = write_run(tmp_path, "demo", "linear-mu0.8", "liggghts", cycles=3)
    for name in ("stages.json", "cycles.csv"):
        (folder / name).unlink()
    row = calibrate.row(scenario, Run(folder))
    assert row["cycles"] == 0 and math.isnan(row["clumps"]) and math.isnan(row["settlement_m"])


def test_gaps_are_tried_at_the_chosen_aspect_and_aspects_at_the_chosen_gap():
    scenario = load_scenario("linear-mu0.8", "full")
    aspect, gap = scenario["clump.aspect"], scenario["packing.lattice_gap"]
    assert calibrate.choices(scenario, [0.015, gap], [1.5, aspect]) == [(1.5, gap), (aspect, gap), (aspect, 0.015)]


def test_beds_that_are_tried_are_no_runs_of_the_scenario(tmp_path):
    write_run(tmp_path, "full", "linear-mu0.8", "liggghts", cycles=3)
    write_run(tmp_path / "calibration/aspect2-gap14.1mm", "full", "linear-mu0.8", "liggghts", cycles=9)
    assert [run.id for run in load_runs(tmp_path)] == ["full/linear-mu0.8/liggghts"]


@pytest.mark.parametrize(
    "text, says",
    [
        ("", "is empty"),
        ("a,b\n1,2,3\n", "column scenario is missing"),
        (",".join(kept_tables.CALIBRATION.columns) + "\n", "has no row"),
    ],
)
def test_a_damaged_table_is_refused_in_a_line_with_the_remedy(tmp_path, text, says):
    (tmp_path / "calibration.csv").write_text(text)
    with pytest.raises(InputError, match=says) as refused:
        kept_tables.read(tmp_path / "calibration.csv", kept_tables.CALIBRATION)
    assert "calibration.csv" in str(refused.value) and "make calibrate" in str(refused.value)


def test_calibrate_writes_a_row_for_every_bed_and_says_which_failed(tmp_path, monkeypatch, capsys):
    def tried(settings, stop):
        scenario = settings.scenario
        state = "failed" if scenario["clump.aspect"] == 2 else "finished"
        folder = write_run(
            tmp_path / f"{scenario['clump.aspect']}",
            "demo",
            scenario.name,
            "liggghts",
            cycles=3,
            info={"state": state, "reason": "not at rest" if state == "failed" else ""},
        )
        return Run(folder)

    monkeypatch.setattr(calibrate, "load", tried)
    monkeypatch.setattr(Liggghts, "version", lambda engine: "liggghts 1")
    out = tmp_path / "calibration.csv"
    code = ballast(
        ["calibrate", "--profile", "demo", "--gaps", "--aspects", "1.8", "2", "--cycles", "3", "--out", str(out)]
    )
    table = pd.DataFrame(kept_tables.read(out, kept_tables.CALIBRATION))
    assert code == 1 and table["state"].tolist() == ["finished", "finished", "failed", "failed"]
    assert table["scenario"].tolist() == ["linear-mu0.8", "nonlinear-en1.0"] * 2
    assert (table["settlement_m"] > 0).all() and table["aspect"].tolist() == [1.8, 1.8, 2, 2]


def test_a_bed_that_failed_is_not_tried_again_but_its_packing_is_known(tmp_path, capsys):
    scenario = load_scenario("linear-mu0.8", "full", cycles=3)
    where = tmp_path / f"calibration/aspect{scenario['clump.aspect']:g}-gap{1e3 * scenario['packing.lattice_gap']:g}mm"
    folder = write_run(where, "full", "linear-mu0.8", "liggghts", cycles=1)
    bare_record(scenario, "liggghts", state="failed", reason="loads not met").write(folder)
    (folder / "stages.json").unlink()
    (folder / "raw").mkdir(exist_ok=True)
    shutil.copy(folder / "bed_before.csv", folder / "raw" / "bed_packed.csv")
    result = calibrate.load(RunSettings(scenario, "liggghts", results=where), StopRequest())
    row = calibrate.row(scenario, result)
    assert "loads not met" in capsys.readouterr().err and row["state"] == "failed"
    assert row["clumps"] == len(result.bed("before")) and 0 < row["porosity_mean"] < 1
    assert math.isnan(row["preload_settlement_m"])
