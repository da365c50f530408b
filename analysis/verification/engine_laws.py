"""What each engine makes of the paper's laws, as the cases must expect it: the only module here that says which engine.

LIGGGHTS has the models of this study, which are the paper's laws. YADE has laws of its own where its package knows no
other.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from analysis import contact_laws
from analysis.scenarios.conversions import viscous_restitution
from analysis.scenarios.deviations import BOND_CHECK_STEPS
from analysis.scenarios.scenario import Scenario
from analysis.verification import oracle


@dataclass(frozen=True)
class Along:
    """A law along an imposed path: how it deviates, as keywords of `oracle.forces_along`, and what is said of it."""

    reason: str = "oracle, eq. 1-16 step by step"
    tolerance: float = 1e-4
    deviates: dict[str, bool] = field(default_factory=dict)
    slip_limit: str = ""
    """What the slip limit holds beside the elastic force; empty in the paper's law."""


NO_CLOSING_SHARE_SLIP_BY_TOTAL = {"closing_scaled": False, "slip_by_total": True}


class EngineLaws:
    """The paper's laws, as LIGGGHTS has them through the models of this study."""

    code, called = "liggghts", "LIGGGHTS"
    has_dashpot_limit = True
    """The hysteretic dashpot has its limit, and contacts at it are counted."""
    rigid_plane_is_wall = True
    """A rigid plane of the cases is a wall with the particles' law; else a held sphere 10^4 times as large."""
    hysteretic_note = hysteretic_remark = ""
    """What stands in for the hysteretic law at e_n < 1: in full and in short; empty where there is no need."""
    wall_slip_limit = ""
    """What the slip limit at walls with a dashpot holds beside the elastic force; empty in the paper's law."""
    sinking_note = "oracle with the limit"
    velocity_age = 0.0
    """By how many steps velocities and spins of a row are older than its places."""
    rotation_tolerance, rotation_note = 0.001, ""
    """Of the energy of free rotation."""
    steps_between_bond_checks = 0
    """Steps between looks for bonds broken by force and moment together; 0: at every step."""

    def pair(self, scenario: Scenario, mass: float, radius: float) -> oracle.Linear | oracle.Hysteretic:
        """Law between two spheres: `mass` by eq. 7, `radius` by eq. 9."""
        get = {
            key: scenario[f"contact.particle_particle.{key}"]
            for key in (
                "normal_stiffness",
                "shear_stiffness",
                "damping_ratio",
                "friction",
                "shear_modulus",
                "poisson_ratio",
                "restitution",
                "damping_mode",
            )
        }
        if scenario["contact.model"] == "linear":
            return oracle.Linear(
                get["normal_stiffness"], get["shear_stiffness"], get["friction"], get["damping_ratio"], mass
            )
        factor = contact_laws.damping_factor(get["damping_mode"], get["restitution"])
        elastic = (get["shear_modulus"], get["poisson_ratio"], radius, get["friction"])
        return self._hysteretic(scenario, elastic, factor, mass)

    def _hysteretic(self, scenario: Scenario, elastic: tuple, factor: float, mass: float) -> oracle.Hysteretic:
        return oracle.Hysteretic(*elastic, factor=factor, mass=mass)

    def along(self, own_contacts: bool) -> Along:
        """The law along a path, with the paper's contacts or the engine's own (contact.origin)."""
        if not own_contacts:
            return Along()
        return Along(
            "oracle with LIGGGHTS' own law: shear as displacement, which outlives a separation, no eq. 3, dashpot's "
            "force in the slip limit",
            0.005,
            NO_CLOSING_SHARE_SLIP_BY_TOTAL | {"by_displacement": True},
            "LIGGGHTS counts the dashpot's force in the slip limit",
        )


class YadeLaws(EngineLaws):
    """YADE's laws: the paper's where it has them, else its own."""

    code, called = "yade", "YADE"
    has_dashpot_limit = rigid_plane_is_wall = False
    hysteretic_note = (
        "YADE has no hysteretic law: viscous Hertz law; restitution as in the paper's law, peaks and duration by its "
        "own"
    )
    hysteretic_remark = "YADE has no hysteretic law: viscous Hertz law with the same restitution"
    wall_slip_limit = "YADE counts the dashpot's force in the slip limit"
    sinking_note = "YADE's viscous Hertz law needs no limit: its own oracle"
    velocity_age = 0.5
    rotation_tolerance = 0.005
    rotation_note = (
        "; YADE's rotation gains energy in proportion to step, time and spin, and keeps the angular momentum"
    )
    steps_between_bond_checks = BOND_CHECK_STEPS

    def _hysteretic(self, scenario: Scenario, elastic: tuple, factor: float, mass: float) -> oracle.Hysteretic:
        if not factor:
            return super()._hysteretic(scenario, elastic, factor, mass)
        return oracle.ViscousHertz(*elastic, mass=mass, restitution=viscous_restitution(scenario))

    def along(self, own_contacts: bool) -> Along:
        return Along(
            "oracle with YADE's own law: no eq. 3, dashpot's force in the slip limit",
            0.005,
            NO_CLOSING_SHARE_SLIP_BY_TOTAL,
            self.wall_slip_limit,
        )


PAPER = EngineLaws()
"""The laws of the paper themselves."""
ENGINE_LAWS = {engine.code: engine for engine in (PAPER, YadeLaws())}


def wall_law(scenario: Scenario, mass: float) -> oracle.Linear:
    """Law between a sphere or clump of this mass and the study's walls."""
    return oracle.Linear(
        *(
            scenario[f"contact.particle_wall.{key}"]
            for key in ("normal_stiffness", "shear_stiffness", "friction", "damping_ratio")
        ),
        mass,
    )
