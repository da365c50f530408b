"""Verification by impacts: head-on, on the wall, oblique, Chung and Ooi's tests, contacts without approach speed."""

from __future__ import annotations

import math
from abc import abstractmethod

import numpy as np
from scipy.integrate import solve_ivp

from analysis import contact_laws
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, load_scenario
from analysis.verification import oracle
from analysis.verification.cases.case import Account, ProbedCase
from analysis.verification.engine_laws import PAPER, wall_law
from analysis.verification.probes import Ball, Probe, Trajectory
from analysis.verification.results import Results

STEPS_BEFORE = 20.4
"""Free flight before the contact, in steps: it closes within a step, as contacts do."""
MEASURES = ("peak_overlap_m", "peak_force_N", "duration_s", "restitution")


# ------------------------------------------------------------------ a head-on impact


def against_ball(
    name: str, scenario: Scenario, law, radius: float, mass: float, speed: float, plane_factor: float = 0.0
) -> Probe:
    """Two equal spheres that approach at `speed`, or one on a held sphere `plane_factor` times as large."""
    step, steps = _resolution(law, speed)
    gap = STEPS_BEFORE * step * speed
    if plane_factor:
        size = plane_factor * radius
        balls = (
            Ball(radius, mass, (0.0, 0.0, radius + gap), (0.0, 0.0, -speed)),
            Ball(size, 1e12, (0.0, 0.0, -size), held=True),
        )
    else:
        balls = (
            Ball(radius, mass, (0.0, 0.0, radius + gap), (0.0, 0.0, -speed / 2)),
            Ball(radius, mass, (0.0, 0.0, -radius), (0.0, 0.0, speed / 2)),
        )
    return Probe(name, scenario, step, steps, balls=balls)


def against_wall(name: str, scenario: Scenario, law, radius: float, mass: float, speed: float, wall: str) -> Probe:
    """One sphere on the wall z = 0."""
    step, steps = _resolution(law, speed)
    ball = Ball(radius, mass, (0.0, 0.0, radius + STEPS_BEFORE * step * speed), (0.0, 0.0, -speed))
    return Probe(name, scenario, step, steps, balls=(ball,), wall=wall)


def _resolution(law, speed: float) -> tuple[float, int]:
    """Time step and number of steps: 3000 steps in contact and a few more."""
    return oracle.head_on(law, speed).duration_s / 3000, 3120


def measure(probe: Probe, found: Trajectory) -> tuple[dict[str, float], np.ndarray, np.ndarray]:
    """Peak overlap, peak force, duration and restitution of a head-on impact along z; overlap and force over time."""
    first = probe.balls[0]
    if probe.wall:
        distance, reach = found.position[:, 0, 2], first.radius
        speed, approach = found.velocity[:, 0, 2], -first.velocity[2]
    else:
        distance = found.position[:, 0, 2] - found.position[:, 1, 2]
        reach = first.radius + probe.balls[1].radius
        speed = found.velocity[:, 0, 2] - found.velocity[:, 1, 2]
        approach = probe.balls[1].velocity[2] - first.velocity[2]
    overlap, force = reach - distance, found.force[:, 0, 2]
    touching = np.flatnonzero(overlap > 0)
    if len(touching) == 0 or touching[-1] + 1 >= len(overlap):
        return dict.fromkeys(MEASURES, math.nan), overlap, force
    ends = []
    for inside, outside in ((touching[0], touching[0] - 1), (touching[-1], touching[-1] + 1)):
        share = overlap[inside] / (overlap[inside] - overlap[outside])
        ends.append(inside + share * (outside - inside))
    return (
        {
            "peak_overlap_m": overlap.max(),
            "peak_force_N": force.max(),
            "duration_s": (ends[1] - ends[0]) * probe.step,
            "restitution": speed[-1] / approach,
        },
        overlap,
        force,
    )


class MeasuredImpacts(ProbedCase):
    """A group of head-on impacts, each with its law, tolerance and remarks."""

    def __init__(self, code: str):
        super().__init__(code)
        self._entries = []
        self.make()

    @abstractmethod
    def make(self) -> None:
        """Add the impacts."""

    def add(
        self,
        probe: Probe,
        law,
        speed: float,
        tolerance: float = 0.002,
        reason: str = "",
        expected: dict[str, float] | None = None,
        only: tuple[str, ...] = MEASURES,
    ) -> None:
        """`expected` replaces values of the oracle, e.g. by closed forms; `only` names what to compare."""
        self._entries.append((probe, law, speed, tolerance, reason, expected or {}, only))

    def probes(self) -> list[Probe]:
        return [entry[0] for entry in self._entries]

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        for probe, law, speed, tolerance, reason, closed, only in self._entries:
            measured, overlap, force = measure(probe, found[probe.name])
            impact = oracle.head_on(law, speed)
            for quantity in only:
                expected = closed.get(quantity, getattr(impact, quantity))
                results.compare(
                    self.name, f"{quantity} of {probe.name}", expected, measured[quantity], tolerance, reason
                )
            time = found[probe.name].time - STEPS_BEFORE * probe.step
            pick = impact.time_s[::8]
            results.curve(
                self.name,
                probe.name,
                time_s=pick,
                force_N=np.interp(pick, time, force),
                force_N_expected=impact.force_N[::8],
                overlap_m=np.interp(pick, time, overlap),
                overlap_m_expected=impact.overlap_m[::8],
            )


# ------------------------------------------------------------------ cases


class HeadOn(MeasuredImpacts):
    """Case 1: two spheres of the clump's radius and mass, linear and hysteretic, at two speeds."""

    name, title = "head-on", "Head-on impact of two spheres"
    account = Account(
        "Two equal spheres meet at 0.1 and 1 m/s, with the linear law and with every damping mode and restitution.",
        "Linear: peak overlap v √(m / k), peak force v √(m k), duration π √(m / k). Hertz: peak overlap (5 m "
        "v² / 4 h)^(2/5), "
        "force h × overlap^(3/2). With damping: restitution from the factor D alone.",
        "Eq. 1 and 8 of the paper, Hertz (1882); with damping eq. 14 to 16, integrated by scipy",
        "0.2 %: a contact lasts 3000 steps. What the steps leave out is below that; a wrong factor or mass is not.",
        ("md1-en0.6-1", "force_N"),
    )

    def make(self) -> None:
        linear, nonlinear = load_scenario("linear-mu0.8"), load_scenario("nonlinear-en1.0")
        self.clump = derived.clump(linear)
        self.mass = contact_laws.effective_mass(self.clump.mass_kg, self.clump.mass_kg)
        self.radius = contact_laws.effective_radius(self.clump.radius_m, self.clump.radius_m)
        for speed in (0.1, 1.0):
            law = self.engine.pair(linear, self.mass, self.radius)
            closed = contact_laws.linear_impact(self.mass, law.normal_stiffness, 0.0, speed)
            self._add_pair("linear", linear, law, speed, expected=closed)
            for mode, nominal in [(m, e) for m in (0, 1, 2) for e in (0.0, 0.3, 0.6, 0.9, 1.0) if m or e]:
                scenario = nonlinear.with_values(
                    {"contact.particle_particle.damping_mode": mode, "contact.particle_particle.restitution": nominal},
                    "head-on",
                )
                law = self.engine.pair(scenario, self.mass, self.radius)
                factor = contact_laws.damping_factor(mode, nominal)
                closed, reason = self._expected(scenario, law, factor, speed)
                self._add_pair(f"md{mode}-en{nominal:g}", scenario, law, speed, reason, closed)

    def _add_pair(self, name: str, scenario: Scenario, law, speed: float, reason: str = "", expected=None) -> None:
        clump = self.clump
        probe = against_ball(f"{name}-{speed:g}", scenario, law, clump.radius_m, clump.mass_kg, speed)
        self.add(probe, law, speed, reason=reason, expected=expected)

    def _expected(self, scenario: Scenario, law, factor: float, speed: float) -> tuple[dict[str, float], str]:
        """What is known in closed form of an impact with the damping factor D, and what is said of it."""
        closed = _hysteretic_closed_form(self.mass, law, factor, speed)
        if isinstance(law, oracle.ViscousHertz):
            own = oracle.head_on(law, speed)
            paper = oracle.head_on(PAPER.pair(scenario, self.mass, self.radius), speed)
            overlap, force = (
                closed["peak_overlap_m"] / own.peak_overlap_m - 1,
                paper.peak_force_N / own.peak_force_N - 1,
            )
            # restitution of the paper's law, not of what stands in
            return {"restitution": contact_laws.hysteretic_restitution(factor)}, (
                f"{self.engine.hysteretic_note}; the paper's law: peak overlap {overlap:+.1%}, peak force {force:+.1%}"
            )
        if factor > contact_laws.LIMIT_FREE_FACTOR:
            return {}, f"D = {factor:.3g}: the dashpot meets its limit, expected from the oracle"
        return closed, ""


def _hysteretic_closed_form(mass: float, law, factor: float, speed: float) -> dict[str, float]:
    coefficient = contact_laws.hertz_coefficient(law.shear_modulus, law.poisson_ratio, law.radius)
    if factor == 0:
        return contact_laws.hertz_impact(mass, coefficient, speed)
    return {
        "peak_overlap_m": contact_laws.hysteretic_peak_overlap(mass, coefficient, factor, speed),
        "restitution": contact_laws.effective_restitution(factor),
    }


class WallDashpot(MeasuredImpacts):
    """Case 5: restitution of the wall's dashpot, 0.8279 at a damping ratio of 0.06."""

    name, title = "wall-dashpot", "Impact on the wall with damping ratio 0.06"
    account = Account(
        "A sphere meets the study's wall at 0.1 and 1 m/s.",
        "Restitution exp(−π β / √(1 − β²)) = 0.828 at β = 0.06, at any speed.",
        "Eq. 1 and 6 of the paper; Kawaguchi's closed form of the free impact",
        "0.2 %: a contact lasts 3000 steps, whose error is below a tenth of that.",
        ("wall-1", "overlap_m"),
    )

    def make(self) -> None:
        scenario = load_scenario("nonlinear-en1.0")
        clump = derived.clump(scenario)
        law = wall_law(scenario, clump.mass_kg)
        for speed in (0.1, 1.0):
            self.add(
                against_wall(f"wall-{speed:g}", scenario, law, clump.radius_m, clump.mass_kg, speed, "linear"),
                law,
                speed,
                expected=contact_laws.linear_impact(clump.mass_kg, law.normal_stiffness, law.damping_ratio, speed),
            )


# Chung and Ooi 2011, Granular Matter 13, 643: Young's modulus (Pa), Poisson's ratio, density (kg/m3)
GLASS, LIMESTONE = (48e9, 0.20, 2800.0), (20e9, 0.25, 2500.0)
ALUMINIUM, MAGNESIUM = (70e9, 0.30, 2699.0), (40e9, 0.35, 1800.0)
ALUMINIUM_OXIDE, CAST_IRON = (380e9, 0.23, 4000.0), (100e9, 0.25, 7000.0)


def _material(
    name: str, young: float, poisson: float, rigid_plane: bool, mode: int = 1, nominal: float = 1.0
) -> Scenario:
    """The hysteretic scenario with another material; a rigid plane doubles the moduli of the contact."""
    shear = young / (2 * (1 + poisson))
    shear, poisson = contact_laws.equivalent_material(shear, poisson, math.inf if rigid_plane else shear, poisson)
    return load_scenario("nonlinear-en1.0").with_values(
        {
            "contact.particle_particle.shear_modulus": shear,
            "contact.particle_particle.poisson_ratio": poisson,
            "contact.particle_particle.damping_mode": mode,
            "contact.particle_particle.restitution": nominal,
        },
        name,
    )


class ChungOoi(MeasuredImpacts):
    """Case 4: tests 1 to 3. The rigid plane of 2 and 3 is a wall with the particles' law where the engine has one, else
    a held sphere 10^4 times as large: the study's own walls are linear. The dashpot of 3 is also tried on those.
    """

    name, title = "chung-ooi", "Chung and Ooi (2011), tests 1, 2 and 3"
    account = Account(
        "Glass and limestone spheres meet; aluminium, magnesium, aluminium oxide and iron ones hit a rigid plane.",
        "Hertz: peak overlap (5 m v² / 4 h)^(2/5), peak force h × overlap^(3/2); test 3: restitution 0.2 to "
        "1, as prescribed.",
        "Chung and Ooi (2011), Granular Matter 13, 643, tests 1 to 3; the published numbers stand in the table",
        "0.2 % for test 1 and 2, elastic and of 3000 steps; 0.5 % for test 3, where the dashpot's limit adds "
        "up to 0.3 %.",
        ("test1-glass", "force_N"),
    )

    def make(self) -> None:
        self._spheres()
        self._plane()
        self._restitutions()

    def _spheres(self) -> None:
        """Test 1: two equal spheres."""
        for name, (young, poisson, density), published in (
            ("glass", GLASS, "274.1 um, 10.70 kN, 40.3 us"),
            ("limestone", LIMESTONE, "368.3 um, 7.11 kN, 54.2 us"),
        ):
            mass = density * 4 / 3 * math.pi * 0.01**3
            scenario = _material(name, young, poisson, False)
            law = self.engine.pair(scenario, mass / 2, contact_laws.effective_radius(0.01, 0.01))
            self.add(
                against_ball(f"test1-{name}", scenario, law, 0.01, mass, 20.0),
                law,
                20.0,
                reason=f"published: {published}",
                expected=_hysteretic_closed_form(mass / 2, law, 0.0, 20.0),
            )

    def _plane(self) -> None:
        """Test 2: a sphere on a rigid plane."""
        for name, (young, poisson, density), published in (
            ("aluminium", ALUMINIUM, "49.72 um, 11.37 kN, 731.7 us"),
            ("magnesium", MAGNESIUM, "52.12 um, 7.23 kN, 767.1 us"),
        ):
            mass = density * 4 / 3 * math.pi * 0.1**3
            scenario = _material(name, young, poisson, True)
            law = self.engine.pair(scenario, mass, contact_laws.effective_radius(0.1))
            probe, place = self._on_plane(f"test2-{name}", scenario, law, 0.1, mass, 0.2)
            self.add(
                probe,
                law,
                0.2,
                reason=f"published: {published}; {place}",
                expected=_hysteretic_closed_form(mass, law, 0.0, 0.2),
            )

    def _restitutions(self) -> None:
        """Test 3: dashpots that give each restitution."""
        for name, (young, poisson, density) in (("oxide", ALUMINIUM_OXIDE), ("iron", CAST_IRON)):
            mass = density * 4 / 3 * math.pi * 0.0025**3
            for out in (0.2, 0.4, 0.6, 0.8, 1.0):
                scenario = _material(name, young, poisson, True, 2, contact_laws.nominal_restitution(2, out))
                law = self.engine.pair(scenario, mass, contact_laws.effective_radius(0.0025))
                probe, place = self._on_plane(f"test3-{name}-{out:g}", scenario, law, 0.0025, mass, 3.9)
                reason = f"M_d = 2 with the e_n that gives this restitution; {place}"
                if (
                    contact_laws.damping_factor(2, contact_laws.nominal_restitution(2, out))
                    > contact_laws.LIMIT_FREE_FACTOR
                    and self.engine.has_dashpot_limit
                ):
                    reason += "; the dashpot meets its limit, which adds 0.3 %"
                self.add(probe, law, 3.9, 0.005, reason, {"restitution": out}, ("restitution",))
                scenario = load_scenario("nonlinear-en1.0").with_values(
                    {"contact.particle_wall.damping_ratio": contact_laws.damping_ratio_of(out)}, name
                )
                law = wall_law(scenario, mass)
                self.add(
                    against_wall(f"test3-{name}-dashpot-{out:g}", scenario, law, 0.0025, mass, 3.9, "linear"),
                    law,
                    3.9,
                    expected={"restitution": out},
                    only=("restitution",),
                    reason="the study's wall: linear with dashpot",
                )

    def _on_plane(self, name: str, scenario: Scenario, law, radius: float, mass: float, speed: float):
        if self.engine.rigid_plane_is_wall:
            return against_wall(name, scenario, law, radius, mass, speed, "hysteretic"), "wall with the particles' law"
        return against_ball(name, scenario, law, radius, mass, speed, 1e4), "held sphere of 10^4 radii as the plane"


class Oblique(ProbedCase):
    """Case 3: a sphere meets the fixed wall at 5 to 85 degrees from the normal, 1 m/s."""

    name, title = "oblique", "Oblique impact on the wall"
    account = Account(
        "A sphere hits the wall at 5 to 85 degrees from the normal, at 1 m/s.",
        "Normal: restitution as above. Gross sliding: velocity along the wall falls by μ (1 + e) × normal velocity. "
        "Sticking: integrated.",
        "Eq. 1 to 7 of the paper, integrated by scipy; like test 5 of Chung and Ooi (2011), on this study's wall",
        "0.5 % of the incoming velocity: 1000 steps in contact, in which sticking turns into slip within a step.",
        ("damped-mu0.3", "tangential_velocity_m_s"),
    )
    ANGLES = (5, 15, 25, 35, 45, 55, 65, 75, 85)

    def __init__(self, code: str):
        linear, nonlinear = load_scenario("linear-mu0.8"), load_scenario("nonlinear-en1.0")
        super().__init__(code)
        self.clump = derived.clump(linear)
        slippery = nonlinear.with_values({"contact.particle_wall.friction": 0.3}, "slippery")
        self._entries = [
            (label, scenario, angle, self._probe(label, scenario, angle))
            for label, scenario in (("linear-mu0.8", linear), ("damped-mu0.9", nonlinear), ("damped-mu0.3", slippery))
            for angle in self.ANGLES
        ]

    def _probe(self, label: str, scenario: Scenario, angle: int) -> Probe:
        law = wall_law(scenario, self.clump.mass_kg)
        duration = contact_laws.linear_impact(law.mass, law.normal_stiffness, law.damping_ratio, 1.0)["duration_s"]
        step = duration / 1000
        normal, sliding = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        ball = Ball(
            self.clump.radius_m,
            self.clump.mass_kg,
            (0.0, 0.0, self.clump.radius_m + STEPS_BEFORE * step * normal),
            (sliding, 0.0, -normal),
        )
        return Probe(f"oblique-{label}-{angle}", scenario, step, 1080, balls=(ball,), wall="linear")

    def probes(self) -> list[Probe]:
        return [entry[-1] for entry in self._entries]

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        curves: dict[str, list] = {}
        for label, scenario, angle, probe in self._entries:
            law = wall_law(scenario, self.clump.mass_kg)
            last, where = found[probe.name], f"of {label} at {angle} deg"
            measured = (last.velocity[-1, 0, 0], last.velocity[-1, 0, 2], last.spin[-1, 0, 1])
            expected = self._judge_impact(where, law, probe, measured, results)
            curves.setdefault(label, []).append((angle, measured[0], expected[0], measured[2], expected[2]))
        for label, points in curves.items():
            columns = np.array(points).T
            results.curve(
                self.name,
                label,
                angle_deg=columns[0],
                tangential_velocity_m_s=columns[1],
                tangential_velocity_m_s_expected=columns[2],
                spin_rad_s=columns[3],
                spin_rad_s_expected=columns[4],
            )

    def _judge_impact(self, where: str, law, probe: Probe, measured: tuple, results: Results) -> np.ndarray:
        """Velocity along and from the wall and spin after an impact; what is expected of them is returned."""
        (x, _, z), (expected, reason) = probe.balls[0].velocity, self._expected(law, probe)
        rebound = -contact_laws.dashpot_restitution(law.damping_ratio) * z
        results.compare(
            self.name,
            f"tangential_velocity_m_s {where}",
            expected[0],
            measured[0],
            0.005,
            reason + "; error in relation to the incoming velocity along the wall",
            scale=x,
        )
        results.compare(self.name, f"normal_velocity_m_s {where}", rebound, measured[1], 0.005, "closed form")
        results.compare(
            self.name,
            f"spin_rad_s {where}",
            expected[2],
            measured[2],
            0.005,
            reason + "; error in relation to that velocity over the radius",
            scale=x / self.clump.radius_m,
        )
        return expected

    def _expected(self, law: oracle.Linear, probe: Probe) -> tuple[np.ndarray, str]:
        """Velocity along and from the wall and spin after the impact, and where they come from."""
        radius, mass, (x, _, z) = self.clump.radius_m, self.clump.mass_kg, probe.balls[0].velocity
        body = oracle.Body(mass, 0.4 * mass * radius**2, ((0.0, 0.0, radius),))
        start = (0, probe.balls[0].position[2], 0, x, z, 0)
        paper = oracle.bounce(body, [law], start, probe.steps * probe.step, 10)[1][-1][3:]
        expected, reason = paper, "oracle"
        if self.engine.wall_slip_limit and law.damping_ratio:
            expected = own_slip_limit(body, [law], start, probe)[-1][3:]
            reason = (
                f"{self.engine.wall_slip_limit}: its own expected value, {expected[0] - paper[0]:+.2g} m/s and "
                f"{expected[2] - paper[2]:+.2g} rad/s from the paper's law"
            )
        sliding = x - law.friction * (1 + contact_laws.dashpot_restitution(law.damping_ratio)) * -z
        if abs(sliding - expected[0]) < 1e-6 * x:
            expected[0], reason = sliding, "closed form of gross sliding"
        return expected, reason


def own_slip_limit(body: oracle.Body, laws, start, probe: Probe) -> np.ndarray:
    """States (rows, 6) of a bounce whose slip limit holds the dashpot's force, at a quarter of the engine's step."""
    return oracle.bounce_in_steps(
        body,
        laws,
        start,
        probe.step / 4,
        4 * probe.steps,
        4 * probe.every,
        probe.gravity,
        closing_scaled=False,
        slip_by_total=True,
    )


class NoApproach(ProbedCase):
    """Case 10: contacts that form with almost no approach speed, or are there when the law is switched on.

    A sphere sinks onto a held one under gravity, at e_n = 0.6, M_d = 1, with the paper's time step: once with the
    spheres just apart and 1e-9 m/s, once from an overlap of 1e-4 m that is there at the start.
    """

    name, title = "no-approach", "Contacts without approach speed: dashpot at its limit"
    account = Account(
        "A sphere sinks onto a held one under gravity, from rest: the dashpot of eq. 15 divides by an "
        "approach speed of almost 0.",
        "At rest the weight is the Hertz force: overlap (m g / h)^(2/3). On the way: eq. 8 and 15 with the "
        "dashpot at its limit.",
        "Eq. 8, 14 and 15 of the paper; the limit is this project's (PARAMETERS.md); integrated by scipy",
        "0.5 %: the paper's full time step, 6000 steps, and what is left of the approach to rest.",
        ("no-approach-overlapping", "overlap_m"),
        1,
    )

    def __init__(self, code: str):
        scenario = load_scenario("nonlinear-md1-en0.6", variant="paper-step")
        super().__init__(code)
        self.scenario, self.clump = scenario, derived.clump(scenario)
        step = derived.time_grid(scenario).step_s
        r, mass = self.clump.radius_m, self.clump.mass_kg
        self._starts = {"touching": (-1e-12, 1e-9), "overlapping": (1e-4, 0.0)}
        self._probes = [
            Probe(
                f"no-approach-{name}",
                scenario,
                step,
                6000,
                gravity=9.81,
                balls=(
                    Ball(r, mass, (0.0, 0.0, 2 * r - overlap), (0.0, 0.0, -speed)),
                    Ball(r, 1e12, (0.0, 0.0, 0.0), held=True),
                ),
            )
            for name, (overlap, speed) in self._starts.items()
        ]

    def probes(self) -> list[Probe]:
        return self._probes

    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        r, mass = self.clump.radius_m, self.clump.mass_kg
        law = self.engine.pair(self.scenario, mass, contact_laws.effective_radius(r, r))
        static = (mass * 9.81 / contact_laws.hertz_coefficient(law.shear_modulus, law.poisson_ratio, law.radius)) ** (
            2 / 3
        )
        for probe in self._probes:
            start, speed = self._starts[probe.name.removeprefix("no-approach-")]
            rows = found[probe.name]
            overlap = 2 * r - (rows.position[:, 0, 2] - rows.position[:, 1, 2])
            expected = sink(law, start, speed, 9.81, rows.time)
            results.compare_curves(
                self.name, f"overlap_m of {probe.name}", expected, overlap, 0.005, self.engine.sinking_note
            )
            results.curve(
                self.name,
                probe.name,
                time_s=rows.time[::30],
                overlap_m=overlap[::30],
                overlap_m_expected=expected[::30],
            )
            if not self.engine.has_dashpot_limit:
                continue  # its weaker dashpot has not brought the sphere to rest by then, and has no limit to count
            results.compare(
                self.name,
                f"overlap_at_rest_m of {probe.name}",
                static,
                overlap[-1],
                0.005,
                "closed form: weight = Hertz force",
            )
            resting = int(rows.at_limit[-1])
            results.compare(self.name, f"contacts_at_limit of {probe.name}", 1, resting, 0.0, "counted at the end")


def sink(law, overlap: float, speed: float, gravity: float, times: np.ndarray) -> np.ndarray:
    """Overlap (m) at `times` of a mass that sinks onto a contact under gravity, from `overlap` and `speed`."""
    approach = speed if overlap <= 0 else 0.0

    def motion(t, state):
        return [state[1], gravity - law.normal(state[0], state[1], approach) / law.mass]

    found = solve_ivp(
        motion,
        (0, times[-1]),
        [overlap, speed],
        t_eval=times,
        rtol=1e-9,
        atol=1e-13,
        method="LSODA",
        max_step=times[-1] / 200,
    )
    return found.y[0]


CASES = (HeadOn, WallDashpot, ChungOoi, Oblique, NoApproach)
