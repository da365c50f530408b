"""The laws against closed forms and published numbers, and the oracle against both."""

import math

import numpy as np
import pytest

from analysis import contact_laws
from analysis.verification import oracle

# the sources of eq. 16: restitution that comes out, by damping mode and nominal restitution
RESTITUTION_OUT = {
    0: {0.3: 0.3042, 0.6: 0.5773, 0.9: 0.8764, 1.0: 1.0},
    1: {0.0: 0.6630, 0.3: 0.6842, 0.6: 0.7561, 0.9: 0.9132, 1.0: 1.0},
    2: {0.0: 0.1787, 0.3: 0.3267, 0.6: 0.5769, 0.9: 0.8959, 1.0: 1.0},
}
TABLE = [(mode, e, out) for mode, row in RESTITUTION_OUT.items() for e, out in row.items()]
MASS = 0.0345


@pytest.mark.parametrize("mode, nominal, out", TABLE)
def test_restitution_that_comes_out(mode, nominal, out):
    factor = contact_laws.damping_factor(mode, nominal)
    assert contact_laws.effective_restitution(factor) == pytest.approx(out, abs=6e-5)


@pytest.mark.parametrize("mode, nominal", [row[:2] for row in TABLE if row[:2] != (2, 0.0)])
def test_restitution_by_integration(mode, nominal):
    """The closed form D (1 + e') = ln((1 + D)/(1 - D e')) is what the equation of motion gives, at any stiffness."""
    factor = contact_laws.damping_factor(mode, nominal)
    law = oracle.Hysteretic(35e6, 0.3, 0.0147, factor=factor, mass=MASS)
    impact = oracle.head_on(law, 0.5)
    assert impact.restitution == pytest.approx(contact_laws.effective_restitution(factor), abs=1e-8)
    coefficient = contact_laws.hertz_coefficient(35e6, 0.3, 0.0147)
    assert impact.peak_overlap_m == pytest.approx(
        contact_laws.hysteretic_peak_overlap(MASS, coefficient, factor, 0.5), rel=1e-7
    )


@pytest.mark.parametrize("mode, nominal", [(0, 0.02), (0, 0.1), (0, 0.15), (0, 0.2), (0, 0.23), (2, 0.0), (0, 0.3)])
@pytest.mark.parametrize("limit", [1.0, 0.5])
def test_restitution_with_the_dashpots_limit_is_that_of_the_equation_of_motion(mode, nominal, limit):
    factor = contact_laws.damping_factor(mode, nominal)
    if limit == 1.0:
        law = oracle.Hysteretic(35e6, 0.3, 0.0147, factor=factor, mass=MASS)
        assert contact_laws.hysteretic_restitution(factor) == pytest.approx(
            oracle.head_on(law, 0.5).restitution, abs=2e-8
        )
    weaker = contact_laws.hysteretic_restitution(factor, limit)
    assert weaker >= contact_laws.hysteretic_restitution(factor, 2 * limit) - 1e-12 and 0 < weaker < 1


def test_the_limit_takes_damping_away():
    assert contact_laws.hysteretic_restitution(contact_laws.damping_factor(0, 0.1)) == pytest.approx(0.1485, abs=5e-5)
    assert contact_laws.effective_restitution(contact_laws.damping_factor(0, 0.1)) == pytest.approx(0.1010, abs=5e-5)


@pytest.mark.parametrize("restitution", [0.02, 0.1, 0.135, 0.2, 0.5, 0.9, 0.98, 0.999, 1.0])
def test_the_viscous_hertz_dashpot_gives_the_restitution_that_was_asked(restitution):
    law = oracle.ViscousHertz(35e6, 0.3, 0.0147, mass=MASS, restitution=restitution)
    assert oracle.head_on(law, 0.5).restitution == pytest.approx(restitution, abs=1e-8)
    share = contact_laws.viscous_hertz_damping_ratio(restitution)
    assert contact_laws.viscous_hertz_restitution(share) == pytest.approx(restitution, abs=1e-13)


def test_no_dashpot_gives_a_restitution_of_0():
    for wrong in (0.0, -0.1, 1.1):
        with pytest.raises(ValueError, match="has no damping ratio"):
            contact_laws.viscous_hertz_damping_ratio(wrong)


def test_damping_mode_0_refuses_restitution_0():
    with pytest.raises(ValueError, match="singular"):
        contact_laws.damping_factor(0, 0.0)


@pytest.mark.parametrize("mode", [0, 1, 2])
def test_nominal_restitution_inverts(mode):
    assert contact_laws.effective_restitution(
        contact_laws.damping_factor(mode, contact_laws.nominal_restitution(mode, 0.8))
    ) == pytest.approx(0.8)


def test_nominal_restitution_refuses_what_a_mode_cannot_give():
    with pytest.raises(ValueError, match="0.663"):
        contact_laws.nominal_restitution(1, 0.5)


@pytest.mark.parametrize("ratio", [0.0, 0.06, 0.3, 0.7])
def test_linear_impact_by_integration(ratio):
    closed = contact_laws.linear_impact(MASS, 1e8, ratio, 0.5)
    impact = oracle.head_on(oracle.Linear(1e8, 1e8, damping_ratio=ratio, mass=MASS), 0.5)
    for name, value in closed.items():
        assert getattr(impact, name) == pytest.approx(value, rel=1e-5), name


def test_wall_dashpot_restitution():
    assert contact_laws.dashpot_restitution(0.06) == pytest.approx(0.8279, abs=5e-5)
    assert contact_laws.dashpot_restitution(contact_laws.damping_ratio_of(0.5)) == pytest.approx(0.5)


# Chung and Ooi 2011, tests 1 and 2: E, nu, density, radius, speed, wall -> overlap (m), force (N), duration (s)
CHUNG_OOI = [
    (48e9, 0.20, 2800, 0.01, 20, False, 274.1e-6, 10.70e3, 40.3e-6),
    (20e9, 0.25, 2500, 0.01, 20, False, 368.3e-6, 7.11e3, 54.2e-6),
    (70e9, 0.30, 2699, 0.1, 0.2, True, 49.72e-6, 11.37e3, 731.7e-6),
    (40e9, 0.35, 1800, 0.1, 0.2, True, 52.12e-6, 7.23e3, 767.1e-6),
]


@pytest.mark.parametrize("young, nu, density, radius, speed, wall, overlap, force, duration", CHUNG_OOI)
def test_chung_and_ooi(young, nu, density, radius, speed, wall, overlap, force, duration):
    shear = young / (2 * (1 + nu))
    mass = density * 4 / 3 * math.pi * radius**3
    shear, nu = contact_laws.equivalent_material(shear, nu, math.inf if wall else shear, nu)
    bar = contact_laws.effective_radius(radius, math.inf if wall else radius)
    impact = contact_laws.hertz_impact(
        mass if wall else mass / 2, contact_laws.hertz_coefficient(shear, nu, bar), speed
    )
    assert impact["peak_overlap_m"] == pytest.approx(overlap, rel=3e-4)
    assert impact["peak_force_N"] == pytest.approx(force, rel=6e-4)
    assert impact["duration_s"] == pytest.approx(duration, rel=1e-3)


def test_equivalent_material_of_equal_ones():
    assert contact_laws.equivalent_material(35e6, 0.3, 35e6, 0.3) == pytest.approx((35e6, 0.3))


def test_hysteretic_law_is_hertz_and_mindlin():
    """Against the textbook forms with E*, R* and G*, which share no term with eq. 8, 9 and 11."""
    young, nu, r1, r2, overlap = 91e6, 0.3, 0.01, 0.03, 1e-4
    e_star, r_star = young / (2 * (1 - nu**2)), r1 * r2 / (r1 + r2)
    g_star = young / (4 * (2 - nu) * (1 + nu))
    shear = young / (2 * (1 + nu))
    bar = contact_laws.effective_radius(r1, r2)
    assert contact_laws.hertz_normal_force(overlap, shear, nu, bar) == pytest.approx(
        4 / 3 * e_star * math.sqrt(r_star) * overlap**1.5
    )
    assert contact_laws.mindlin_shear_stiffness(overlap, shear, nu, bar) == pytest.approx(
        8 * g_star * math.sqrt(r_star * overlap)
    )


def test_slip_keeps_direction_and_uses_the_elastic_force():
    force = contact_laws.slip([3.0, 4.0, 0.0], contact_laws.shear_strength(0.5, 2.0))
    assert force == pytest.approx([0.6, 0.8, 0.0])
    assert contact_laws.slip([0.3, 0.4, 0.0], 1.0) == pytest.approx([0.3, 0.4, 0.0])


def test_closing_share():
    assert contact_laws.closing_share(3e-6, -1e-6) == pytest.approx(0.75)
    assert contact_laws.closing_share(3e-6, 1e-6) == 1.0


def test_dashpot_limit():
    """Eq. 15 below the limit, critical damping above it and at no approach speed; the force never pulls."""
    elastic, overlap, mass = 10.0, 1e-4, MASS
    limit = 2 * math.sqrt(mass * 1.5 * elastic / overlap)
    assert contact_laws.hysteretic_dashpot_coefficient(0.5, elastic, 1.0, overlap, mass) == (pytest.approx(5.0), False)
    assert contact_laws.hysteretic_dashpot_coefficient(0.5, elastic, 1e-9, overlap, mass) == (
        pytest.approx(limit),
        True,
    )
    assert contact_laws.hysteretic_dashpot_coefficient(0.5, elastic, 0.0, overlap, mass) == (pytest.approx(limit), True)
    assert contact_laws.hysteretic_dashpot_coefficient(0.0, elastic, 0.0, overlap, mass) == (0.0, False)
    assert contact_laws.hysteretic_normal_force(10.0, 5.0, -3.0) == 0.0


def test_limit_stays_clear_of_the_paper_cases():
    """No impact of the paper reaches the limit (D < 4), so it changes no restitution; the first beyond does."""
    for mode, nominal, _ in TABLE:
        assert contact_laws.damping_factor(mode, nominal) < contact_laws.LIMIT_FREE_FACTOR or (mode, nominal) == (
            2,
            0.0,
        )  # which the paper leaves out
    for factor, shift in ((3.9, 0.0), (5.54, 0.0042)):
        law = oracle.Hysteretic(35e6, 0.3, 0.0147, factor=factor, mass=MASS)
        assert oracle.head_on(law, 0.5).restitution == pytest.approx(
            contact_laws.effective_restitution(factor) * (1 + shift), rel=1e-4
        )


# ------------------------------------------------------------------ oracle

BALL = oracle.Body(MASS, 0.4 * MASS * 0.015**2, ((0.0, 0.0, 0.015),))


def bounce(friction, degrees, shear_stiffness=1e8, speed=1.0):
    law = oracle.Linear(1e8, shear_stiffness, friction, 0.06, MASS)
    normal, sliding = speed * math.cos(math.radians(degrees)), speed * math.sin(math.radians(degrees))
    end = 1e-7 / normal + 1.05 * math.pi * math.sqrt(MASS / 1e8)
    _, states, _ = oracle.bounce(BALL, [law], (0, 0.015 + 1e-7, 0, sliding, -normal, 0), end)
    return normal, sliding, states[-1]


@pytest.mark.parametrize("degrees", [75, 80, 85])
def test_gross_sliding(degrees):
    """Friction mu times the impulse m (1 + e) v_n; the dashpot's part of the impulse is zero over a whole contact."""
    normal, sliding, state = bounce(0.3, degrees)
    impulse = 0.3 * (1 + contact_laws.dashpot_restitution(0.06)) * normal
    assert state[3] == pytest.approx(sliding - impulse, rel=1e-6)
    assert state[5] == pytest.approx(impulse * MASS * 0.015 / BALL.inertia, rel=1e-3)  # lever R - overlap/2


def test_sticking_bounce_of_infinite_friction():
    """Linear springs, no slip: v_t follows a sine of frequency sqrt(7/2 k_s/m) for half a period of the normal one."""
    law = oracle.Linear(1e8, 3e7, 1e6, 0.0, MASS)
    end = math.pi * math.sqrt(MASS / 1e8)
    _, states, _ = oracle.bounce(BALL, [law], (0, 0.015 + 1e-12, 0, 1e-3, -1e-3, 0), end * 1.01)
    phase = math.sqrt(3.5 * 3e7 / MASS) * end
    assert states[-1][3] == pytest.approx(1e-3 * (1 - 2 / 7 * (1 - math.cos(phase))), rel=1e-4)


def test_bounce_keeps_energy_without_friction_and_damping():
    body = oracle.Body(MASS, 2e-5, ((-0.012, 0.0, 0.0147), (0.012, 0.0, 0.0147)))
    law = oracle.Linear(1e8, 1e8, 0.0, 0.0, MASS)
    _, states, _ = oracle.bounce(body, [law, law], (0, 0.03, 0.4, 0.3, -1.0, 2.0), 0.05)
    energy = 0.5 * MASS * (states[:, 3] ** 2 + states[:, 4] ** 2) + 0.5 * body.inertia * states[:, 5] ** 2
    assert states[-1][4] > 0
    assert energy[-1] == pytest.approx(energy[0], rel=1e-6)


@pytest.mark.parametrize("friction, degrees", [(0.3, 20), (0.3, 50), (0.9, 40), (0.9, 80)])
def test_steps_of_a_code_converge_to_the_integration(friction, degrees):
    """Sticking, slipping and mixed bounces of a leaning two-ball body: an error of the order of the step."""
    body = oracle.Body(MASS, 2e-5, ((-0.012, 0.0, 0.0147), (0.012, 0.0, 0.0147)))
    law = oracle.Linear(1e8, 7e7, friction, 0.06, MASS)
    normal, sliding = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    start = (0, 0.0147 + 0.012 * math.sin(0.1) + 1e-7, 0.1, sliding, -normal, 0.0)
    duration = 3e-4
    _, states, _ = oracle.bounce(body, [law, law], start, duration, 3)
    for step, allowed in ((1e-7, 6e-3), (2e-8, 1.2e-3)):
        stepped = oracle.bounce_in_steps(body, [law, law], start, step, round(duration / step), round(duration / step))
        assert stepped[-1][3:5] == pytest.approx(states[-1][3:5], abs=allowed)


def test_path_follows_the_differential_equation():
    """The paper's steps converge to the shear force integrated by scipy, through slip, reversal and unloading."""
    law = oracle.Hysteretic(35e6, 0.3, 0.0147, friction=0.4)
    times = np.linspace(0, 1.0, 20001)

    def overlap(t):
        return 2e-4 * np.sin(math.pi * (0.1 + 0.8 * t))

    def sliding(t):
        return 1.5e-3 * np.cos(2 * math.pi * 1.3 * t)

    expected = oracle.shear_along(law, overlap, sliding, times)
    middles = (times[1:] + times[:-1]) / 2
    _, shear = oracle.forces_along(law, overlap(times), np.diff(overlap(times)) / times[1], sliding(middles) * times[1])
    assert np.abs(shear - expected[1:]).max() < 2e-3 * np.abs(expected).max()
    slipping = np.isclose(np.abs(expected[1:]), 0.4 * np.array([law.elastic(u) for u in overlap(times[1:])]), rtol=1e-6)
    assert 0.05 < slipping.mean() < 0.95  # both branches are exercised


def test_path_forgets_over_a_separation():
    law = oracle.Linear(1e8, 1e8, friction=10.0)
    closing = np.array([-1, 1, 2, -1, -1, 1]) * 1e-6
    normal, shear = oracle.forces_along(law, closing, np.diff(closing) / 1e-6, np.full(5, -1e-6))
    assert normal == pytest.approx([100, 200, 0, 0, 100])
    assert shear == pytest.approx([50, 150, 0, 0, 50])


def test_viscous_hertz_gives_its_nominal_restitution():
    law = oracle.ViscousHertz(35e6, 0.3, 0.0147, mass=MASS, restitution=0.6)
    impact = oracle.head_on(law, 0.5)
    assert impact.restitution == pytest.approx(0.6, rel=1e-7)
    assert impact.force_N.min() >= 0
