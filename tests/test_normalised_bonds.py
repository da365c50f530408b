"""Bonds of a run by cycle, from what the engine wrote last."""

import csv

import pytest

from analysis.formats import file_columns
from analysis.normalised import bonds
from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario

SCENARIO = load_scenario("chen2015", "demo")
CYCLE = derived.time_grid(SCENARIO).steps_per_cycle
PRELOAD = 5000


@pytest.fixture
def run(tmp_path):
    """A run of three cycles, whose bonds broke in preload, in the last step of cycle 1, in the first of cycle 3."""
    raw = tmp_path / "raw"
    raw.mkdir()
    (raw / "state.csv").write_text(
        file_columns.header(file_columns.RAW_STATE)
        + "".join(
            f"{stage},{step}" + ",0" * 9 + "\n"
            for stage, step in (("packing", 99), ("preload", 2500), ("preload", PRELOAD), ("cyclic", CYCLE))
        )
    )
    rows = [(1, 2, 0.1, 0.2, 0.3, 0, -1, "", 5.0, 6.0)] * 4
    for step, mode in ((PRELOAD, "tension"), (PRELOAD + CYCLE, "shear"), (PRELOAD + 2 * CYCLE + 1, "tension")):
        rows.append((3, 4, 0.4, 0.5, 0.6, 1, step, mode, 0, 0))
    for name, last in (("bonds_preloaded", 5), ("bonds_cycle_000003", 7)):
        lines = "".join(",".join(map(str, row)) + "\n" for row in rows[:last])
        (raw / f"{name}.csv").write_text(file_columns.header(file_columns.BONDS) + lines)
    return tmp_path


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_bonds_are_counted_by_the_cycle_in_which_they_broke(run):
    bonds.write(run, SCENARIO, 3)
    counts = [tuple(int(row[name]) for name in file_columns.BOND_COUNTS) for row in table(run / bonds.COUNTS)]
    assert counts == [(0, 6, 1, 0), (1, 5, 1, 1), (2, 5, 1, 1), (3, 4, 2, 1)]
    broken = table(run / bonds.BROKEN)
    assert [(row["cycle"], row["mode"]) for row in broken] == [("0", "tension"), ("1", "shear"), ("3", "tension")]
    assert (broken[0]["x_m"], broken[0]["y_m"], broken[0]["z_m"]) == ("0.4", "0.5", "0.6")


def test_a_run_without_bonds_gets_no_file(run):
    bonds.write(run, load_scenario("linear-mu0.8", "demo"), 3)
    assert not (run / bonds.COUNTS).exists()


def test_a_list_of_bonds_that_is_none_is_named(run):
    (run / "raw" / "bonds_cycle_000003.csv").write_text("a,b\n1,2\n")
    with pytest.raises(ValueError, match=r"raw/bonds_cycle_000003.csv"):
        bonds.write(run, SCENARIO, 3)


def test_broken_bonds_are_read_as_they_were_written(run):
    bonds.write(run, SCENARIO, 3)
    broken = bonds.read_broken(run / bonds.BROKEN)
    assert list(broken["cycle"]) == [0, 1, 3] and list(broken["mode"]) == ["tension", "shear", "tension"]
    assert broken[["x_m", "y_m", "z_m"]].to_numpy().tolist() == [[0.4, 0.5, 0.6]] * 3


@pytest.mark.parametrize(
    "content, said",
    [
        ("", "No columns"),
        ("cycle,x_m\n", "line 1: expected cycle,x_m,y_m,z_m,mode"),
        ("cycle,x_m,y_m,z_m,mode\n1,0,0,0,tension\n1,0,x,0,shear\n", "line 3"),
        ("cycle,x_m,y_m,z_m,mode\n1,0,0,0,torn\n", "line 2"),
        ("cycle,x_m,y_m,z_m,mode\n1,0,0\n", "line 2"),
    ],
)
def test_a_damaged_list_of_broken_bonds_is_named_with_its_line(tmp_path, content, said):
    path = tmp_path / bonds.BROKEN
    path.write_text(content)
    with pytest.raises(ValueError, match=rf"^bonds_broken.csv.*{said}") as caught:
        bonds.read_broken(path)
    assert "\n" not in str(caught.value)
