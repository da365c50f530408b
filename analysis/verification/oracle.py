"""What the engines should do in small cases, computed without them: scipy integrates the equations of motion.

The laws come from `analysis.contact_laws`; the integration, the search for the moments at which contacts close, slip,
stick and open, and the rigid-body motion are independent of both engines. Everything is in SI units.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp

from analysis import contact_laws

TIGHT = {"rtol": 1e-10, "method": "DOP853"}


@dataclass(frozen=True)
class Linear:
    """Linear law of one contact; `mass` is the effective one (eq. 7)."""

    normal_stiffness: float
    shear_stiffness: float
    friction: float = 0.0
    damping_ratio: float = 0.0
    mass: float = 1.0

    def elastic(self, overlap: float) -> float:
        return contact_laws.linear_normal_force(overlap, self.normal_stiffness)

    def elastic_slope(self, overlap: float) -> float:
        return self.normal_stiffness

    def shear_slope(self, overlap: float) -> float:
        return self.shear_stiffness

    def normal(self, overlap: float, speed: float, approach_speed: float) -> float:
        """Normal force at this closing speed, in tension too where the dashpot pulls."""
        if overlap <= 0:
            return 0.0
        return self.elastic(overlap) + speed * contact_laws.linear_dashpot_coefficient(
            self.damping_ratio, self.mass, self.normal_stiffness
        )


@dataclass(frozen=True)
class Hysteretic:
    """Hysteretic law of one contact; `factor` is D of eq. 16, `radius` that of eq. 9."""

    shear_modulus: float
    poisson_ratio: float
    radius: float
    friction: float = 0.0
    factor: float = 0.0
    mass: float = 1.0

    def elastic(self, overlap: float) -> float:
        return contact_laws.hertz_normal_force(overlap, self.shear_modulus, self.poisson_ratio, self.radius)

    def elastic_slope(self, overlap: float) -> float:
        return (
            1.5
            * contact_laws.hertz_coefficient(self.shear_modulus, self.poisson_ratio, self.radius)
            * math.sqrt(max(overlap, 0))
        )

    def shear_slope(self, overlap: float) -> float:
        return contact_laws.mindlin_shear_stiffness(overlap, self.shear_modulus, self.poisson_ratio, self.radius)

    def normal(self, overlap: float, speed: float, approach_speed: float) -> float:
        if overlap <= 0:
            return 0.0
        elastic = self.elastic(overlap)
        dashpot, _ = contact_laws.hysteretic_dashpot_coefficient(
            self.factor, elastic, approach_speed, overlap, self.mass
        )
        return contact_laws.hysteretic_normal_force(elastic, dashpot, speed)


@dataclass(frozen=True)
class ViscousHertz(Hysteretic):
    """YADE's damped Hertz law: a dashpot of a share of critical damping at the tangent stiffness, chosen so that the
    restitution comes out when the contact does not pull. Not in the paper; it stands in for the hysteretic law where
    YADE has none.
    """

    restitution: float = 1.0

    def normal(self, overlap: float, speed: float, approach_speed: float) -> float:
        if overlap <= 0:
            return 0.0
        stiffness = self.elastic_slope(overlap)
        dashpot = 2 * contact_laws.viscous_hertz_damping_ratio(self.restitution) * math.sqrt(self.mass * stiffness)
        return max(0.0, self.elastic(overlap) + dashpot * speed)


# ------------------------------------------------------------------ head-on impact


@dataclass(frozen=True)
class ImpactCourse:
    """A head-on impact: its measures, and overlap and force over time."""

    peak_overlap_m: float
    peak_force_N: float
    duration_s: float
    restitution: float
    time_s: np.ndarray = field(repr=False)
    overlap_m: np.ndarray = field(repr=False)
    force_N: np.ndarray = field(repr=False)


@functools.lru_cache(1000)
def head_on(law, speed: float, points: int = 400) -> ImpactCourse:
    """Integrate mass * overlap'' = -force from touch to separation. Relative error about 1e-8."""
    length = (law.mass * speed**2 / (law.elastic(1e-3) * 1e-3)) ** 0.4 * 1e-3
    scale = length / speed

    def motion(t, state):
        overlap, closing = state[0] * length, state[1] * speed
        return [state[1], -law.normal(overlap, closing, speed) / law.mass * scale / speed]

    def opened(t, state):
        return state[0]

    opened.terminal, opened.direction = True, -1

    found = solve_ivp(motion, (0, 1e3), [0.0, 1.0], events=opened, dense_output=True, atol=1e-13, **TIGHT)
    end = found.t_events[0][-1]
    grid = np.linspace(0, end, points)
    states = found.sol(grid)

    def force_at(u, w):
        return law.normal(max(u * length, 1e-30), w * speed, speed)  # just in contact at the very start

    force = np.array([force_at(u, w) for u, w in states.T])

    def peak(values, function) -> float:
        k = int(np.argmax(values))
        fine = np.linspace(grid[max(k - 1, 0)], grid[min(k + 1, points - 1)], 401)
        return float(max(function(u, w) for u, w in found.sol(fine).T))

    return ImpactCourse(
        peak(states[0], lambda u, w: u * length),
        peak(force, force_at),
        float(end * scale),
        -float(found.sol(end)[1]),
        grid * scale,
        states[0] * length,
        force,
    )


# ------------------------------------------------------------------ forces along a prescribed path


def forces_along(
    law, overlap, closing_speed, sliding, *, closing_scaled=True, slip_by_total=False, by_displacement=False
):
    """Normal and shear force (N) of one contact after each step of a prescribed motion, eq. 1-16 in their order.

    `overlap` (m) before the first and after each step, negative while apart, shape (n + 1,); `closing_speed` (m/s) and
    shear displacement `sliding` (m, along one line) in each step, shape (n,). The approach speed is the closing speed
    in the step in which the contact forms. Both forces are zero while apart, and the history is lost.
    Not the paper's law, but what other codes do: `closing_scaled=False` leaves eq. 3 out, `slip_by_total=True` counts
    the dashpot in eq. 4, `by_displacement=True` keeps the shear displacement, over a separation too, and multiplies it
    by the present stiffness.
    """
    normal, shear = np.zeros(len(sliding)), np.zeros(len(sliding))
    force, approach, shift = 0.0, 0.0, 0.0
    for n, (old, now, speed, slid) in enumerate(zip(overlap[:-1], overlap[1:], closing_speed, sliding, strict=True)):
        if now <= 0:
            force = 0.0
            continue
        if old <= 0:
            force, approach = 0.0, speed
            if closing_scaled:
                slid = slid * contact_laws.closing_share(now, old)
        normal[n] = law.normal(now, speed, approach)
        stiffness = law.shear_slope(now)
        if by_displacement:
            force = -stiffness * shift
        trial = contact_laws.trial_shear_force([force], stiffness, [slid])
        limiting = abs(normal[n]) if slip_by_total else law.elastic(now)
        shear[n] = force = float(contact_laws.slip(trial, contact_laws.shear_strength(law.friction, limiting))[0])
        shift = -force / stiffness
    return normal, shear


def shear_along(law, overlap, sliding_speed, times: np.ndarray) -> np.ndarray:
    """Shear force (N) at `times` by scipy, for overlap(t) > 0 and sliding speed(t) given as functions of time.

    Independent of `forces_along`: the force is integrated as a differential equation, with events where it slips and
    sticks again.
    """
    planar = _Contacts([law])

    def kinematics(t, state):
        width = 1e-6 * (times[-1] - times[0])
        rate = (overlap(t + width) - overlap(t - width)) / (2 * width)
        return [(overlap(t), rate, sliding_speed(t))]

    out = planar.integrate(kinematics, lambda t, state, forces: np.zeros(0), np.zeros(0), times, closed=[True])
    return out[0][:, 0]


# ------------------------------------------------------------------ a rigid body meets a wall, in a plane


class _Contacts:
    """Integrates a motion together with the shear forces of its contacts, each open, sticking or slipping.

    The shear force sticks with rate -k_s v_t until it reaches mu F_elastic, then follows that limit for as long as
    the sticking rate would exceed the limit's rate. An open contact has no force.
    """

    def __init__(self, laws):
        self.laws = laws
        self.approach = [0.0] * len(laws)

    def integrate(self, kinematics, motion, start: np.ndarray, times: np.ndarray, closed=None):
        """Return shear forces (len(times), contacts) and states (len(times), len(start)).

        `kinematics(t, state)` gives for each contact (overlap, closing, sliding speed), `motion(t, state, forces)`
        the derivative of the state under forces [(normal, shear), ...].
        """
        count, n = len(self.laws), len(start)
        modes = ["stick" if c else "open" for c in closed or [False] * count]
        state, t = np.concatenate([start, np.zeros(count)]), times[0]
        shears, states = np.zeros((len(times), count)), np.zeros((len(times), n))
        filled, span = 0, times[-1] - times[0]
        for _ in range(10_000):
            for k, mode in enumerate(modes):
                if mode == "stick":
                    modes[k] = self._stick_or_slip(k, kinematics, t, state, n)
            events = self._events(modes, kinematics, n)
            found = solve_ivp(
                lambda time, y: self._rates(time, y, modes, kinematics, motion, n),
                (t, times[-1]),
                state,
                events=events,
                dense_output=True,
                atol=1e-12,
                max_step=span / 50,
                **TIGHT,
            )
            t = found.t[-1]
            while filled < len(times) and times[filled] <= t + 1e-15 * span:
                y = found.sol(min(times[filled], t))
                states[filled] = y[:n]
                shears[filled] = [0.0 if m == "open" else f for m, f in zip(modes, y[n:], strict=True)]
                filled += 1
            if filled == len(times):
                return shears, states
            state = found.y[:, -1].copy()
            self._change_mode(*self._fired(found, events), modes, kinematics(t, state), state[n:])
        raise RuntimeError("oracle: too many changes between sticking and slipping")

    def _change_mode(self, k: int, what: str, modes: list[str], contacts, shears: np.ndarray) -> None:
        """What has happened to contact `k` sets its mode, and its shear force to zero where it closes or opens."""
        if what == "close":
            modes[k], shears[k], self.approach[k] = "stick", 0.0, contacts[k][1]
        elif what == "open":
            modes[k], shears[k] = "open", 0.0
        elif what == "slip":
            modes[k] = "slip+" if shears[k] > 0 else "slip-"
        else:
            modes[k] = "stick"

    def _stick_or_slip(self, k, kinematics, t, state, n) -> str:
        """A contact that has just closed slips at once where its shear force would outrun its strength."""
        overlap, closing, sliding = kinematics(t, state)[k]
        law = self.laws[k]
        tiny = max(overlap, 1e-12)
        closes = state[n + k] == 0.0 and overlap <= 1e-12
        if closes and law.shear_slope(tiny) * abs(sliding) > law.friction * law.elastic_slope(tiny) * abs(closing):
            return "slip+" if sliding < 0 else "slip-"
        return "stick"

    def _rates(self, t, y, modes, kinematics, motion, n):
        forces, rates = [], []
        for k, (overlap, closing, sliding) in enumerate(kinematics(t, y)):
            law, mode = self.laws[k], modes[k]
            if mode == "open":
                forces.append((0.0, 0.0))
                rates.append(0.0)
                continue
            # within an integration step the overlap may pass zero by a rounding error: the event ends the phase there
            overlap = max(overlap, 1e-18)
            normal = law.normal(overlap, closing, self.approach[k])
            if mode.startswith("slip"):
                sign = 1.0 if mode == "slip+" else -1.0
                forces.append((normal, sign * law.friction * law.elastic(overlap)))
                rates.append(sign * law.friction * law.elastic_slope(overlap) * closing)
            else:
                forces.append((normal, y[n + k]))
                rates.append(-law.shear_slope(overlap) * sliding)
        return np.concatenate([motion(t, y[:n], forces), rates])

    def _events(self, modes, kinematics, n):
        events = []

        def add(k, what, function, direction):
            function.terminal, function.direction, function.contact, function.what = True, direction, k, what
            events.append(function)

        for k, mode in enumerate(modes):
            law = self.laws[k]
            if mode == "open":
                add(k, "close", lambda t, y, k=k: kinematics(t, y)[k][0], 1)
                continue
            add(k, "open", lambda t, y, k=k: kinematics(t, y)[k][0], -1)
            if mode.startswith("slip"):
                sign = 1.0 if mode == "slip+" else -1.0

                def outruns(t, y, k=k, law=law, sign=sign):
                    overlap, closing, sliding = kinematics(t, y)[k]
                    overlap = max(overlap, 1e-18)
                    root = law.elastic_slope(overlap)
                    return -sign * law.shear_slope(overlap) / root * sliding - law.friction * closing

                add(k, "stick", outruns, -1)
            else:

                def excess(t, y, k=k, law=law):
                    return abs(y[n + k]) - law.friction * law.elastic(max(kinematics(t, y)[k][0], 0.0))

                add(k, "slip", excess, 1)
        return events

    def _fired(self, found, events):
        fired = [(e[0], event) for e, event in zip(found.t_events, events, strict=True) if len(e)]
        if found.status != 1 or not fired:
            raise RuntimeError(f"oracle: integration stopped: {found.message}")
        _, event = min(fired, key=lambda pair: pair[0])
        return event.contact, event.what


@dataclass(frozen=True)
class Body:
    """A rigid body in the plane: mass (kg), inertia about the plane's normal (kg m2), member discs [(x, z, radius)]
    in the body's frame (m)."""

    mass: float
    inertia: float
    members: tuple[tuple[float, float, float], ...]

    def levers(self, state) -> list[tuple[float, float, float]]:
        """For each member: overlap with the wall z = 0, and the contact point relative to the body's centre (x, z); it
        lies on the member's radius, half the overlap inside it."""
        c, s = math.cos(state[2]), math.sin(state[2])
        out = []
        for a, b, radius in self.members:
            dz = -s * a + c * b
            overlap = radius - (state[1] + dz)
            out.append((overlap, c * a + s * b, dz - (radius - max(overlap, 0.0) / 2)))
        return out

    def kinematics(self, state) -> list[tuple[float, float, float]]:
        """For each member: overlap, closing speed and sliding speed along +x at the contact point."""
        vx, vz, spin = state[3:6]
        return [(overlap, -(vz - spin * dx), vx + spin * arm) for overlap, dx, arm in self.levers(state)]

    def acceleration(self, state, forces, gravity: float) -> np.ndarray:
        """(a_x, a_z, angular acceleration) under [(normal, shear), ...]; the shear force acts along +x on the body."""
        torque = sum(
            arm * shear - dx * normal for (_, dx, arm), (normal, shear) in zip(self.levers(state), forces, strict=True)
        )
        return np.array(
            [
                sum(shear for _, shear in forces) / self.mass,
                sum(normal for normal, _ in forces) / self.mass - gravity,
                torque / self.inertia,
            ]
        )


def bounce(body: Body, laws, start, duration: float, points: int = 200, gravity: float = 0.0):
    """A rigid body bounces on the wall z = 0. Rotation is positive from z to x (about +y).

    `start` = (x, z, angle, v_x, v_z, spin). Returns times (n), states (n, 6) and shear forces (n, members).
    """
    times = np.linspace(0, duration, points)
    shears, states = _Contacts(laws).integrate(
        lambda t, state: body.kinematics(state),
        lambda t, state, forces: np.concatenate([state[3:6], body.acceleration(state, forces, gravity)]),
        np.asarray(start, float),
        times,
    )
    return times, states, shears


def bounce_in_steps(
    body: Body,
    laws,
    start,
    step: float,
    steps: int,
    every: int = 1,
    gravity: float = 0.0,
    *,
    closing_scaled=True,
    slip_by_total=False,
):
    """The same by the steps of a DEM code, with the laws of other codes as in `forces_along`.

    The error is of the order of `step`. Returns states (n, 6), of step 0 and each `every` steps.
    """
    state = np.asarray(start, float).copy()
    contacts = [_SteppedContact(law, closing_scaled, slip_by_total) for law in laws]
    for contact, (overlap, *_) in zip(contacts, body.levers(state), strict=True):
        contact.overlap = overlap
    states = [state.copy()]
    for n in range(1, steps + 1):
        motions = zip(contacts, body.kinematics(state), strict=True)
        forces = [contact.advance(overlap, closing, sliding, step) for contact, (overlap, closing, sliding) in motions]
        state[3:6] += step * body.acceleration(state, forces, gravity)
        state[:3] += step * state[3:6]
        if n % every == 0:
            states.append(state.copy())
    return np.array(states)


@dataclass
class _SteppedContact:
    """A contact as DEM codes carry it from step to step; overlap in m, speeds in m/s, forces in N."""

    law: object
    closing_scaled: bool
    slip_by_total: bool
    overlap: float = 0.0
    shear: float = 0.0
    approach: float = 0.0

    def advance(self, overlap: float, closing: float, sliding: float, step: float) -> tuple[float, float]:
        """Normal and shear force after a step of `step` s that ends at this overlap."""
        before, self.overlap = self.overlap, overlap
        if overlap <= 0:
            self.shear = 0.0
            return 0.0, 0.0
        moved = sliding * step
        if before <= 0:
            self.approach = closing
            if self.closing_scaled:
                moved *= contact_laws.closing_share(overlap, before)
        normal = self.law.normal(overlap, closing, self.approach)
        limit = self.law.friction * (abs(normal) if self.slip_by_total else self.law.elastic(overlap))
        self.shear = min(limit, max(-limit, self.shear - self.law.shear_slope(overlap) * moved))
        return normal, self.shear
