"""Verification of parallel bonds: two spheres moved along paths until the bond breaks, a cantilever, energy, clumps."""

from __future__ import annotations

import math

import numpy as np

from analysis import bond_law
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, load_scenario
from analysis.verification import bond_oracle, oracle
from analysis.verification.cases.case import Account, ProbedCase
from analysis.verification.cases.clump_cases import Motion
from analysis.verification.probes import Ball, ClumpAt, Probe, Trajectory
from analysis.verification.results import Results

HELD_MASS = 1e12
OVERLAP = 1e-12
"""Spheres must touch to be bonded, m: too little to be felt (0.1 mN)."""
STRONG = {"contact.bond.normal_strength": 1e9, "contact.bond.shear_strength": 1e9}
"""Bonds that never break."""


def bonded(name: str, values: dict[str, float] | None = None) -> Scenario:
    """Linear contacts with bonds that are as stiff in shear as along the normal, so that every way of breaking is near.

    Strengths are a tenth of Table 3's.
    """
    chosen = {
        "contact.bond.model": "parallel",
        "contact.bond.shear_stiffness": 4e9,
        "contact.bond.normal_strength": 3e6,
        "contact.bond.shear_strength": 3e6,
    }
    return load_scenario("linear-mu0.8").with_values(chosen | (values or {}), name)


def contact_law(scenario: Scenario) -> oracle.Linear:
    """The linear contact beside the bond."""
    stiffness = (scenario[f"contact.particle_particle.{way}_stiffness"] for way in ("normal", "shear"))
    return oracle.Linear(*stiffness, scenario["contact.particle_particle.friction"])


class BondPaths(ProbedCase):
    """Two bonded spheres, one held, one moved: force and torque at every point, and the load at which the bond breaks.

    The last path ends with the broken pair pressed and slid: nothing but the linear contact is left.
    """

    name, title = "bond-path", "Two bonded spheres along prescribed paths"
    account = Account(
        "Two bonded spheres are pulled, sheared, bent, twisted and all at once until the bond breaks.",
        "Force and moment grow by stiffness × way and turn with the bond; it breaks at strength × A, × I / R, × J / R.",
        "Potyondy and Cundall (2004), step by step in Python; strengths in closed form",
        "0.01 % of the greatest load; the step of breaking by 2 steps, in YADE by the steps between its "
        "looks at bonds.",
        ("pulled and bent", "torque_Nm"),
        4,
    )
    STEPS, STEP = 10_000, 1e-6

    def __init__(self, code: str):
        super().__init__(code)
        self.radius = derived.clump(load_scenario("linear-mu0.8")).radius_m
        limit = 3e6 / 4e9  # displacement at which a pulled or sheared bond breaks, m
        duration = self.STEPS * self.STEP
        pull, turn = limit / duration, limit / self.radius / duration
        self._entries = self._one_way(pull, turn) | self._several_ways(pull, turn)
        self._probes = {name: self._probe(name, *entry) for name, entry in self._entries.items()}

    def _one_way(self, pull: float, turn: float) -> dict[str, tuple]:
        """Paths that load the bond in one way, until it breaks after STEPS steps at `pull` m/s or `turn` rad/s.

        By name: scenario, radius of the held sphere over that of the moved one, [(velocity, spin, steps)].
        """
        none, n = (0.0, 0.0, 0.0), int(1.1 * self.STEPS)
        return {
            "pulled": (bonded("pulled"), 1.0, [((0, 0, pull), none, n)]),
            "sheared": (bonded("sheared"), 1.0, [((pull, 0, 0), none, n)]),
            "bent": (bonded("bent"), 1.0, self._arc(turn, n)),
            "twisted": (bonded("twisted"), 1.0, [(none, (0, 0, turn), n)]),
        }

    def _several_ways(self, pull: float, turn: float) -> dict[str, tuple]:
        """Paths that load the bond in several ways, or go on after it has broken; as those of `_one_way`."""
        none, n = (0.0, 0.0, 0.0), self.STEPS
        return {
            "pulled and bent": (
                bonded("pulled-bent"),
                1.0,
                [((0, 0, pull), none, n // 2), ((turn * self.radius, 0, 0), (0, turn, 0), n)],
            ),
            "all ways": (
                bonded("all-ways", STRONG),
                1.6,
                [
                    ((0, 0, 0.4 * pull), none, n // 4),
                    ((0.5 * pull, 0.8 * pull, 0), (0.2 * turn, -0.3 * turn, 0.9 * turn), n // 2),
                    ((-9 * pull, 4 * pull, 0), (-0.4 * turn, 0.6 * turn, -0.5 * turn), n // 2),
                    ((0, 0, -0.5 * pull), (0, 0.5 * turn, 3 * turn), n // 4),
                ],
            ),
            "broken": (
                bonded("broken", {"contact.bond.normal_strength": 3e5}),
                1.0,
                [
                    ((0, 0, 0.2 * pull), none, n),
                    ((0, 0, -0.4 * pull), none, int(0.4 * n)),  # to where a bond that heals would hold
                    ((0, 0, -0.4 * pull), (0, turn, 0), int(0.2 * n)),
                    ((0.5 * pull, 0, 0), (0, 0, turn), n // 4),
                    ((-0.2 * pull, 0.1 * pull, 0.02 * pull), none, n // 4),
                ],
            ),
        }

    def _arc(self, turn: float, steps: int, chords: int = 20) -> list:
        """The moved sphere spins at `turn` (rad/s) and goes round the held one half as fast: bending alone."""
        part = steps // chords
        angles = turn / 2 * self.STEP * part * np.arange(chords + 1)
        places = 2 * self.radius * np.column_stack([np.sin(angles), 0 * angles, np.cos(angles)])
        velocities = np.diff(places, axis=0) / (part * self.STEP)
        return [(tuple(velocity), (0, turn, 0), part) for velocity in velocities]

    def _probe(self, name: str, scenario: Scenario, larger: float, parts: list) -> Probe:
        other = larger * self.radius
        balls = (
            Ball(self.radius, 0.05, (0.0, 0.0, self.radius + other - OVERLAP)),
            Ball(other, HELD_MASS, (0.0, 0.0, 0.0), held=True),
        )
        return Probe(
            f"bond-{name.replace(' ', '-')}",
            scenario,
            self.STEP,
            sum(steps for *_, steps in parts),
            balls=balls,
            path=tuple((tuple(map(float, velocity)), steps) for velocity, _, steps in parts),
            spins=tuple(tuple(map(float, spin)) for _, spin, _ in parts),
        )

    def probes(self) -> list[Probe]:
        return list(self._probes.values())

    def loads(self, name: str) -> bond_oracle.Loads:
        """What the oracle expects."""
        scenario, larger, parts = self._entries[name]
        probe = self._probes[name]
        counts = [steps for *_, steps in parts]
        velocity = np.repeat([v for v, *_ in parts], counts, axis=0).astype(float)
        spin = np.repeat([w for _, w, _ in parts], counts, axis=0).astype(float)
        still = np.zeros_like(velocity)
        place = probe.balls[0].position + np.vstack([np.zeros(3), np.cumsum(velocity * probe.step, axis=0)])
        radii = (self.radius, larger * self.radius)
        return bond_oracle.loads_along(
            derived.bond(scenario, *radii),
            contact_law(scenario),
            radii,
            np.stack([place, np.zeros_like(place)], axis=1),
            np.stack([velocity, still], axis=1),
            np.stack([spin, still], axis=1),
            probe.step,
        )

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        for name, probe in self._probes.items():
            self._judge(name, found[probe.name], results)

    def _judge(self, name: str, found: Trajectory, results: Results) -> None:
        expected, steps = self.loads(name), self._probes[name].steps
        force, torque, holds = found.force[1 : steps + 1, 0], found.torque[1 : steps + 1, 0], found.bonds[1:] > 0
        first = expected.broken_at if expected.broken_at >= 0 else steps
        broke = int(np.argmin(holds)) if not holds.all() else steps
        # between the two moments at which oracle and engine break, nothing can be compared
        alike = np.ones(steps, bool)
        alike[min(first, broke) : max(first, broke) + (2 if first != steps else 0)] = False
        for what, mine, theirs in (("force_N", expected.force, force), ("torque_Nm", expected.torque, torque)):
            self._judge_path(name, what, mine, theirs, np.flatnonzero(alike), results)
        results.compare(self.name, f"bonds at the start of {name}", 1, found.bonds[0], 0.0, "spheres that touch")
        if first == steps:
            results.compare(self.name, f"bonds at the end of {name}", 1, found.bonds[-1], 0.0, "strong enough")
            return
        results.compare(self.name, f"bonds at the end of {name}", 0, found.bonds[-1], 0.0, "broken stays broken")
        checks = 0 if name in ("pulled", "sheared") else self.engine.steps_between_bond_checks
        late = checks or 2
        looks = f" between {self.engine.called}'s looks" if checks else ""
        note = f"the strength is reached in step {first}; {late} steps{looks}"
        results.compare(self.name, f"step in which it breaks, {name}", first, broke, late / first, note)
        self._judge_load(name, expected, force, torque, broke, late, results)
        pick = np.arange(0, steps, 25)
        results.curve(
            self.name,
            name,
            step=pick + 1.0,
            force_N=np.linalg.norm(force[pick], axis=1),
            force_N_expected=np.linalg.norm(expected.force[pick], axis=1),
            torque_Nm=np.linalg.norm(torque[pick], axis=1),
            torque_Nm_expected=np.linalg.norm(expected.torque[pick], axis=1),
        )

    def _judge_path(self, name: str, what: str, mine, theirs, pick: np.ndarray, results: Results) -> None:
        """Force or torque (steps, 3) at the steps `pick` of the path; `mine` is the oracle's."""
        # without a load in this way: what a ten-thousandth of the load at which a bond breaks would be
        law = derived.bond(self._entries[name][0])
        scale = max(
            np.abs(mine).max(),
            1e-4 * law.normal_stiffness * law.area * 7.5e-4 * (1.0 if what == "force_N" else law.radius),
        )
        worst = np.unravel_index(np.argmax(np.abs(theirs - mine)[pick]), (len(pick), 3))
        results.compare(
            self.name,
            f"{what} of {name}",
            mine[pick][worst],
            theirs[pick][worst],
            1e-4,
            "worst component of the whole path, in relation to the greatest; oracle step by step",
            scale=scale,
        )

    def _judge_load(self, name, expected, force, torque, broke, late, results: Results) -> None:
        """Load at which a bond breaks in one way alone, in closed form."""
        law = derived.bond(self._entries[name][0])
        last = broke - 1
        closed = {
            "pulled": (np.abs(force[last, 2]), law.tensile_strength * law.area, "strength x area"),
            "sheared": (
                np.abs(force[last, 0]),
                law.shear_strength * law.area,
                "strength x area; the pair lengthens and turns by up to 0.03 rad",
            ),
            "bent": (
                np.abs(torque[last, 1]),
                law.tensile_strength * law.moment_of_inertia / law.radius,
                "strength x I/R",
            ),
            "twisted": (np.abs(torque[last, 2]), law.shear_strength * law.polar_moment / law.radius, "strength x J/R"),
        }
        if name in closed:
            measured, strength, note = closed[name]
            tolerance = (1e-3 if name in ("sheared", "bent") else 2e-4) + late / self.STEPS
            results.compare(self.name, f"load at which it breaks, {name}", strength, measured, tolerance, note)


class BondCantilever(ProbedCase):
    """Ten bonded spheres in a row, the first held, under a weight that acts of a sudden: the tip swings about its rest.

    Expected: the same row as a linear system with deflection and rotation of each sphere, all modes; and beam theory.
    """

    name, title = "bond-cantilever", "Cantilever of ten bonded spheres"
    account = Account(
        "Ten bonded spheres in a row, the first held, bend under a weight that acts of a sudden.",
        "Row of springs as a linear system, all modes; at rest Timoshenko's cantilever.",
        "Linear algebra by numpy; Timoshenko beam theory",
        "1 %: the linear system leaves out that the row shortens as it bends.",
        ("tip", "tip_deflection_m"),
    )
    COUNT, GRAVITY, MASS = 10, 2.0, 0.04
    STEP, STEPS, EVERY = 4e-6, 60_000, 60

    def __init__(self, code: str):
        super().__init__(code)
        self.scenario = bonded("cantilever", STRONG)
        self.radius = derived.clump(self.scenario).radius_m
        self.length = 2 * self.radius - OVERLAP
        balls = tuple(
            Ball(self.radius, HELD_MASS if k == 0 else self.MASS, (k * self.length, 0.0, 0.0), held=k == 0)
            for k in range(self.COUNT)
        )
        self._probe = Probe(
            "bond-cantilever",
            self.scenario,
            self.STEP,
            self.STEPS,
            balls=balls,
            gravity=self.GRAVITY,
            every=self.EVERY,
        )

    def probes(self) -> list[Probe]:
        return [self._probe]

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        rows = found[self._probe.name]
        law = derived.bond(self.scenario)
        chain = bond_oracle.Chain(law, self.length, self.MASS, 0.4 * self.MASS * self.radius**2, self.COUNT - 1)
        static, moving = chain.under_weight(self.GRAVITY, rows.time)
        tip = -rows.position[:, -1, 2]
        note = "row as a linear system; its shortening is left out"
        results.compare_curves(self.name, "tip_deflection_m", moving[:, -1], tip, 0.01, note)
        period = 2 * math.pi / chain.first_frequency()
        mean = tip[rows.time <= period * int(rows.time[-1] / period)].mean()
        self._judge_rest(static[-1], self._by_beam_theory(law), mean, results)
        results.compare(self.name, "bonds", self.COUNT - 1, rows.bonds[-1], 0.0, "one between neighbours")
        pick = slice(None, None, 4)
        results.curve(
            self.name,
            "tip",
            time_s=rows.time[pick],
            tip_deflection_m=tip[pick],
            tip_deflection_m_expected=moving[pick, -1],
        )

    def _judge_rest(self, static: float, by_beam_theory: float, mean: float, results: Results) -> None:
        """The mean over whole swings is the deflection at rest, by the linear system and by beam theory (m)."""
        results.compare(
            self.name,
            "mean tip deflection_m",
            static,
            mean,
            0.01,
            "at rest, the same system; mean over whole periods of the first mode",
        )
        results.compare(
            self.name,
            "mean tip deflection_m against beam theory",
            by_beam_theory,
            mean,
            0.01,
            "Timoshenko's cantilever under an even load, and half a sphere's weight that hangs over the tip",
        )

    def _by_beam_theory(self, law: bond_law.Bond) -> float:
        """Deflection of the tip at rest, m, by Timoshenko's beam."""
        bend, slide = law.normal_stiffness * law.moment_of_inertia, law.shear_stiffness * law.area
        weight, span = self.MASS * self.GRAVITY, (self.COUNT - 1) * self.length
        stiffnesses = (bend * self.length, slide * self.length)
        return bond_oracle.beam_deflection(*stiffnesses, span, weight / self.length, weight / 2)


class BondEnergy(ProbedCase):
    """A free bonded pair that stretches, shears, bends and twists: energy, momentum and angular momentum are kept.

    The bond's energy is the oracle's, along the motion that the engine found.
    """

    name, title = "bond-energy", "Energy of a free bonded pair"
    account = Account(
        "A free bonded pair stretches, shears, bends and twists.",
        "Kinetic energy + energy of bond and contact stay; so do momentum and angular momentum.",
        "Conservation laws; energy of the bond from its loads and stiffnesses",
        "0.5 % of the energy, 0.2 % of the momenta at the worst moment of 20 ms: velocities are half a step "
        "apart from forces and are averaged.",
        ("total", "energy_J"),
    )
    MASS, STEP, STEPS = 0.04, 1e-6, 20_000

    def __init__(self, code: str):
        super().__init__(code)
        self.scenario = bonded("energy", STRONG | {"contact.particle_particle.friction": 0.0})
        self.radius = derived.clump(self.scenario).radius_m
        self.inertia = 0.4 * self.MASS * self.radius**2
        half = self.radius - OVERLAP / 2
        self._probe = Probe(
            "bond-energy",
            self.scenario,
            self.STEP,
            self.STEPS,
            balls=(
                Ball(self.radius, self.MASS, (0.0, 0.0, half), (0.3, 0.0, 0.5), (20.0, 0.0, 40.0)),
                Ball(self.radius, self.MASS, (0.0, 0.0, -half), (0.0, 0.2, -0.2), (-10.0, 15.0, -20.0)),
            ),
        )

    def probes(self) -> list[Probe]:
        return [self._probe]

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        rows, step = found[self._probe.name], self.STEP
        # velocities in the middle of each step, from the places; spins likewise from their mean
        moving = np.diff(rows.position, axis=0) / step
        turning = (rows.spin[1:] + rows.spin[:-1]) / 2
        radii = (self.radius, self.radius)
        loads = bond_oracle.loads_along(
            derived.bond(self.scenario), contact_law(self.scenario), radii, rows.position, moving, turning, step
        )
        # level with the forces: the mean of the two half steps around
        velocity = (moving[1:] + moving[:-1]) / 2
        spin = rows.spin[1:-1]
        if self.engine.velocity_age:  # half a step
            spin = (rows.spin[2:] + rows.spin[1:-1]) / 2
        kinetic = 0.5 * self.MASS * (velocity**2).sum(axis=(1, 2)) + 0.5 * self.inertia * (spin**2).sum(axis=(1, 2))
        self._judge_energy(rows.time[1:-1], kinetic, loads, results)
        self._judge_momenta(rows.position[1:-1], velocity, spin, results)
        results.compare(self.name, "bonds", 1, rows.bonds[-1], 0.0, "strong enough")

    def _judge_energy(self, time: np.ndarray, kinetic: np.ndarray, loads: bond_oracle.Loads, results: Results) -> None:
        """Kinetic energy (J, shape (rows,)) and what bond and contact hold stay together; the bond takes part."""
        total = kinetic + loads.bond_energy[:-1] + loads.contact_energy[:-1]
        start = sum(
            0.5 * self.MASS * np.dot(ball.velocity, ball.velocity) + 0.5 * self.inertia * np.dot(ball.spin, ball.spin)
            for ball in self._probe.balls
        )
        worst = total[np.argmax(np.abs(total - start))]
        results.compare(self.name, "energy_J", start, worst, 0.005, "worst moment of 20 ms")
        stored = float(loads.bond_energy.max() > 0.2 * start)
        what = "share of the energy in the bond"
        results.compare(self.name, what, 1.0, stored, 0.0, "more than a fifth at times")
        pick = slice(None, None, 50)
        results.curve(
            self.name,
            "total",
            time_s=time[pick],
            energy_J=total[pick],
            energy_J_expected=np.full(len(total[pick]), start),
        )

    def _judge_momenta(self, place: np.ndarray, velocity: np.ndarray, spin: np.ndarray, results: Results) -> None:
        """Momentum and angular momentum stay; arrays are (rows, balls, 3)."""
        momentum, spin_start = np.zeros(3), np.zeros(3)
        for ball in self._probe.balls:
            momentum += self.MASS * np.array(ball.velocity)
            spin_start += self.MASS * np.cross(ball.position, ball.velocity) + self.inertia * np.array(ball.spin)
        angular = (self.MASS * np.cross(place, velocity) + self.inertia * spin).sum(axis=1)
        linear = self.MASS * velocity.sum(axis=1)
        for what, expected, values in (
            ("momentum_kgm_s", momentum, linear),
            ("angular_momentum_kgm2_s", spin_start, angular),
        ):
            worst = np.unravel_index(np.argmax(np.abs(values - expected)), values.shape)
            results.compare(
                self.name,
                what,
                expected[worst[1]],
                values[worst],
                0.002,
                "worst component and moment, in relation to its size",
                scale=np.linalg.norm(expected),
            )


class BondsBetweenClumps(ProbedCase):
    """Two clumps that touch at one pair of spheres, one of them on the wall: one bond, none inside them or at the wall.

    They part with the bond between them, across a gap: it pulls on both clumps, momentum and angular momentum are kept.
    """

    name, title = "bond-clumps", "Bonds between clumps, not within them nor at walls"
    account = Account(
        "Two clumps that touch at one pair of spheres part, with a bond between them, one of them from the wall.",
        "One bond, none inside clumps nor at the wall; it pulls by k_n A × gap.",
        "Newton's third law; Potyondy and Cundall (2004)",
        "0.2 % of the pull and of the momenta: 1500 steps.",
    )
    SPEED, STEP, STEPS = 0.5, 1e-6, 1500

    def __init__(self, code: str):
        super().__init__(code)
        self.scenario = bonded("clumps", STRONG)
        self.clump = derived.clump(self.scenario)
        reach = self.clump.radius_m + self.clump.half_distance_m
        place = np.array([0.2, 0.2, reach - OVERLAP])
        upper = place + [0.0, 0.0, 2 * reach - OVERLAP]
        self._probe = Probe(
            "bond-clumps",
            self.scenario,
            self.STEP,
            self.STEPS,
            clumps=(
                ClumpAt(tuple(map(float, place)), velocity=(0.0, 0.0, self.SPEED), spin=(2.0, 0.0, 5.0)),
                ClumpAt(tuple(map(float, upper)), velocity=(0.1, 0.0, 2 * self.SPEED), spin=(0.0, 3.0, 0.0)),
            ),
            wall="linear",
        )

    def probes(self) -> list[Probe]:
        return [self._probe]

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        rows = found[self._probe.name]
        law = derived.bond(self.scenario)
        results.compare(self.name, "bonds", 1, rows.bonds[0], 0.0, "one pair of spheres of different clumps touches")
        for sphere in (0, 3):
            results.compare(
                self.name,
                f"force_N on sphere {sphere + 1}, after the wall",
                0.0,
                np.abs(rows.force[10:, sphere]).max(),
                0.0,
                "bonded to nothing: it touches only its own clump, or touched the wall",
            )
        stretch = np.linalg.norm(rows.position[-1, 2] - rows.position[-1, 1]) - 2 * self.clump.radius_m
        axis = rows.position[-1, 1] - rows.position[-1, 2]
        pull = -rows.force[-1, 1] @ axis / np.linalg.norm(axis)
        results.compare(
            self.name, "pull_N across the gap", law.normal_stiffness * law.area * stretch, pull, 0.002, "k_n A x gap"
        )
        self._judge_momenta(Motion(self.clump, rows), results)

    def _judge_momenta(self, motion: Motion, results: Results) -> None:
        """Momentum and angular momentum stay after the wall; velocities may be half a step old, both ends alike."""
        mass = self.clump.mass_kg
        linear = mass * motion.velocity.sum(axis=1)
        about = (mass * np.cross(motion.centre, motion.velocity) + motion.angular_momentum()).sum(axis=1)
        for what, values in (("momentum_kgm_s", linear), ("angular_momentum_kgm2_s", about)):
            results.compare(
                self.name,
                f"change of {what}",
                0.0,
                np.abs(values[-1] - values[10]).max(),
                0.002,
                "after the wall, in relation to its size",
                scale=np.linalg.norm(values[10]),
            )


CASES = (BondPaths, BondCantilever, BondEnergy, BondsBetweenClumps)
