"""Where a code does something else than the paper's laws say, declared once.

run.json, the report and the table of docs/method.md are made from it. Standard library and numpy only: YADE's Python
reads it too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from analysis.scenarios import conversions
from analysis.scenarios.scenario import Scenario

PP, PW = conversions.PP, conversions.PW
BOND_CHECK_STEPS = 50
"""Steps between YADE's looks for bonds that break by force and moment together."""


@dataclass(frozen=True)
class Deviation:
    """One deviation of one code.

    code     yade | liggghts
    law      what the paper (or Potyondy and Cundall for bonds) has: an equation, or a few words
    said     the sentence, with {restitution} and {nominal} where they depend on the scenario
    when     the scenarios that it concerns, in words
    applies  the same as a rule
    """

    code: str
    law: str
    said: str
    when: str
    applies: Callable[[Scenario], bool]

    def sentence(self, scenario: Scenario) -> str:
        """What run.json says of it in a scenario."""
        if "{" not in self.said:
            return self.said
        return self.said.format(
            restitution=f"{conversions.viscous_restitution(scenario):.4f}", nominal=f"{scenario[PP + 'restitution']:g}"
        )


def _always(_: Scenario) -> bool:
    return True


def _stock(scenario: Scenario) -> bool:
    return scenario["contact.origin"] == "engine"


def _hysteretic_dashpot(scenario: Scenario) -> bool:
    """True where contacts between particles have the dashpot of eq. 15, which does nothing at e_n = 1."""
    return scenario["contact.model"] == "hysteretic" and scenario[PP + "restitution"] < 1


def restitution_equivalent(scenario: Scenario) -> bool:
    """True where YADE stands in for the dashpot of eq. 15 by a viscous one of the same restitution."""
    return _hysteretic_dashpot(scenario) and not _stock(scenario)


def _dashpot(scenario: Scenario) -> bool:
    """True where contacts between particles have any dashpot."""
    return _hysteretic_dashpot(scenario) or (
        scenario["contact.model"] == "linear" and scenario[PP + "damping_ratio"] > 0
    )


def _bonded(scenario: Scenario) -> bool:
    return scenario["contact.bond.model"] != "none"


DEVIATIONS = (
    Deviation(
        "yade",
        "eq. 3: share of the closing step",
        "Eq. 3 is left out, YADE has no such rule: the whole shear increment of the closing step counts.",
        "all",
        _always,
    ),
    Deviation(
        "yade",
        "contact point at planes",
        "At planes (floor, end wall, side walls) YADE's contact point lies on the plane, in LIGGGHTS in the middle of "
        "the overlap: the lever of shear forces is half the overlap shorter. Blocks are alike.",
        "all",
        _always,
    ),
    Deviation(
        "yade",
        "eq. 15: hysteretic dashpot",
        "Restitution-equivalent damping: YADE has no hysteretic dashpot (eq. 15), so particles meet with its viscous "
        "Hertz dashpot at the restitution {restitution} that the hysteretic law gives in a free impact at nominal "
        "e_n = {nominal}.",
        "hysteretic contacts with e_n < 1",
        restitution_equivalent,
    ),
    Deviation(
        "yade",
        "eq. 4 and 12: slip limit between particles",
        "The slip limit between particles includes the dashpot's force.",
        "contacts between particles with a dashpot",
        _dashpot,
    ),
    Deviation(
        "yade",
        "limit of the hysteretic dashpot (ours)",
        "contact.dashpot_limit acts through that restitution only: YADE has no dashpot that could be capped.",
        "`contact.dashpot_limit` other than 1",
        lambda s: s["contact.dashpot_limit"] != 1,
    ),
    Deviation(
        "yade",
        "eq. 4: slip limit at walls",
        "The slip limit at walls includes the dashpot's force.",
        "walls with a dashpot: all nonlinear scenarios",
        lambda s: s[PW + "damping_ratio"] > 0,
    ),
    Deviation(
        "yade",
        "parallel bond: when it breaks",
        "Bonds break at once by tension or shear alone; by force and moment together within "
        f"{BOND_CHECK_STEPS} steps of reaching the strength, because YADE's law does not add them up.",
        "bonded scenarios",
        _bonded,
    ),
    Deviation(
        "yade",
        "parallel bond: after it broke",
        f"A bond broken by shear alone still pushes for up to {BOND_CHECK_STEPS} steps, without friction.",
        "bonded scenarios",
        _bonded,
    ),
    Deviation(
        "yade",
        "variant `stock`: contacts between particles",
        "Contacts between particles are YADE's own: relative velocities that avoid granular ratcheting, and at e_n < 1 "
        "a viscous Hertz dashpot with e_n as its restitution.",
        "variant `stock`",
        _stock,
    ),
    Deviation(
        "liggghts",
        "variant `stock`: contacts between particles",
        "Contacts between particles are LIGGGHTS's own: the shear force is the shear displacement times the present "
        "stiffness, eq. 3 is left out, the slip limit includes the dashpot's force, and at e_n < 1 a viscous Hertz "
        "dashpot has e_n as its restitution.",
        "variant `stock`",
        _stock,
    ),
)


def sentences(scenario: Scenario, code: str) -> list[str]:
    """What `code` does otherwise in this scenario, one sentence each."""
    return [d.sentence(scenario) for d in DEVIATIONS if d.code == code and d.applies(scenario)]
