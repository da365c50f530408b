"""Where packing starts: clumps of random orientation on a hexagonal lattice in the free space of the box.

Both codes start from this file, so that a seed means the same bed before the engines begin to differ.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator

from analysis.scenarios import derived


def lattice_bed(scenario, seed: int) -> list[tuple[float, ...]]:
    """Poses (x, y, z, qw, qx, qy, qz) of the lattice clumps of a scenario, metres and unit quaternions.

    Lattice balls of the grown radius stay clear of walls and sleeper; layers of hexagonal close packing lie flat.
    The orientations are uniform over rotations; they and the empty sites depend on `seed` only.
    """
    generator = random.Random(seed)
    poses = []
    for y, z, along in _rows(scenario):
        for x in along:
            quaternion = [generator.gauss(0, 1) for _ in range(4)]
            norm = math.sqrt(sum(c * c for c in quaternion))
            poses.append((x, y, z, *(c / norm for c in quaternion)))
    empty = set(generator.sample(range(len(poses)), _vacancies(scenario, len(poses))))
    return [pose for n, pose in enumerate(poses) if n not in empty]


def site_count(scenario) -> int:
    """Number of clumps that `lattice_bed` places."""
    sites = sum(len(along) for _, _, along in _rows(scenario))
    return sites - _vacancies(scenario, sites)


def _vacancies(scenario, sites: int) -> int:
    """Number of sites that stay empty."""
    return round(scenario["packing.lattice_vacancies"] * sites)


def void_fraction(scenario) -> float:
    """Porosity of the lattice clumps, filling the free space of the box without overlap; <= 0 is impossible."""
    return 1 - site_count(scenario) * derived.clump(scenario).volume_m3 / derived.apparatus(scenario).ballast_volume_m3


def _rows(scenario) -> Iterator[tuple[float, float, list[float]]]:
    """Rows of sites along x that keep clear of the sleeper: (y, z, places along x), m."""
    box = derived.apparatus(scenario)
    spacing, margin = derived.lattice_spacing(scenario), scenario["clump.ball_radius"]
    low, high = box.sleeper.low, box.sleeper.high
    for k, z in enumerate(_steps(margin, box.height_m - margin, spacing * math.sqrt(2 / 3))):
        first = margin + (k % 2) * spacing / (2 * math.sqrt(3))
        for j, y in enumerate(_steps(first, box.width_m - margin, spacing * math.sqrt(3) / 2)):
            if not (z > low[2] - margin and low[1] - margin < y < high[1] + margin):
                first_x = box.end_m + margin + ((j + k) % 2) * spacing / 2
                yield y, z, _steps(first_x, box.length_m - margin, spacing)


def _steps(start: float, stop: float, step: float) -> list[float]:
    return [start + i * step for i in range(int((stop - start) / step + 1e-9) + 1)] if stop >= start else []
