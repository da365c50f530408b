"""The table of all runs."""

import pytest
from bare_run import write_run
from driver import run_folder

from analysis.__main__ import main as ballast
from analysis.driver import status
from analysis.driver.locks import hold
from analysis.formats import file_columns
from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario

SCENARIO = load_scenario("nonlinear-en1.0", "demo")


def make(results, code, state, cycles=2, **more):
    """A run's folder, as far as the status needs it."""
    steps = derived.time_grid(SCENARIO).steps_per_cycle
    rows = [
        {"cycle": n, "tracking_rms_Pa": 1000 * (cycles + 1 - n), "sleeper_stress_max_Pa": 460e3}
        for n in range(1, cycles + 1)
    ]
    more |= {"state": state, "steps": {"cyclic": cycles * steps}}
    return write_run(run_folder(results, SCENARIO.name, code), SCENARIO, code, rows, speed=steps / 10, **more)


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


@pytest.mark.parametrize(
    "name, content, said",
    [
        ("run.json", "{", "run.json: is damaged"),
        ("run.json", "[]", "run.json: is damaged (it holds no table)"),
        ("run.json", '{"state": "finished"}', "run.json: timing = null is refused"),
        ("scenario.json", "[]", "scenario.json: is damaged (it holds no table)"),
        ("scenario.json", '{"name": "linear', "scenario.json: is damaged"),
        ("cycles.csv", "\ufeffcycle\n", "cycles.csv: line 1 holds bytes that are no text"),
        ("cycles.csv", "cycle;time_s\n1;2\n", "cycles.csv: line 1: column cycle is missing"),
        ("cycles.csv", ",".join(file_columns.CYCLES) + "\n1,garbage\n", "cycles.csv: line 2 has 2 values"),
        ("cycles.csv", ",".join(file_columns.CYCLES) + "\n1" + "," * 15 + "\n", 'cycles.csv: line 2: time_s = ""'),
    ],
)
def test_a_damaged_file_does_not_hide_the_other_runs(tmp_path, capsys, name, content, said):
    make(tmp_path, "yade", "finished")
    (make(tmp_path, "liggghts", "finished") / name).write_text(content)
    assert ballast(["status", "--results", str(tmp_path)]) == 0
    _, damaged, good = capsys.readouterr().out.splitlines()
    assert "damaged" in damaged and said in damaged
    assert "yade" in good and "2/5" in good and "finished" in good


@pytest.mark.parametrize(
    "error, code, said",
    [
        (PermissionError(13, "Permission denied", "/x/y.csv"), 1, "/x/y.csv: Permission denied; see to it, "),
        (OSError(28, "No space left on device"), 1, "a file: No space left on device; see to it, "),
        (KeyboardInterrupt(), 130, "stopped"),
    ],
)
def test_whatever_the_system_refuses_ends_any_command_in_one_line(monkeypatch, capsys, error, code, said):
    def execute(_):
        raise error

    monkeypatch.setattr(status, "execute", execute)
    assert ballast(["status"]) == code
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(said)


def test_without_runs_it_says_how_to_make_some(tmp_path, capsys):
    assert ballast(["status", "--results", str(tmp_path)]) == 0
    assert "make demo" in capsys.readouterr().out
