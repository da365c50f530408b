"""How a scenario's parameters become those of YADE and of LIGGGHTS: the table in PARAMETERS.md, which tests
compare with the values that the engines use.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from analysis import contact_laws
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario

PP, PW = "contact.particle_particle.", "contact.particle_wall."


@dataclass(frozen=True)
class Conversion:
    """One row: parameter of the scenario file, what it becomes, by which formula, and how the engines name the result.

    `yade_key` is <pair>.<attribute> of YADE's contact (phys) or body, `liggghts_key` the property and pair of types;
    the callables give the values that belong there.
    """

    parameter: str
    model: str
    yade: str
    liggghts: str
    yade_key: str
    yade_value: Callable[[Scenario], float]
    liggghts_key: str
    liggghts_value: Callable[[Scenario], float]


def _same(key: str) -> Callable[[Scenario], float]:
    return lambda s: s[key]


def _dashpot_mass(scenario: Scenario) -> float:
    """Mass of a sphere as its dashpots see it, kg."""
    return derived.clump(scenario).mass_kg * scenario["contact.dashpot_mass_share"]


def _pair_mass(scenario: Scenario) -> float:
    return contact_laws.effective_mass(_dashpot_mass(scenario), _dashpot_mass(scenario))


def _hertz(scenario: Scenario) -> float:
    radius = derived.clump(scenario).radius_m
    return contact_laws.hertz_coefficient(
        scenario[PP + "shear_modulus"], scenario[PP + "poisson_ratio"], contact_laws.effective_radius(radius, radius)
    )


def _mindlin(scenario: Scenario) -> float:
    radius = derived.clump(scenario).radius_m
    return contact_laws.mindlin_shear_stiffness(
        1.0,
        scenario[PP + "shear_modulus"],
        scenario[PP + "poisson_ratio"],
        contact_laws.effective_radius(radius, radius),
    )


def viscous_restitution(scenario: Scenario) -> float:
    """Restitution at which YADE's viscous Hertz dashpot stands in for the hysteretic one: that of a free impact."""
    factor = contact_laws.damping_factor(scenario[PP + "damping_mode"], scenario[PP + "restitution"])
    return contact_laws.hysteretic_restitution(factor, scenario["contact.dashpot_limit"]) if factor else 1.0


def viscous_damping_ratio(scenario: Scenario) -> float:
    """Share of critical damping of that dashpot; 0 without damping."""
    return contact_laws.viscous_hertz_damping_ratio(viscous_restitution(scenario))


def _wall_dashpot(scenario: Scenario) -> float:
    return contact_laws.linear_dashpot_coefficient(
        scenario[PW + "damping_ratio"], _dashpot_mass(scenario), scenario[PW + "normal_stiffness"]
    )


def _pair_dashpot(scenario: Scenario) -> float:
    return contact_laws.linear_dashpot_coefficient(
        scenario[PP + "damping_ratio"], _pair_mass(scenario), scenario[PP + "normal_stiffness"]
    )


CONVERSIONS = (
    Conversion(
        PP + "normal_stiffness",
        "linear",
        "`kn` = k_n",
        "`normalStiffness` = k_n",
        "pp.kn",
        _same(PP + "normal_stiffness"),
        "normal_stiffness[1][1]",
        _same(PP + "normal_stiffness"),
    ),
    Conversion(
        PP + "shear_stiffness",
        "linear",
        "`ks` = k_s (`kRatio` = k_s/k_n with a dashpot)",
        "`shearStiffness` = k_s",
        "pp.ks",
        _same(PP + "shear_stiffness"),
        "shear_stiffness[1][1]",
        _same(PP + "shear_stiffness"),
    ),
    Conversion(
        PP + "damping_ratio",
        "linear",
        "`betan` = beta; `cn` = 2 beta sqrt(m k_n), m = m1 m2/(m1 + m2)",
        "`dampingRatio` = beta; the same coefficient",
        "pp.cn",
        _pair_dashpot,
        "damping_ratio[1][1]",
        _same(PP + "damping_ratio"),
    ),
    Conversion(
        PP + "friction",
        "both",
        "`frictAngle` = atan(mu)",
        "`slipFriction` = mu",
        "pp.tangensOfFrictionAngle",
        _same(PP + "friction"),
        "slip_friction[1][1]",
        _same(PP + "friction"),
    ),
    Conversion(
        PP + "shear_modulus",
        "hysteretic",
        "`young` = 2 G (1 + nu); `kno` = 2 G sqrt(2 R)/(3 (1 - nu)), 1/R = (1/R1 + 1/R2)/2",
        "`shearModulus` = G; eq. 8",
        "pp.kno",
        _hertz,
        "shear_modulus[1][1]",
        _same(PP + "shear_modulus"),
    ),
    Conversion(
        PP + "poisson_ratio",
        "hysteretic",
        "`poisson` = nu; `kso` = 2 G sqrt(2 R)/(2 - nu)",
        "`contactPoissonRatio` = nu; eq. 11",
        "pp.kso",
        _mindlin,
        "poisson_ratio[1][1]",
        _same(PP + "poisson_ratio"),
    ),
    Conversion(
        PP + "restitution",
        "hysteretic",
        "`betan` = beta with exp(-2 z acos(z)/sqrt(1 - z^2)) = e', z = sqrt(1.2) beta; e' of a free impact, "
        "D (1 + e') = ln((1 + D)/(1 - D e')) where the dashpot's limit is not met; `betas` = 0",
        "`nominalRestitution` = e_n; eq. 15",
        "pp.betan",
        viscous_damping_ratio,
        "restitution[1][1]",
        _same(PP + "restitution"),
    ),
    Conversion(
        PP + "damping_mode",
        "hysteretic",
        "in D: M_d 0 (1 - e_n^2)/e_n, 1 3 (1 - e_n^2)/4, 2 3 (1 - e_n^2) exp(2 (1 - e_n))/4",
        "`dampingMode` = M_d; eq. 16",
        "pp.betan",
        viscous_damping_ratio,
        "damping_mode",
        _same(PP + "damping_mode"),
    ),
    Conversion(
        PW + "normal_stiffness",
        "both",
        "`kn` = k_n",
        "`normalStiffness` = k_n",
        "pw.kn",
        _same(PW + "normal_stiffness"),
        "normal_stiffness[1][2]",
        _same(PW + "normal_stiffness"),
    ),
    Conversion(
        PW + "shear_stiffness",
        "both",
        "`ks` = k_s (`kRatio` = k_s/k_n with a dashpot)",
        "`shearStiffness` = k_s",
        "pw.ks",
        _same(PW + "shear_stiffness"),
        "shear_stiffness[1][2]",
        _same(PW + "shear_stiffness"),
    ),
    Conversion(
        PW + "damping_ratio",
        "both",
        "`betan` = beta; `cn` = 2 beta sqrt(m k_n), m of the clump",
        "`dampingRatio` = beta; the same coefficient",
        "pw.cn",
        _wall_dashpot,
        "damping_ratio[1][2]",
        _same(PW + "damping_ratio"),
    ),
    Conversion(
        PW + "friction",
        "both",
        "`frictAngle` = atan(mu)",
        "`slipFriction` = mu",
        "pw.tangensOfFrictionAngle",
        _same(PW + "friction"),
        "slip_friction[1][2]",
        _same(PW + "friction"),
    ),
    Conversion(
        "clump.density",
        "both",
        "`state.mass` of the clump = density x volume of the union; of its spheres, as dashpots see it, times "
        "`contact.dashpot_mass_share`",
        "`place mass`; mass of each sphere as the dashpot sees it, the same",
        "sphere.mass",
        _dashpot_mass,
        "sphere_mass",
        lambda s: derived.clump(s).mass_kg,
    ),
    Conversion(
        "time.step",
        "both",
        "`O.dt` = 1/(f n), n the multiple of output.rows_per_cycle nearest to 1/(f time.step)",
        "`timestep`, the same",
        "dt",
        lambda s: derived.time_grid(s).step_s,
        "dt",
        lambda s: derived.time_grid(s).step_s,
    ),
)


OWN_MODELS = (
    ("contact models", "`FrictMat`; `FrictMat` with Mindlin", "`hooke/stiffness`; `hertz`, `tangential history`"),
    ("normal, shear stiffness (linear)", "`kn` = k_n, `ks` = k_s", "`kn` = k_n, `kt` = k_s"),
    ("damping ratio (linear)", "`betan` = beta", "`gamman` = 2 beta sqrt(k_n/m), m of half a clump; `gammat` = 0"),
    (
        "shear modulus, Poisson's ratio",
        "`young` = 2 G (1 + nu), `poisson` = nu",
        "`youngsModulus` and `poissonsRatio`, same",
    ),
    ("restitution", "`en` = e_n, `es` = 1", "`coefficientRestitution` = e_n"),
    ("friction", "`frictAngle` = atan(mu)", "`coefficientFriction` = mu"),
    ("slip limit", "with the dashpot's force", "with the dashpot's force"),
    ("shear force", "in increments of force", "shear displacement times the present stiffness; kept while apart"),
    ("eq. 3, share of the closing step", "none", "none"),
    ("relative velocity", "without granular ratcheting", "of the contact point"),
)
"""With contact.origin = engine: what, in YADE, in LIGGGHTS. Walls stay the paper's."""
BONDS = (
    ("`contact.bond.normal_stiffness`", "`kn` = k_n A, `kr` = k_n I", "`stiffness`, first value"),
    ("`contact.bond.shear_stiffness`", "`ks` = k_s A, `ktw` = k_s J", "`stiffness`, second value"),
    ("`contact.bond.normal_strength`", "`normalAdhesion` = strength x A", "`strength`, first value"),
    ("`contact.bond.shear_strength`", "`shearAdhesion` = strength x A", "`strength`, second value"),
)
"""Parallel bonds of radius R: A = pi R^2, I = pi R^4 / 4, J = 2 I; in the reading `total` k and strength over A."""


def _plain_table(first: str, rows) -> list[str]:
    lines = [f"| {first} | YADE | LIGGGHTS |", "| --- | --- | --- |"]
    return lines + [f"| {' | '.join(row)} |" for row in rows]


def markdown() -> str:
    """The tables for PARAMETERS.md."""
    lines = [
        "## The same parameter in YADE and in LIGGGHTS\n",
        "Tests compare each row with the values that the engines use. [docs/method.md](docs/method.md"
        "#what-each-code-does-otherwise) lists what YADE does otherwise.\n",
        "| parameter | contact model | YADE | LIGGGHTS |",
        "| --- | --- | --- | --- |",
    ]
    lines += [f"| `{c.parameter}` | {c.model} | {c.yade} | {c.liggghts} |" for c in CONVERSIONS]
    lines += [
        "\nWith `contact.origin` = engine (variant `stock`), between particles:\n",
        *_plain_table("what", OWN_MODELS),
    ]
    bond = "\nParallel bonds of radius R, A = pi R^2, I = pi R^4/4, J = 2 I; in the reading `total`, over A:\n"
    lines += [bond, *_plain_table("parameter", BONDS)]
    return "\n".join(lines) + "\n"
