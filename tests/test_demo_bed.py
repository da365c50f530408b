"""The demo bed: the end of the full bed next to the plates, with a smooth wall where it is cut; one bed for both."""

import math
import re
import shutil

import numpy as np
import pytest
from driver import ROOT, run_folder
from synthetic import write_run

from analysis.comparison.findings.find import find
from analysis.driver.liggghts import parameter_deck
from analysis.formats import file_columns
from analysis.normalised import beds, porosity, stages
from analysis.normalised.frames import read_table
from analysis.normalised.readers import load_runs
from analysis.reference.curves import load_references
from analysis.report import demo_outcome
from analysis.report.tables.demo_tables import beside_table
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, ScenarioError, load_scenario

LINEAR, NONLINEAR = "linear-mu0.8", "nonlinear-en1.0"
FULL, DEMO = (load_scenario(LINEAR, profile) for profile in ("full", "demo"))
SHORT = DEMO.with_values({"geometry.cut_x": 0.62})
"""A piece that holds no measurement sphere."""


def test_the_cut_leaves_plates_side_walls_and_the_sleepers_section_as_they_are():
    whole, piece = derived.apparatus(FULL), derived.apparatus(DEMO)
    assert (piece.plates, piece.fixed_wall, piece.plate_area_m2) == (
        whole.plates,
        whole.fixed_wall,
        whole.plate_area_m2,
    )
    assert (piece.length_m, piece.width_m, piece.height_m) == (whole.length_m, whole.width_m, whole.height_m)
    assert piece.sleeper.low[1:] == whole.sleeper.low[1:] and piece.sleeper.high == whole.sleeper.high
    assert piece.end_m == piece.sleeper.low[0] == DEMO["geometry.cut_x"] > whole.end_m == whole.sleeper.low[0] == 0


def test_loads_masses_and_drags_of_the_sleeper_follow_its_area_those_of_plates_stay():
    whole, piece = derived.apparatus(FULL), derived.apparatus(DEMO)
    share = (0.8 - DEMO["geometry.cut_x"]) / 0.8
    assert piece.sleeper_area_m2 == pytest.approx(share * whole.sleeper_area_m2)
    assert piece.ballast_volume_m3 == pytest.approx(share * whole.ballast_volume_m3)
    assert derived.share_of_box(DEMO) == pytest.approx(share)
    large, small = derived.load_control(FULL), derived.load_control(DEMO)
    for key, value in large.items():
        assert small[key] == pytest.approx(value * (share if key.startswith("sleeper") else 1)), key


@pytest.mark.parametrize(
    "name, variant, expected",
    [
        (LINEAR, "", "9a919897df1f"),
        (NONLINEAR, "", "e714472a7c12"),
        (NONLINEAR, "servo", "04ac12bb0a2b"),
    ],
)
def test_the_full_bed_is_the_same_physics_as_before_there_was_a_cut(name, variant, expected):
    """Kept runs and runs of the study go on: the key's neutral value takes no part in the hash."""
    assert load_scenario(name, variant=variant).hash == expected


def test_liggghts_is_told_where_the_smooth_end_wall_is():
    deck = parameter_deck(DEMO, 1)
    assert f'variable geometry_cut_x index "{DEMO["geometry.cut_x"]!r}"' in deck
    assert 'variable end_friction_share index "0.0"' in deck
    assert 'variable end_friction_share index "1.0"' in parameter_deck(FULL, 1)


def test_both_codes_have_the_end_wall_at_the_cut_and_no_friction_on_it(preloaded, code, scenario):
    """Of all walls only the cut is smooth: shear forces are zero there, on side walls and floor they are not."""
    folder = run_folder(preloaded, scenario, code)
    made = Scenario.read(folder / "scenario.json")
    box, radius = derived.apparatus(made), derived.clump(made).radius_m
    assert box.end_m > 0
    contacts = read_table(folder / "raw" / "contacts_preloaded.csv", file_columns.CONTACTS, None)
    walls = contacts[contacts["clump_2"] == 0]
    near = 0.1 * radius
    at_end, at_side = walls[walls["x_m"] < box.end_m + near], walls[walls["y_m"] < near]
    at_end, at_side = at_end[at_end["nx"].abs() > 0.99], at_side[at_side["ny"].abs() > 0.99]
    assert len(at_end) > 3 and (at_end["normal_force_N"] > 0).all() and (at_end["shear_force_N"] == 0).all()
    assert len(at_side) > 3 and (at_side["shear_force_N"] > 0).any()
    bed = beds.read_bed(folder / "raw" / "bed_preloaded.csv")
    spheres = beds.sphere_centres(bed, derived.clump(made).half_distance_m)
    assert spheres[:, 0].min() == pytest.approx(box.end_m + radius, abs=near)


def test_a_clump_must_fit_between_the_cut_and_the_plates(tmp_path):
    path = tmp_path / "scenarios.toml"
    text = (ROOT / "scenarios.toml").read_text()
    path.write_text(re.sub(r"(geometry\.cut_x\s*= \{ value = )[\d.]+", r"\g<1>0.79", text))
    with pytest.raises(ScenarioError, match=r"geometry\.cut_x = 0\.79 is refused; allowed: <= 0\.763 m"):
        load_scenario(LINEAR, "demo", path)


# ---------------------------------------------------------------------- measurement spheres


def test_a_measurement_sphere_that_does_not_fit_is_left_out_not_shrunk(tmp_path):
    assert derived.apparatus(FULL).measurement_fits == (True, True, True)
    assert derived.apparatus(DEMO).measurement_fits == (False, False, True)
    assert derived.apparatus(SHORT).measurement_fits == (False, False, False)
    centres = np.random.default_rng(1).uniform((DEMO["geometry.cut_x"], 0, 0), (0.8, 0.6, 0.3), (2000, 3))
    part, error = porosity.MeasurementSpheres(DEMO, 20_000).measure(centres)
    whole, _ = porosity.MeasurementSpheres(FULL, 20_000).measure(centres)
    assert np.isnan(part[:2]).all() and part[2] == whole[2] and error > 0
    values, error = porosity.MeasurementSpheres(SHORT, 20_000).measure(centres)
    assert np.isnan([*values, error]).all()


def test_porosities_that_were_not_measured_are_empty_columns_and_stand_in_no_table(tmp_path):
    folder = write_run(tmp_path / "raw", "demo", LINEAR, "liggghts", cycles=2)
    run = load_runs(tmp_path / "raw")[0]
    cycles = run.cycles.assign(porosity_1=math.nan, porosity_2=math.nan)
    cycles.to_csv(folder / "cycles.csv", index=False, lineterminator="\n")
    again = load_runs(tmp_path / "raw")
    assert not again.problems and again[0].cycles["porosity_1"].isna().all()
    full = write_run(tmp_path / "full", "full", LINEAR, "liggghts", cycles=2, contacts=False)
    shutil.copy(folder / "cycles.csv", full / "cycles.csv")
    assert "porosity_1 of cycle 1" in load_runs(tmp_path / "full").problems[0]
    bed = folder / "bed_before.csv"
    measures = stages.bed_measures(bed, DEMO, porosity.MeasurementSpheres(DEMO, 1000), {})
    assert measures["clumps"] > 0 and [n for n in measures if n.startswith("porosity")] == ["porosity_3"]


# ---------------------------------------------------------------------- one bed for both codes


@pytest.mark.parametrize("name", [LINEAR, NONLINEAR, f"{NONLINEAR}+servo"])
def test_yade_takes_the_demo_bed_that_liggghts_packed(name):
    s = load_scenario(f"{name}+same-bed", "demo")
    assert (s["packing.bed_from"], s["packing.bed_code"]) == (LINEAR, "liggghts")
    assert load_scenario(name, "demo").changed_keys(s, "preload", "loading") == []


def test_the_summary_of_the_demo_tells_settlements_agreement_and_the_full_bed(tmp_path):
    for variant in ("", "+servo"):
        bed = {"cycles": 3, "contacts": False}
        write_run(tmp_path, "demo", f"{NONLINEAR}{variant}", "liggghts", **bed)
        write_run(tmp_path, "demo", f"{NONLINEAR}+same-bed{variant}", "yade", **bed | {"cycles": 2})
    write_run(tmp_path, "full", NONLINEAR, "liggghts", cycles=4, noise=0.2, rng=5, contacts=False)
    runs = load_runs(tmp_path)
    lines = demo_outcome.summary(find(runs, load_references()), "report/index.html")
    by_id = {run.id: run.cycles.set_index("cycle")["settlement_m"] for run in runs}
    here, full = by_id[f"demo/{NONLINEAR}/liggghts"].at[2], by_id[f"full/{NONLINEAR}/liggghts"].at[2]
    assert len(lines) == 4, lines
    assert "in 2 cycles" in lines[0] and f"{1e3 * here:.3g} mm in LIGGGHTS" in lines[0]
    assert f"the full bed {1e3 * full:.3g} mm." in lines[0] and "PFC's servo" in lines[1] and "full bed" not in lines[1]
    assert "differ by 0 %, 0 %" in lines[2] and "15 %" in lines[2]
    assert "report/index.html" in lines[3] and "make" in lines[3]


def test_the_demo_bed_is_told_beside_the_full_beds_over_their_packings(tmp_path):
    for seed in (1, 2):
        write_run(tmp_path, "demo", LINEAR, "liggghts", seed=seed, cycles=3, contacts=False)
        write_run(tmp_path, "full", LINEAR, "liggghts", seed=seed, cycles=4, noise=0.2, rng=seed, contacts=False)
    write_run(tmp_path, "full", NONLINEAR, "liggghts", cycles=4, contacts=False)
    runs = load_runs(tmp_path)
    rows = demo_outcome.beside_full(find(runs, load_references()).members)
    assert [(r.scenario, r.reading, r.cycle) for r in rows] == [(LINEAR, "true load", n) for n in (1, 2, 3)]
    settled = {run.id: run.cycles.set_index("cycle")["settlement_m"] for run in runs}
    demo, full = ([v.at[2] for name, v in settled.items() if f"{p}/{LINEAR}/" in name] for p in ("demo", "full"))
    assert sorted(rows[1].demo_m) == sorted(demo) and sorted(rows[1].full_m) == sorted(full)
    assert rows[1].ratio == pytest.approx(np.mean(demo) / np.mean(full))
    far = demo_outcome.Beside(LINEAR, "true load", 1, (2.1e-3,), (1e-3, 1e-3), 2e-3, 1e-3)
    table = beside_table([rows[0], far])
    assert not far.alike and table.rows[1][6].text == "no" and table.rows[1][4] == "1 (1 to 1, 2 beds)"
