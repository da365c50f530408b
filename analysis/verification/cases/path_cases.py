"""Verification by imposed motion: a sphere is pressed, sheared, reversed, unloaded and reloaded along a path."""

from __future__ import annotations

import numpy as np

from analysis import contact_laws
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, load_scenario
from analysis.verification import oracle
from analysis.verification.cases.case import Account, ProbedCase
from analysis.verification.engine_laws import Along, wall_law
from analysis.verification.probes import Ball, Probe, Trajectory
from analysis.verification.results import Results

HELD_MASS = 1e12

# (closing, sliding) in units of the path's speed, and steps
LOADING = ((1.0, 0.5), 21)
SLIDING = ((0.0, 1.0), 60)
BACK = ((0.0, -1.0), 60)
UNLOADING = ((-0.7, -0.4), 12)
RELOADING = ((0.9, 4.0), 20)
SEPARATION = ((-2.6, 0.3), 13)  # so fast that the dashpots would pull
CLOSING_AGAIN = ((1.1, -0.6), 30)
PATH = (LOADING, SLIDING, BACK, UNLOADING, RELOADING, SEPARATION, CLOSING_AGAIN)


def _ends() -> np.ndarray:
    """Step after which each part of the path has ended."""
    return np.cumsum([steps for _, steps in PATH])


class PrescribedPaths(ProbedCase):
    """Case 2: normal and shear force at every point of the path, in a wall contact and in contacts of two spheres."""

    name, title = "path", "Imposed motion: normal and shear force along a path"
    account = Account(
        "A sphere is pressed onto another or the wall, slid, reversed, unloaded, reloaded, pulled off and "
        "pressed on again.",
        "Normal force eq. 1 or 8; shear force: old force + stiffness × way of the step, cut to μ × elastic "
        "normal force.",
        "Eq. 1 to 5 and 8 to 16 of the paper, step by step in Python; YADE's own law where it has no other",
        "0.01 % in LIGGGHTS, whose arithmetic is the same; 0.5 % in YADE, which turns the shear force to first order.",
        ("spheres-damped", "shear_force_N"),
        4,
    )

    def __init__(self, code: str):
        super().__init__(code)
        linear, nonlinear = load_scenario("linear-mu0.8"), load_scenario("nonlinear-en1.0")
        damped = nonlinear.with_values({"contact.particle_particle.restitution": 0.6}, "damped")
        own = {"contact.origin": "engine"}
        self.clump = derived.clump(linear)
        # each: scenario, on a wall?, step (s), length of a unit step (m), how much longer the steps along the contact
        # are, and the gap at the start in unit steps: the contact closes within the first step or the second
        self._entries = {
            "wall-linear": (linear, True, 1e-6, 0.4e-6, 10.0, 1.4),
            "wall-damped": (nonlinear, True, 1e-6, 1e-6, 1.5, 1.4),
            "spheres-linear": (linear, False, 1e-6, 1e-6, 1.5, 0.4),
            "spheres-hertz": (nonlinear, False, 1e-6, 5e-6, 1.5, 1.4),
            "spheres-damped": (damped, False, 1e-5, 5e-6, 1.5, 0.4),
            "spheres-hooke": (linear.with_values(own, "hooke"), False, 1e-6, 1e-6, 1.5, 0.4),
            "spheres-hertz-stock": (nonlinear.with_values(own, "hertz"), False, 1e-6, 5e-6, 1.5, 1.4),
        }
        self._probes = {name: self._probe(name, *entry) for name, entry in self._entries.items()}

    def _probe(
        self, name: str, scenario: Scenario, wall: bool, step: float, length: float, stretch: float, gap: float
    ) -> Probe:
        r, mass, speed = self.clump.radius_m, self.clump.mass_kg, length / step
        height = r if wall else 2 * r
        balls = (Ball(r, mass, (0.0, 0.0, height + gap * length)), Ball(r, HELD_MASS, (0.0, 0.0, 0.0), held=True))
        path = tuple(((slide * stretch * speed, 0.0, -close * speed), steps) for (close, slide), steps in PATH)
        return Probe(
            f"path-{name}",
            scenario,
            step,
            sum(steps for _, steps in PATH),
            path=path,
            wall="linear" if wall else "",
            balls=balls[:1] if wall else balls,
        )

    def probes(self) -> list[Probe]:
        return list(self._probes.values())

    def geometry(self, probe: Probe) -> tuple[np.ndarray, ...]:
        """From the path alone: overlap (n + 1), closing speed and sliding (n), directions of the contact (n, 3)."""
        velocity = np.repeat([v for v, _ in probe.path], [steps for _, steps in probe.path], axis=0)
        place = probe.balls[0].position + np.vstack([np.zeros(3), np.cumsum(velocity * probe.step, axis=0)])
        if probe.wall:
            normal = np.tile([0.0, 0.0, 1.0], (len(place), 1))
            overlap = probe.balls[0].radius - place[:, 2]
        else:
            distance = np.linalg.norm(place, axis=1)
            normal = place / distance[:, None]
            overlap = 2 * probe.balls[0].radius - distance
        along = np.column_stack([normal[:, 2], np.zeros(len(normal)), -normal[:, 0]])
        closing = -np.einsum("ij,ij->i", velocity, normal[1:])
        sliding = np.einsum("ij,ij->i", velocity, along[1:]) * probe.step
        return overlap, closing, sliding, normal[1:], along[1:]

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        for name, probe in self._probes.items():
            self._judge(name, probe, found[probe.name], results)

    def _judge(self, name: str, probe: Probe, found: Trajectory, results: Results) -> None:
        scenario, wall, *_ = self._entries[name]
        overlap, closing, sliding, normal, along = self.geometry(probe)
        law = wall_law(scenario, self.clump.mass_kg) if wall else self._law_of_spheres(scenario)
        own = self.engine.along(scenario["contact.origin"] == "engine")
        normal_force, shear_force = oracle.forces_along(law, overlap, closing, sliding, **own.deviates)
        force = found.force[1 : len(normal) + 1, 0]
        measured_normal, measured_shear = (np.einsum("ij,ij->i", force, axis) for axis in (normal, along))

        reason, tolerance = own.reason, own.tolerance
        results.compare_curves(self.name, f"normal_force_N of {name}", normal_force, measured_normal, tolerance, reason)
        results.compare_curves(self.name, f"shear_force_N of {name}", shear_force, measured_shear, tolerance, reason)

        self._judge_moments(name, overlap, shear_force, measured_shear, own, results)
        self._judge_apart(name, overlap, force, results)
        slips = _ends()[4] - 1
        limit = law.friction * law.elastic(overlap[slips + 1])
        note = "friction x elastic force, without the dashpot"
        if own.slip_limit:
            paper, limit = limit, law.friction * abs(normal_force[slips])
            note = f"{own.slip_limit}; the paper's law: {paper:.4g} N"
        what = f"slip_limit_N at {closing[slips]:.2g} m/s closing of {name}"
        results.compare(self.name, what, limit, abs(measured_shear[slips]), tolerance, note)
        results.curve(
            self.name,
            name,
            step=np.arange(1, len(normal) + 1),
            normal_force_N=measured_normal,
            normal_force_N_expected=normal_force,
            shear_force_N=measured_shear,
            shear_force_N_expected=shear_force,
        )

    def _law_of_spheres(self, scenario: Scenario):
        """The engine's law between the moved sphere and the held one."""
        r, mass = self.clump.radius_m, self.clump.mass_kg
        return self.engine.pair(
            scenario, contact_laws.effective_mass(mass, HELD_MASS), contact_laws.effective_radius(r, r)
        )

    def _judge_apart(self, name: str, overlap: np.ndarray, force: np.ndarray, results: Results) -> None:
        """No force (n, 3) in the middle of the time in which the contact is open; `overlap` (n + 1,)."""
        ends = _ends()
        apart = int((overlap[ends[4] : ends[5]] < 0).sum()) // 2 + ends[4] + 1
        while overlap[apart] >= 0:
            apart += 1
        worst = np.abs(force[apart - 1]).max()
        results.compare(self.name, f"force_N while apart of {name}", 0.0, worst, 0.0, "no contact")

    def _judge_moments(self, name: str, overlap, expected, measured, own: Along, results: Results) -> None:
        """Shear force (n,) after the steps in which the contact closes; `overlap` (n + 1,)."""
        ends = _ends()
        closes = int(np.flatnonzero(overlap[1:] > 0)[0])
        again = ends[5] + int(np.flatnonzero(overlap[ends[5] + 1 :] > 0)[0])
        for step, what in ((closes, "after the closing step"), (again, "after closing again")):
            note = (
                "eq. 3: share of the step in contact"
                if not own.deviates
                else "the code has no eq. 3: the whole step counts"
            )
            results.compare(
                self.name, f"shear_force_N {what} of {name}", expected[step], measured[step], own.tolerance, note
            )


CASES = (PrescribedPaths,)
