"""Parallel bonds between clumps, with YADE's stock cohesive law (CohFrictMat and its law with moments).

YADE keeps one contact for a pair of spheres. Each clump therefore gets a second shell of spheres that carry nothing but
bonds. No collision mask lets them touch anything: their contacts are the bonds, made by hand. Where a broken pair still
overlaps, YADE makes a contact of the shell's own material, whose stiffness is nothing: broken stays broken.
The law itself knows tension or shear alone; a bond that breaks by its moments too is found here, now and then.
"""

from __future__ import annotations

import json

import numpy as np
from yade import utils
from yade.wrapper import (
    CohFrictMat,
    CohFrictPhys,
    Ip2_CohFrictMat_CohFrictMat_CohFrictPhys,
    Law2_ScGeom6D_CohFrictPhys_CohesionMoment,
    Omega,
    PyRunner,
)

import __main__
from analysis import bond_law
from analysis.files import write_aside
from analysis.formats.file_columns import BONDS, header
from analysis.scenarios import derived
from analysis.scenarios.deviations import BOND_CHECK_STEPS

O = Omega()
MATERIAL, MEETS_NOTHING = "bond", 0
NO_STIFFNESS = 1e-20
"""Young's modulus of the shell, Pa: bonds get their stiffness by hand, and what YADE makes of a broken one has none."""


def material(density: float) -> CohFrictMat:
    """The material of the shell that carries bonds."""
    return CohFrictMat(density=density, young=NO_STIFFNESS, frictionAngle=0.0, momentRotationLaw=True, label=MATERIAL)


def functors() -> tuple:
    """What the contact loop needs for bonds: the functor that makes them and their law."""
    return Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(), Law2_ScGeom6D_CohFrictPhys_CohesionMoment(
        useIncrementalForm=True, neverErase=False
    )


def is_bond(interaction) -> bool:
    """True for the contacts of this module, also broken ones."""
    return isinstance(interaction.phys, CohFrictPhys)


def holds(interaction) -> bool:
    """True for a bond that is not broken."""
    return interaction.isReal and is_bond(interaction) and not interaction.phys.cohesionBroken


class Bonds:
    """All bonds of the simulation: how they are made, watched, counted and written.

    made -- how many were made
    broken -- for each broken one: clump_1, clump_2, x, y, z (m), steps since bonds were made, mode
    """

    def __init__(self, scenario, memory: str = ""):
        """No bonds yet, or those of a simulation that was just loaded, with the `memory` saved beside it."""
        self.scenario = scenario
        self.made, self.broken, self.start = 0, [], 0
        self._alive = []
        if memory:
            saved = json.loads(memory)
            self.made, self.start, self.broken = saved["made"], saved["start"], [tuple(row) for row in saved["broken"]]
            self._alive = [self._entry(i) for i in O.interactions if holds(i)]
        __main__.check_bonds = self.check  # where PyRunner looks names up

    @staticmethod
    def engine() -> PyRunner:
        """Looks for broken bonds; to stand between the contact loop and the integrator."""
        return PyRunner(command="check_bonds()", iterPeriod=BOND_CHECK_STEPS, label="bonds")

    def memory(self) -> str:
        """What must be saved beside the simulation."""
        self.check()
        return json.dumps({"made": self.made, "start": self.start, "broken": self.broken})

    def _law(self, interaction) -> bond_law.Bond:
        return derived.bond(self.scenario, interaction.geom.refR1, interaction.geom.refR2)

    def _entry(self, interaction):
        return interaction, (interaction.id1, interaction.id2), self._law(interaction)

    def make(self) -> None:
        """Bond all spheres of different clumps that touch. Each ball of a verification case is a clump of its own."""
        spheres = [b for b in O.bodies if b and b.isClumpMember and b.material.label == MATERIAL]
        centres = np.array([tuple(b.state.pos) for b in spheres]).reshape(-1, 3)
        radii = np.array([b.shape.radius for b in spheres])
        for first, second in touching(centres, radii):
            one, two = spheres[first], spheres[second]
            if one.clumpId == two.clumpId:
                continue
            self._alive.append(self._bond(*sorted((one.id, two.id))))
        self.made, self.start = len(self._alive), O.iter

    def _bond(self, first: int, second: int):
        interaction = utils.createInteraction(first, second)
        entry = self._entry(interaction)
        law, phys = entry[2], interaction.phys
        phys.kn, phys.ks = law.normal_stiffness * law.area, law.shear_stiffness * law.area
        phys.kr, phys.ktw = law.normal_stiffness * law.moment_of_inertia, law.shear_stiffness * law.polar_moment
        phys.normalAdhesion, phys.shearAdhesion = law.tensile_strength * law.area, law.shear_strength * law.area
        phys.unp = interaction.geom.penetrationDepth  # the bond is made without force
        phys.maxRollPl = phys.maxTwistPl = -1.0  # no plastic moments
        for name in ("rollingAdhesion", "twistingAdhesion"):  # since YADE 2025, where 0 lets no moment through
            if hasattr(phys, name):
                setattr(phys, name, -1.0)
        phys.tangensOfFrictionAngle = 0.0
        phys.fragile, phys.momentRotationLaw, phys.initCohesion = True, True, False
        phys.updateAttrs({"cohesionBroken": False})  # not to be assigned in YADE 2025
        return entry

    def check(self) -> None:
        """Take out the bonds that the law has broken, and break those whose stress has reached the strength."""
        alive = []
        for entry in self._alive:
            interaction, (first, second), law = entry
            if O.bodies[first] is None or O.bodies[second] is None:  # the clump was deleted
                self.made -= 1
                continue
            mode = self._broken_now(interaction, law)
            if not mode:
                alive.append(entry)
                continue
            clumps = (O.bodies[first].clumpId, O.bodies[second].clumpId)
            place = (O.bodies[first].state.pos + O.bodies[second].state.pos) / 2
            self.broken.append((*clumps, *place, O.iter - self.start, mode))
            O.interactions.erase(first, second)
        self._alive = alive

    @staticmethod
    def _broken_now(interaction, law: bond_law.Bond) -> str:
        """The mode in which a bond has broken or must break, or an empty text. The law lets go of one broken in tension
        and keeps one broken in shear with its stiffness."""
        if not holds(interaction):
            sheared = interaction.isReal and interaction.phys.kn > 0.5 * law.normal_stiffness * law.area
            return bond_law.SHEAR if sheared else bond_law.TENSION
        tensile, shear = (
            s / limit
            for s, limit in zip(stress_of(interaction, law), (law.tensile_strength, law.shear_strength), strict=True)
        )
        if max(tensile, shear) < 1:
            return ""
        return bond_law.TENSION if tensile >= shear else bond_law.SHEAR

    def count(self) -> int:
        """Number of bonds that hold."""
        return sum(holds(interaction) for interaction, _, _ in self._alive)

    def write_bonds(self, bed, path) -> None:
        """Write all bonds, those that hold first. Stresses at the end, 0 once broken."""
        self.check()
        number = dict(zip(bed.body_ids(), bed.numbers, strict=True))
        lines = []
        for interaction, (first, second), law in self._alive:
            bodies = O.bodies[first], O.bodies[second]
            place = (bodies[0].state.pos + bodies[1].state.pos) / 2
            values = ",".join(repr(float(v)) for v in stress_of(interaction, law))
            spot = ",".join(repr(float(v)) for v in place)
            lines.append(f"{number[bodies[0].clumpId]},{number[bodies[1].clumpId]},{spot},0,-1,,{values}")
        for one, two, x, y, z, step, mode in self.broken:
            lines.append(f"{number.get(one, 0)},{number.get(two, 0)},{x!r},{y!r},{z!r},1,{step},{mode},0,0")
        write_aside(path, header(BONDS) + "".join(line + "\n" for line in lines))


def stress_of(interaction, law: bond_law.Bond) -> tuple[float, float]:
    """Greatest tensile and shear stress of a bond, Pa."""
    geom, phys = interaction.geom, interaction.phys
    twist = phys.moment_twist.norm()
    state = bond_law.BondState(0.0, phys.normalForce.dot(geom.normal), phys.shearForce, twist, phys.moment_bending)
    return bond_law.stresses(law, state)


def touching(centres: np.ndarray, radii: np.ndarray) -> list[tuple[int, int]]:
    """Pairs of spheres that overlap, in ascending order. Cells as wide as the largest sphere."""
    if not len(radii):
        return []
    cells: dict[tuple, list[int]] = {}
    width = 2 * radii.max()
    keys = [tuple(key) for key in np.floor(centres / width).astype(int)]
    for n, key in enumerate(keys):
        cells.setdefault(key, []).append(n)
    around = [(a, b, c) for a in (-1, 0, 1) for b in (-1, 0, 1) for c in (-1, 0, 1)]
    found = []
    for n, (i, j, k) in enumerate(keys):
        near = [m for a, b, c in around for m in cells.get((i + a, j + b, k + c), ()) if m > n]
        for m in near:
            if np.linalg.norm(centres[n] - centres[m]) < radii[n] + radii[m]:
                found.append((n, m))
    return sorted(found)
