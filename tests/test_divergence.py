"""The limits of the watch, row by row: each names what was passed, and none is touched by a healthy run."""

import math

import pytest

from analysis.driver.divergence import Diverged, Watch
from analysis.formats import file_columns
from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario

SCENARIO = load_scenario("linear-mu0.8", "demo")
GRID = derived.time_grid(SCENARIO)


def state(stage="cyclic", **values):
    row = dict.fromkeys(file_columns.RAW_STATE, "0") | {
        "stage": stage,
        "step": str(GRID.steps_per_block),
        "at_limit_share": "nan",
    }
    return row | {key: str(value) for key, value in values.items()}


def load(step, stress=0.0, down=0.001):
    return dict.fromkeys(file_columns.RAW_LOADING, "0") | {
        "step": str(step),
        "sleeper_stress_mean_Pa": repr(stress),
        "sleeper_displacement_m": repr(down),
    }


def cycle(watch, number, peak, grid=GRID):
    """Feed all rows of a cycle whose load rises to `peak`."""
    for row in range(SCENARIO["output.rows_per_cycle"]):
        step = number * grid.steps_per_cycle + (row + 1) * grid.steps_per_row
        watch.load(load(step, peak * math.sin(math.pi * (row + 1) / SCENARIO["output.rows_per_cycle"])))


def test_a_healthy_run_passes():
    watch = Watch(SCENARIO, "cyclic")
    watch.load(load(0))
    for number in range(3):
        cycle(watch, number, 460e3)
        watch.state(state(kinetic_energy_J=1e-6, overlap_max_ratio=0.02, unbalanced_ratio="inf"))


@pytest.mark.parametrize(
    "values, said",
    [
        ({"kinetic_energy_J": "nan"}, "kinetic_energy_J is nan"),
        ({"kinetic_energy_J": "inf"}, "kinetic_energy_J is inf"),
        ({"kinetic_energy_J": "1.2-5"}, "raw/state.csv: kinetic_energy_J is '1.2-5'"),
        ({"kinetic_energy_J": 10.1}, "kinetic energy 10.1 J per clump .* limit 10 J .limits.kinetic_energy."),
        ({"overlap_max_ratio": 0.21}, "overlap of 0.21 sphere radii .* limit 0.2 .limits.overlap_ratio."),
    ],
)
def test_a_state_beyond_a_limit_stops_the_run(values, said):
    Watch(SCENARIO, "cyclic").state(state())
    with pytest.raises(Diverged, match=said):
        Watch(SCENARIO, "cyclic").state(state(**values))


def test_packing_starts_with_overlaps_and_preload_does_not():
    Watch(SCENARIO, "packing").state(state("packing", overlap_max_ratio=0.9))
    with pytest.raises(Diverged, match="overlap"):
        Watch(SCENARIO, "preload").state(state("preload", overlap_max_ratio=0.9))


@pytest.mark.parametrize(
    "down, said",
    [
        (0.325, "through the floor: 0.325 m down"),
        (-0.15, "thrown out of the bed: 0.15 m up"),
        (math.nan, "sleeper_displacement_m is nan"),
    ],
)
def test_a_sleeper_that_leaves_its_place_stops_the_run(down, said):
    with pytest.raises(Diverged, match=said):
        Watch(SCENARIO, "cyclic").load(load(0, down=down))


def test_a_cycle_without_its_load_stops_the_run_at_its_end():
    watch = Watch(SCENARIO, "cyclic")
    watch.load(load(0))
    cycle(watch, 0, 460e3)
    with pytest.raises(Diverged, match="load not reached: at most 200 kPa on the sleeper in cycle 2, target 460 kPa"):
        cycle(watch, 1, 200e3)


def test_a_load_that_pfcs_servo_does_not_reach_is_a_result_and_stops_nothing():
    servo = load_scenario("linear-mu0.8", "demo", variant="servo")
    watch, grid = Watch(servo, "cyclic"), derived.time_grid(servo)
    watch.load(load(0))
    for number in range(3):
        cycle(watch, number, 200e3, grid)


def test_the_rest_of_a_cycle_that_was_resumed_in_its_middle_is_not_judged():
    half = GRID.steps_per_cycle // 2
    watch = Watch(SCENARIO, "cyclic", last_step=half)
    for step in range(half + GRID.steps_per_row, GRID.steps_per_cycle + 1, GRID.steps_per_row):
        watch.load(load(step, 10e3))


@pytest.mark.parametrize(
    "last, step, due",
    [(None, 5, 0), (100, 100, 100 + GRID.steps_per_row), (100, 100 + 2 * GRID.steps_per_row, 100 + GRID.steps_per_row)],
)
def test_a_gap_or_a_duplicate_stops_the_run(last, step, due):
    with pytest.raises(Diverged, match=f"row of step {step} where {due} was due"):
        Watch(SCENARIO, "cyclic", last).load(load(step))
