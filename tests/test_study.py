"""The list of the study, and how make works through it."""

import subprocess

import pytest
from bare_run import write_run

from analysis.__main__ import main as ballast
from analysis.driver import status
from analysis.driver import study as command
from analysis.driver.folder import run_folder
from analysis.scenarios import study_list
from analysis.scenarios.scenario import SCENARIO_FILE, ScenarioError, load_scenario, scenario_names, split_id

ROWS = study_list.rows()


def asked(code, seed=1, cycles=None):
    """Ids that the list asks for, at least so many cycles."""
    return {r.scenario for r in ROWS if (r.code, r.seed) == (code, seed) and (cycles is None or r.cycles >= cycles)}


def folder(results, row):
    return run_folder(results, "full", row.scenario, row.code, row.seed)


def make_run(results, row, cycles, state="finished", reason=""):
    """A run's folder as far as the list looks at it."""
    peak = 460e3 if state == "finished" else 300e3
    rows = [
        {"cycle": n, "sleeper_stress_min_Pa": 50e3, "sleeper_stress_max_Pa": peak, "tracking_rms_Pa": 100.0}
        for n in range(1, cycles + 1)
    ]
    scenario = load_scenario(row.scenario, cycles=row.cycles)
    return write_run(folder(results, row), scenario, row.code, rows, seed=row.seed, state=state, reason=reason)


# ------------------------------------------------------------------ the list


def test_every_scenario_of_the_paper_is_asked_for_in_both_readings_first():
    paper = scenario_names(group="paper")
    assert len(paper) == 14
    both = {f"{name}{variant}" for name in paper for variant in ("", "+servo")}
    assert {r.scenario for r in ROWS[:28]} == both
    assert all((r.code, r.seed, r.cycles) == ("liggghts", 1, 100) for r in ROWS[:28])


def test_long_runs_seeds_and_yade_are_in_the_list():
    assert asked("liggghts", cycles=1000) == {"nonlinear-en1.0+servo", "linear-mu0.8", "nonlinear-en1.0"}
    names = ["linear-mu0.8", "nonlinear-en1.0", *(f"nonlinear-md{mode}-en0.6" for mode in range(3))]
    for seed in (2, 3):
        assert asked("liggghts", seed) == {f"{name}{variant}" for name in names for variant in ("", "+servo")}
    assert {"nonlinear-en1.0", "nonlinear-en1.0+servo", "linear-mu0.8"} == asked("yade", cycles=100)
    assert {f"{name}+same-bed{v}" for name in names for v in ("", "+servo")} < asked("yade", cycles=20)


def test_all_runs_of_a_seed_share_one_packed_bed_unless_they_pack_something_else():
    own = {(r.scenario, r.code) for r in ROWS if r.bed == "own"}
    packed = ("aspect-", "gap-")
    assert own >= {("linear-mu0.8", "liggghts"), ("linear-mu0.8", "yade")}
    for r in ROWS:
        name, variants = split_id(r.scenario)
        packs = "chen2015" if name == "chen2015" else "linear-mu0.8"  # Chen et al. have more and smaller clumps
        if not any(v.startswith(packed) for v in variants) and r.scenario != packs:
            assert r.bed == f"{packs}/{'liggghts' if 'same-bed' in variants else r.code}", r


def test_no_row_is_there_twice_and_every_row_has_a_name_of_its_own():
    assert len({r.name for r in ROWS}) == len(ROWS) == len({(r.run, r.cycles) for r in ROWS})
    final = study_list.final_rows()
    assert len({r.run for r in final}) == len(final) == len({r.run for r in ROWS})
    most = {r.run: max(other.cycles for other in ROWS if other.run == r.run) for r in ROWS}
    assert all(r.cycles == most[r.run] for r in final)


@pytest.mark.parametrize(
    "old, new, words",
    [
        ('variants  = ["paper-step"]', 'variants  = ["papers-step"]', ["variant 'papers-step' is unknown"]),
        ('codes     = ["yade"]', 'codes     = ["pfc"]', ["codes = 'pfc'", "yade, liggghts"]),
        ("seeds     = [2, 3]", "seeds     = [0]", ["seeds = 0", "whole numbers above 0"]),
        ("cycles    = 1000", "cycle     = 1000", ["cycle = 1000", "one of title, scenarios"]),
        ('scenarios = ["nonlinear-md1-en0.6"]', 'scenarios = ["nonlinear"]', ["scenarios = 'nonlinear'"]),
    ],
)
def test_a_bad_row_is_refused_in_one_line(tmp_path, old, new, words):
    text = SCENARIO_FILE.read_text()
    assert old in text
    path = tmp_path / "mine.toml"
    path.write_text(text.replace(old, new))
    with pytest.raises(ScenarioError) as caught:
        study_list.rows(path)
    message = str(caught.value)
    assert message.startswith("mine.toml: ") and "\n" not in message and all(word in message for word in words)


# ------------------------------------------------------------------ make's queue


def test_make_starts_the_rows_in_order_and_longer_runs_after_the_shorter_ones(tmp_path):
    rules = command.makefile(ROWS, "echo")
    done = subprocess.run(
        ["make", "--no-print-directory", "-f", "-", "study"], input=rules, capture_output=True, text=True, check=True
    )
    assert [line.split()[-1] for line in done.stdout.splitlines()] == [r.name for r in ROWS]
    long = next(r for r in ROWS if r.run == ("nonlinear-en1.0+servo", "liggghts", 1) and r.cycles == 1000)
    alone = subprocess.run(
        ["make", "--no-print-directory", "-f", "-", long.name], input=rules, capture_output=True, text=True, check=True
    )
    assert [line.split()[-1] for line in alone.stdout.splitlines()] == [
        long.name.replace("1000cycles", "100cycles"),
        long.name,
    ]


def test_a_row_that_is_done_answers_at_once(tmp_path, capsys):
    row = ROWS[0]
    where = make_run(tmp_path, row, cycles=1000)
    before = {path.name: path.read_bytes() for path in where.iterdir()}
    assert ballast(["study", "--row", row.name, "--results", str(tmp_path)]) == 0
    assert "done: 1000 cycles" in capsys.readouterr().out
    assert {path.name: path.read_bytes() for path in where.iterdir()} == before


def test_a_run_that_diverged_is_a_result_and_one_that_failed_otherwise_is_tried_again(tmp_path):
    row = ROWS[0]
    where = make_run(tmp_path, row, 40, "failed", "diverged: sleeper through the floor: 0.33 m down")
    assert "ended after 40 of 100 cycles, which is a result: diverged: sleeper" in command.settled(where, row.cycles)
    other = make_run(tmp_path, ROWS[1], 40, "failed", "no space left for x; free some")
    assert command.settled(other, ROWS[1].cycles) == ""


def test_an_unknown_row_is_refused(tmp_path, capsys):
    assert ballast(["study", "--row", "mine", "--results", str(tmp_path)]) == 2
    assert ballast(["study", "--array", "1000", "--results", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("no such row") == 2


def test_status_shows_how_far_the_list_is(tmp_path, capsys):
    make_run(tmp_path, ROWS[0], cycles=100)
    make_run(tmp_path, ROWS[1], 40, "failed", "diverged: thrown")
    assert ballast(["status", "--results", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    (first,) = [line for line in lines if line.startswith("1. Both readings")]
    assert first.split()[-3:] == ["1/28", "1", "140/2800"]


# ------------------------------------------------------------------ a load that is not reached


def test_status_says_what_the_load_swung_between_where_it_is_not_reached(tmp_path):
    where = make_run(tmp_path, ROWS[0], 40, "running")
    row = status.row(where)
    assert row["scenario"] == "nonlinear-en1.0+servo"
    assert row["reason"].endswith("load not reached: 50 to 300 instead of 50 to 460 kPa in cycle 40")
    reached = make_run(tmp_path, ROWS[1], 40)
    assert status.row(reached)["reason"] == ""
