"""Every format under 300 random damages: the reader accepts it, or refuses it in one line. No traceback, ever."""

import gzip
import json
import os
import random
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from damage import OF_TABLES, OF_TEXTS, damaged
from synthetic import write_run

from analysis.__main__ import main as ballast
from analysis.comparison.claims.verdicts import ClaimError, load_claims
from analysis.driver import checkpoints, status
from analysis.driver.bench import bench_tables
from analysis.driver.unload import UnloadError, add_row, unload
from analysis.files import KEPT_RUNS, KEPT_VERIFICATION, PUBLISHED, ROOT
from analysis.formats import bed_file, file_columns, kept_tables, table_file
from analysis.formats.errors import InputError
from analysis.formats.quantities import QUANTITIES
from analysis.formats.run_record import RunRecord
from analysis.normalised import beds, bonds, microstructure, stages
from analysis.normalised.frames import read_table
from analysis.reference.ballast_stiffness import ballast_stiffness
from analysis.reference.curves import ReferenceError, load_references
from analysis.reference.reported import reported
from analysis.reference.settlement_laws import settlement_laws
from analysis.reference.settlement_shapes import settlement_shapes
from analysis.report.answer import step_shares
from analysis.report.figures.verification_figures import case_curves
from analysis.report.pages.verification_page import case_table
from analysis.report.tables.benchmark_tables import profile_table, sizes_table, speeds_table
from analysis.report.tables.calibration_tables import calibration_table
from analysis.report.tables.timestep_tables import runs_table, shares_table
from analysis.scenarios import cost, derived, study_list
from analysis.scenarios.scenario import Scenario, load_scenario
from analysis.scenarios.schema import KEYS
from analysis.scenarios.study_list import key_scenarios
from analysis.verification.impact_file import read_impacts

MUTATIONS = 300
SEED = os.environ.get("FUZZ_SEED", "")
"""Another one tries other damages: FUZZ_SEED=2 python -m pytest tests/test_fuzz.py"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run's folder with few cycles and clumps."""
    folder = write_run(tmp_path_factory.mktemp("run"), "demo", "linear-mu0.8", "liggghts", cycles=3)
    for path in (*folder.glob("bed_*.csv"), *folder.glob("raw/contacts_*.csv")):
        path.write_text("".join(path.read_text().splitlines(keepends=True)[:40]))
    return folder


def fuzz(path, kinds, read, check=lambda found: None, seed="", mutations=MUTATIONS):
    """Damage the file, read it; return how often it was refused. Nothing beside it may change."""
    good, refused = path.read_bytes(), 0
    listed = sorted(path.parent.rglob("*"))
    for case in range(mutations):
        content = damaged(good, random.Random(f"{path.name} {seed} {SEED} {case}"), kinds)
        path.write_bytes(content)
        try:
            found = read(path)
        except InputError as error:
            refused += 1
            assert len(str(error)) < 600 and str(error).isprintable(), (case, str(error))
        else:
            check(found)
        assert path.read_bytes() == content and sorted(path.parent.rglob("*")) == listed, case
    path.write_bytes(good)
    check(read(path))
    return refused


def check_columns(columns):
    def check(table):
        for name in columns:
            assert all(QUANTITIES[name].accepts(value) for value in table[name]), name

    return check


@pytest.mark.parametrize("name", ["cycles.csv", "history.csv", "microstructure.csv"])
def test_tables(run, name):
    columns = {"cycles.csv": file_columns.CYCLES, "history.csv": file_columns.HISTORY}.get(
        name, file_columns.MICROSTRUCTURE
    )
    whole = name != "history.csv"
    refused = fuzz(run / name, OF_TABLES, lambda path: read_table(path, columns, whole), check_columns(columns))
    assert refused > MUTATIONS / 2
    if name == "cycles.csv":
        fuzz(run / name, OF_TABLES, lambda path: table_file.last_cycle(path, columns), seed="last")


def test_contacts(run):
    path = run / "raw" / "contacts_preloaded.csv"
    assert fuzz(path, OF_TABLES, microstructure.read_contacts, check_columns(file_columns.CONTACTS)) > MUTATIONS / 2


TABLES_OF_KEPT_RUNS = {
    "harmonics.csv": (file_columns.HARMONICS, True),
    "loops.csv": (file_columns.LOOPS, False),
    "plates.csv": (file_columns.PLATE_STRESSES, True),
    "unload.csv": (file_columns.UNLOAD, False),
}


@pytest.mark.parametrize("name", TABLES_OF_KEPT_RUNS)
def test_tables_of_kept_runs(tmp_path, name):
    (source, *_) = sorted((ROOT / "reference_data" / "runs" / "full").glob(f"*/liggghts*/{name}"))
    shutil.copy(source, tmp_path)
    columns, whole = TABLES_OF_KEPT_RUNS[name]
    found = fuzz(tmp_path / name, OF_TABLES, lambda path: read_table(path, columns, whole), check_columns(columns))
    assert found > MUTATIONS / 2


def test_unloading_in_a_code_without_that_stage_names_the_one_that_has_it(tmp_path):
    with pytest.raises(UnloadError, match="yade has no stage that unloads; give CODE=liggghts"):
        unload(tmp_path, "yade", 1)


def test_unloading_adds_to_a_table_or_refuses_a_damaged_one_and_leaves_it(tmp_path):
    (source, *_) = sorted((ROOT / "reference_data" / "runs" / "full").glob("*/liggghts*/unload.csv"))
    path, row = tmp_path / "unload.csv", dict.fromkeys(file_columns.UNLOAD, 0.5) | {"cycle": 7}
    good, refused = source.read_bytes(), 0
    for case in range(MUTATIONS):
        content = damaged(good, random.Random(f"unload {SEED} {case}"), OF_TABLES)
        path.write_bytes(content)
        try:
            add_row(path, row)
        except InputError as error:
            refused += 1
            assert str(error).startswith("unload.csv: ") and path.read_bytes() == content, case
        else:
            check_columns(file_columns.UNLOAD)(read_table(path, file_columns.UNLOAD, False))
    assert refused > MUTATIONS / 2


def check_bonds(rows):
    assert all((row["mode"] in ("tension", "shear")) == (row["broken"] == "1") for row in rows)
    assert all(row["broken"] == "0" or int(row["step"]) >= 0 for row in rows)


def test_bonds(tmp_path):
    """The list of an engine, the counts by cycle, and the list of broken bonds."""
    holds, broke = "{0},{1},0.1,0.2,0.3,0,-1,,5.0,6.0\n", "{0},{1},0.4,0.5,0.6,1,{2},{3},0,0\n"
    rows = [holds.format(k, k + 1) for k in range(1, 8)]
    rows += [broke.format(k, k + 1, 900 * k, ("tension", "shear")[k % 2]) for k in range(8, 15)]
    raw = tmp_path / "bonds_cycle_000003.csv"
    raw.write_text(file_columns.header(file_columns.BONDS) + "".join(rows))
    assert fuzz(raw, OF_TABLES, bonds.read_list, check_bonds) > MUTATIONS / 2
    counts = tmp_path / bonds.COUNTS
    counts.write_text(
        file_columns.header(file_columns.BOND_COUNTS) + "".join(f"{k},{90 - 2 * k},{k},{k}\n" for k in range(9))
    )
    columns = file_columns.BOND_COUNTS
    assert fuzz(counts, OF_TABLES, lambda path: read_table(path, columns), check_columns(columns)) > MUTATIONS / 2
    broken = tmp_path / bonds.BROKEN
    broken.write_text(
        file_columns.header(file_columns.BONDS_BROKEN) + "".join(f"{k},0.1,0.2,0.3,tension\n" for k in range(9))
    )
    assert fuzz(broken, OF_TABLES, bonds.read_broken) > MUTATIONS / 2


def check_calibration(columns):
    calibration_table(pd.DataFrame(columns), (1.8, 0.0141))


def check_timestep(columns):
    table = pd.DataFrame(columns)
    assert shares_table(table).rows and runs_table(table).rows and step_shares(table, key_scenarios()) is not None


def check_shown(build):
    return lambda columns: build(pd.DataFrame(columns)).rows


KEPT_TABLES = {
    KEPT_RUNS / "calibration.csv": (kept_tables.CALIBRATION, check_calibration),
    KEPT_RUNS / "timestep.csv": (kept_tables.TIMESTEP, check_timestep),
    KEPT_RUNS / "benchmark.csv": (kept_tables.BENCHMARK, check_shown(speeds_table)),
    KEPT_RUNS / "benchmark_sizes.csv": (kept_tables.BENCHMARK_SIZES, check_shown(sizes_table)),
    KEPT_RUNS / "benchmark_profile.csv": (kept_tables.BENCHMARK_PROFILE, check_shown(profile_table)),
    KEPT_VERIFICATION / "verification.csv": (
        kept_tables.VERIFICATION,
        check_shown(lambda rows: case_table(rows, "all")),
    ),
}


@pytest.mark.parametrize("path", KEPT_TABLES, ids=lambda path: path.stem)
def test_tables_of_studies(tmp_path, path):
    """Whatever is accepted can be shown."""
    kind, check = KEPT_TABLES[path]
    few = path.read_text().splitlines(keepends=True)[:60]
    (tmp_path / path.name).write_text("".join(few))
    assert fuzz(tmp_path / path.name, OF_TABLES, lambda path: kept_tables.read(path, kind), check) > MUTATIONS / 2


def test_timings_of_a_benchmark(tmp_path):
    path = tmp_path / "timings.csv"
    row = "liggghts,linear,{},4573,1,17216,17216,9.{},10.5,1.0\n"
    rows = "".join(row.format(who, k) for who in ("paper", "verified", "stock") for k in range(1, 6))
    path.write_text(file_columns.header(kept_tables.TIMINGS.columns) + rows)
    assert (
        fuzz(path, OF_TABLES, bench_tables.read_timings, lambda found: bench_tables.comparison(found, []))
        > MUTATIONS / 2
    )


def test_the_baseline_of_the_benchmark(tmp_path, monkeypatch):
    shutil.copy(bench_tables.BASELINE, tmp_path)
    path = tmp_path / bench_tables.BASELINE.name
    monkeypatch.setattr(bench_tables, "BASELINE", path)
    assert fuzz(path, OF_TEXTS, lambda path: bench_tables.comparison([], bench_tables.read_baseline())) > MUTATIONS / 3


def test_curves_of_the_verification(tmp_path):
    """A damaged curve is left out; one that is not is drawn."""
    path = tmp_path / "head-on_liggghts.csv"
    few = (KEPT_VERIFICATION / "verification" / path.name).read_text().splitlines(keepends=True)[:60]
    path.write_text("".join(few))
    good, left_out = path.read_bytes(), 0
    for case in range(MUTATIONS):
        path.write_bytes(damaged(good, random.Random(f"{path.name} {SEED} {case}"), OF_TABLES))
        found = case_curves(tmp_path, "head-on")
        left_out += not found
        for curve in found.values():
            numbers = curve.drop(columns="series").to_numpy()
            assert numbers.dtype == float and not (abs(numbers) > 1e30).any(), case
    assert MUTATIONS / 5 < left_out < MUTATIONS


def check_bed(bed):
    assert bed["id"].is_unique and bed["id"].min() >= 1 and (abs(beds.positions(bed)) <= 100).all()


def test_beds(run):
    assert fuzz(run / "bed_before.csv", OF_TABLES, beds.read_bed, check_bed) > MUTATIONS / 2


def check_count(clumps):
    assert clumps > 0


def test_beds_to_start_from(tmp_path):
    places = [(0.56 + 0.05 * k, 0.05 + 0.15 * n, 0.05) for k in range(5) for n in range(4)]
    bed_file.write(tmp_path / "bed.csv", [(n, *at, 1.0, 0.0, 0.0, 0.0) for n, at in enumerate(places, start=1)])
    scenario = load_scenario("linear-mu0.8", "demo")
    refused = fuzz(tmp_path / "bed.csv", OF_TABLES, lambda path: beds.check_fits(path, scenario), check_count)
    assert refused > MUTATIONS / 2


def test_packed_beds(run, tmp_path):
    """Damage within the compressed file: torn, flipped, garbage."""
    path = tmp_path / "bed.csv.gz"
    path.write_bytes(gzip.compress((run / "bed_before.csv").read_bytes(), mtime=0))
    assert fuzz(path, OF_TABLES, bed_file.read) > MUTATIONS / 2


def check_record(record):
    assert record.state in ("running", "finished", "interrupted", "failed") and record.seed >= 1


def test_run_json(run):
    assert fuzz(run / "run.json", OF_TEXTS, lambda path: RunRecord.read(path.parent), check_record) > MUTATIONS / 3


def test_scenario_json(run):
    def check(scenario):
        for key, parameter in scenario.parameters.items():
            assert key not in KEYS or KEYS[key].accepts(parameter.value), key

    assert fuzz(run / "scenario.json", OF_TEXTS, Scenario.read, check) > MUTATIONS / 5


def test_stages_json(run):
    assert fuzz(run / "stages.json", OF_TEXTS, lambda path: stages.read_stages(path.parent)) > MUTATIONS / 3


def test_checkpoint_sidecars(run):
    """What is damaged does not count; the checkpoint and its sidecar stay where they are."""
    grid, path = load_scenario("linear-mu0.8", "demo"), run / "checkpoints" / "cyclic_000003.restart"
    path.write_bytes(b"state" * 1000)
    checkpoint = checkpoints.Checkpoint(3, 0, path)
    checkpoint.certify(derived.time_grid(grid))
    good, before = checkpoint.sidecar.read_bytes(), path.read_bytes()
    for case in range(MUTATIONS):
        content = damaged(good, random.Random(f"sidecar {SEED} {case}"), OF_TEXTS)
        checkpoint.sidecar.write_bytes(content)
        said = []
        found = checkpoints.last_good(run / "checkpoints", 10, said.append)
        assert found == checkpoint or (found is None and len(said) == 1), case
    assert path.read_bytes() == before and checkpoint.sidecar.read_bytes() == content


def test_status_of_a_run_with_any_file_damaged(run):
    for name in ("run.json", "scenario.json", "cycles.csv"):
        kinds = OF_TABLES if name.endswith("csv") else OF_TEXTS
        fuzz(run / name, kinds, lambda path: status.table([status.row(path.parent)]), seed="status", mutations=100)


COMMANDS = (
    ("status",),
    *((name, "linear-mu0.8", "--code", "liggghts") for name in ("prepare", "unload", "delete", "keep")),
)


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
def test_commands_on_a_damaged_run(run, tmp_path, monkeypatch, capsys, command):
    """They do what they are for or refuse it in one line, and leave every file of the run as it is."""
    results, mutations = run.parents[2], MUTATIONS // len(COMMANDS)
    files = sorted(path for path in run.rglob("*") if path.is_file() and path.suffix in (".csv", ".json"))
    monkeypatch.setattr("builtins.input", lambda *_: "no")
    kept = ["--out", str(tmp_path / "kept")] if command[0] == "keep" else []
    for case in range(mutations):
        generator = random.Random(f"{command[0]} {SEED} {case}")
        path = generator.choice(files)
        good = path.read_bytes()
        path.write_bytes(damaged(good, generator, OF_TABLES if path.suffix == ".csv" else OF_TEXTS))
        before = {file: file.read_bytes() for file in files}
        code = ballast([*command, "--results", str(results), *kept])
        said = capsys.readouterr()
        lines = said.err.splitlines() if command[0] != "delete" else said.out.splitlines()[-1:]
        assert code == 0 or len(lines) == 1, (case, path.name, said.err)
        assert {file: file.read_bytes() for file in files} == before, (case, path.name)
        path.write_bytes(good)


# ------------------------------------------------------------------ what people write


def test_scenario_files(tmp_path):
    path = tmp_path / "mine.toml"
    shutil.copy(ROOT / "scenarios.toml", path)

    def check(scenario):
        for key, parameter in scenario.parameters.items():
            assert KEYS[key].accepts(parameter.value), key

    refused = fuzz(path, OF_TEXTS, lambda path: load_scenario("nonlinear-en1.0", "full", path), check)
    assert refused > MUTATIONS / 4


def test_impact_files(tmp_path):
    for name in ("impact.toml", "chung-ooi/test7.toml"):
        path = tmp_path / Path(name).name
        shutil.copy(ROOT / "docs" / "examples" / name, path)
        assert fuzz(path, OF_TEXTS, lambda path: read_impacts(path).impacts[0].probe()) > MUTATIONS / 5


OF_THE_LITERATURE = {
    "settlement_laws/laws.toml": settlement_laws,
    "settlement_shapes/shapes.toml": settlement_shapes,
    "ballast_stiffness/stiffness.toml": ballast_stiffness,
    "talebiahooie2021/reported.toml": reported,
}


@pytest.mark.parametrize("name", OF_THE_LITERATURE)
def test_published_references(tmp_path, name):
    """Laws, shapes and stiffnesses; and a claims file, with the same promise."""
    folder = shutil.copytree(ROOT / "reference_data" / "published", tmp_path / "published")
    read = OF_THE_LITERATURE[name]
    assert fuzz(folder / name, OF_TEXTS, lambda path: as_input(read, folder)) > MUTATIONS / 3


def test_claims_file(tmp_path):
    shutil.copy(ROOT / "reference_data" / "claims.toml", tmp_path)
    assert fuzz(tmp_path / "claims.toml", OF_TEXTS, lambda path: as_input(load_claims, path)) > MUTATIONS / 3


def as_input(read, *arguments):
    """Errors of references and claims as those of other input: one line is promised of them too."""
    try:
        return read(*arguments)
    except (ReferenceError, ClaimError) as error:
        raise InputError(str(error)) if len(str(error).splitlines()) == 1 else AssertionError(str(error)) from None


def test_the_list_of_the_study(tmp_path):
    """The part of a scenario file that `make study` reads; the file is read once per damage, which takes its time."""
    path = tmp_path / "scenarios.toml"
    shutil.copy(ROOT / "scenarios.toml", path)
    assert fuzz(path, OF_TEXTS, study_list.rows, mutations=MUTATIONS // 3) > MUTATIONS / 12


SIDECAR = """
source = "indraratna2013"
figure = "made up"
kind = "experiment"
status = "digitised"
licence = "none"
files = ["{file}"]
digitised_by = "A. Tester"
date = 2026-03-01
method = "synthetic"
error = {{ value = 0.2, unit = "mm", source = "made up" }}
curves = [{{ dataset = "experiment" }}]
[axes.x]
quantity = "cycle"
unit = "-"
range = [0, 1000]
[axes.y]
quantity = "settlement"
unit = "mm"
range = [0, 20]
reversed = false
"""
POINTS = [(1, 2.0), (10, 5.0), (100, 9.0), (500, 11.5), (1000, 12.5)]
CURVES = {
    "settlement.csv": "".join(f"{x}, {y}\n" for x, y in POINTS),
    "wpd.json": json.dumps(
        {
            "axesColl": [{"name": "XY", "type": "XYAxes", "calibrationPoints": []}],
            "datasetColl": [{"name": "experiment", "axesName": "XY", "data": [{"value": p} for p in POINTS]}],
        }
    ),
}


def references(folder, file):
    """A source with one digitised curve, as WebPlotDigitizer leaves it in `file`."""
    source = folder / "indraratna2013"
    source.mkdir()
    shutil.copy(PUBLISHED / "indraratna2013" / "reference.bib", source)
    (source / "settlement.toml").write_text(SIDECAR.format(file=file))
    (source / file).write_text(CURVES[file])
    found = load_references(folder)
    assert found.problems == [] and len(found.curves) == len(POINTS)
    return source


@pytest.mark.parametrize("file, name", [("settlement.csv", "settlement.toml"), *((f, f) for f in CURVES)])
def test_reference_sidecars_and_curves(tmp_path, file, name):
    path = references(tmp_path, file) / name
    good, refused = path.read_bytes(), 0
    kinds = OF_TABLES if name.endswith(".csv") else OF_TEXTS
    for case in range(MUTATIONS):
        path.write_bytes(damaged(good, random.Random(f"{name} {SEED} {case}"), kinds))
        found = load_references(tmp_path)
        refused += bool(found.problems)
        assert all(line.isprintable() and len(line) < 700 for line in found.problems), (case, found.problems)
        values = found.curves[["value", "error"]].to_numpy(dtype=float)
        assert np.isfinite(values).all() and (abs(values) < 1).all(), case
    assert refused > MUTATIONS / 3
    assert sorted(p.name for p in path.parent.iterdir()) == sorted({"reference.bib", "settlement.toml", file})


@pytest.mark.parametrize(
    "edit, said",
    [
        (lambda s: s.replace("value = 0.2", "value = nan"), "error.value = NaN is refused"),
        (lambda s: s.replace("2026-03-01", '"2026-13-45"'), 'date = "2026-13-45" is refused'),
        (lambda s: s.replace("2026-03-01", '"9999-01-01"'), 'date = "9999-01-01" is refused'),
        (lambda s: s.replace("1000", "1" * 5000), "is not valid TOML"),
        (lambda s: "x = " + "[" * 5000 + "]" * 5000 + s, "is not valid TOML: is nested too deep"),
        (lambda s: "a." * 3000 + "a = 1" + s, "is nested deeper"),
    ],
)
def test_nothing_absurd_is_accepted_from_a_sidecar(tmp_path, edit, said):
    path = references(tmp_path, "settlement.csv") / "settlement.toml"
    path.write_text(edit(path.read_text()))
    (problem, *_) = load_references(tmp_path).problems
    assert problem.startswith("indraratna2013/settlement.toml: ") and said in problem


@pytest.mark.parametrize("kind", ["folder", "dangling link", "Latin-1 bibliography", "huge field", "10^400"])
def test_odd_files_in_a_source_are_one_line(tmp_path, kind):
    source = references(tmp_path, "wpd.json" if kind == "10^400" else "settlement.csv")
    if kind == "folder":
        (source / "other.toml").mkdir()
    elif kind == "dangling link":
        (source / "other.toml").symlink_to(source / "nothing")
    elif kind == "Latin-1 bibliography":
        (source / "reference.bib").write_bytes("@article{indraratna2013, author = {Müller}}".encode("latin-1"))
    elif kind == "huge field":
        (source / "settlement.csv").write_text('"' + "1" * 200_000 + '", 2\n')
    else:
        path = source / "wpd.json"
        path.write_text(path.read_text().replace("1000", "1" + "0" * 400))
    problems = load_references(tmp_path).problems
    assert problems and all(line.isprintable() and len(line) < 400 for line in problems)


@pytest.mark.parametrize(
    "key, value",
    [
        ("loading.frequency", "5e-324"),
        ("time.verified_step", "1e-300"),
        ("output.rows_per_cycle", str(2**63)),
        ("load_control.pfc_update_interval", "10" + "0" * 30),
        ("contact.particle_particle.normal_stiffness", "1e300"),
        ("contact.particle_particle.normal_stiffness", "1e-300"),
        ("load_control.sleeper_mass", "1e300"),
        ("geometry.box_length", "100.0"),
        ("packing.relax_steps", str(2**63)),
        ("clump.density", "nan"),
    ],
)
def test_a_number_that_no_bed_has_is_refused(tmp_path, key, value):
    path = tmp_path / "mine.toml"
    text = (ROOT / "scenarios.toml").read_text()
    unit = KEYS[key].unit
    entry = f'{{ value = {value}, unit = "{unit}", status = "assumed", source = "a test" }}'
    path.write_text(f'{text}\n[scenario.mine]\ntitle = "mine"\n{key} = {entry}\n')
    with pytest.raises(InputError, match=rf"mine.toml: scenario.mine.{key}.value = .* is refused; allowed: "):
        load_scenario("mine", "demo", path)


@pytest.mark.parametrize(
    "changes, said",
    [
        ({"time.verified_step": 1e-9, "time.choice": "verified", "loading.cycles": 10_000_000}, "a run of at most 1e"),
        ({"packing.lattice_radius": 1e-3, "packing.lattice_gap": 0.0}, "a bed of at most 1,000,000 clumps"),
    ],
)
def test_what_a_run_would_cost_is_checked_before_it_starts(changes, said):
    scenario = load_scenario("linear-mu0.8", "full")
    for key, value in changes.items():
        scenario = scenario.with_values({"time.step" if key == "time.verified_step" else key: value})
    assert any(said in allowed for _, allowed in cost.too_much(scenario))
    assert list(cost.too_much(load_scenario("linear-mu0.8", "full"))) == []
