"""Checkpoints and raw files after a kill: what counts, what is kept, what is cut."""

import os
import random
import socket

import pytest
from driver import damage

from analysis.driver import checkpoints, locks, rawfiles
from analysis.formats.growing_csv import GrowingCsv, RowsByStep
from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario

GRID = derived.time_grid(load_scenario("linear-mu0.8", "demo"))


def make(folder, *names):
    """Write checkpoints with checksums."""
    for name in names:
        (folder / name).write_bytes(name.encode() * 50)
    for checkpoint in checkpoints.listed(folder):
        if checkpoint.path.name in names:
            checkpoint.certify(GRID)


def names(folder):
    return [c.path.name for c in checkpoints.listed(folder)]


def test_checkpoints_are_listed_in_the_order_of_time(tmp_path):
    make(
        tmp_path,
        "cyclic_000010.restart",
        "cyclic_000009_block7.restart",
        "cyclic_000009.restart",
        "cyclic_1000000.restart",
    )
    for other in ("cyclic_000011.restart.partial", "partial_cyclic_000011.yade.gz", "cyclic_11.restart", "notes.txt"):
        (tmp_path / other).write_text("")
    assert names(tmp_path) == [
        "cyclic_000009.restart",
        "cyclic_000009_block7.restart",
        "cyclic_000010.restart",
        "cyclic_1000000.restart",
    ]
    assert [c.step(GRID) for c in checkpoints.listed(tmp_path)][
        1
    ] == 9 * GRID.steps_per_cycle + 7 * GRID.steps_per_block


def test_the_last_good_one_is_taken_and_damage_is_named(tmp_path):
    make(tmp_path, "cyclic_000000.yade.gz", "cyclic_000001.yade.gz", "cyclic_000002.yade.gz")
    damage(tmp_path / "cyclic_000002.yade.gz")
    (tmp_path / "cyclic_000003.yade.gz").write_text("without checksum")
    said = []
    assert checkpoints.last_good(tmp_path, 9, said.append).cycle == 1
    assert len(said) == 1 and "cyclic_000002.yade.gz is damaged" in said[0]
    assert checkpoints.last_good(tmp_path, 1, said.append).cycle == 0


@pytest.mark.parametrize("sidecar", ["", "{", "[]", "{}", "null", '{"sha256": "0"}'])
def test_a_torn_checksum_is_damage(tmp_path, sidecar):
    make(tmp_path, "cyclic_000000.restart")
    (tmp_path / "cyclic_000000.restart.json").write_text(sidecar)
    assert checkpoints.last_good(tmp_path, 9, lambda text: None) is None


def test_a_truncated_checkpoint_is_damage(tmp_path):
    make(tmp_path, "cyclic_000000.restart")
    path = tmp_path / "cyclic_000000.restart"
    path.write_bytes(path.read_bytes()[:-1])
    assert not checkpoints.listed(tmp_path)[0].is_good()


def test_the_last_two_and_the_first_are_kept(tmp_path):
    make(tmp_path, *(f"cyclic_{cycle:06d}.restart" for cycle in range(0, 25, 5)), "cyclic_000007_block3.restart")
    checkpoints.prune(tmp_path)
    assert names(tmp_path) == ["cyclic_000000.restart", "cyclic_000015.restart", "cyclic_000020.restart"]
    make(tmp_path, "cyclic_000021_block2.restart")
    checkpoints.prune(tmp_path)
    assert len(names(tmp_path)) == 4  # one from a stop, until a scheduled one follows
    make(tmp_path, "cyclic_000025.restart")
    checkpoints.prune(tmp_path)
    assert names(tmp_path) == ["cyclic_000000.restart", "cyclic_000020.restart", "cyclic_000025.restart"]
    assert len(list(tmp_path.glob("*.json"))) == 3


def test_later_checkpoints_are_forgotten(tmp_path):
    make(tmp_path, "cyclic_000000.restart", "cyclic_000001.restart", "cyclic_000002.restart")
    checkpoints.forget_after(tmp_path, checkpoints.listed(tmp_path)[1])
    assert names(tmp_path) == ["cyclic_000000.restart", "cyclic_000001.restart"]
    checkpoints.forget_after(tmp_path, None)
    assert not list(tmp_path.iterdir())


ROWS = "".join(f"{step},{step * 0.1!r}\n" for step in range(0, 100, 10))


@pytest.mark.parametrize("seed", range(20))
def test_a_file_torn_anywhere_keeps_its_whole_rows_up_to_the_step(tmp_path, seed):
    full = "step,time_s\n" + ROWS
    cut = random.Random(seed).randrange(len(full))
    (tmp_path / "cyclic.csv").write_text(full[:cut])
    rawfiles.cut_stage(tmp_path, "cyclic", 50)
    whole = [line for line in full[:cut].splitlines(keepends=True) if line.endswith("\n")]
    if not whole:
        assert not (tmp_path / "cyclic.csv").exists()
    else:
        assert (tmp_path / "cyclic.csv").read_text() == "".join(whole[:7])


def test_rows_of_other_stages_stay(tmp_path):
    (tmp_path / "state.csv").write_text("stage,step\npacking,90\npreload,80\ncyclic,10\ncyclic,20\n\0\0\0\ncyclic,3")
    rawfiles.cut_stage(tmp_path, "cyclic", 10)
    assert (tmp_path / "state.csv").read_text() == "stage,step\npacking,90\npreload,80\ncyclic,10\n"
    assert {stage: row["step"] for stage, row in rawfiles.last_rows(tmp_path / "state.csv").items()} == {
        "packing": "90",
        "preload": "80",
        "cyclic": "10",
    }
    rawfiles.cut_stage(tmp_path, "cyclic", 0)  # the engine writes the row of step 0 itself
    assert (tmp_path / "state.csv").read_text() == "stage,step\npacking,90\npreload,80\n"


def test_a_row_is_read_once_and_only_when_its_line_has_ended(tmp_path):
    path = tmp_path / "state.csv"
    tail = GrowingCsv(path)
    assert tail.new_rows() == []
    path.write_text("step,x\n1,2\n3,")
    assert tail.new_rows() == [{"step": "1", "x": "2"}]
    with open(path, "a") as file:
        file.write("4\n")
    assert tail.new_rows() == [{"step": "3", "x": "4"}] and tail.new_rows() == []


def test_rows_by_step_are_taken_once_and_kept(tmp_path):
    path = tmp_path / "cyclic.csv"
    path.write_text("step,x\n1,2\n")
    rows = RowsByStep(path, ("step", "x"))
    assert rows.update() == {1: {"step": "1", "x": "2"}}  # somebody else looked first
    with open(path, "a") as file:
        file.write("2,3\n3,")
    assert rows.take() == [{"step": "1", "x": "2"}, {"step": "2", "x": "3"}] and rows.take() == []
    assert set(rows.rows) == {1, 2}


def test_a_lock_is_held_by_one(tmp_path):
    path = tmp_path / "run.lock"
    assert not locks.is_held(path)
    path.write_text('{"pid": 1, "host": "of a run that was killed"}\n')
    with locks.hold(path):
        assert locks.is_held(path)
        with pytest.raises(locks.Busy) as refused, locks.hold(path):
            pass
        assert refused.value.holder == {"pid": os.getpid(), "host": socket.gethostname()}
        with pytest.raises(locks.Busy), locks.hold(path, wait=lambda: False):
            pass
    assert not locks.is_held(path)
