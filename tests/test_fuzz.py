"""Every format under 300 random damages: the reader accepts it, or refuses it in one line. No traceback, ever."""

import random
import shutil
from pathlib import Path

import pytest
from damage import OF_TABLES, OF_TEXTS, damaged
from synthetic import write_run

from analysis.driver import checkpoints, status
from analysis.formats import bed_file, file_columns, table_file
from analysis.formats.errors import InputError
from analysis.formats.quantities import QUANTITIES
from analysis.formats.run_record import RunRecord
from analysis.normalised import beds, microstructure, stages
from analysis.normalised.frames import read_table
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, load_scenario
from analysis.scenarios.schema import KEYS
from analysis.verification.impact import read_impact

ROOT = Path(__file__).resolve().parent.parent
MUTATIONS = 300


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
        content = damaged(good, random.Random(f"{path.name} {seed} {case}"), kinds)
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


def check_bed(bed):
    assert bed["id"].is_unique and bed["id"].min() >= 1 and (abs(beds.positions(bed)) <= 100).all()


def test_beds(run):
    assert fuzz(run / "bed_before.csv", OF_TABLES, beds.read_bed, check_bed) > MUTATIONS / 2


def check_count(clumps):
    assert clumps > 0


def test_beds_to_start_from(tmp_path):
    places = [(0.1 + 0.06 * k, 0.036, 0.05 + 0.06 * n) for k in range(10) for n in range(2)]
    bed_file.write(tmp_path / "bed.csv", [(n, *at, 1.0, 0.0, 0.0, 0.0) for n, at in enumerate(places, start=1)])
    scenario = load_scenario("linear-mu0.8", "demo")
    refused = fuzz(tmp_path / "bed.csv", OF_TABLES, lambda path: beds.check_fits(path, scenario), check_count)
    assert refused > MUTATIONS / 2


def test_packed_beds(run, tmp_path):
    """Damage within the compressed file: torn, flipped, garbage."""
    import gzip

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
        content = damaged(good, random.Random(f"sidecar {case}"), OF_TEXTS)
        checkpoint.sidecar.write_bytes(content)
        said = []
        found = checkpoints.last_good(run / "checkpoints", 10, said.append)
        assert found == checkpoint or (found is None and len(said) == 1), case
    assert path.read_bytes() == before and checkpoint.sidecar.read_bytes() == content


def test_status_of_a_run_with_any_file_damaged(run):
    for name in ("run.json", "scenario.json", "cycles.csv"):
        kinds = OF_TABLES if name.endswith("csv") else OF_TEXTS
        fuzz(run / name, kinds, lambda path: status.table([status.row(path.parent)]), seed="status", mutations=100)


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
    path = tmp_path / "impact.toml"
    shutil.copy(ROOT / "tests" / "impact.toml", path)
    assert fuzz(path, OF_TEXTS, lambda path: read_impact(path).probe()) > MUTATIONS / 4


@pytest.fixture
def references(tmp_path):
    """A folder of one digitised figure, as WebPlotDigitizer leaves it."""
    source = tmp_path / "indraratna2013"
    shutil.copytree(ROOT / "reference_data" / "indraratna2013", source)
    for other in source.glob("*.toml"):
        if other.name != "settlement.toml":
            other.unlink()
    return source
