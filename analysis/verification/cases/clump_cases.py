"""Verification of clumps as rigid bodies: free rotation, bounces, mass in the dashpot, conservation of energy."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

from analysis import contact_laws
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, load_scenario
from analysis.verification import oracle
from analysis.verification.cases.case import Account, ProbedCase
from analysis.verification.cases.impact_cases import own_slip_limit
from analysis.verification.engine_laws import PAPER, wall_law
from analysis.verification.probes import ClumpAt, Probe, Trajectory
from analysis.verification.results import Results

X, Y = 0.2, 0.2
"""Where cases take place, m: anywhere in the box."""


def about_y(degrees: float) -> tuple[float, float, float, float]:
    """Quaternion of a turn about y: the clump's axis leans from z to x."""
    x, y, z, w = Rotation.from_euler("y", degrees, degrees=True).as_quat()
    return (w, x, y, z)


class Motion:
    """Clumps as rigid bodies, from the spheres of a trajectory. Arrays (rows, clumps, 3), in space."""

    def __init__(self, clump: derived.Clump, found: Trajectory):
        self.clump, self.time = clump, found.time
        low, high = found.position[:, 0::2], found.position[:, 1::2]
        self.centre = (low + high) / 2
        self.axis = (high - low) / (2 * clump.half_distance_m)
        self.velocity = (found.velocity[:, 0::2] + found.velocity[:, 1::2]) / 2
        self.spin = found.spin[:, 0::2]
        self.force = found.force[:, 0::2] + found.force[:, 1::2]

    def angular_momentum(self) -> np.ndarray:
        """kg m2/s."""
        along = np.einsum("rci,rci->rc", self.spin, self.axis)[:, :, None] * self.axis
        return self.clump.inertia_transverse_kgm2 * (self.spin - along) + self.clump.inertia_axial_kgm2 * along

    def kinetic_energy(self) -> np.ndarray:
        """J per clump, translation and rotation, shape (rows, clumps)."""
        moving = 0.5 * self.clump.mass_kg * (self.velocity**2).sum(axis=2)
        return moving + 0.5 * np.einsum("rci,rci->rc", self.spin, self.angular_momentum())


class FreeRotation(ProbedCase):
    """Case 6a: a clump that spins freely about no principal axis keeps its energy and its angular momentum, and its
    axis goes round the momentum at |L| / I_transverse. No contact ever acts between its own spheres."""

    name, title = "free-rotation", "A clump spins freely"
    account = Account(
        "A clump spins freely about an axis that is none of its own.",
        "Energy and angular momentum L stay; the clump's axis goes round L at |L| / I_transverse.",
        "Euler's equations of a symmetric body, closed form",
        "0.1 % of the momentum, 0.5 % of the axis over 10⁵ steps; 0.5 % of the energy in YADE, whose "
        "rotation gains energy in "
        "proportion to step and time.",
        ("axis", "axis_x"),
    )
    SPIN = (60.0, 20.0, 150.0)

    def __init__(self, code: str):
        # The paper's step: what YADE's rotation gains grows with the step, and the tolerance was set for this one.
        super().__init__(code)
        self.scenario = load_scenario("linear-mu0.8", variant="paper-step")
        self.clump = derived.clump(self.scenario)
        step = derived.time_grid(self.scenario).step_s
        self._probe = Probe(
            "free-rotation",
            self.scenario,
            step,
            100_000,
            every=100,
            clumps=(ClumpAt((X, Y, 0.2), velocity=(0.1, -0.05, 0.02), spin=self.SPIN),),
        )

    def probes(self) -> list[Probe]:
        return [self._probe]

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        rows = found[self._probe.name]
        motion = Motion(self.clump, rows)
        momentum = np.array(
            [
                self.clump.inertia_transverse_kgm2 * self.SPIN[0],
                self.clump.inertia_transverse_kgm2 * self.SPIN[1],
                self.clump.inertia_axial_kgm2 * self.SPIN[2],
            ]
        )
        self._judge_kept(momentum, motion, results)
        self._judge_axis(momentum, motion, rows.time, results)
        for quantity, value in (("contacts", rows.contacts.max()), ("force_N", np.abs(rows.force).max())):
            between = f"{quantity} between the clump's own spheres"
            results.compare(self.name, between, 0, value, 0.0, "they overlap, never act")

    def _judge_kept(self, momentum: np.ndarray, motion: Motion, results: Results) -> None:
        """Energy and angular momentum stay."""
        energy = 0.5 * momentum @ np.array(self.SPIN) + 0.5 * self.clump.mass_kg * (0.1**2 + 0.05**2 + 0.02**2)
        reason = "closed form, 1e5 steps of the scenario"
        results.compare(
            self.name,
            "kinetic_energy_J",
            energy,
            motion.kinetic_energy()[-1, 0],
            self.engine.rotation_tolerance,
            reason + self.engine.rotation_note,
        )
        for k, axis in enumerate("xyz"):
            results.compare(
                self.name,
                f"angular_momentum_{axis}_kgm2_s",
                momentum[k],
                motion.angular_momentum()[-1, 0, k],
                0.001,
                reason + "; in relation to its size",
                scale=np.linalg.norm(momentum),
            )

    def _judge_axis(self, momentum: np.ndarray, motion: Motion, time: np.ndarray, results: Results) -> None:
        """The axis goes round the momentum."""
        transverse = self.clump.inertia_transverse_kgm2
        expected = precession(motion.axis[1, 0], momentum, transverse, time - time[1])
        turns = np.linalg.norm(momentum) / transverse * time[-1] / 2 / math.pi
        for k, axis in enumerate("xyz"):
            results.compare_curves(
                self.name,
                f"axis_{axis}",
                expected[1:, k],
                motion.axis[1:, 0, k],
                0.005,
                f"closed form over {turns:.1f} turns",
            )
        pick = slice(1, None, 5)
        results.curve(
            self.name,
            "axis",
            time_s=time[pick],
            axis_x=motion.axis[pick, 0, 0],
            axis_x_expected=expected[pick, 0],
            axis_z=motion.axis[pick, 0, 2],
            axis_z_expected=expected[pick, 2],
        )


def precession(axis: np.ndarray, momentum: np.ndarray, transverse: float, times: np.ndarray) -> np.ndarray:
    """Axis of a free symmetric body over time: it turns about the constant angular momentum at |L| / I_transverse."""
    size = np.linalg.norm(momentum)
    return Rotation.from_rotvec(np.outer(size / transverse * times, momentum / size)).apply(axis)


class ClumpBounce(ProbedCase):
    """Case 6b: a clump falls obliquely on the wall, with friction, against an integration of the rigid body.

    One falls upright, so that the dashpot's mass shows: it is the whole clump's.
    """

    name, title = "clump-bounce", "A clump bounces off the wall"
    account = Account(
        "A clump falls on the wall: upright, flat, leaning, on both ends, spinning.",
        "Newton's and Euler's equations of the rigid clump with the wall's law at each sphere; the dashpot "
        "has the clump's mass.",
        "Eq. 1 to 7 of the paper; rigid body integrated by scipy",
        "0.5 % of the incoming speed: contacts of some 1000 steps, slip that begins within a step.",
        ("leaning-damped", "velocity_x_m_s"),
        7,
    )
    # lean of the axis (degrees), velocity (x, z), spin about y
    FALLS = {
        "upright": (0.0, 0.0, -1.0, 0.0),
        "flat": (90.0, 0.3, -1.0, 0.0),
        "leaning": (35.0, 0.5, -1.0, 0.0),
        "two-ends": (86.0, -0.4, -1.0, 5.0),
        "spinning": (60.0, 1.0, -0.5, -40.0),
    }

    def __init__(self, code: str):
        super().__init__(code)
        linear, nonlinear = load_scenario("linear-mu0.8"), load_scenario("nonlinear-en1.0")
        self.clump = derived.clump(linear)
        self._entries = [
            (f"{name}-{label}", scenario, *self._probe(f"clump-{name}-{label}", scenario, *fall))
            for label, scenario in (("linear", linear), ("damped", nonlinear))
            for name, fall in self.FALLS.items()
        ]

    def _probe(self, name: str, scenario: Scenario, lean: float, vx: float, vz: float, spin: float):
        law = wall_law(scenario, self.clump.mass_kg)
        step = math.pi * math.sqrt(law.mass / law.normal_stiffness) / 1000
        reach = self.clump.radius_m + self.clump.half_distance_m * abs(math.cos(math.radians(lean)))
        height = reach - 20.4 * step * vz
        start = (0.0, height, math.radians(lean), vx, vz, spin)
        probe = Probe(
            name,
            scenario,
            step,
            4000,
            wall="linear",
            every=4,
            clumps=(ClumpAt((X, Y, height), about_y(lean), (vx, 0.0, vz), (0.0, spin, 0.0)),),
        )
        return probe, start

    def probes(self) -> list[Probe]:
        return [entry[2] for entry in self._entries]

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        for name, scenario, probe, start in self._entries:
            rows = found[probe.name]
            motion, law = Motion(self.clump, rows), wall_law(scenario, self.clump.mass_kg)
            states, reason = self._expected(law, probe, start, rows.time)
            speed, h = math.hypot(start[3], start[4]), self.clump.half_distance_m
            measured = (motion.velocity[-1, 0, 0], motion.velocity[-1, 0, 2], motion.spin[-1, 0, 1])
            scales = (speed, speed, speed / h)
            for quantity, expected, value, scale in zip(
                ("velocity_x_m_s", "velocity_z_m_s", "spin_rad_s"), states[-1][3:], measured, scales, strict=True
            ):
                results.compare(self.name, f"{quantity} of {name}", expected, value, 0.005, reason, scale=scale)
            if name.startswith("upright"):
                results.compare(
                    self.name,
                    f"restitution of {name}",
                    contact_laws.dashpot_restitution(law.damping_ratio),
                    -measured[1] / start[4],
                    0.005,
                    "closed form with the mass of the whole clump",
                )
            pick = slice(None, None, 10)
            results.curve(
                self.name,
                name,
                time_s=rows.time[pick],
                velocity_x_m_s=motion.velocity[pick, 0, 0],
                velocity_x_m_s_expected=states[pick, 3],
                velocity_z_m_s=motion.velocity[pick, 0, 2],
                velocity_z_m_s_expected=states[pick, 4],
                spin_rad_s=motion.spin[pick, 0, 1],
                spin_rad_s_expected=states[pick, 5],
            )

    def _expected(self, law: oracle.Linear, probe: Probe, start: tuple, time: np.ndarray) -> tuple[np.ndarray, str]:
        """States of the rigid body over time by the engine's law, and what is said of them."""
        h, r = self.clump.half_distance_m, self.clump.radius_m
        body = oracle.Body(self.clump.mass_kg, self.clump.inertia_transverse_kgm2, ((0.0, -h, r), (0.0, h, r)))
        _, states, _ = oracle.bounce(body, [law, law], start, time[-1], len(time))
        scale = "error in relation to the incoming speed"
        if not (self.engine.wall_slip_limit and law.damping_ratio):
            return states, f"rigid body integrated by scipy; {scale}"
        paper, states = states[-1][3:], own_slip_limit(body, [law, law], start, probe)
        along, down, turning = states[-1][3:] - paper
        return states, (
            f"{self.engine.wall_slip_limit}: its own value, {along:+.2g}, {down:+.2g} m/s and {turning:+.2g} rad/s "
            f"from the paper's law; {scale}"
        )


class ClumpPair(ProbedCase):
    """Case 6c: two clumps meet head-on, end to end: inertia and dashpot have the mass of whole clumps."""

    name, title = "clump-pair", "Two clumps meet end to end"
    account = Account(
        "Two clumps meet end to end at 1 m/s.",
        "As two spheres of the clump's mass: restitution, peak overlap and peak force.",
        "Eq. 6, 7 and 14 to 16 of the paper, integrated by scipy",
        "0.5 %: 2000 steps in contact; a dashpot with the mass of half a clump changes the linear "
        "restitution by a fifth.",
        ("hysteretic", "force_N"),
        1,
    )
    SPEED = 1.0

    def __init__(self, code: str):
        super().__init__(code)
        linear, damped = load_scenario("linear-mu0.8"), load_scenario("nonlinear-md1-en0.6")
        self.clump = derived.clump(linear)
        mass, radius = self.clump.mass_kg / 2, self.clump.radius_m
        self._entries = []
        for name, scenario in (
            ("linear", linear.with_values({"contact.particle_particle.damping_ratio": 0.2}, "damped")),
            ("hysteretic", damped),
        ):
            law = self.engine.pair(scenario, mass, contact_laws.effective_radius(radius, radius))
            step = oracle.head_on(law, self.SPEED).duration_s / 2000
            reach = radius + self.clump.half_distance_m + 10.2 * step * self.SPEED
            clumps = tuple(
                ClumpAt((X + side * reach, Y, 0.2), about_y(90), (-side * self.SPEED / 2, 0.0, 0.0)) for side in (-1, 1)
            )
            self._entries.append((name, law, Probe(f"clump-pair-{name}", scenario, step, 2200, clumps=clumps)))

    def probes(self) -> list[Probe]:
        return [entry[-1] for entry in self._entries]

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        for name, law, probe in self._entries:
            motion = Motion(self.clump, found[probe.name])
            expected = oracle.head_on(law, self.SPEED)
            apart = motion.centre[:, 1, 0] - motion.centre[:, 0, 0]
            overlap = 2 * (self.clump.radius_m + self.clump.half_distance_m) - apart
            restitution = (motion.velocity[-1, 1, 0] - motion.velocity[-1, 0, 0]) / self.SPEED
            results.compare(self.name, f"restitution of {name}", expected.restitution, restitution, 0.005, "oracle")
            force = motion.force[:, 1, 0]
            for quantity, peak in (("peak_overlap_m", overlap.max()), ("peak_force_N", force.max())):
                results.compare(self.name, f"{quantity} of {name}", getattr(expected, quantity), peak, 0.005, "oracle")
            pick = expected.time_s[::8]
            force = np.interp(pick, motion.time - 20.4 * probe.step, force)
            results.curve(self.name, name, time_s=pick, force_N=force, force_N_expected=expected.force_N[::8])


class ColumnEnergy(ProbedCase):
    """Case 8: a column of clumps falls on the floor under gravity.

    Without friction and damping its energy stays within 0.5 % over 1e5 steps. With friction the balance closes: energy
    at the start = kinetic + potential + elastic + dissipated, where the dissipation is summed from slip and dashpots.
    """

    name, title = "energy", "Energy of a column of clumps"
    account = Account(
        "Three clumps fall on the floor and bounce, without losses; one slides over the floor, with friction "
        "and dashpot.",
        "Kinetic + potential + elastic energy stays; with friction plus what slip and dashpots lost.",
        "Conservation of energy; elastic energy ½ k × overlap², Hertz ⅖ h × overlap^(5/2)",
        "0.5 % over 10⁵ steps: so much it may drift; the column of Hertz contacts in YADE comes nearest to it.",
        ("friction", "energy_J"),
    )

    def __init__(self, code: str):
        super().__init__(code)
        linear, nonlinear = load_scenario("linear-mu0.8"), load_scenario("nonlinear-en1.0")
        self.clump = derived.clump(linear)
        self._column = {
            "linear": self._falling("linear", linear, 1e-6),
            "hertz": self._falling("hertz", nonlinear, 2e-6),
        }
        height = self.clump.radius_m + self.clump.half_distance_m * math.sin(math.radians(4.0)) + 2e-5
        slider = (ClumpAt((X, Y, height), about_y(86.0), (1.0, 0.2, -0.3), (0.0, 10.0, 0.0)),)
        self._slider = Probe(
            "energy-friction",
            nonlinear.with_values({"contact.particle_wall.friction": 0.3}, "rough"),
            5e-7,
            6000,
            clumps=slider,
            wall="linear",
            gravity=9.81,
        )

    def _falling(self, name: str, scenario: Scenario, step: float) -> Probe:
        """Three clumps above each other, without friction and damping."""
        smooth = {
            "contact.particle_particle.friction": 0.0,
            "contact.particle_wall.friction": 0.0,
            "contact.particle_wall.damping_ratio": 0.0,
        }
        pitch = 2 * self.clump.radius_m + 2e-3
        clumps = tuple(
            ClumpAt((X + 1e-3 * k, Y + 5e-4 * k, self.clump.radius_m + 1e-3 + k * pitch), about_y(90 + 3 * k))
            for k in range(3)
        )
        return Probe(
            f"energy-{name}",
            scenario.with_values(smooth, "smooth"),
            step,
            100_000,
            clumps=clumps,
            wall="linear",
            gravity=9.81,
            every=50,
        )

    def probes(self) -> list[Probe]:
        return [*self._column.values(), self._slider]

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        for name, probe in self._column.items():
            kinetic, potential, elastic = self._energies(probe, found[probe.name])
            total = kinetic + potential + elastic
            time = found[probe.name].time
            results.compare(self.name, f"energy_J of the {name} column", total[1], total[-1], 0.005, "after 1e5 steps")
            worst = 1 + int(np.argmax(np.abs(total[1:] - total[1])))
            results.compare(
                self.name, f"energy_J of the {name} column, worst row", total[1], total[worst], 0.005, "over 1e5 steps"
            )
            pick = slice(1, None, 10)
            results.curve(
                self.name,
                f"{name} column",
                time_s=time[pick],
                energy_J=total[pick],
                energy_J_expected=np.full_like(total[pick], total[1]),
            )
        self._judge_friction(found[self._slider.name], results)

    def _energies(self, probe: Probe, found: Trajectory):
        """Kinetic, potential and elastic energy (J) of all clumps over time, from positions and velocities alone."""
        motion = Motion(self.clump, found)
        # bring the velocity level with the position
        gravity = np.array([0.0, 0.0, -probe.gravity])
        late = self.engine.velocity_age * probe.step
        motion.velocity = motion.velocity + (motion.force / self.clump.mass_kg + gravity) * late
        kinetic = motion.kinetic_energy().sum(axis=1)
        potential = self.clump.mass_kg * probe.gravity * motion.centre[:, :, 2].sum(axis=1)
        r, mass = self.clump.radius_m, self.clump.mass_kg
        elastic = np.zeros(len(found.time))
        floor = np.maximum(r - found.position[:, :, 2], 0.0)
        elastic += 0.5 * probe.scenario["contact.particle_wall.normal_stiffness"] * (floor**2).sum(axis=1)
        pair = PAPER.pair(probe.scenario, mass / 2, contact_laws.effective_radius(r, r))
        for i in range(found.position.shape[1]):
            for j in range(i + 1, found.position.shape[1]):
                if i // 2 == j // 2:
                    continue
                overlap = np.maximum(2 * r - np.linalg.norm(found.position[:, i] - found.position[:, j], axis=1), 0.0)
                if isinstance(pair, oracle.Linear):
                    elastic += 0.5 * pair.normal_stiffness * overlap**2
                else:
                    elastic += (
                        0.4
                        * contact_laws.hertz_coefficient(pair.shear_modulus, pair.poisson_ratio, pair.radius)
                        * overlap**2.5
                    )
        return kinetic, potential, elastic

    def _judge_friction(self, found: Trajectory, results: Results) -> None:
        probe = self._slider
        law = wall_law(probe.scenario, self.clump.mass_kg)
        kinetic, potential, elastic = self._energies(probe, found)
        shear = found.force[:, :, :2]
        elastic = elastic + 0.5 * (shear**2).sum(axis=(1, 2)) / law.shear_stiffness
        slip_work, dashpot_work = dissipation(law, self.clump.radius_m, found, probe.step)
        total = kinetic + potential + elastic + np.cumsum(slip_work + dashpot_work)
        lost = kinetic[1] + potential[1] - kinetic[-1] - potential[-1]
        results.compare(
            self.name,
            "dissipated_J with friction and dashpot",
            lost,
            (slip_work + dashpot_work).sum(),
            0.005,
            f"lost kinetic and potential energy; {slip_work.sum() / lost:.0%} of it by slip",
        )
        worst = 1 + int(np.argmax(np.abs(total[1:] - total[1])))
        results.compare(
            self.name,
            "energy_J with friction and dashpot, worst row",
            total[1],
            total[worst],
            0.005,
            "kinetic + potential + elastic + dissipated",
        )
        pick = slice(1, None, 20)
        results.curve(
            self.name,
            "friction",
            time_s=found.time[pick],
            energy_J=total[pick],
            energy_J_expected=np.full_like(total[pick], total[1]),
        )


def dissipation(law: oracle.Linear, radius: float, found: Trajectory, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Work (J) of slip and of the dashpot in each step before a row, all spheres on the wall z = 0; shape (rows,).

    Slip is what is left of the shear displacement of a step after its elastic part, the change of force over k_s.
    """
    slip, dashpot = np.zeros(len(found.time)), np.zeros(len(found.time))
    coefficient = contact_laws.linear_dashpot_coefficient(law.damping_ratio, law.mass, law.normal_stiffness)
    for k in range(found.position.shape[1]):
        place, spin, force = found.position[:, k], found.spin[:, k], found.force[:, k]
        overlap = radius - place[:, 2]
        touching = overlap > 0
        moved = np.diff(place, axis=0)
        turned = (spin[1:] + spin[:-1]) / 2 * step
        arm = radius - np.maximum(overlap[1:], 0) / 2
        along = np.column_stack([moved[:, 0] - arm * turned[:, 1], moved[:, 1] + arm * turned[:, 0]])
        share = np.where(
            touching[:-1], 1.0, np.clip(overlap[1:] / np.where(moved[:, 2] != 0, -moved[:, 2], 1.0), 0.0, 1.0)
        )
        change = np.diff(force[:, :2], axis=0)
        mean = (force[1:, :2] + force[:-1, :2]) / 2
        slip[1:] -= np.einsum("ij,ij->i", mean, along * share[:, None] + change / law.shear_stiffness) * (
            touching[1:] | touching[:-1]
        )
        dashpot[1:] += coefficient * moved[:, 2] ** 2 / step * (touching[1:])
    return slip, dashpot


CASES = (FreeRotation, ClumpBounce, ClumpPair, ColumnEnergy)
