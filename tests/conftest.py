"""Runs that several tests share: a small bed in both codes and both scenarios of the demo, packed and preloaded."""

from __future__ import annotations

import functools

import pytest
from driver import REAL, copy_run, drive, run_folder, start
from small_bed import write_scenarios

from analysis.driver.engines import CODES

CYCLES = 3
SCENARIOS = ("linear-mu0.8", "nonlinear-md1-en0.6")
"""One of each law; the nonlinear one has dashpots everywhere, so that set-up forces depend on velocities too."""


@pytest.fixture(scope="session")
def small_scenarios(tmp_path_factory):
    """Scenario file of the small bed."""
    return write_scenarios(tmp_path_factory.mktemp("small") / "scenarios.toml")


@pytest.fixture(scope="session")
def preloaded(small_scenarios, tmp_path_factory):
    """Results with all runs packed and preloaded, not loaded yet; both codes side by side."""
    results = tmp_path_factory.mktemp("preloaded")
    for scenario in SCENARIOS:
        lanes = [
            start(
                REAL,
                scenario,
                "--code",
                code,
                "--cycles",
                CYCLES,
                "--results",
                results,
                "--scenarios",
                small_scenarios,
                "--until",
                "preload",
            )
            for code in CODES
        ]
        for process in lanes:
            out, err = process.communicate(timeout=3600)  # real time, on a busy machine
            assert process.returncode == 0, out + err
    return results


@pytest.fixture(params=CODES)
def code(request):
    """Both codes, one after the other."""
    return request.param


@pytest.fixture(params=SCENARIOS)
def scenario(request):
    """Both scenarios, one after the other."""
    return request.param


@pytest.fixture(scope="session")
def begin(preloaded, small_scenarios):
    """Function that copies a preloaded run to other results; returns its folder and the driver's arguments."""

    def copy(results, scenario: str, code: str, cycles: int = CYCLES):
        folder = copy_run(run_folder(preloaded, scenario, code), run_folder(results, scenario, code))
        return folder, [
            scenario,
            "--code",
            code,
            "--cycles",
            cycles,
            "--results",
            results,
            "--scenarios",
            small_scenarios,
        ]

    return copy


@pytest.fixture(scope="session")
def undisturbed(begin, tmp_path_factory):
    """Function that gives the folder of a run of a scenario in a code that nobody disturbed; each is made once."""

    @functools.cache
    def run(scenario: str, code: str):
        folder, arguments = begin(tmp_path_factory.mktemp("undisturbed"), scenario, code)
        done = drive(REAL, *arguments)
        assert done.returncode == 0, done.stdout + done.stderr
        return folder

    return run
