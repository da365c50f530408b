"""The driver alone, with an engine that computes nothing worth the time: resume, refuse, stop, fail."""

import errno
import gzip
import json
import os
import random
import re
import shutil
import signal
import socket
import subprocess

import pytest
from driver import (
    FAKE,
    ROOT,
    copy_run,
    damage,
    drive,
    engines_of,
    kill_until_done,
    latest,
    read_record,
    results_of,
    run_folder,
    start,
    steps,
    wait_for,
    wait_until,
)
from small_bed import set_value

from analysis.driver import checkpoints, provenance
from analysis.driver.folder import cycles_done
from analysis.driver.run import unusable
from analysis.formats import file_columns
from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario

CYCLES = 4
LINEAR = ("linear-mu0.8", "--code", "yade", "--cycles", CYCLES)
NO_LOCKS = (
    FAKE[0],
    "-c",
    "import errno, fcntl, os, runpy, sys\n"
    "def flock(*_): raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))\n"
    f"fcntl.flock, sys.argv[0] = flock, {FAKE[1]!r}\n"
    f"sys.path.insert(0, {str(ROOT)!r}); runpy.run_path({FAKE[1]!r}, run_name='__main__')",
)
GRID = derived.time_grid(load_scenario("linear-mu0.8", "demo"))


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """Folder of a run that nobody disturbed."""
    results = tmp_path_factory.mktemp("undisturbed")
    done = drive(FAKE, *LINEAR, "--results", results)
    assert done.returncode == 0, done.stderr
    return run_folder(results, "linear-mu0.8", "yade")


@pytest.fixture
def finished(undisturbed, tmp_path):
    """A copy of the finished run, to be tampered with: (results, folder)."""
    return tmp_path, copy_run(undisturbed, run_folder(tmp_path, "linear-mu0.8", "yade"))


def assert_no_gap(folder, cycles=CYCLES):
    end = cycles * GRID.steps_per_cycle
    assert steps(folder / "raw" / "cyclic.csv") == list(range(0, end + 1, GRID.steps_per_row))
    assert steps(folder / "raw" / "state.csv") == list(range(GRID.steps_per_block, end + 1, GRID.steps_per_block))


def test_a_run_ends_with_all_rows_and_says_so(undisturbed):
    body = read_record(undisturbed)
    assert (body["state"], body["stage"], body["clumps"], body["resumes"]) == ("finished", "cyclic", 2, [])
    assert body["steps"]["cyclic"] == CYCLES * GRID.steps_per_cycle
    assert str(ROOT) not in json.dumps(body)
    assert_no_gap(undisturbed)


def test_processor_time_is_recorded_beside_wall_time(undisturbed):
    timing = read_record(undisturbed)["timing"]
    steps = read_record(undisturbed)["steps"]
    cpu = timing.get("cpu_s", {})
    assert set(cpu) <= set(steps), "stages whose engine took no measurable time may lack"
    assert all(timing["cpu_steps"][stage] == steps[stage] and cpu[stage] > 0 for stage in cpu)
    assert "cyclic" in timing["cpu_s"]


def test_a_finished_run_is_left_alone(finished):
    results, folder = finished
    before = (folder / "run.json").read_bytes()
    done = drive(FAKE, *LINEAR, "--results", results)
    assert done.returncode == 0 and "finished already: 4 cycles" in done.stdout
    assert (folder / "run.json").read_bytes() == before


def test_the_same_command_gives_the_same_files(undisturbed, tmp_path):
    assert drive(FAKE, *LINEAR, "--results", tmp_path).returncode == 0
    assert results_of(run_folder(tmp_path, "linear-mu0.8", "yade")) == results_of(undisturbed)


@pytest.mark.parametrize("seed", range(3))
def test_killed_at_random_moments_it_gives_the_same_files(undisturbed, tmp_path, seed):
    folder = run_folder(tmp_path, "linear-mu0.8", "yade")
    kills = kill_until_done(FAKE, [*LINEAR, "--results", tmp_path], folder, random.Random(seed))
    assert kills > 0 and results_of(folder) == results_of(undisturbed)
    assert_no_gap(folder)


FALLS_BEHIND = (
    FAKE[0],
    "-c",
    f"import runpy, sys\nsys.path.insert(0, {str(ROOT)!r}); sys.argv[0] = {FAKE[1]!r}\n"
    "from analysis.driver import checkpoints, supervise\nfrom analysis.normalised.normalise import Normaliser\n"
    "supervise.POLL_S, add = 3.0, Normaliser.cycle\n"
    "def cycle(self, number):\n"
    "    safe = [c.cycle for c in checkpoints.listed(self.folder / 'checkpoints') if c.is_certified()]\n"
    "    print('ADDS', number, 'AFTER', max(safe))\n"
    "    add(self, number)\n"
    "Normaliser.cycle = cycle\n"
    f"runpy.run_path({FAKE[1]!r}, run_name='__main__')",
)


def test_a_kill_costs_no_more_where_the_driver_falls_behind(tmp_path):
    """The engine does all cycles while the driver sleeps: each checkpoint is certified before the next cycle counts."""
    done = drive(FALLS_BEHIND, *LINEAR, "--results", tmp_path)
    assert done.returncode == 0, done.stderr
    said = re.findall(r"ADDS (\d+) AFTER (\d+)", done.stdout)
    assert said == [(str(n), str(n - 1)) for n in range(1, CYCLES + 1)]


def test_the_engine_dies_with_a_killed_driver(tmp_path):
    folder = run_folder(tmp_path, "linear-mu0.8", "yade")
    process = start(FAKE, *LINEAR, "--results", tmp_path)
    wait_for(folder / "raw" / "cyclic.csv", process)
    assert engines_of(folder)
    process.kill()
    process.communicate()
    wait_until(lambda: not engines_of(folder), "the engine lives on", seconds=60)
    table = drive((FAKE[0], "-m", "analysis"), "status", "--results", tmp_path).stdout
    assert read_record(folder)["state"] == "running" and "interrupted  killed; the same command goes on" in table


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_stop_waits_for_the_checkpoint_and_goes_on_from_it(tmp_path, number, code):
    folder = run_folder(tmp_path, "linear-mu0.8", "yade")
    process = start(FAKE, *LINEAR, "--results", tmp_path)
    wait_for(folder / "raw" / "bed_cycle_000001.csv", process)
    process.send_signal(number)
    _, err = process.communicate(timeout=300)
    assert process.returncode == code and "to go on: make run SCENARIO=linear-mu0.8 CODE=yade" in err
    assert (
        read_record(folder)["state"] == "interrupted" and read_record(folder)["reason"] == f"stopped by {number.name}"
    )
    stopped_at = latest(folder)
    assert stopped_at.step(GRID) == steps(folder / "raw" / "cyclic.csv")[-1]
    assert drive(FAKE, *LINEAR, "--results", tmp_path).returncode == 0
    assert read_record(folder)["resumes"] == [{"stage": "cyclic", "cycle": stopped_at.cycle, "block": stopped_at.block}]
    assert_no_gap(folder)


def test_a_second_interrupt_kills_an_engine_that_does_not_stop(tmp_path):
    folder = run_folder(tmp_path, "linear-mu0.8", "yade")
    folder.mkdir(parents=True)
    (folder / "behave").write_text("deaf")
    process = start(FAKE, *LINEAR, "--results", tmp_path)
    wait_for(folder / "raw" / "preload.csv", process)
    process.send_signal(signal.SIGINT)
    with pytest.raises(subprocess.TimeoutExpired):
        process.communicate(timeout=1.5)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=300)
    assert process.returncode == 130 and read_record(folder)["state"] == "interrupted" and not engines_of(folder)


def unfinish(folder, cycles):
    """Make a copy of a finished run what it was after `cycles` cycles, when it was killed."""
    rows = (folder / "cycles.csv").read_text().splitlines(keepends=True)
    (folder / "cycles.csv").write_text("".join(rows[: cycles + 1]))
    for checkpoint in checkpoints.listed(folder / "checkpoints"):
        if checkpoint.cycle > cycles:
            checkpoint.delete()
    for later in range(cycles + 1, CYCLES + 1):
        (folder / "raw" / f"bed_cycle_{later:06d}.csv").unlink(missing_ok=True)
    (folder / "run.json").write_text((folder / "run.json").read_text().replace('"finished"', '"running"'))


@pytest.fixture
def two_cycles(tmp_path):
    """A run of two cycles: (results, folder). Its checkpoints are those after cycles 0, 1 and 2."""
    done = drive(FAKE, *LINEAR[:-1], 2, "--results", tmp_path)
    assert done.returncode == 0, done.stderr
    return tmp_path, run_folder(tmp_path, "linear-mu0.8", "yade")


def test_a_damaged_checkpoint_is_named_and_the_one_before_is_used(undisturbed, two_cycles):
    results, folder = two_cycles
    unfinish(folder, 2)
    bad = latest(folder)
    damage(bad.path)
    done = drive(FAKE, *LINEAR, "--results", results)
    assert done.returncode == 0 and f"checkpoints/{bad.path.name} is damaged" in done.stdout
    assert read_record(folder)["resumes"] == [{"stage": "cyclic", "cycle": 1, "block": 0}]
    assert results_of(folder) == results_of(undisturbed)
    assert_no_gap(folder)


def test_a_checkpoint_without_its_checksum_does_not_count(undisturbed, two_cycles):
    results, folder = two_cycles
    unfinish(folder, 2)
    latest(folder).sidecar.unlink()
    assert drive(FAKE, *LINEAR, "--results", results).returncode == 0
    assert read_record(folder)["resumes"] == [{"stage": "cyclic", "cycle": 1, "block": 0}]
    assert results_of(folder) == results_of(undisturbed)


def test_a_preloaded_bed_without_a_cycle_is_preloaded_again_where_its_checkpoint_is_damaged(undisturbed, tmp_path):
    folder = run_folder(tmp_path, "linear-mu0.8", "yade")
    assert drive(FAKE, *LINEAR, "--results", tmp_path, "--until", "preload").returncode == 0
    damage(latest(folder).path)
    done = drive(FAKE, *LINEAR, "--results", tmp_path)
    assert done.returncode == 0 and "is damaged" in done.stdout and "preload done" in done.stdout
    assert results_of(folder) == results_of(undisturbed)


# ---------------------------------------------------------------------- results that exist


def everything(folder):
    """All files of a run but the lock, whose content is who had it last."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.name not in ("run.lock", "packing.lock"))
    return {path: path.read_bytes() for path in files}


def lose_checkpoints(folder):
    shutil.rmtree(folder / "checkpoints")


def lose_checksums(folder):
    for path in folder.glob("checkpoints/*.json"):
        path.unlink()


def damage_last(folder):
    damage(latest(folder).path)


def damage_all(folder):
    for checkpoint in checkpoints.listed(folder / "checkpoints"):
        damage(checkpoint.path)


def lose_raw(folder):
    shutil.rmtree(folder / "raw")


def lose_raw_rows(folder):
    (folder / "raw" / "cyclic.csv").unlink()


def lose_bed_and_checkpoints(folder):
    (folder / "raw" / "bed_packed.csv").unlink()
    shutil.rmtree(folder / "checkpoints")


LOSSES = (
    lose_checkpoints,
    lose_checksums,
    damage_last,
    damage_all,
    lose_raw,
    lose_raw_rows,
    lose_bed_and_checkpoints,
)


@pytest.mark.parametrize("lose", LOSSES)
def test_more_cycles_of_a_finished_run_that_cannot_go_on_are_refused_and_nothing_is_lost(finished, lose):
    results, folder = finished
    lose(folder)
    before = everything(folder)
    done = drive(FAKE, *LINEAR[:-1], CYCLES + 2, "--results", results)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1, done.stderr
    assert "REDO=yes" in done.stderr and everything(folder) == before
    assert "finished already" in drive(FAKE, *LINEAR, "--results", results).stdout  # what it has, it still has


def test_only_when_told_cycles_are_computed_again(undisturbed, finished):
    results, folder = finished
    damage_all(folder)
    unfinish(folder, 4)
    refused = drive(FAKE, *LINEAR, "--results", results)
    assert refused.returncode == 1 and "would drop 4 of 4 cycles" in refused.stderr
    done = drive(FAKE, *LINEAR, "--results", results, "--redo")
    assert done.returncode == 0 and "preload done" in done.stdout
    assert results_of(folder) == results_of(undisturbed)


def test_a_finished_run_needs_only_its_normalised_files_and_no_right_to_write(finished):
    results, folder = finished
    for name in ("raw", "checkpoints", "log"):
        shutil.rmtree(folder / name)
    for name in ("run.lock", "packing.lock", "parameters.in"):
        (folder / name).unlink(missing_ok=True)
    for path in (*folder.iterdir(), folder):
        path.chmod(0o555 if path.is_dir() else 0o444)
    before = everything(folder)
    done = drive(FAKE, *LINEAR, "--results", results)
    assert done.returncode == 0 and f"finished already: {CYCLES} cycles" in done.stdout
    assert everything(folder) == before and not (folder / "run.lock").exists()
    folder.chmod(0o755)


@pytest.mark.parametrize("tear", [1, 5, 40])
def test_a_torn_last_row_is_no_cycle(undisturbed, finished, tear):
    results, folder = finished
    unfinish(folder, CYCLES)
    rows = (folder / "cycles.csv").read_bytes()
    (folder / "cycles.csv").write_bytes(rows[:-tear])
    assert cycles_done(folder) == CYCLES - 1
    assert drive(FAKE, *LINEAR, "--results", results).returncode == 0
    assert results_of(folder) == results_of(undisturbed)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda text: "\ufeff" + text,
        lambda text: text.replace(",", ";"),
        lambda text: text.replace("\n2,", "\nrubbish\n2,"),
        lambda text: text.replace("\n2,", "\n3,"),
        lambda text: text.replace("\n2,", "\n,"),
    ],
)
def test_a_damaged_table_of_cycles_is_refused_and_left_as_it_is(finished, spoil):
    results, folder = finished
    unfinish(folder, CYCLES)
    (folder / "cycles.csv").write_text(spoil((folder / "cycles.csv").read_text()))
    before = everything(folder)
    done = drive(FAKE, *LINEAR[:-1], CYCLES + 1, "--results", results)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1 and "cycles.csv: line" in done.stderr
    assert everything(folder) == before


@pytest.mark.parametrize("content", ["", "[]", '{"state": "finished"}', "{", "null"])
def test_a_damaged_record_is_refused_and_left_as_it_is(finished, content):
    results, folder = finished
    (folder / "run.json").write_text(content)
    before = everything(folder)
    done = drive(FAKE, *LINEAR[:-1], CYCLES + 1, "--results", results)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1, done.stderr
    assert f"{folder}/run.json" in done.stderr and "restore" in done.stderr and everything(folder) == before


def test_more_cycles_extend_a_finished_run(finished, tmp_path):
    results, folder = finished
    done = drive(FAKE, *LINEAR[:-1], CYCLES + 2, "--results", results)
    assert done.returncode == 0 and "goes on from cycle 4 of 6" in done.stdout
    other = tmp_path / "at once"
    assert drive(FAKE, *LINEAR[:-1], CYCLES + 2, "--results", other).returncode == 0
    at_once = run_folder(other, "linear-mu0.8", "yade")
    assert (folder / "cycles.csv").read_bytes() == (at_once / "cycles.csv").read_bytes()
    assert_no_gap(folder, CYCLES + 2)
    assert "finished already" in drive(FAKE, *LINEAR, "--results", results).stdout  # fewer are there as well


def test_without_a_number_of_cycles_a_run_goes_on_to_where_it_was_going(finished):
    results, folder = finished
    assert drive(FAKE, *LINEAR[:-1], CYCLES + 3, "--results", results).returncode == 0
    (folder / "raw" / f"bed_cycle_{CYCLES + 3:06d}.csv").unlink()
    (folder / "run.json").write_text((folder / "run.json").read_text().replace('"finished"', '"running"'))
    done = drive(FAKE, *LINEAR[:-2], "--results", results)  # the demo's own 5 are fewer
    assert done.returncode == 0 and f"finished: {CYCLES + 3} cycles" in done.stdout
    assert_no_gap(folder, CYCLES + 3)


def variant(tmp_path, key, value):
    """A scenario file that differs in one value."""
    path = tmp_path / "scenarios.toml"
    path.write_text(set_value((ROOT / "scenarios.toml").read_text(), key, value))
    return path


def test_a_changed_scenario_is_refused_with_the_difference(finished, tmp_path):
    results, folder = finished
    before = results_of(folder)
    path = variant(tmp_path, "relax_steps", "12345")
    done = drive(FAKE, *LINEAR, "--results", results, "--scenarios", path)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1
    assert "packing.relax_steps: " in done.stderr and " -> 12345" in done.stderr and "make distclean-run" in done.stderr
    assert results_of(folder) == before


def test_a_changed_limit_of_the_watch_is_no_change_of_the_bed(finished, tmp_path):
    results, _ = finished
    path = variant(tmp_path, "overlap_ratio", "0.3")
    assert drive(FAKE, *LINEAR, "--results", results, "--scenarios", path).returncode == 0


def test_a_bed_that_is_only_packed_serves_another_load(tmp_path):
    arguments = (*LINEAR, "--results", tmp_path)
    assert drive(FAKE, *arguments, "--until", "packing").returncode == 0
    lighter = variant(tmp_path, "sleeper_mass", "5.0")
    done = drive(FAKE, *arguments, "--scenarios", lighter)
    assert done.returncode == 0, done.stderr
    folder = run_folder(tmp_path, "linear-mu0.8", "yade")
    assert json.loads((folder / "scenario.json").read_text())["parameters"]["load_control.sleeper_mass"]["value"] == 5.0
    rougher = drive(FAKE, *arguments, "--scenarios", variant(tmp_path, "compaction_friction", "0.6"))
    assert rougher.returncode == 1 and "packing.compaction_friction: 0.5 -> 0.6" in rougher.stderr


def test_another_bed_is_refused(finished, undisturbed):
    results, _ = finished
    done = drive(FAKE, *LINEAR, "--results", results, "--bed", undisturbed / "raw" / "bed_packed.csv")
    assert done.returncode == 1 and "bed: own -> bed_packed.csv" in done.stderr


HEADER = ",".join(file_columns.BED)


@pytest.mark.parametrize(
    "text, said",
    [
        (None, "No such file"),
        ("", "line 1 is not id,x_m"),
        (HEADER + "\n", "holds no clumps"),
        ("x,y,z\n1,2,3\n", "line 1 is not id,x_m"),
        (HEADER + "\n1,0.1,0.05,0.1,1,0,0,soft\n", "line 2 is no clump"),
        (HEADER + "\n1,0.1,0.05,0.1,1,0,0\n", "line 2 is no clump"),
        (HEADER + "\n1,0.1,0.05,0.1,2,0,0,0\n", "line 2 has a quaternion of length 2"),
        (HEADER + "\n1,0.1,0.05,0.1,1,0,0,0\n1,0.1,0.05,0.2,1,0,0,0\n", "line 3 gives clump 1 again"),
        (HEADER + "\n1,0.6,0.05,0.1,1,0,0,0\n2,0.6,0.61,0.1,1,0,0,0\n", "line 3 lies outside the box"),
        (HEADER + "\n1,0.1,0.05,nan,1,0,0,0\n", "line 2: z_m"),
    ],
)
def test_a_file_that_is_no_bed_is_refused(tmp_path, text, said):
    path = tmp_path / "bed.csv"
    if text is not None:
        path.write_text(text)
    done = drive(FAKE, *LINEAR, "--results", tmp_path / "results", "--bed", path)
    assert done.returncode == 1 and said in done.stderr and len(done.stderr.splitlines()) == 1


BOX = derived.apparatus(load_scenario("linear-mu0.8", "demo"))
IN_THE_SLEEPER = [(low + high) / 2 for low, high in zip(BOX.sleeper.low, BOX.sleeper.high, strict=True)]


@pytest.mark.parametrize(
    "places, said",
    [
        ([(0.6, 0.3, 0.1), IN_THE_SLEEPER], "line 3 lies inside the sleeper"),
        ([(0.6, 0.3, 0.1), (0.7, 0.3, 0.1), (0.6, 0.3, 0.1)], "line 4 overlaps the clump of line 2"),
        ([(0.6, 0.3, 0.1), (0.602, 0.3, 0.1)], "line 3 overlaps the clump of line 2 by more than 0.5 of the radius"),
        ([(0.6, 0.3, 0.1), (0.6, -0.001, 0.1)], "line 3 lies outside the box"),
    ],
)
def test_a_bed_that_stones_cannot_form_is_refused_with_its_line(tmp_path, places, said):
    path = tmp_path / "bed.csv.gz"
    rows = "".join(",".join(map(str, (n, *at, 1, 0, 0, 0))) + "\n" for n, at in enumerate(places, start=1))
    path.write_bytes(gzip.compress((HEADER + "\n" + rows).encode()))
    done = drive(FAKE, *LINEAR, "--results", tmp_path / "results", "--bed", path)
    assert done.returncode == 1 and said in done.stderr and len(done.stderr.splitlines()) == 1, done.stderr


@pytest.mark.parametrize("text", ["[]", '{"name": "x"', "", None])
def test_a_scenario_that_cannot_be_read_beside_a_bed_is_named_in_one_line(undisturbed, tmp_path, text):
    bed = tmp_path / "other" / "raw" / "bed_packed.csv"
    bed.parent.mkdir(parents=True)
    shutil.copy(undisturbed / "raw" / "bed_packed.csv", bed)
    beside = tmp_path / "other" / "scenario.json"
    beside.write_text(text) if text is not None else beside.mkdir()
    done = drive(FAKE, *LINEAR, "--results", tmp_path / "results", "--bed", bed)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1, done.stderr
    assert f"{beside}: " in done.stderr and "move the bed file elsewhere" in done.stderr


def test_a_bed_of_other_clumps_is_refused(undisturbed, tmp_path):
    path = variant(tmp_path, "aspect", "1.5")
    done = drive(
        FAKE, *LINEAR, "--results", tmp_path, "--scenarios", path, "--bed", undisturbed / "raw" / "bed_packed.csv"
    )
    assert done.returncode == 1 and re.search(r"clump.aspect: [\d.]+ -> 1.5;", done.stderr)


def test_two_runs_that_need_one_bed_pack_it_once(tmp_path):
    both = [
        start(FAKE, name, "--code", "yade", "--cycles", 1, "--results", tmp_path)
        for name in ("nonlinear-en1.0", "nonlinear-md1-en0.6", "linear-mu0.8")
    ]
    said = [process.communicate(timeout=300) for process in both]
    assert [process.returncode for process in both] == [0, 0, 0], said
    assert "".join(out for out, _ in said).count("packing done") == 1
    beds = {
        (run_folder(tmp_path, name, "yade") / "raw" / "bed_packed.csv").read_bytes()
        for name in ("linear-mu0.8", "nonlinear-en1.0", "nonlinear-md1-en0.6")
    }
    assert len(beds) == 1
    body = read_record(run_folder(tmp_path, "nonlinear-en1.0", "yade"))
    assert body["bed"] == "../../linear-mu0.8/yade/raw/bed_packed.csv"


def test_a_run_in_progress_is_refused_to_others(tmp_path):
    first = start(FAKE, *LINEAR, "--results", tmp_path)
    wait_for(run_folder(tmp_path, "linear-mu0.8", "yade") / "raw" / "preload.csv", first)
    second = drive(FAKE, *LINEAR, "--results", tmp_path)
    assert (
        second.returncode == 1
        and f"in progress already, process {first.pid} on {socket.gethostname()}" in second.stderr
    )
    first.communicate(timeout=300)
    assert first.returncode == 0


@pytest.mark.parametrize(
    "behaviour, reason",
    [
        ("error", "ERROR: packing: not at rest after 1 s"),
        ("crash", "the engine was killed by SIGSEGV; read packing.log"),
        ("nothing", "yade ended without raw/bed_packed.csv"),
        ("overlap", "diverged: overlap of 0.3 sphere radii"),
        ("gap", "diverged: raw/cyclic.csv: row of step"),
        ("nan", "diverged: kinetic_energy_J is nan at step"),
    ],
)
def test_a_failure_has_a_reason_an_exit_code_and_keeps_what_is_good(tmp_path, behaviour, reason):
    folder = run_folder(tmp_path, "linear-mu0.8", "yade")
    folder.mkdir(parents=True)
    (folder / "behave").write_text(behaviour)
    done = drive(FAKE, *LINEAR, "--results", tmp_path)
    assert done.returncode == 1 and reason in done.stderr and len(done.stderr.splitlines()) == 1
    body = read_record(folder)
    assert body["state"] == "failed" and reason in body["reason"] and not engines_of(folder)
    if behaviour in ("overlap", "nan"):
        assert latest(folder).cycle == 2 and latest(folder).is_good()
    (folder / "behave").write_text("well")
    assert drive(FAKE, *LINEAR, "--results", tmp_path).returncode == 0  # mended, it goes on
    assert_no_gap(folder)


def test_two_runs_that_start_in_the_same_instant_are_one(tmp_path):
    both = [start(FAKE, *LINEAR, "--results", tmp_path) for _ in range(2)]
    said = [process.communicate(timeout=300) for process in both]
    assert sorted(process.returncode for process in both) == [0, 1], said
    assert any("in progress already, process" in err for _, err in said)
    assert_no_gap(run_folder(tmp_path, "linear-mu0.8", "yade"))


def test_a_run_whose_reader_goes_away_goes_on_in_silence(tmp_path):
    process = start(FAKE, *LINEAR, "--results", tmp_path)
    process.stdout.close()  # as `make run | head` does
    _, err = process.communicate(timeout=300)
    assert (process.returncode, err) == (0, "")
    assert read_record(run_folder(tmp_path, "linear-mu0.8", "yade"))["state"] == "finished"


def test_where_a_file_system_has_no_locks_a_run_is_still_refused_to_others(tmp_path):
    first = start(NO_LOCKS, *LINEAR, "--results", tmp_path)
    folder = run_folder(tmp_path, "linear-mu0.8", "yade")
    wait_for(folder / "raw" / "preload.csv", first)
    second = drive(NO_LOCKS, *LINEAR, "--results", tmp_path)
    assert (
        second.returncode == 1
        and f"in progress already, process {first.pid} on {socket.gethostname()}" in second.stderr
    )
    assert first.communicate(timeout=300) and first.returncode == 0
    assert_no_gap(folder)
    assert "finished already" in drive(NO_LOCKS, *LINEAR, "--results", tmp_path).stdout


needs_git = pytest.mark.skipif(not shutil.which("git"), reason="git is not installed")


def git(folder, *words):
    return subprocess.run(["git", "-C", folder, *words], check=True, capture_output=True, text=True).stdout.strip()


@needs_git
def test_a_copy_inside_another_repository_does_not_take_its_commit(tmp_path, monkeypatch):
    git(tmp_path, "init", "-q")
    git(tmp_path, "-c", "user.name=a", "-c", "user.email=a@b", "commit", "-q", "--allow-empty", "-m", "other")
    monkeypatch.setattr(provenance, "ROOT", tmp_path)
    assert provenance.git_state() == {"git_commit": git(tmp_path, "rev-parse", "HEAD"), "git_dirty": False}
    (tmp_path / "unpacked").mkdir()
    for root in (tmp_path / "unpacked", tmp_path / "nowhere"):
        monkeypatch.setattr(provenance, "ROOT", root)
        found = provenance.git_state()
        assert found["git_commit"].startswith("unknown (release ") and found["git_dirty"] is None
        assert provenance.short_commit(found["git_commit"]) == found["git_commit"]
    monkeypatch.setenv("GIT_DIR", str(tmp_path / ".git"))  # as a hook would set it
    assert provenance.git_state()["git_commit"].startswith("unknown")


@needs_git
def test_a_shallow_clone_knows_its_commit(tmp_path, monkeypatch):
    git(tmp_path, "init", "-q", "origin")
    for name in ("first", "second"):
        author = ("-c", "user.name=a", "-c", "user.email=a@b")
        git(tmp_path / "origin", *author, "commit", "-q", "--allow-empty", "-m", name)
    git(tmp_path, "clone", "-q", "--depth", "1", f"file://{tmp_path}/origin", "shallow")
    assert git(tmp_path / "shallow", "rev-list", "--count", "HEAD") == "1"
    monkeypatch.setattr(provenance, "ROOT", tmp_path / "shallow")
    found = provenance.git_state()
    assert found == {"git_commit": git(tmp_path / "origin", "rev-parse", "HEAD"), "git_dirty": False}


@needs_git
def test_a_result_kept_in_the_clone_does_not_make_the_program_a_changed_one(tmp_path, monkeypatch):
    git(tmp_path, "init", "-q")
    for name in ("program", "reference_data/kept.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("before\n")
    git(tmp_path, "add", ".")
    git(tmp_path, "-c", "user.name=a", "-c", "user.email=a@b", "commit", "-q", "-m", "first")
    monkeypatch.setattr(provenance, "ROOT", tmp_path)

    def dirty(**options):
        return provenance.git_state(**options)["git_dirty"]

    (tmp_path / "reference_data" / "kept.csv").write_text("after\n")
    assert dirty() and not dirty(beside=("reference_data",))
    (tmp_path / "program").write_text("after\n")
    assert dirty() and dirty(beside=("reference_data",))


def test_every_part_of_a_run_says_what_did_it_and_only_equal_parts_are_repeatable(tmp_path):
    folder = run_folder(tmp_path, "linear-mu0.8", "yade")
    arguments = (*LINEAR, "--results", tmp_path)
    assert drive(FAKE, *arguments, "--until", "preload").returncode == 0
    body = read_record(folder)
    assert [part["stage"] for part in body["parts"]] == ["packing", "preload"] and body["repeatable"] is True
    assert {(part["engine"], part["ranks"], part["host"]) for part in body["parts"]} == {
        ("fake 1", 1, socket.gethostname())
    }
    done = drive(FAKE, *arguments, "--ranks", 2)
    body = read_record(folder)
    assert done.returncode == 0 and [part["ranks"] for part in body["parts"]] == [1, 1, 2]
    assert body["repeatable"] is False and any("2 ranks or threads" in sentence for sentence in body["deviations"])
    assert drive(FAKE, *LINEAR[:-1], CYCLES + 1, "--results", tmp_path).returncode == 0
    body = read_record(folder)
    assert [(part["cycle"], part["ranks"]) for part in body["parts"]] == [(0, 1), (0, 1), (0, 2), (CYCLES, 1)]
    assert body["repeatable"] is False and any("2 ranks or threads" in sentence for sentence in body["deviations"])


def test_parts_by_other_programs_are_not_repeatable():
    part = {"engine": "fake 1", "git_commit": "a" * 40, "git_dirty": False, "ranks": 1, "threads": 1, "host": "here"}
    assert provenance.is_repeatable([part, part | {"host": "there"}])
    for change in ({"engine": "fake 2"}, {"git_commit": "b" * 40}, {"threads": 2}, {"ranks": 2}):
        assert not provenance.is_repeatable([part, part | change])


def test_a_clump_that_leaves_ends_the_run_in_one_line(tmp_path):
    folder = run_folder(tmp_path, "linear-mu0.8", "yade")
    folder.mkdir(parents=True)
    (folder / "behave").write_text("loss")
    done = drive(FAKE, *LINEAR, "--results", tmp_path)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1
    assert "1 of 2 clumps left the simulated space before step" in done.stderr
    assert read_record(folder)["state"] == "failed" and cycles_done(folder) == 2


def test_a_place_that_cannot_be_written_is_one_line_with_a_remedy(tmp_path):
    (tmp_path / "file").write_text("")
    done = drive(FAKE, *LINEAR, "--results", tmp_path / "file")
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1
    assert "Not a directory; " in done.stderr and "None" not in done.stderr
    line = unusable(PermissionError(errno.EACCES, os.strerror(errno.EACCES), "/x"))  # root is refused nothing
    assert line == "/x: Permission denied; give yourself the right to write there, or another RESULTS"


@pytest.mark.parametrize("code, commands", [("yade", 3), ("liggghts", 3)])
def test_a_prepared_run_starts_nothing_and_its_deck_tells_what_each_value_is(tmp_path, code, commands):
    ballast = (FAKE[0], "-m", "analysis", "prepare")
    done = drive(ballast, "linear-mu0.8", "--code", code, "--results", tmp_path)
    folder = run_folder(tmp_path, "linear-mu0.8", code)
    said = done.stdout.splitlines()[1:]
    assert done.returncode == 0 and len(said) == commands, done.stderr
    for stage, line in zip(("packing", "preload", "cyclic"), said, strict=True):
        assert f"{code}/{stage}." in line and str(folder) in line
    assert (folder / "raw" / "bed_start.csv").exists() and not (folder / "raw" / "state.csv").exists()
    if code == "liggghts":
        lines = (folder / "parameters.in").read_text().splitlines()
        assert "# [contact.particle_particle]" in lines and all(len(line) < 2000 for line in lines)
        (friction,) = [line for line in lines if line.startswith("variable contact_particle_particle_friction ")]
        assert friction.split("#")[1].strip() == "-, reported: Table 1"
    again = drive(FAKE, "linear-mu0.8", "--code", code, "--cycles", 1, "--results", tmp_path)
    assert again.returncode == 0, again.stderr


@pytest.mark.parametrize("kept", [("cycles.csv",), ("raw", "checkpoints")])
def test_a_run_that_has_results_is_not_prepared_again(finished, kept):
    results, folder = finished
    for path in folder.iterdir():
        if path.name not in (*kept, "run.json", "scenario.json"):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    before = everything(folder)
    done = drive((FAKE[0], "-m", "analysis", "prepare"), "linear-mu0.8", "--code", "yade", "--results", results)
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1 and "another SEED or RESULTS" in done.stderr
    assert everything(folder) == before


def test_a_run_that_takes_a_bed_is_prepared_with_it(finished, tmp_path):
    results, _ = finished
    ballast = (FAKE[0], "-m", "analysis", "prepare")
    done = drive(ballast, "nonlinear-en1.0", "--code", "yade", "--results", results)
    folder = run_folder(results, "nonlinear-en1.0", "yade")
    assert done.returncode == 0 and [f"yade/{stage}.py" in done.stdout for stage in ("packing", "preload")] == [
        False,
        True,
    ]
    assert (folder / "raw" / "bed_packed.csv").exists()
    refused = drive(ballast, "nonlinear-en1.0", "--code", "liggghts", "--results", results)
    assert refused.returncode == 1 and "bed_packed.csv" in refused.stderr and len(refused.stderr.splitlines()) == 1


def test_a_missing_engine_is_one_line(tmp_path):
    done = drive((FAKE[0], "-m", "analysis", "run"), *LINEAR, "--results", tmp_path, env={"PATH": str(tmp_path)})
    assert (done.returncode, done.stderr) == (1, "yade: not installed; run `make setup`\n")
    assert not list(tmp_path.iterdir())


def test_until_pauses_after_a_stage_and_goes_on(tmp_path, undisturbed):
    folder = run_folder(tmp_path, "linear-mu0.8", "yade")
    for stage, product in (("packing", "raw/bed_packed.csv"), ("preload", "checkpoints/cyclic_000000.yade.gz")):
        assert drive(FAKE, *LINEAR, "--results", tmp_path, "--until", stage).returncode == 0
        assert (folder / product).exists() and read_record(folder)["state"] == "interrupted"
    assert drive(FAKE, *LINEAR, "--results", tmp_path).returncode == 0
    assert results_of(folder) == results_of(undisturbed)


HOURS_AGO = (
    FAKE[0],
    "-c",
    f"import datetime, runpy, sys, time\nsys.path.insert(0, {str(ROOT)!r}); sys.argv[0] = {FAKE[1]!r}\n"
    "real = time.time\n"
    "time.time = lambda: real() - 36000\n"
    "class Early(datetime.datetime):\n"
    "    now = classmethod(lambda cls, tz=None: cls.fromtimestamp(time.time(), tz))\n"
    "from analysis.driver import provenance\nprovenance.datetime = Early\n"
    f"runpy.run_path({FAKE[1]!r}, run_name='__main__')",
)


def test_a_clock_that_was_set_back_changes_nothing(undisturbed, tmp_path):
    """A run that goes on hours before it began; what it has done is told from its products, never from times."""
    folder = run_folder(tmp_path, "linear-mu0.8", "yade")
    arguments = (*LINEAR, "--results", tmp_path)
    process = start(FAKE, *arguments)
    wait_for(folder / "raw" / "bed_cycle_000001.csv", process)
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=300)
    began = read_record(folder)["timing"]
    assert drive(HOURS_AGO, *arguments).returncode == 0
    assert read_record(folder)["timing"]["end"] < began["start"] == read_record(folder)["timing"]["start"]
    assert results_of(folder) == results_of(undisturbed)
    assert_no_gap(folder)
    table = drive((FAKE[0], "-m", "analysis"), "status", "--results", tmp_path)
    assert table.returncode == 0 and "finished" in table.stdout


def test_a_run_does_not_depend_on_locale_or_temporary_folder(undisturbed, tmp_path):
    odd = {"LC_ALL": "C", "LANG": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0", "TMPDIR": "/nonexistent"}
    results = tmp_path / "n\u00e4chste"
    done = drive(FAKE, *LINEAR, "--results", results, env=os.environ | odd)
    assert done.returncode == 0, done.stderr
    assert results_of(run_folder(results, "linear-mu0.8", "yade")) == results_of(undisturbed)
