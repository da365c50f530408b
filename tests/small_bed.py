"""Scenarios for tests with the real engines: the project's own with larger clumps and time steps and shorter cycles.

A run takes seconds instead of minutes. Every other parameter, and with it every law and procedure, stays what it is.
"""

from __future__ import annotations

import re
from pathlib import Path

from analysis.scenario import SCENARIO_FILE

CHANGES = {
    "ball_radius": "0.037",
    "lattice_radius": "0.023125",
    "lattice_gap": "0.027",
    "packing.lattice_gap": "0.027",
    "geometry.width_scale": "0.35",  # the demo slice, widened like the clumps: 130 of them
    "step": "8.2e-6",
    "time.step": "1.26e-5",
    "frequency": "80.0",
    "unbalanced_ratio": "2e-2",
}


def write_scenarios(path: Path, **more: str) -> Path:
    """Write the scenario file of the small bed; `more` sets further keys by the last part of their names."""
    text = SCENARIO_FILE.read_text()
    for key, value in (CHANGES | more).items():
        text, found = re.subn(rf"^({re.escape(key)}\s*= {{ value = )[^,]+", rf"\g<1>{value}", text, flags=re.MULTILINE)
        assert found, f"{SCENARIO_FILE.name} has no key {key} any more"
    rest, limits = text.split("[base.limits]")
    text = (
        re.sub(r"^(kinetic_energy\s*= { value = )[^,]+", r"\g<1>1e-5", rest, flags=re.MULTILINE)
        + "[base.limits]"
        + limits
    )
    path.write_text(text)
    return path
