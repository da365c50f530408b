"""The parallel bond of Potyondy and Cundall (2004), which acts beside the linear contact of two spheres.

A disc of elastic cement between the spheres: it carries a normal force, a shear force, a twisting and a bending moment,
pulls as well as it pushes, acts across a gap, and breaks once and for all.

Conventions: body 1 against body 2; `normal` is the unit vector from body 2 to body 1; displacement and rotation are
those of body 1 relative to body 2; forces and moments act on body 1, body 2 gets their opposites. A normal force is
positive where it pushes the bodies apart, a stress where it pulls. SI units. Needs numpy and the standard library only.

Source: Potyondy and Cundall 2004, Int. J. Rock Mech. Min. Sci. 41, 1329, eq. 14 to 19, with a factor of 1 on the
moments' share of the stresses. Normal force: the increments k_n A dU_n sum to k_n A times the change in distance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

PER_AREA, TOTAL = "per_area", "total"
"""Readings of printed stiffnesses and strengths: Pa/m and Pa, or those of the whole bond, N/m and N."""
TENSION, SHEAR = "tension", "shear"
"""Modes of breaking."""


@dataclass(frozen=True)
class Bond:
    """Constants of one bond, per area of its disc: radius (m), stiffnesses (Pa/m), strengths (Pa)."""

    radius: float
    normal_stiffness: float
    shear_stiffness: float
    tensile_strength: float
    shear_strength: float

    @property
    def area(self) -> float:
        """A, m2."""
        return math.pi * self.radius**2

    @property
    def moment_of_inertia(self) -> float:
        """I of the disc about a diameter, m4: bending."""
        return math.pi * self.radius**4 / 4

    @property
    def polar_moment(self) -> float:
        """J of the disc about its axis, m4: twisting."""
        return math.pi * self.radius**4 / 2


def bond_radius(multiplier: float, radius_1: float, radius_2: float) -> float:
    """Radius of the disc, m: the multiplier times the smaller of the spheres' radii."""
    return multiplier * min(radius_1, radius_2)


def bond(
    radius: float,
    normal_stiffness: float,
    shear_stiffness: float,
    tensile_strength: float,
    shear_strength: float,
    reading: str = PER_AREA,
) -> Bond:
    """The bond of this radius (m). `reading` says whether the other values are per area (Pa/m, Pa) or total (N/m, N).

    Raises ValueError for another reading.
    """
    if reading not in (PER_AREA, TOTAL):
        raise ValueError(f"reading {reading!r} of a bond's values is unknown: {PER_AREA} or {TOTAL}")
    share = 1.0 if reading == PER_AREA else 1.0 / (math.pi * radius**2)
    values = (normal_stiffness, shear_stiffness, tensile_strength, shear_strength)
    return Bond(radius, *(value * share for value in values))


def _zero() -> np.ndarray:
    return np.zeros(3)


@dataclass
class BondState:
    """What a bond remembers: the distance (m) at which it was made, and what it carries on body 1."""

    rest_distance: float
    normal_force: float = 0.0
    """N, positive where it pushes."""
    shear_force: np.ndarray = field(default_factory=_zero)
    """N, shape (3,)."""
    twisting_moment: float = 0.0
    """N m, about the normal."""
    bending_moment: np.ndarray = field(default_factory=_zero)
    """N m, shape (3,), square to the normal."""
    broken: str = ""
    """Empty, or the mode in which it broke: tension or shear."""


def carried(vector, normal, mean_turn) -> np.ndarray:
    """A vector of the contact plane after the contact has moved, shape (3,): turned by the bodies' mean rotation about
    the normal (`mean_turn`, rad, a vector), then laid into the new plane at its old size."""
    vector, normal = np.asarray(vector, float), np.asarray(normal, float)
    size = np.linalg.norm(vector)
    turned = vector + np.dot(mean_turn, normal) * np.cross(normal, vector)
    turned = turned - np.dot(turned, normal) * normal
    length = np.linalg.norm(turned)
    return turned * (size / length) if length > 0 else np.zeros(3)


def advance(
    law: Bond, state: BondState, distance: float, normal, displacement, turn, mean_turn=(0.0, 0.0, 0.0)
) -> None:
    """Take a bond through one step, in place.

    distance, normal -- of the centres after the step, m and (3,)
    displacement -- relative displacement at the contact point in this step, m, (3,); only its part in the plane counts
    turn -- relative rotation in this step, rad, (3,)
    mean_turn -- mean rotation of both bodies in this step, rad, (3,)
    """
    if state.broken:
        return
    normal, displacement, turn = (np.asarray(v, float) for v in (normal, displacement, turn))
    slide = displacement - np.dot(displacement, normal) * normal
    twist = float(np.dot(turn, normal))
    bend = turn - twist * normal
    state.normal_force = -law.normal_stiffness * law.area * (distance - state.rest_distance)
    state.shear_force = carried(state.shear_force, normal, mean_turn) - law.shear_stiffness * law.area * slide
    state.twisting_moment -= law.shear_stiffness * law.polar_moment * twist
    bending = carried(state.bending_moment, normal, mean_turn)
    state.bending_moment = bending - law.normal_stiffness * law.moment_of_inertia * bend
    tensile, shear = stresses(law, state)
    if tensile >= law.tensile_strength or shear >= law.shear_strength:
        broken = TENSION if tensile / law.tensile_strength >= shear / law.shear_strength else SHEAR
        state.normal_force = state.twisting_moment = 0.0
        state.shear_force, state.bending_moment, state.broken = _zero(), _zero(), broken


def stresses(law: Bond, state: BondState) -> tuple[float, float]:
    """Greatest tensile and shear stress at the disc's edge, Pa (eq. 18 and 19)."""
    bending, shear = np.linalg.norm(state.bending_moment), np.linalg.norm(state.shear_force)
    return (
        float(-state.normal_force / law.area + bending * law.radius / law.moment_of_inertia),
        float(shear / law.area + abs(state.twisting_moment) * law.radius / law.polar_moment),
    )


def elastic_energy(law: Bond, state: BondState) -> float:
    """Energy stored in the bond, J."""
    bending, shear = np.linalg.norm(state.bending_moment), np.linalg.norm(state.shear_force)
    return float(
        state.normal_force**2 / (2 * law.normal_stiffness * law.area)
        + shear**2 / (2 * law.shear_stiffness * law.area)
        + state.twisting_moment**2 / (2 * law.shear_stiffness * law.polar_moment)
        + bending**2 / (2 * law.normal_stiffness * law.moment_of_inertia)
    )
