"""Verification of blocks, as sleeper and plates are: a sphere at faces, edges and corners, and around an edge."""

from __future__ import annotations

import itertools

import numpy as np

from analysis.scenarios import derived
from analysis.scenarios.scenario import load_scenario
from analysis.verification.cases.case import Account, ProbedCase
from analysis.verification.probes import BLOCK_M, Ball, Probe, Trajectory
from analysis.verification.results import Results

OVERLAP = 1e-6  # m
STEP = 1e-6  # s
NEAR_EDGE = 1e-6  # m: so close to the edge of a face is the sphere that triangles would push it twice
LEG, ARC = 60, 1200  # steps along a face, and around the edge

HALF = np.array(BLOCK_M)


def nearest(place: np.ndarray) -> np.ndarray:
    """The point of the block that is nearest to each place, (n, 3)."""
    return np.clip(place, -HALF, HALF)


class BlockContacts(ProbedCase):
    """Case: one contact per sphere and block, at the nearest point of it, on a face, an edge or a corner.

    Expected at rest: stiffness x overlap along the line to the nearest point. Around an edge, without slip: a shear
    force of stiffness x way, which follows the contact, and no work over a closed path.
    """

    name, title = "block", "A sphere at faces, edges and corners of a block"
    account = Account(
        "A sphere touches a block, as sleeper and plates are, on each face, edge and corner, and is rolled "
        "around an edge.",
        "One contact, at the nearest point: force = stiffness × overlap. Around an edge: shear force = "
        "stiffness × way, and no "
        "work over the closed path.",
        "Eq. 1 and 2 of the paper; geometry",
        "0.01 % for forces: places are rounded. 0.2 and 0.5 % around an edge: YADE turns the force to first order.",
        ("edge", "shear_force_N"),
        1,
    )

    def __init__(self, code: str):
        super().__init__(code)
        base = load_scenario("linear-mu0.8")
        self.radius, self.mass = derived.clump(base).radius_m, derived.clump(base).mass_kg
        self.normal_stiffness = base["contact.particle_wall.normal_stiffness"]
        self.shear_stiffness = base["contact.particle_wall.shear_stiffness"]
        smooth, rough = (
            base.with_values({"contact.particle_wall.friction": friction}, f"block-{friction}")
            for friction in (0.0, 1e5)
        )
        self.places = self._places()
        self._probes = {
            "places": self._probe("places", smooth, self.places),
            "edge": self._probe("edge", rough, self._around()),
        }

    def _places(self) -> np.ndarray:
        """Centres that touch each face, edge and corner by OVERLAP, and each face close to each of its edges."""
        reach, places = self.radius - OVERLAP, []
        for sides in itertools.product((-1, 0, 1), repeat=3):
            if any(sides):
                places.append(HALF * sides + reach * np.array(sides) / np.linalg.norm(sides))
        for axis, side in itertools.product(range(3), (-1, 1)):
            for other, end in itertools.product(set(range(3)) - {axis}, (-1, 1)):
                place = np.zeros(3)
                place[axis], place[other] = side * (HALF[axis] + reach), end * (HALF[other] - NEAR_EDGE)
                places.append(place)
        return np.array(places)

    def _around(self) -> np.ndarray:
        """Out along the upper face, around its edge and down the side, and the same way back."""
        reach = self.radius - OVERLAP
        x, z = HALF[0], HALF[2]
        slide = np.linspace(0.0, 2e-5, LEG)
        angle = np.linspace(0.0, np.pi / 2, ARC)[1:]
        out = [(x - slide[-1] + s, z + reach) for s in slide]
        out += [(x + reach * np.sin(a), z + reach * np.cos(a)) for a in angle]
        out += [(x + reach, z - s) for s in slide[1:]]
        return np.array([(u, 0.0, w) for u, w in out + out[-2::-1]])

    def _probe(self, name: str, scenario, places: np.ndarray) -> Probe:
        velocity = np.diff(places, axis=0) / STEP
        path = tuple((tuple(float(c) for c in v), 1) for v in (*velocity, np.zeros(3)))
        ball = Ball(self.radius, self.mass, tuple(float(c) for c in places[0]))
        return Probe(f"block-{name}", scenario, STEP, len(path), balls=(ball,), path=path, wall="block")

    def probes(self) -> list[Probe]:
        return list(self._probes.values())

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        self._judge_places(found["block-places"], results)
        self._judge_edge(found["block-edge"], results)

    def _judge_places(self, found: Trajectory, results: Results) -> None:
        places = found.position[:, 0]
        away = places - nearest(places)
        distance = np.linalg.norm(away, axis=1)
        expected = self.normal_stiffness * (self.radius - distance)[:, None] * away / distance[:, None]
        error = np.linalg.norm(found.force[:, 0] - expected, axis=1)
        count = len(self.places)
        size = self.normal_stiffness * OVERLAP
        for first, last, what in ((0, 26, "26 faces, edges and corners"), (26, count, "24 faces close to an edge")):
            results.compare(
                self.name,
                f"force_N with its largest error, {what}",
                size,
                size + error[first:last].max(),
                1e-4,
                "stiffness x overlap along the line to the nearest point; 1e-4: the path's places are rounded",
            )
        results.compare(
            self.name, "contacts at each place", 1.0, float(found.contacts[:count].mean()), 0.0, "one per block"
        )

    def _judge_edge(self, found: Trajectory, results: Results) -> None:
        places, force = found.position[:, 0], found.force[:, 0]
        step = np.diff(places, axis=0)
        normal = places[1:] - nearest(places[1:])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        along = np.column_stack([normal[:, 2], np.zeros(len(normal)), -normal[:, 0]])
        way = np.cumsum(np.einsum("ij,ij->i", step, along))
        shear = np.einsum("ij,ij->i", force[1:], along)
        results.compare_curves(
            self.name,
            "shear_force_N around an edge and back",
            -self.shear_stiffness * way,
            shear,
            2e-3,
            "stiffness x way without slip; 0.2 %: YADE turns the old force to first order in the angle of a step",
        )
        work = np.einsum("ij,ij->", 0.5 * (force[1:] + force[:-1]), step)
        stored = 0.5 * self.shear_stiffness * way.max() ** 2
        results.compare(
            self.name,
            "energy_J stored half way, and what the closed path adds to it",
            stored,
            stored + work,
            5e-3,
            "elastic: nothing is lost; 0.5 %: as above",
        )
        results.curve(
            self.name, "edge", way_m=way, shear_force_N=shear, shear_force_N_expected=-self.shear_stiffness * way
        )


CASES = (BlockContacts,)
