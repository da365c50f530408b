"""Beds for speed: a preloaded bed, or mirror images of it side by side, cut to the width that is asked for."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.formats import bed_file
from analysis.formats.growing_csv import GrowingCsv
from analysis.formats.quantities import PLATES
from analysis.scenarios import derived
from analysis.scenarios.scenario import SCENARIO_FILE, Scenario, load_scenario

DEEPEST = 0.1  # of the radius: a clump of the widened bed that reaches deeper into a wall is left out
NARROW_GAP_M = 0.008
"""Gap of the lattice of narrow boxes: the loader refuses the full bed's, which would not fill them."""
VARIANT = """
[variant.bench]
title = "the bed of a benchmark: where preload left the sleeper; at rest at once"
geometry.box_width           = {{ value = {width!r}, unit = "m", status = "derived", source = "number of clumps" }}
geometry.sleeper_width       = {{ value = {sleeper!r}, unit = "m", status = "derived", source = "likewise" }}
packing.lattice_gap          = {{ value = {gap!r}, unit = "m", status = "derived", source = "nothing is packed" }}
geometry.sleeper_base        = {{ value = {base!r}, unit = "m", status = "derived", source = "settlement in preload" }}
rest.unbalanced_ratio        = {{ value = 1.0, unit = "-", status = "derived", source = "at rest after one block" }}
rest.kinetic_energy          = {{ value = 1e3, unit = "J", status = "derived", source = "likewise" }}
preload.stress_tolerance     = {{ value = 0.5, unit = "-", status = "derived", source = "loaded after a few blocks" }}
preload.ramp_time            = {{ value = 1e-3, unit = "s", status = "derived", source = "likewise" }}
preload.averaging_time       = {{ value = 1e-3, unit = "s", status = "derived", source = "likewise" }}
output.blocks_per_cycle      = {{ value = 16, unit = "-", status = "derived", source = "short blocks" }}
"""


@dataclass(frozen=True)
class Preloaded:
    """A run of ours that has been preloaded: its bed, and where sleeper and plates stand."""

    folder: Path

    @property
    def bed(self) -> Path:
        """Its bed file."""
        return self.folder / "raw" / "bed_preloaded.csv"

    def ways_m(self) -> dict[str, float]:
        """How far sleeper (down) and plates (outward) went in preload, m."""
        last = GrowingCsv(self.folder / "raw" / "preload.csv").new_rows()[-1]
        return {name: float(last[f"{name}_displacement_m"]) for name in ("sleeper", *(f"plate_{k}" for k in PLATES))}


def bench_scenario(name: str, variant: str, bed: Preloaded, width: float, work: Path, profile: str) -> Scenario:
    """Scenario `name`, `width` times as wide, whose sleeper starts where `bed` has it; one cycle.

    Preload of it only makes a checkpoint: it calls the bed at rest and loaded after a few hundred steps.
    """
    own = load_scenario(name, profile)
    file = work / "scenarios.toml"
    text = VARIANT.format(
        width=own["geometry.box_width"] * width,
        sleeper=own["geometry.sleeper_width"] * width,
        gap=min(own["packing.lattice_gap"], NARROW_GAP_M if width < 0.5 else math.inf),
        base=own["geometry.sleeper_base"] - bed.ways_m()["sleeper"],
    )
    file.write_text(SCENARIO_FILE.read_text() + text)
    return load_scenario(name, profile, file, 1, ",".join(filter(None, (variant, "bench"))))


def widened(poses: np.ndarray, scenario, width: float) -> np.ndarray:
    """Poses (x, y, z in m, qw, qx, qy, qz) of a bed `width` times as wide: mirror images beside each other, cut.

    `scenario` is that of the wide bed. Clumps that the cut or its sleeper would hit are left out.
    """
    box, clump = derived.apparatus(scenario), derived.clump(scenario)
    single = box.width_m / width
    tiles = [_tile(poses, k, single) for k in range(math.ceil(width - 1e-9))]
    wide = np.concatenate(tiles)
    return wide[_depths(wide, box, clump) <= DEEPEST * clump.radius_m]


def _tile(poses: np.ndarray, number: int, width: float) -> np.ndarray:
    tile = poses.copy()
    if number % 2:  # mirrored in a plane y = constant: of a clump's quaternion, which has an axis only, x and z change
        tile[:, 1] = width - tile[:, 1]
        tile[:, [4, 6]] *= -1
    tile[:, 1] += number * width
    return tile


def sphere_centres(poses: np.ndarray, half_distance_m: float) -> np.ndarray:
    """Centres (clumps, 2, 3) of both spheres, m."""
    w, x, y, z = poses[:, 3:].T
    axis = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)
    return poses[:, None, :3] + half_distance_m * np.array([-1, 1])[None, :, None] * axis[:, None, :]


def _depths(poses: np.ndarray, box: derived.Apparatus, clump: derived.Clump) -> np.ndarray:
    """How deep each clump reaches into side walls and sleeper, m."""
    centres = sphere_centres(poses, clump.half_distance_m)
    side = clump.radius_m - np.minimum(centres[..., 1], box.width_m - centres[..., 1])
    low, high = np.array(box.sleeper.low), np.array(box.sleeper.high)
    nearest = np.clip(centres, low, high)
    block = clump.radius_m - np.linalg.norm(centres - nearest, axis=-1)
    return np.maximum(side, block).max(axis=1)


def write_widened(source: Path, scenario, width: float, target: Path) -> int:
    """Write the widened bed of the bed file `source`; number of its clumps."""
    poses = np.array([pose.row[1:] for pose in bed_file.read(source)])
    wide = poses if width == 1 else widened(poses, scenario, width)
    target.parent.mkdir(parents=True, exist_ok=True)
    bed_file.write(target, ((number, *map(float, pose)) for number, pose in enumerate(wide, start=1)))
    return len(wide)
