"""What can happen to a long run, with both real engines: killed, stopped, damaged, out of space, diverging.

Each test starts from the same preloaded small bed; the first makes one anew, from packing on.
"""

import contextlib
import csv
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess

import numpy as np
import pandas as pd
import pytest
from driver import (
    REAL,
    ROOT,
    damage,
    drive,
    engines_of,
    latest,
    read_record,
    results_of,
    run_folder,
    start,
    steps,
    wait_for,
    wait_until,
)
from small_bed import write_scenarios
from torture import Tormentor

from analysis.driver import status
from analysis.driver.engines import ENGINES, LIGGGHTS, YADE
from analysis.formats import bed_file
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario


def grid_of(folder):
    return derived.time_grid(Scenario.from_json((folder / "scenario.json").read_text()))


def assert_no_gap(folder, cycles):
    grid = grid_of(folder)
    end = cycles * grid.steps_per_cycle
    assert steps(folder / "raw" / "cyclic.csv") == list(range(0, end + 1, grid.steps_per_row))
    assert steps(folder / "raw" / "state.csv") == list(range(grid.steps_per_block, end + 1, grid.steps_per_block))


def test_a_repeated_run_gives_the_same_files(code, undisturbed, small_scenarios, tmp_path):
    first = undisturbed("linear-mu0.8", code)
    done = drive(
        REAL, "linear-mu0.8", "--code", code, "--cycles", 3, "--results", tmp_path, "--scenarios", small_scenarios
    )
    assert done.returncode == 0, done.stderr
    again = run_folder(tmp_path, "linear-mu0.8", code)
    assert results_of(again) == results_of(first)
    for name in ("bed_packed.csv", "bed_preloaded.csv", "cyclic.csv", "state.csv"):
        assert (again / "raw" / name).read_bytes() == (first / "raw" / name).read_bytes(), name


@pytest.mark.parametrize("seed", [1])
def test_killed_and_stopped_at_random_moments_it_gives_the_same_files(
    scenario, code, undisturbed, begin, tmp_path, seed
):
    """A few disturbances on the small bed; `make torture` does many on the demo bed."""
    folder, arguments = begin(tmp_path, scenario, code)
    tormentor = Tormentor(REAL, arguments, folder, undisturbed(scenario, code), random.Random(seed), longest_s=1.0)
    tormentor.until_done(4)
    assert tormentor.done.total() > 0
    assert_no_gap(folder, 3)


def before_the_last_cycle(folder, finished):
    """Put a copy of the finished run of three cycles in `folder`, as it was before the third."""
    shutil.rmtree(folder)
    shutil.copytree(finished, folder)
    for path in (*folder.glob("checkpoints/cyclic_000003*"), folder / "raw" / "bed_cycle_000003.csv"):
        path.unlink()
    cycles = (folder / "cycles.csv").read_text().splitlines(keepends=True)
    (folder / "cycles.csv").write_text("".join(cycles[:-1]))


def test_going_on_from_a_checkpoint_gives_the_same_files(scenario, code, undisturbed, begin, tmp_path):
    """The last cycle once more, from the checkpoint before it: here no kill's moment decides what is seen."""
    expected = undisturbed(scenario, code)
    folder, arguments = begin(tmp_path, scenario, code)
    before_the_last_cycle(folder, expected)
    done = drive(REAL, *arguments)
    assert done.returncode == 0, done.stderr
    assert latest(folder).cycle == 3
    assert results_of(folder) == results_of(expected)
    assert_no_gap(folder, 3)


def test_a_damaged_checkpoint_is_named_and_the_one_before_is_used(code, undisturbed, begin, tmp_path):
    expected = undisturbed("linear-mu0.8", code)
    folder, arguments = begin(tmp_path, "linear-mu0.8", code)
    before_the_last_cycle(folder, expected)
    bad = latest(folder)
    damage(bad.path)
    refused = drive(REAL, *arguments)
    assert refused.returncode == 1 and "REDO=yes" in refused.stderr  # cycles that exist would be computed again
    done = drive(REAL, *arguments, "--redo")
    assert done.returncode == 0 and f"checkpoints/{bad.path.name} is damaged" in done.stdout
    assert results_of(folder) == results_of(expected)
    assert_no_gap(folder, 3)


def test_a_stop_in_mid_cycle_does_not_change_the_run(scenario, code, begin, tmp_path):
    """Asked to stop in the second cycle, a few blocks after a checkpoint that the undisturbed run has too."""
    blocks, cycles = 8, 24 if code == "liggghts" else 10  # so many that the signal comes before the end on any machine
    expected, arguments = begin(tmp_path / "whole", scenario, code, cycles)
    assert drive(REAL, *arguments).returncode == 0
    folder, arguments = begin(tmp_path, scenario, code, cycles)
    process = start(REAL, *arguments)
    wait_until(lambda: state_rows(folder) > blocks + 1 or process.poll() is not None, "no second cycle", seconds=200)
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 143, out + err
    assert blocks < state_rows(folder) < cycles * blocks
    done = drive(REAL, *arguments)
    assert done.returncode == 0, done.stderr
    assert results_of(folder) == results_of(expected)
    assert (folder / "raw" / "cyclic.csv").read_bytes() == (expected / "raw" / "cyclic.csv").read_bytes()
    assert_no_gap(folder, cycles)


def state_rows(folder):
    """Blocks of the cyclic stage that have ended."""
    path = folder / "raw" / "state.csv"
    return len(steps(path)) if path.read_bytes().endswith(b"\n") else 0


def test_yade_stopped_between_checkpoints_takes_the_same_path(scenario, begin, tmp_path):
    """On the full bed five cycles lie between checkpoints: a stop writes the one of the last complete cycle."""

    def engine(folder, checkpoint):
        argv = YADE.command("cyclic", folder, folder / "checkpoints" / checkpoint)
        environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        return subprocess.Popen(argv, cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    folders = [begin(tmp_path / name, scenario, "yade")[0] for name in ("whole", "stopped")]
    for folder in folders:
        text = (folder / "scenario.json").read_text()
        asked = json.loads(text)
        asked["parameters"]["output.checkpoint_cycles"]["value"] = 5
        asked["parameters"]["loading.cycles"]["value"] = 4
        (folder / "scenario.json").write_text(json.dumps(asked))
    whole, stopped = folders
    process = engine(whole, "cyclic_000000.yade.gz")
    assert process.communicate(timeout=300) and process.returncode == 0
    process = engine(stopped, "cyclic_000000.yade.gz")
    wait_until(lambda: state_rows(stopped) > 2 * 8 + 1 or process.poll() is not None, "no third cycle", seconds=200)
    process.send_signal(signal.SIGTERM)
    assert process.communicate(timeout=120) and process.returncode == 75
    kept = sorted(path.name for path in (stopped / "checkpoints").glob("*.gz"))
    assert kept == ["cyclic_000000.yade.gz", "cyclic_000002.yade.gz"]
    process = engine(stopped, kept[-1])
    assert process.communicate(timeout=300) and process.returncode == 0
    for name in ("cyclic.csv", "state.csv", *(f"bed_cycle_{cycle:06d}.csv" for cycle in range(1, 5))):
        assert (stopped / "raw" / name).read_bytes() == (whole / "raw" / name).read_bytes(), name


def test_ctrl_c_leaves_a_checkpoint_that_the_run_goes_on_from(code, begin, tmp_path):
    cycles = 12 if code == "yade" else 60  # so that the signal comes before the end on any machine
    folder, arguments = begin(tmp_path, "linear-mu0.8", code, cycles)
    process = start(REAL, *arguments)
    wait_until(lambda: state_rows(folder) > 8 or process.poll() is not None, "no second cycle", seconds=200)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 130 and "to go on: make run SCENARIO=linear-mu0.8" in err
    assert read_record(folder)["state"] == "interrupted" and not engines_of(folder)
    stopped_at = latest(folder)
    last = steps(folder / "raw" / "cyclic.csv")[-1]
    # YADE drops the cycle that is not complete
    assert 0 < stopped_at.step(grid_of(folder)) <= last if code == "yade" else stopped_at.step(grid_of(folder)) == last
    assert drive(REAL, *arguments).returncode == 0
    assert read_record(folder)["resumes"] == [{"stage": "cyclic", "cycle": stopped_at.cycle, "block": stopped_at.block}]
    assert_no_gap(folder, cycles)


def test_the_engine_dies_with_a_killed_driver(code, begin, tmp_path):
    folder, arguments = begin(tmp_path, "linear-mu0.8", code, cycles=12 if code == "yade" else 60)
    process = start(REAL, *arguments)
    wait_for(folder / "raw" / "cyclic.csv", process)
    assert engines_of(folder)
    process.kill()
    process.communicate()
    wait_until(lambda: not engines_of(folder), "the engine lives on", seconds=10)


def test_yade_leaves_nothing_in_the_temporary_folder_however_it_ends(tmp_path):
    """YADE makes a folder there, whatever TMPDIR says, and takes it away only where it ends by itself."""
    script = tmp_path / "script.py"
    script.write_text(
        "import os, signal\nfrom yade.wrapper import Omega\nfrom temporary import remove_own_folder\n"
        "print('folder', os.path.dirname(Omega().tmpFilename()), flush=True)\n"
        "remove_own_folder()\nos.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run(["yade/launch.sh", "-n", "-x", script], cwd=ROOT, capture_output=True, text=True, timeout=300)
    (folder,) = re.findall(r"^folder (/\S+)$", done.stdout, re.MULTILINE)
    assert done.returncode == -signal.SIGKILL and not os.path.exists(folder)
    for name in ("stage.py", "verify.py"):  # all that a command of ours starts
        assert "    remove_own_folder()\n" in (ROOT / "yade" / name).read_text()


def test_a_run_that_diverges_is_stopped_and_its_last_good_state_kept(code, preloaded, tmp_path):
    """Two thousand times the load crushes the bed within a cycle."""
    too_much = write_scenarios(tmp_path / "scenarios.toml", stress_max="9.2e8")
    bed = run_folder(preloaded, "linear-mu0.8", code) / "raw" / "bed_packed.csv"
    done = drive(REAL, "linear-mu0.8", "--code", code, "--results", tmp_path, "--scenarios", too_much, "--bed", bed)
    folder = run_folder(tmp_path, "linear-mu0.8", code)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1
    assert re.search("diverged: (overlap of|kinetic energy|sleeper through the floor)", done.stderr)
    assert read_record(folder)["state"] == "failed" and read_record(folder)["bed"] == "bed_packed.csv"
    assert latest(folder).is_good() and not engines_of(folder)


@pytest.mark.parametrize("lost", [0, 1])
def test_engines_miss_a_clump_beside_the_simulated_space_and_none_that_flies(code, lost, begin, tmp_path):
    """Two of the uppermost clumps lie in each other, or one of them lies behind a side wall: in YADE beyond the space,
    in LIGGGHTS, which takes no such bed, so near to the wall that it is pushed out. The driver ends a run whose engine
    counts fewer clumps.
    """
    folder, _ = begin(tmp_path, "linear-mu0.8", code)
    path, state = folder / "raw" / "bed_packed.csv", folder / "raw" / "state.csv"
    rows = sorted((pose.row for pose in bed_file.read(path)), key=lambda row: row[3])
    (number, *_), (_, x, y, z, *turned) = rows[-2:]
    beside, up = {"yade": -0.06, "liggghts": -0.03}[code], z + 0.011  # a third of the radius of the small bed's spheres
    rows[-2] = (number, x, beside, z, *turned) if lost else (number, x, y, up, *turned)
    bed_file.write(path, sorted(rows))
    for name in ("state", "preload"):
        (folder / "raw" / f"{name}.csv").unlink()
    argv = ENGINES[code].command("preload", folder)
    engine = subprocess.Popen(argv, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT)
    try:
        wait_until(lambda: len(clumps_counted(state)) > 1 or engine.poll() is not None, "no rows", seconds=600)
    finally:
        engine.kill()
        engine.wait()
    assert clumps_counted(state)[-1] == len(rows) - lost


def clumps_counted(path):
    """The column of complete rows."""
    lines = path.read_text().split("\n")[:-1] if path.exists() else []
    return [int(row["clumps"]) for row in csv.DictReader(lines)]


def test_liggghts_on_two_ranks_stops_and_goes_on(undisturbed, begin, tmp_path):
    """Not bit for bit like one rank: rounding grows, so a quarter of a cycle is compared, and the record says so."""
    cycles = 60
    folder, arguments = begin(tmp_path, "linear-mu0.8", "liggghts", cycles)
    process = start(REAL, *arguments, "--ranks", 2)
    wait_for(folder / "raw" / "cyclic.csv", process)
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 143 and not engines_of(folder), out + err
    assert latest(folder).step(grid_of(folder)) > 0
    done = drive(REAL, *arguments, "--ranks", 2)
    assert done.returncode == 0, done.stderr
    body = read_record(folder)
    assert body["ranks"] == 2 and any("differ in their last digits" in sentence for sentence in body["deviations"])
    assert_no_gap(folder, cycles)
    one, two = (
        pd.read_csv(f / "raw" / "cyclic.csv")["sleeper_displacement_m"].iloc[:16]
        for f in (undisturbed("linear-mu0.8", "liggghts"), folder)
    )
    # The quarter cycle of rising load: rounding (1e-17 m) has grown to 1e-12 m in it, and reaches what a cycle settles
    # at the peak.
    np.testing.assert_allclose(two, one, rtol=0, atol=1e-9)
    assert np.ptp(one) > 1e-6

    process = start(
        REAL, *arguments[:3], "--cycles", 3 * cycles, *arguments[5:], "--ranks", 2
    )  # and killed, its ranks die as well
    wait_until(lambda: len(engines_of(folder)) >= 2 or process.poll() is not None, "no ranks", seconds=60)
    process.kill()
    process.communicate()
    wait_until(lambda: not engines_of(folder), "ranks live on", seconds=10)


def test_an_mpirun_of_another_mpi_is_noticed_at_once(begin, tmp_path):
    """It starts as many copies as there should be ranks, each a run of its own in the same folder."""
    folder, arguments = begin(tmp_path / "results", "linear-mu0.8", "liggghts")
    other = tmp_path / "bin" / "mpirun"
    other.parent.mkdir()
    other.write_text('#!/bin/sh\nwhile [ "$1" != -np ]; do shift; done\nshift 2\n"$@" & "$@" & wait $!\n')
    other.chmod(0o755)
    before = (folder / "raw" / "state.csv").read_bytes()
    environment = os.environ | {"PATH": f"{other.parent}:{os.environ['PATH']}"}
    done = drive(REAL, *arguments, "--ranks", 2, env=environment)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1
    assert "2 ranks were asked for, but this process is one of 1" in done.stderr
    assert (folder / "raw" / "state.csv").read_bytes() == before and not engines_of(folder)


@pytest.mark.parametrize("name", ["a b", "half#", "$HOME", "100%", "star*", "it's", "n\u00e4chste", "x" * 160])
def test_results_in_any_folder_work_or_are_refused_before_anything_starts(begin, code, tmp_path, name):
    folder, arguments = begin(tmp_path / name, "linear-mu0.8", code, cycles=1)
    done = drive(REAL, *arguments)
    works = code == "yade" or name.startswith("n")
    assert done.returncode == (0 if works else 1) and len(done.stderr.splitlines()) == (0 if works else 1), done.stderr
    if not works:
        assert "LIGGGHTS cannot read a path" in done.stderr and "RESULTS=" in done.stderr
        assert not (folder / "log" / "cyclic.log").exists()


@contextlib.contextmanager
def small_disk(path):
    """A place with little room: a file system in memory where that is allowed, else a limit on the size of files.

    Yields (cycles that cannot be done in it, function that fills it and gives options for the driver, function that
    makes room). The limit on files lets a checkpoint pass: beyond it YADE would try for ever to write one, which only a
    full file system tells the driver.
    """
    path.mkdir()
    mount = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64m", "tmpfs", path], capture_output=True, check=False)
    if mount.returncode:
        options = {
            "preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000)),
            "env": os.environ | {"PMIX_MCA_gds": "hash"},  # Open MPI's own files would be too large
        }
        yield 15, lambda: options, lambda: None
        return
    filler = path / "filler"

    def fill():
        filler.write_bytes(bytes(shutil.disk_usage(path).free - 200_000))
        return {}

    try:
        yield 3, fill, filler.unlink
    finally:
        subprocess.run(["umount", "--lazy", path], check=True)


@contextlib.contextmanager
def tiny_disk(path):
    """A file system of its own; yields functions that fill it to the last byte and make room again."""
    path.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=32m", "tmpfs", path], capture_output=True).returncode:
        pytest.skip("no right to mount a file system")
    filler = path / "filler"

    def fill():
        with open(filler, "wb", buffering=0) as file, contextlib.suppress(OSError):
            while file.write(bytes(1 << 20)):
                pass

    try:
        yield fill, filler.unlink
    finally:
        subprocess.run(["umount", "--lazy", path], check=True)


@pytest.mark.parametrize("stage", ["packing", "preload"])
def test_a_disk_that_fills_in_packing_or_preload_is_one_line_and_the_stage_begins_again(code, stage, begin, tmp_path):
    with tiny_disk(tmp_path / "disk") as (fill, make_room):
        folder, arguments = begin(tmp_path / "disk" / "results", "linear-mu0.8", code)
        if stage == "packing":
            shutil.rmtree(folder)
        else:
            preloaded = (folder / "raw" / "bed_preloaded.csv").read_bytes()
            shutil.rmtree(folder / "checkpoints")
            for name in ("cyclic", "preload", "bed_preloaded"):
                (folder / "raw" / f"{name}.csv").unlink(missing_ok=True)
        rows = folder / "raw" / ("state.csv" if stage == "packing" else "preload.csv")
        process = start(REAL, *arguments, "--until", stage)
        wait_for(rows, process)
        fill()
        out, err = process.communicate(timeout=1800)
        assert process.returncode == 1 and len(err.splitlines()) == 1, out + err
        assert f"no space left for {folder}" in err and not engines_of(folder)
        assert not (folder / "raw" / f"bed_{'packed' if stage == 'packing' else 'preloaded'}.csv").exists()
        assert status.row(folder)["state"] in ("failed", "interrupted")
        make_room()
        if stage == "packing":  # that it begins again is enough: it would take long
            process = start(REAL, *arguments, "--until", stage)
            wait_until(lambda: process.poll() is not None or engines_of(folder), "no engine")
            assert process.poll() is None
            process.send_signal(signal.SIGTERM)
            process.communicate(timeout=1800)
            assert process.returncode == 143 and not engines_of(folder)
        else:
            done = drive(REAL, *arguments, "--until", stage)
            assert done.returncode == 0, done.stderr
            assert (folder / "raw" / "bed_preloaded.csv").read_bytes() == preloaded


@pytest.mark.parametrize("name", ["raw/state.csv", "raw/cyclic.csv", "raw/bed_cycle_000001.csv.partial"])
def test_liggghts_notices_that_a_file_cannot_be_written_whole(begin, tmp_path, name):
    folder, _ = begin(tmp_path, "linear-mu0.8", "liggghts")
    (folder / name).unlink(missing_ok=True)
    (folder / name).symlink_to("/dev/full")
    argv = LIGGGHTS.command("cyclic", folder, folder / "checkpoints" / "cyclic_000000.restart")
    done = subprocess.run(argv, cwd=ROOT, capture_output=True, text=True, timeout=1800)
    errors = [line for line in (done.stdout + done.stderr).splitlines() if "ERROR" in line]
    assert done.returncode == 1 and len(errors) == 1 and "cannot be written (No space left on device)" in errors[0]
    assert name.removesuffix(".partial") in errors[0] and not (folder / "raw" / "bed_cycle_000001.csv").exists()


def test_a_full_disk_is_one_line_and_the_run_goes_on_once_there_is_room(code, undisturbed, begin, tmp_path):
    expected = undisturbed("linear-mu0.8", code)
    with small_disk(tmp_path / "disk") as (cycles, fill, make_room):
        folder, arguments = begin(tmp_path / "disk" / "results", "linear-mu0.8", code, cycles)
        done = drive(REAL, *arguments, **fill())
        assert done.returncode == 1 and len(done.stderr.splitlines()) == 1, done.stderr
        assert f"no space left for {folder}" in done.stderr and "give the same command again" in done.stderr
        assert not engines_of(folder) and latest(folder).is_good()
        assert status.row(folder)["state"] in ("failed", "interrupted")
        make_room()
        done = drive(REAL, *arguments)
        assert done.returncode == 0, done.stderr
        assert (folder / "cycles.csv").read_text().startswith((expected / "cycles.csv").read_text())
        assert_no_gap(folder, cycles)
