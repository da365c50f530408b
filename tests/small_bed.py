"""Scenarios for tests with the real engines: the project's own with larger clumps and time steps and shorter cycles.

A run takes seconds instead of minutes. Every other parameter, and with it every law and procedure, stays what it is.
"""

from __future__ import annotations

import re
from pathlib import Path

from analysis.scenarios.scenario import SCENARIO_FILE

CHANGES = {
    "ball_radius": "0.037",
    "lattice_radius": "0.023125",
    "lattice_gap": "0.027",
    "packing.lattice_gap": "0.0256",
    "geometry.cut_x": "0.58",  # the demo bed, a little longer for such clumps: 133 of them
    "verified_step": "8.2e-6",
    "time.verified_step": "1.26e-5",
    "frequency": "80.0",
    "unbalanced_ratio": "2e-2",
}


def set_value(text: str, key: str, value: str) -> str:
    """Replace the value of every line `key = { value = ..., ` of a scenario file."""
    text, found = re.subn(rf"^({re.escape(key)}\s*= {{ value = )[^,]+", rf"\g<1>{value}", text, flags=re.MULTILINE)
    assert found, f"{SCENARIO_FILE.name} has no key {key} any more"
    return text


def write_scenarios(path: Path, **more: str) -> Path:
    """Write the scenario file of the small bed; `more` sets further keys by the last part of their names."""
    text = SCENARIO_FILE.read_text()
    for key, value in (CHANGES | more).items():
        text = set_value(text, key, value)
    rest, limits = text.split("[base.limits]")
    path.write_text(set_value(rest, "kinetic_energy", "1e-5") + "[base.limits]" + limits)
    return path
