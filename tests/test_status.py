"""The table of all runs."""

import dataclasses

from driver import run_folder

from analysis.__main__ import main as ballast
from analysis.driver import provenance, status
from analysis.driver.locks import hold
from analysis.formats.file_columns import CYCLES, header
from analysis.formats.run_record import RunRecord, Timing
from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario

SCENARIO = load_scenario("nonlinear-en1.0", "demo")


def make(results, code, state, seed=1, cycles=2, **more):
    """A run's folder, as far as the status needs it."""
    folder = run_folder(results, SCENARIO.name, code)
    folder.mkdir(parents=True)
    steps = derived.time_grid(SCENARIO).steps_per_cycle
    record = RunRecord(
        scenario=SCENARIO.name,
        profile="demo",
        code=code,
        scenario_hash=SCENARIO.hash,
        title=SCENARIO.title,
        versions={"engine": "fake 1"},
        command="make run",
        seed=seed,
        bed="own",
        git_commit="0" * 40,
        git_dirty=False,
        ranks=1,
        threads=1,
        state=state,
        reason="",
        stage="cyclic",
        steps={"cyclic": cycles * steps},
        clumps=380,
        deviations=[],
        resumes=[],
        timing=Timing(
            start=provenance.now(),
            steps_per_second={"cyclic": steps / 10},
            pid=1,
            host="here",
            heartbeat=provenance.now(),
        ),
    )
    dataclasses.replace(record, **more).write(folder)
    (folder / "scenario.json").write_text(SCENARIO.to_json())
    rows = [{"cycle": n, "tracking_rms_Pa": 1000 * (cycles + 1 - n)} for n in range(1, cycles + 1)]
    cells = [",".join(str(row.get(name, 460e3)) for name in CYCLES) + "\n" for row in rows]
    (folder / "cycles.csv").write_text(header(CYCLES) + "".join(cells))
    return folder


def test_a_running_run_shows_how_far_it_is(tmp_path):
    with hold(make(tmp_path, "yade", "running") / "run.lock"):
        row = status.row(run_folder(tmp_path, SCENARIO.name, "yade"))
    assert row["state"] == "running" and row["cycle"] == "2/5" and row["time left"] == "0:30"  # 3 cycles of 10 s
    # the worst cycle, not the last
    assert row["tracking %"] == f"{100 * 2000 / 460e3:.2f}"


def test_a_run_that_nobody_runs_was_interrupted(tmp_path):
    folder = make(tmp_path, "yade", "running")
    assert status.row(folder)["state"] == "interrupted" and status.row(folder)["time left"] == ""


def test_a_failure_shows_why(tmp_path, capsys):
    make(tmp_path, "liggghts", "failed", reason="diverged: overlap of 0.3 sphere radii")
    make(tmp_path, "yade", "finished", cycles=5)
    assert ballast(["status", "--results", str(tmp_path)]) == 0
    head, first, second = capsys.readouterr().out.splitlines()
    assert head.split()[:4] == ["profile", "scenario", "code", "seed"]
    assert "liggghts" in first and first.endswith("failed    diverged: overlap of 0.3 sphere radii")
    assert "5/5" in second and second.endswith("finished")


def test_a_run_json_that_cannot_be_read_does_not_hide_the_others(tmp_path, capsys):
    make(tmp_path, "yade", "finished")
    (make(tmp_path, "liggghts", "finished") / "run.json").write_text("{")
    assert ballast(["status", "--results", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "yade" in out and "run.json: is damaged" in out


def test_without_runs_it_says_how_to_make_some(tmp_path, capsys):
    assert ballast(["status", "--results", str(tmp_path)]) == 0
    assert "make demo" in capsys.readouterr().out
