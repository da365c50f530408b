"""The test that the paper prescribes and what it reports of it: the numbers that sentences and figures name."""

from __future__ import annotations

import math
from dataclasses import dataclass

from analysis.reference.reported import Reported, reported
from analysis.scenarios.scenario import ScenarioError, load_scenario
from analysis.scenarios.study_list import key_scenarios

PRESCRIBED = {
    "stress_min_Pa": "loading.stress_min",
    "stress_max_Pa": "loading.stress_max",
    "frequency_Hz": "loading.frequency",
    "cycles": "loading.cycles",
    "plate_stress_Pa": "preload.plate_stress",
}


@dataclass(frozen=True)
class Paper:
    """Of the linear key scenario at full size; nan where the scenario file cannot be read."""

    stress_min_Pa: float
    stress_max_Pa: float
    frequency_Hz: float
    cycles: float
    plate_stress_Pa: float
    reported: Reported

    @property
    def stress_mean_Pa(self) -> float:
        """Middle of the prescribed stress on the sleeper."""
        return (self.stress_min_Pa + self.stress_max_Pa) / 2

    @property
    def omega_per_s(self) -> float:
        """Angular frequency of the load."""
        return 2 * math.pi * self.frequency_Hz


def paper() -> Paper:
    """What the paper prescribes, from the scenario file, and what it reports, from the reference data."""
    try:
        scenario = load_scenario(key_scenarios()[0], "full")
    except ScenarioError:
        return Paper(**dict.fromkeys(PRESCRIBED, math.nan), reported=reported())
    return Paper(**{name: scenario[key] for name, key in PRESCRIBED.items()}, reported=reported())
