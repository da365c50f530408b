"""What packing and preload left behind, as stages.json: one small table per stage, units in the names.

    packing   the bed that preload started from: clumps, porosity_1 to _3 and mean, contacts and overlaps, mean contact
              force (where this run packed it), and bed_sha256, which tells whether two runs began from the same bed
    preload   the same at its end, with the sleeper's settlement_m (downward) and lateral_1_m to _5_m (outward) since
              the beginning of preload; both count from zero again in cyclic loading; and critical_step_s of that bed
              with step_share, the run's own step over it

A function of the raw files only. Not having a file costs what is in it: those values are left out.
"""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path

from analysis import files
from analysis.formats import file_columns, json_file
from analysis.formats.errors import InputError
from analysis.formats.quantities import QUANTITIES
from analysis.normalised import beds, critical_step, microstructure, porosity
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario

FILE = "stages.json"
Stages = dict[str, dict[str, float | str]]


def write_stages(
    folder: Path, scenario: Scenario, moved: dict[str, float], spheres: porosity.MeasurementSpheres
) -> None:
    """Write stages.json of a run that has been preloaded; `moved` holds settlement_m and lateral_1_m to _5_m."""
    raw, stages = folder / "raw", {}
    for stage, label, places in (("packing", "packed", {}), ("preload", "preloaded", moved)):
        bed_file, contacts_file = raw / f"bed_{label}.csv", raw / f"contacts_{label}.csv"
        if not bed_file.exists():
            continue
        stages[stage] = {**bed_measures(bed_file, scenario, spheres, places), **places}
        if contacts_file.exists():
            forces = microstructure.force_measures(microstructure.read_contacts(contacts_file))
            if "normal_force_mean_N" in forces:
                stages[stage]["normal_force_mean_N"] = forces["normal_force_mean_N"]
            if stage == "preload" and (critical := critical_step.measure(bed_file, contacts_file, scenario, moved)):
                stages[stage] |= {
                    "critical_step_s": critical,
                    "step_share": derived.time_grid(scenario).step_s / critical,
                }
        stages[stage]["bed_sha256"] = hashlib.sha256(bed_file.read_bytes()).hexdigest()
    files.write_aside(folder / FILE, json.dumps(stages, indent=1) + "\n")


def bed_measures(
    path: Path, scenario: Scenario, spheres: porosity.MeasurementSpheres, places: dict[str, float]
) -> dict[str, float]:
    """Clumps, porosity of the three spheres and their mean, contacts and overlaps of a bed file. A sphere that does not
    fit into the box has no porosity, and the mean is that of all three or is left out.

    `places` tells where sleeper and plates stand (settlement_m, lateral_1_m to _5_m); empty: where they began.
    Raises ValueError where the file is not a bed.
    """
    clump, bed = derived.clump(scenario), beds.read_bed(path)
    centres = beds.sphere_centres(bed, clump.half_distance_m)
    at = places.get("settlement_m", 0.0), [places.get(f"lateral_{k}_m", 0.0) for k in file_columns.PLATES]
    porosities, _ = spheres.measure(centres, *at)
    measured = {f"porosity_{n}": float(value) for n, value in zip(file_columns.SPHERES, porosities, strict=True)}
    measured["porosity_mean"] = float(sum(porosities) / len(porosities))
    return {
        "clumps": len(bed),
        **{name: value for name, value in measured.items() if math.isfinite(value)},
        **microstructure.contact_measures(centres, clump.radius_m, derived.apparatus(scenario), *at),
    }


def read_stages(folder: Path) -> Stages:
    """stages.json of a run, {} without one. InputError, one line, where anything in it is damaged or cannot be."""
    try:
        found = json_file.read(folder / FILE)
    except FileNotFoundError:
        return {}
    for stage, table in found.items():
        if not isinstance(table, dict):
            raise InputError(FILE, stage, table, "a table of quantities")
        for name, value in table.items():
            if name == "bed_sha256":
                good, allowed = isinstance(value, str), "a checksum"
            else:
                quantity = QUANTITIES.get(name)
                is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
                good = quantity is not None and is_number and quantity.accepts(value)
                allowed = f"a number from {quantity.low:g} to {quantity.high:g}" if quantity else "a known quantity"
            if not good:
                raise InputError(FILE, f"{stage}.{name}", value, allowed)
    return found
