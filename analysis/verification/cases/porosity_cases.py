"""Verification of the porosity in measurement spheres: lattices of known porosity and overlapping pairs."""

from __future__ import annotations

import itertools
import math

import numpy as np

from analysis.normalised.porosity import porosity, solid, sphere_points
from analysis.verification.case_sketch import Disc, Sketch
from analysis.verification.cases.case import Account, OwnCase
from analysis.verification.results import Results

RADIUS = 0.01
AROUND_PAIR = 0.025
"""Radius of the measurement sphere around two spheres, m."""


class Porosity(OwnCase):
    """Case 9: needs no engine; beds of both codes are measured by the same function."""

    name, title = "porosity", "Porosity in a measurement sphere"
    account = Account(
        "Porosity in a measurement sphere is measured in lattices of spheres and in overlapping pairs.",
        "Simple cubic 1 − π / 6, hexagonal 1 − π / √18; a pair: volume of two spheres less their common part.",
        "Geometry",
        "0.5 % and 1 %: the points that sample the sphere scatter by 0.1 %, and its border cuts lattice spheres.",
    )

    @classmethod
    def sketch(cls) -> Sketch:
        """A pair of spheres that overlap, in the measurement sphere around them."""
        pair = (Disc(0.0, side * RADIUS / 2, RADIUS) for side in (-1, 1))
        return Sketch((Disc(0.0, 0.0, AROUND_PAIR, hollow=True), *pair))

    def judge(self, results: Results) -> None:
        cells = range(-14, 15)
        cubic = np.array(list(itertools.product(cells, cells, cells)), float) * 2 * RADIUS
        measured, error = self._measure(cubic, 0.134)
        results.compare(
            self.name,
            "porosity of a simple cubic lattice",
            1 - math.pi / 6,
            measured,
            0.005,
            f"standard error {error:.4f}; the sphere cuts 13 spheres across",
        )
        measured, error = self._measure(hexagonal(RADIUS, 0.2), 0.134)
        results.compare(
            self.name,
            "porosity of a hexagonal close-packed lattice",
            1 - math.pi / math.sqrt(18),
            measured,
            0.01,
            f"standard error {error:.4f}",
        )
        for share in (0.5, 1.0, 1.75):
            distance = share * RADIUS
            pair = np.array([[0.0, 0.0, -distance / 2], [0.0, 0.0, distance / 2]])
            cap = math.pi * (2 * RADIUS - distance) ** 2 * (distance**2 + 4 * distance * RADIUS) / (12 * distance)
            volume = 8 / 3 * math.pi * RADIUS**3 - cap
            measured, error = self._measure(pair, AROUND_PAIR)
            results.compare(
                self.name,
                f"porosity around two spheres {share:g} r apart",
                1 - volume / (4 / 3 * math.pi * AROUND_PAIR**3),
                measured,
                0.005,
                f"standard error {error:.4f}; the overlap counts once",
            )

    @staticmethod
    def _measure(centres: np.ndarray, radius: float) -> tuple[float, float]:
        far = np.full(3, 1.0)
        return porosity(solid(sphere_points(np.zeros(3), radius, -far, far), centres, RADIUS))


def hexagonal(radius: float, reach: float) -> np.ndarray:
    """Centres of touching spheres in hexagonal close packing within `reach` of the origin; m, shape (n, 3)."""
    d, n = 2 * radius, int(reach / radius)
    points = [
        (d * (i + (j + k) % 2 / 2), d * math.sqrt(3) / 2 * (j + k % 2 / 3), d * math.sqrt(2 / 3) * k)
        for i, j, k in itertools.product(range(-n, n + 1), repeat=3)
    ]
    centres = np.array(points)
    return centres[(centres**2).sum(axis=1) < reach**2]


CASES = (Porosity,)
