"""Unloading of a copy: what of a settlement is elastic."""

import csv
import hashlib

import pytest

from analysis.driver.unload import UnloadError, unload
from analysis.formats.file_columns import UNLOAD


def contents(folder):
    """Checksums of all files of a run."""
    return {path: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.rglob("*") if path.is_file()}


def test_an_unloaded_copy_springs_back_and_the_run_stays_as_it_is(undisturbed):
    folder = undisturbed("nonlinear-md1-en0.6", "liggghts")
    before = contents(folder)
    row = unload(folder, "liggghts", seed=1)
    assert contents(folder) == before
    with open(folder / "cycles.csv", newline="") as file:
        last = list(csv.DictReader(file))[-1]
    assert tuple(row) == UNLOAD and row["cycle"] == int(last["cycle"])
    assert row["settlement_before_m"] == pytest.approx(float(last["settlement_m"]), rel=0, abs=1e-12)  # the same row
    assert row["stress_after_Pa"] == pytest.approx(50e3, rel=0.05)  # the small bed jumps at the end
    with open(folder / "history.csv", newline="") as file:
        end = list(csv.DictReader(file))[-1]
    # 2 %: the row of the run was written within its last step, that of the copy before its first, with other velocities
    assert row["stress_before_Pa"] == pytest.approx(float(end["sleeper_stress_Pa"]), rel=0.02)


def test_what_cannot_be_unloaded_is_refused_in_one_line(undisturbed, tmp_path):
    with pytest.raises(UnloadError, match="give CODE=liggghts"):
        unload(undisturbed("linear-mu0.8", "yade"), "yade", seed=1)
    with pytest.raises(UnloadError, match="there is no run"):
        unload(tmp_path, "liggghts", seed=1)
