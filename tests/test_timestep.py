"""The table of time steps: what is wanted, what counts as done, what is told of it."""

import math

import pytest
from synthetic import write_run

from analysis.driver import timestep
from analysis.normalised.readers import Run
from analysis.normalised.sleeper_work import sleeper_work
from analysis.scenarios.scenario import load_scenario

NAME, CRITICAL_S = "nonlinear-en1.0", 1.5e-5


def want(case):
    return next(w for w in timestep.wanted(NAME, CRITICAL_S) if w.case == case)


def test_steps_are_those_of_paper_and_study_and_shares_of_the_critical_one():
    steps = {w.case: w.step_s for w in timestep.wanted(NAME, CRITICAL_S)}
    assert steps["paper"] == load_scenario(NAME)["time.paper_step"] == 2 * steps["half"]
    assert steps["0.8"] == pytest.approx(1.2e-5, rel=1e-12)
    assert "0.7" not in steps, "the study's own step is that already, and no run is made twice"
    assert {"seed 2", "seed 3", "rounding", "verified"} < set(steps)


def test_a_run_counts_for_its_step_its_seed_and_its_ranks_only(tmp_path):
    run = Run(write_run(tmp_path, "full", NAME, "liggghts", cycles=20, contacts=False))
    done = [w.case for w in timestep.wanted(NAME, CRITICAL_S) if w.is_done_by(run)]
    assert done == ["verified"] and timestep.only_time_differs(run)


def test_steps_are_compared_from_one_packed_bed(tmp_path):
    def run(step, bed, seed=1):
        name = f"{step}-{bed}-{seed}"
        folder = write_run(tmp_path / name, "full", NAME + step, "liggghts", cycles=20, contacts=False, seed=seed)
        made = Run(folder)
        made.stages["packing"] = {"bed_sha256": bed}
        return made

    runs = [run("", "new"), run("+paper-step", "old"), run("+paper-step", "new"), run("", "other", seed=2)]
    bed = timestep.common_bed(runs, timestep.wanted(NAME, CRITICAL_S))
    assert bed == "new"
    assert timestep.best(runs, want("paper"), bed) is runs[2]
    assert timestep.best(runs[:2], want("paper"), bed) is None
    assert timestep.best(runs, want("seed 2"), bed) is runs[3], "a seed is another bed"


def test_a_run_of_another_law_of_loading_does_not_count(tmp_path):
    run = Run(write_run(tmp_path, "full", f"{NAME}+servo", "liggghts", cycles=2, contacts=False))
    assert not timestep.only_time_differs(run)


def test_a_run_that_ends_early_has_its_rows_and_is_pending(tmp_path):
    run = Run(write_run(tmp_path, "full", NAME, "liggghts", cycles=5, contacts=False))
    rows = timestep.rows_of(run, want("verified"), CRITICAL_S)
    assert [(row["cycle"], row["state"]) for row in rows] == [(1, "done"), (2, "done"), (5, "done"), (20, "pending")]
    assert rows[0]["step_share"] == pytest.approx(
        load_scenario(NAME)["time.step"] / CRITICAL_S, rel=0.01
    )  # whole steps
    assert rows[2]["settlement_m"] == run.cycles["settlement_m"].iloc[4]


def test_a_run_that_is_not_there_is_pending():
    (row,) = timestep.rows_of(None, want("0.8"), CRITICAL_S)
    assert row["state"] == "pending" and row["step_share"] == pytest.approx(0.8, rel=1e-12)


def test_the_work_of_the_sleeper_is_the_area_of_its_loop(tmp_path):
    run = Run(write_run(tmp_path, "full", NAME, "liggghts", cycles=2, contacts=False))
    share = 2 * math.pi * (run.history["cycle"] - 1)
    run.history["sleeper_stress_Pa"] = 1e5 - 5e4 * share.map(math.cos)
    run.history["settlement_m"] = -1e-3 * share.map(lambda x: math.cos(x - 0.3))
    area = load_scenario(NAME)["geometry.sleeper_length"] * load_scenario(NAME)["geometry.sleeper_width"]
    expected = math.pi * 5e4 * area * 1e-3 * math.sin(0.3)
    assert sleeper_work(run)[2] == pytest.approx(expected, rel=0.01)  # 64 rows stand for the circle
