"""The parallel bond against closed forms."""

import math

import numpy as np
import pytest

from analysis import bond_law
from analysis.bond_law import Bond, BondState, advance, bond, elastic_energy, stresses

X, Y, Z = np.eye(3)
RADIUS, DISTANCE = 0.0125, 0.025
LAW = bond(RADIUS, 4e9, 5e6, 3e7, 3e7)
EQUAL = bond(RADIUS, 4e9, 4e9, 3e7, 3e7)
STILL = np.zeros(3)
EXACT = 1e-12
"""Sums of a hundred equal increments: rounding only."""


def pull(law, stretch, steps=100):
    """Draw the bodies apart along z by `stretch`, m."""
    state = BondState(DISTANCE)
    for n in range(1, steps + 1):
        advance(law, state, DISTANCE + stretch * n / steps, Z, Z * stretch / steps, STILL)
    return state


def move(law, slide=STILL, turn=STILL, steps=100):
    """Slide and turn body 1 at a fixed distance and normal, in equal steps."""
    state = BondState(DISTANCE)
    for _ in range(steps):
        advance(law, state, DISTANCE, Z, np.asarray(slide) / steps, np.asarray(turn) / steps)
    return state


def test_area_and_moments_of_inertia_are_those_of_a_disc():
    """By summing the disc's rings and strips, not by the formulas."""
    rings = (np.arange(20000) + 0.5) / 20000 * RADIUS
    ring_area = 2 * math.pi * rings * RADIUS / 20000
    assert LAW.area == pytest.approx(ring_area.sum(), rel=1e-6)
    assert LAW.polar_moment == pytest.approx((ring_area * rings**2).sum(), rel=1e-6)
    assert LAW.moment_of_inertia == pytest.approx(LAW.polar_moment / 2, rel=EXACT)  # perpendicular axes


def test_the_radius_is_the_multiplier_times_the_smaller_sphere():
    assert bond_law.bond_radius(1.0, 0.02, 0.01) == 0.01
    assert bond_law.bond_radius(0.5, 0.01, 0.02) == 0.005


def test_a_pulled_bond_pulls_back_with_stiffness_times_area():
    state = pull(LAW, 1e-4)
    assert state.normal_force == pytest.approx(-4e9 * math.pi * RADIUS**2 * 1e-4, rel=EXACT)
    assert not state.shear_force.any() and not state.bending_moment.any() and not state.twisting_moment


def test_a_pressed_bond_pushes_and_never_breaks():
    assert pull(LAW, -0.01).normal_force == pytest.approx(4e9 * math.pi * RADIUS**2 * 0.01, rel=EXACT)


def test_a_sheared_bond_resists_along_the_displacement():
    state = move(LAW, slide=(3e-4, 4e-4, 1e-3))  # what lies along the normal does not count
    np.testing.assert_allclose(state.shear_force, -5e6 * LAW.area * np.array([3e-4, 4e-4, 0.0]), rtol=EXACT)


def test_rotation_is_split_into_twist_and_bending():
    state = move(LAW, turn=(0.01, -0.02, 0.03))
    assert state.twisting_moment == pytest.approx(-5e6 * LAW.polar_moment * 0.03, rel=EXACT)
    np.testing.assert_allclose(
        state.bending_moment, -4e9 * LAW.moment_of_inertia * np.array([0.01, -0.02, 0.0]), rtol=EXACT
    )


BREAKING = {
    "pulled": (lambda law, load: pull(law, load), 3e7 / 4e9, bond_law.TENSION),
    "sheared": (lambda law, load: move(law, slide=X * load), 3e7 / 4e9, bond_law.SHEAR),
    "bent": (lambda law, load: move(law, turn=Y * load), 3e7 / (4e9 * RADIUS), bond_law.TENSION),
    "twisted": (lambda law, load: move(law, turn=Z * load), 3e7 / (4e9 * RADIUS), bond_law.SHEAR),
}


@pytest.mark.parametrize("way", BREAKING)
def test_a_bond_breaks_in_each_way_at_its_strength(way):
    """Stress k_n u, k_s u, k_n theta R and k_s theta R, equal to the strength: just below it holds, just above not."""
    load, limit, mode = BREAKING[way]
    assert not load(EQUAL, 0.999 * limit).broken
    state = load(EQUAL, 1.001 * limit)
    assert state.broken == mode
    assert state.normal_force == state.twisting_moment == 0
    assert not state.shear_force.any() and not state.bending_moment.any()


def test_pulling_and_bending_add_up_and_pressing_relieves():
    bending = 0.6 * 3e7 * EQUAL.moment_of_inertia / RADIUS
    for normal_force, share in ((-0.3, 0.9), (0.0, 0.6), (0.4, 0.2)):
        state = BondState(
            DISTANCE, normal_force=normal_force * 3e7 * EQUAL.area, bending_moment=np.array([0.0, bending, 0.0])
        )
        assert stresses(EQUAL, state)[0] == pytest.approx(share * 3e7, rel=EXACT)


def test_shearing_and_twisting_add_up():
    state = BondState(
        DISTANCE,
        shear_force=0.3 * 3e7 * EQUAL.area * X,
        twisting_moment=-0.5 * 3e7 * EQUAL.polar_moment / RADIUS,
    )
    assert stresses(EQUAL, state)[1] == pytest.approx(0.8 * 3e7, rel=EXACT)


def test_broken_stays_broken():
    state = pull(LAW, 0.01)
    assert state.broken
    advance(LAW, state, DISTANCE, Z, X * 1e-4, Y * 1e-3)
    assert state.normal_force == 0 and not state.shear_force.any() and not state.bending_moment.any()


def test_forces_and_moments_follow_the_contact():
    """A bonded pair that turns as one rigid body keeps what it carries, turned by the same rotation."""
    state = move(EQUAL, slide=X * 1e-4, turn=X * 1e-3)
    spin, steps = np.array([0.3, 0.5, 0.7]), 20000
    turn = spin / steps
    for n in range(1, steps + 1):
        advance(EQUAL, state, DISTANCE, rotation(spin * n / steps) @ Z, STILL, STILL, turn)
    whole = rotation(spin)
    np.testing.assert_allclose(state.shear_force, whole @ (-4e9 * EQUAL.area * 1e-4 * X), rtol=0, atol=1e-4 * 196)
    np.testing.assert_allclose(
        state.bending_moment, whole @ (-4e9 * EQUAL.moment_of_inertia * 1e-3 * X), rtol=0, atol=1e-4 * 0.0767
    )


def rotation(vector):
    """Matrix of a rotation vector (Rodrigues)."""
    angle = np.linalg.norm(vector)
    a, b, c = vector / angle
    cross = np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def test_the_stored_energy_is_the_work_done():
    """Half of force times displacement, in each of the four ways."""
    for state, work in (
        (pull(LAW, 1e-4), 0.5 * 4e9 * LAW.area * 1e-4**2),
        (move(LAW, slide=X * 1e-4), 0.5 * 5e6 * LAW.area * 1e-4**2),
        (move(LAW, turn=Z * 1e-3), 0.5 * 5e6 * LAW.polar_moment * 1e-3**2),
        (move(LAW, turn=X * 1e-3), 0.5 * 4e9 * LAW.moment_of_inertia * 1e-3**2),
    ):
        assert elastic_energy(LAW, state) == pytest.approx(work, rel=1e-9)


def test_total_values_are_those_of_the_whole_bond():
    whole = bond(RADIUS, 4e9, 5e6, 3e7, 3e7, bond_law.TOTAL)
    assert pull(whole, 1e-4).normal_force == pytest.approx(-4e5, rel=EXACT)
    assert whole.tensile_strength * whole.area == pytest.approx(3e7, rel=EXACT)
    assert whole.shear_stiffness * whole.area == pytest.approx(5e6, rel=EXACT)


def test_an_unknown_reading_is_refused():
    with pytest.raises(ValueError, match="per_area or total"):
        bond(RADIUS, 4e9, 5e6, 3e7, 3e7, "per_bond")
    assert isinstance(bond(RADIUS, 4e9, 5e6, 3e7, 3e7, bond_law.PER_AREA), Bond)
