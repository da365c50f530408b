"""The contact laws of the paper, equations 1 to 16, once.

Conventions: `overlap` = -g_s of the paper, metres, positive in contact; `closing_speed` = d(overlap)/dt, m/s; a normal
force is positive where it pushes the bodies apart; shear forces and shear displacements are vectors in the contact
plane, of body 1 relative to body 2. SI units. Needs numpy and the standard library only: YADE's Python reads it.

Source: Talebiahooie et al. 2021, Sustainability 13, 12247, section 2; eq. 16 as repaired in `damping_factor`.
"""

from __future__ import annotations

import cmath
import math

import numpy as np

HERTZ_DURATION = 4 * math.sqrt(math.pi) * math.gamma(0.4) / (5 * math.gamma(0.9))
"""Duration of an elastic Hertz impact in units of peak overlap over approach speed, 2.9433."""
LIMIT_FREE_FACTOR = 4.0
"""Below this D of eq. 16 the dashpot's limit is not met in a free impact: there
limit / coefficient at peak overlap = sqrt(2.4 / (D - ln(1 + D)))."""


# ------------------------------------------------------------------ linear model, eq. 1-7


def linear_normal_force(overlap: float, normal_stiffness: float) -> float:
    """Eq. 1, N: compression only."""
    return normal_stiffness * overlap if overlap > 0 else 0.0


def trial_shear_force(old_force, shear_stiffness: float, displacement) -> np.ndarray:
    """Eq. 2 (and 10, whose k_s is negative), N: the shear force is incremental in force, not in displacement."""
    return np.asarray(old_force, float) - shear_stiffness * np.asarray(displacement, float)


def closing_share(overlap: float, old_overlap: float) -> float:
    """Eq. 3: share of a step's shear displacement that counts, when the contact closes within the step."""
    return overlap / (overlap - old_overlap) if old_overlap < 0 < overlap else 1.0


def shear_strength(friction: float, elastic_normal_force: float) -> float:
    """Eq. 4 and 12, N: the dashpot's force does not count."""
    return friction * elastic_normal_force


def slip(force, strength: float) -> np.ndarray:
    """Eq. 5 and 13, N: the trial force, shortened to the strength where it exceeds it."""
    size = float(np.linalg.norm(force))
    return np.asarray(force, float) * (strength / size if size > strength else 1.0)


def linear_dashpot_coefficient(damping_ratio: float, mass: float, normal_stiffness: float) -> float:
    """Eq. 6, N s/m: normal dashpot force over closing speed."""
    return 2 * damping_ratio * math.sqrt(mass * normal_stiffness)


def effective_mass(mass_1: float, mass_2: float = math.inf) -> float:
    """Eq. 7, kg; masses of whole clumps, `mass_2` infinite against a wall."""
    return 1 / (1 / mass_1 + 1 / mass_2)


# ------------------------------------------------------------------ hysteretic model, eq. 8-16


def effective_radius(radius_1: float, radius_2: float = math.inf) -> float:
    """Eq. 9, m; `radius_2` infinite against a plane."""
    return 2 / (1 / radius_1 + 1 / radius_2)


def hertz_coefficient(shear_modulus: float, poisson_ratio: float, radius: float) -> float:
    """h_n of eq. 8, N/m^1.5; `radius` from `effective_radius`."""
    return 2 * shear_modulus * math.sqrt(2 * radius) / (3 * (1 - poisson_ratio))


def hertz_normal_force(overlap: float, shear_modulus: float, poisson_ratio: float, radius: float) -> float:
    """Eq. 8, N."""
    return hertz_coefficient(shear_modulus, poisson_ratio, radius) * overlap**1.5 if overlap > 0 else 0.0


def mindlin_shear_stiffness(overlap: float, shear_modulus: float, poisson_ratio: float, radius: float) -> float:
    """Eq. 11, N/m, as a positive number."""
    return 2 * shear_modulus * math.sqrt(2 * overlap * radius) / (2 - poisson_ratio) if overlap > 0 else 0.0


def hysteretic_dashpot_coefficient(
    factor: float, elastic_force: float, approach_speed: float, overlap: float, mass: float
) -> tuple[float, bool]:
    """Eq. 14-15 as a coefficient D F_h / v_n0 (N s/m), and whether it is at its limit.

    The limit is our rule, assumed: critical damping 2 sqrt(m k_t) with the tangent stiffness k_t = 1.5 F_h / overlap,
    because the coefficient of eq. 15 has no bound as the approach speed v_n0 goes to zero.
    """
    if elastic_force <= 0 or factor == 0:
        return 0.0, False
    limit = 2 * math.sqrt(mass * 1.5 * elastic_force / overlap)
    if approach_speed <= 0 or factor * elastic_force > limit * approach_speed:
        return limit, True
    return factor * elastic_force / approach_speed, False


def hysteretic_normal_force(elastic_force: float, dashpot_coefficient: float, closing_speed: float) -> float:
    """Sum of eq. 8 and 15, N; never tensile (our rule, assumed)."""
    return max(0.0, elastic_force + dashpot_coefficient * closing_speed)


def damping_factor(mode: int, restitution: float) -> float:
    """Eq. 16: D of damping mode M_d = `mode` at the nominal restitution e_n.

    The printed equation has lost its fractions. These are the forms of the sources it names: 0 Gonthier et al.,
    1 Lankarani and Nikravesh, 2 Zhiying and Qishao.
    """
    e = restitution
    if mode == 0:
        if e == 0:
            raise ValueError("damping mode 0 is singular at restitution 0: choose mode 1 or a larger restitution")
        return (1 - e * e) / e
    if mode == 1:
        return 0.75 * (1 - e * e)
    if mode == 2:
        return 0.75 * (1 - e * e) * math.exp(2 * (1 - e))
    raise ValueError(f"damping mode {mode!r} is unknown: 0, 1 or 2")


# ------------------------------------------------------------------ what a free impact does


def dashpot_restitution(damping_ratio: float) -> float:
    """Restitution of a free impact with the linear spring and dashpot (Kawaguchi): exp(-pi beta / sqrt(1 - beta^2))."""
    return math.exp(-math.pi * damping_ratio / math.sqrt(1 - damping_ratio**2))


def damping_ratio_of(restitution: float) -> float:
    """Inverse of `dashpot_restitution`."""
    logarithm = math.log(restitution)
    return -logarithm / math.hypot(math.pi, logarithm)


def effective_restitution(factor: float) -> float:
    """Restitution e' that comes out of a free impact with the hysteretic law, from its factor D.

    Root of D (1 + e') = ln((1 + D) / (1 - D e')); independent of mass, stiffness and speed. Found by bisection, error
    below 1e-14. Holds up to D = LIMIT_FREE_FACTOR, see there.
    """
    if factor == 0:
        return 1.0

    def excess(e: float) -> float:
        return factor * (1 + e) - math.log1p(factor) + math.log1p(-factor * e)

    low, high = 0.0, min(1.0, 1 / factor)
    for _ in range(200):
        middle = (low + high) / 2
        # log1p(-D e') reaches -infinity at e' = 1/D
        low, high = (middle, high) if factor * middle < 1 and excess(middle) > 0 else (low, middle)
    return (low + high) / 2


def hysteretic_restitution(factor: float, limit: float = 1.0) -> float:
    """Restitution of a free impact with the hysteretic law and the dashpot's limit, `limit` times critical damping.

    Where the limit is not met that is `effective_restitution`. Where it is, the contact passes to the limit at an
    overlap x_c and, unless it opens there, back: with length (m v0^2 / h)^(2/5) and speed v0 as units, below x_c
    v dv/(1 + D v) = -x^1.5 dx, above it with p = x^1.25 a linear oscillator, v dv/dp = -0.8 (p + c v). Free of mass,
    stiffness and speed. Relative error about 1e-9.
    """
    if factor - math.log1p(factor) <= 2.4 * limit**2:
        return effective_restitution(factor)
    limited = 2 * limit * math.sqrt(1.5)
    overlap = (limited / factor) ** 0.8

    def energy(v: float) -> float:  # integral of v / (1 + D v)
        return v / factor - math.log1p(factor * v) / factor**2

    share = 0.4 * overlap**2.5
    speed = _root(lambda v: energy(v) - energy(1.0) + share, 0.0, 1.0)
    # the oscillator from (p, v) = (x_c^1.25, speed): p'' = -0.8 (p + c p'), solved by its two exponentials
    start = overlap**1.25
    shift = cmath.sqrt((0.4 * limited) ** 2 - 0.8)
    roots = -0.4 * limited + shift, -0.4 * limited - shift
    first = (speed - roots[1] * start) / (2 * shift)
    weights = first, start - first

    def derivative(time: float, order: int) -> float:
        return sum(w * r**order * cmath.exp(r * time) for w, r in zip(weights, roots, strict=True)).real

    step = 1e-2
    time = next(k * step for k in range(1, 100_000) if derivative(k * step, 1) < 0)
    while derivative(time, 2) < 0 and derivative(time, 0) > start:
        time += step
    if derivative(time, 2) >= 0:
        opens = _root(lambda s: derivative(s, 2), time - step, time)
        if derivative(opens, 0) > start:
            return -derivative(opens, 1)  # no force is left
    back = -derivative(_root(lambda s: start - derivative(s, 0), time - step, time), 1)
    return _root(lambda e: energy(-e) - energy(-back) - share, back, (1 - 1e-15) / factor)


def _root(function, low: float, high: float) -> float:
    """Where a function that is below 0 at `low` and above at `high` crosses it."""
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) < 0 else (low, middle)
    return (low + high) / 2


def viscous_hertz_restitution(damping_ratio: float) -> float:
    """Restitution of a free impact with Hertz's force and a dashpot 2 beta sqrt(m k_t) that cannot pull.

    k_t is the tangent stiffness. In p = x^(5/4) it is a linear spring and dashpot of the ratio z = sqrt(1.2) beta,
    whose force is used up at the phase 2 acos z: exp(-2 z acos(z) / sqrt(1 - z^2)), with acosh where z exceeds 1.
    """
    z = math.sqrt(1.2) * damping_ratio
    if abs(z - 1) < 1e-8:
        return math.exp(-2)
    angle = math.acos(z) / math.sqrt(1 - z * z) if z < 1 else math.acosh(z) / math.sqrt(z * z - 1)
    return math.exp(-2 * z * angle)


def viscous_hertz_damping_ratio(restitution: float) -> float:
    """Inverse of `viscous_hertz_restitution`, found by bisection; restitution above 0, to 1."""
    if restitution == 1:
        return 0.0
    if not 0 < restitution < 1:
        raise ValueError(f"restitution {restitution:g} has no damping ratio: choose one above 0, to 1")
    high = 1.0
    while viscous_hertz_restitution(high) > restitution:
        high *= 2
    return _root(lambda beta: restitution - viscous_hertz_restitution(beta), 0.0, high)


def nominal_restitution(mode: int, effective: float) -> float:
    """e_n that makes a free impact come out with restitution `effective` in damping mode `mode`.

    Raises ValueError below the least that the mode can give (0.663 for mode 1, 0.179 for mode 2).
    """
    low, high = (1e-6 if mode == 0 else 0.0), 1.0
    least = effective_restitution(damping_factor(mode, low))
    if not least <= effective <= 1:
        raise ValueError(f"damping mode {mode} gives restitutions from {least:.3f} to 1, not {effective:g}")
    for _ in range(100):
        middle = (low + high) / 2
        below = effective_restitution(damping_factor(mode, middle)) < effective
        low, high = (middle, high) if below else (low, middle)
    return (low + high) / 2


def linear_impact(mass: float, normal_stiffness: float, damping_ratio: float, speed: float) -> dict[str, float]:
    """Head-on impact with the linear law: peak_overlap_m, peak_force_N, duration_s, restitution.

    `mass` from `effective_mass`. The contact ends where the overlap is zero: the force ends in tension if damped.
    """
    omega = math.sqrt(normal_stiffness / mass)
    damped = omega * math.sqrt(1 - damping_ratio**2)
    # the k-th derivative of the overlap is v/damped (-omega)^k exp(-beta omega t) sin(damped t - k phase)
    phase = math.acos(damping_ratio)
    decay = damping_ratio * omega / damped
    force_phase = 3 * phase - math.pi
    force = math.exp(-decay * force_phase) if force_phase > 0 else 2 * damping_ratio
    return {
        "peak_overlap_m": speed / omega * math.exp(-decay * phase),
        "peak_force_N": mass * speed * omega * force,
        "duration_s": math.pi / damped,
        "restitution": dashpot_restitution(damping_ratio),
    }


def hysteretic_peak_overlap(mass: float, coefficient: float, factor: float, speed: float) -> float:
    """Peak overlap (m) of a head-on impact with the hysteretic law; `coefficient` from `hertz_coefficient`.

    From v dv/(1 + D v/v0) = -(h/m) overlap^1.5 d(overlap), integrated from v0 to rest.
    """
    share = (factor - math.log1p(factor)) / factor**2 if factor > 1e-6 else 0.5 - factor / 3
    return (2.5 * mass * speed**2 / coefficient * share) ** 0.4


def hertz_impact(mass: float, coefficient: float, speed: float) -> dict[str, float]:
    """Head-on elastic Hertz impact: peak_overlap_m, peak_force_N, duration_s, restitution."""
    peak = hysteretic_peak_overlap(mass, coefficient, 0.0, speed)
    return {
        "peak_overlap_m": peak,
        "peak_force_N": coefficient * peak**1.5,
        "duration_s": HERTZ_DURATION * peak / speed,
        "restitution": 1.0,
    }


def equivalent_material(
    shear_modulus_1: float, poisson_ratio_1: float, shear_modulus_2: float, poisson_ratio_2: float
) -> tuple[float, float]:
    """Shear modulus (Pa) and Poisson's ratio that give eq. 8 and 11 the stiffness of two different materials.

    A rigid body has an infinite shear modulus. From 1/E* = sum (1 - nu)/(2 G) and 1/G* = sum (2 - nu)/G, which for
    equal materials are E* = G/(1 - nu) and G* = G/(2 (2 - nu)). The ratio of unequal ones may lie outside 0-0.5: it
    only carries the two stiffnesses.
    """
    normal = 2 / ((1 - poisson_ratio_1) / shear_modulus_1 + (1 - poisson_ratio_2) / shear_modulus_2)
    shear = 2 / ((2 - poisson_ratio_1) / shear_modulus_1 + (2 - poisson_ratio_2) / shear_modulus_2)
    # normal = G/(1 - nu), shear = G/(2 - nu)
    ratio = (normal - 2 * shear) / (normal - shear)
    return normal * (1 - ratio), ratio
