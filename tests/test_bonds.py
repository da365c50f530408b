"""Parallel bonds in whole runs of the real engines: kept by checkpoints bit for bit, the same on two ranks."""

import csv

import pytest
from driver import REAL, drive, results_of, run_folder
from small_bed import write_scenarios


@pytest.fixture(scope="module")
def bonded_scenarios(tmp_path_factory):
    """The small bed with bonds of which some break under this load; checkpoints after every cycle."""
    path = write_scenarios(
        tmp_path_factory.mktemp("bonded") / "scenarios.toml",
        normal_strength="1e6",
        checkpoint_cycles="1",
    )
    text = path.read_text()
    off = 'model             = { value = "none"'
    assert text.count(off) == 1
    path.write_text(text.replace(off, 'model             = { value = "parallel"'))
    return path


def bonds(folder, name):
    with open(folder / "raw" / name, newline="") as file:
        return list(csv.DictReader(file))


def go(code, results, scenarios, *more):
    done = drive(REAL, "linear-mu0.8", "--code", code, "--results", results, "--scenarios", scenarios, *more)
    assert done.returncode == 0, done.stderr
    return run_folder(results, "linear-mu0.8", code)


@pytest.fixture(scope="module")
def packed(bonded_scenarios, tmp_path_factory):
    """One packed bed for all tests."""
    folder = go("liggghts", tmp_path_factory.mktemp("packed"), bonded_scenarios, "--until", "packing")
    return folder / "raw" / "bed_packed.csv"


def test_bonds_go_through_a_checkpoint_bit_for_bit(code, packed, bonded_scenarios, tmp_path):
    """Two cycles in one go, and one cycle that is extended by another: the same files, bonds and breaks included."""
    whole = go(code, tmp_path / "whole", bonded_scenarios, "--bed", packed, "--cycles", 2)
    parts = go(code, tmp_path / "parts", bonded_scenarios, "--bed", packed, "--cycles", 1)
    go(code, tmp_path / "parts", bonded_scenarios, "--bed", packed, "--cycles", 2)
    assert results_of(parts) == results_of(whole)
    for name in ("bonds_cycle_000002.csv", "contacts_cycle_000002.csv", "cyclic.csv"):
        assert (parts / "raw" / name).read_bytes() == (whole / "raw" / name).read_bytes(), name
    before, after = bonds(whole, "bonds_preloaded.csv"), bonds(whole, "bonds_cycle_000002.csv")
    assert len(before) == len(after) > 100, "bonds are made once"
    broken = [{(row["clump_1"], row["clump_2"]) for row in rows if row["broken"] == "1"} for rows in (before, after)]
    assert broken[0] <= broken[1], "broken stays broken"
    assert broken[1] and len(broken[1]) < len(after), "some break under this load, and some hold"
    assert all(row["clump_1"] != row["clump_2"] for row in after), "never within a clump"


def test_bonds_are_the_same_on_two_ranks(packed, bonded_scenarios, tmp_path):
    """Rounding alone differs: the same bonds are made, and the preloaded bed is the same within a hundredth of an
    overlap."""
    one = go("liggghts", tmp_path / "one", bonded_scenarios, "--bed", packed, "--until", "preload")
    two = go("liggghts", tmp_path / "two", bonded_scenarios, "--bed", packed, "--until", "preload", "--ranks", 2)
    pairs = [
        sorted((row["clump_1"], row["clump_2"]) for row in bonds(folder, "bonds_preloaded.csv"))
        for folder in (one, two)
    ]
    assert pairs[0] == pairs[1]
