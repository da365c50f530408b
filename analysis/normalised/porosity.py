"""Porosity in the measurement spheres: share of a fixed point set that lies in no particle.

All spheres of a bed have one radius, so the union of all clumps, overlaps counted once, is exactly the set of points
closer than that radius to a sphere's centre. The points are the start of a Halton sequence: the same in every run,
cycle and on every machine, so that changes of porosity are not blurred by the sampling. The stated standard error is
the binomial one, sqrt(n (1 - n) / points), an upper bound for evenly spread points.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree
from scipy.stats import qmc

from analysis.scenarios import derived

POINTS = 250_000
"""Points in a measurement sphere: the binomial standard error is at most 0.5 / sqrt(POINTS) = 0.001."""


def solid(points: np.ndarray | cKDTree, centres: np.ndarray, radius: float) -> np.ndarray:
    """True for every point (shape (n, 3), m) that is closer than `radius` to one of the `centres` (shape (m, 3))."""
    tree = points if isinstance(points, cKDTree) else cKDTree(points)
    inside = np.zeros(tree.n, dtype=bool)
    if len(centres):
        for hits in tree.query_ball_point(centres, np.nextafter(radius, 0)):
            inside[hits] = True
    return inside


def porosity(inside: np.ndarray) -> tuple[float, float]:
    """Share of points that are not solid, and its binomial standard error; nan without points."""
    if inside.size == 0:
        return np.nan, np.nan
    void = float(np.mean(~inside))
    return void, float(np.sqrt(void * (1 - void) / inside.size))


def sphere_points(centre, radius: float, low, high, count: int = POINTS) -> np.ndarray:
    """`count` evenly spread points (m) of the part of a sphere that lies in the box from `low` to `high`."""
    centre = np.asarray(centre, dtype=float)
    corner = np.maximum(centre - radius, low)
    edges = np.minimum(centre + radius, high) - corner
    if not (edges > 0).all():
        return np.empty((0, 3))
    tried = 2 * count
    while True:
        points = corner + edges * qmc.Halton(3, scramble=False).random(tried)
        points = points[np.sum((points - centre) ** 2, axis=1) <= radius**2]
        if len(points) >= count:
            return points[:count]
        tried *= 2


class MeasurementSpheres:
    """The three measurement spheres of a scenario; made once, then measured for every bed.

    A sphere that does not fit into the box has no porosity: a smaller one would be another quantity.
    """

    def __init__(self, scenario, count: int | None = None):
        self._box = derived.apparatus(scenario)
        self._clump_radius = derived.clump(scenario).radius_m
        low = np.array([self._box.end_m, 0.0, 0.0])
        high = np.array([self._box.length_m, self._box.width_m, self._box.height_m])
        self._trees = [
            cKDTree(
                sphere_points(c, self._box.measurement_radius_m, low, high, count or POINTS),
                balanced_tree=False,
                compact_nodes=False,
            )
            if fits
            else None
            for c, fits in zip(self._box.measurement_centres_m, self._box.measurement_fits, strict=True)
        ]

    def measure(
        self, centres: np.ndarray, sleeper_down_m: float = 0.0, plates_out_m=(0.0,) * 5
    ) -> tuple[list[float], float]:
        """Porosities of spheres 1 to 3 and the largest of their standard errors; nan for a sphere that does not fit.

        centres   of all spheres of the bed, shape (n, 3), m
        sleeper_down_m, plates_out_m   where sleeper and plates stand: their inside is not measured
        """
        values, errors = [], []
        for centre, tree in zip(self._box.measurement_centres_m, self._trees, strict=True):
            if tree is None:
                values.append(np.nan)
                continue
            reach = self._box.measurement_radius_m + self._clump_radius
            near = centres[np.sum((centres - np.array(centre)) ** 2, axis=1) <= reach**2]
            inside = solid(tree, near, self._clump_radius)
            value, error = porosity(inside[~self._occupied(tree.data, sleeper_down_m, plates_out_m)])
            values.append(value)
            errors.append(error)
        return values, max(errors, default=np.nan)

    def _occupied(self, points, sleeper_down_m, plates_out_m) -> np.ndarray:
        """True for points inside the sleeper or behind a plate's face."""
        low, high = self._box.sleeper.low, self._box.sleeper.high
        hidden = (points[:, 2] > low[2] - sleeper_down_m) & (points[:, 1] > low[1]) & (points[:, 1] < high[1])
        for plate, out in zip(self._box.plates, plates_out_m, strict=True):
            if out < 0:
                hidden |= (
                    (points[:, 0] > plate.low[0] + out) & (points[:, 2] > plate.low[2]) & (points[:, 2] < plate.high[2])
                )
        return hidden
