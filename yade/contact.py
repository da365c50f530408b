"""The contact laws of the paper in stock YADE: materials, functors, and what YADE does otherwise."""

from __future__ import annotations

import math

from yade.wrapper import (Bo1_Box_Aabb, Bo1_Sphere_Aabb, Bo1_Wall_Aabb, FrictMat, Ig2_Box_Sphere_ScGeom,
                          Ig2_Sphere_Sphere_ScGeom, Ig2_Wall_Sphere_ScGeom, InsertionSortCollider, InteractionLoop,
                          Ip2_FrictMat_FrictMat_FrictPhys, Law2_ScGeom_FrictPhys_CundallStrack, MatchMaker, Omega)

O = Omega()
VERLET_DISTANCE = 0.0004
"""By how much the collider enlarges the spheres, m; 0.2-0.5 mm is fastest."""


class ContactLaw:
    """Contact law `model` (linear | hysteretic) with the parameters of `scenario`."""

    def __init__(self, scenario, model: str):
        self.scenario, self.model = scenario, model
        density = scenario["clump.density"]
        self.particle = O.materials.append(FrictMat(density=density, label="particle"))
        self.wall = O.materials.append(FrictMat(density=density, label="wall"))
        self.shells, self.wall_mask = (("particle", 1),), 1
        self._linear = Ip2_FrictMat_FrictMat_FrictPhys()
        self.set_stiffness(1.0)
        self.set_friction(scenario["contact.particle_particle.friction"], scenario["contact.particle_wall.friction"])

    def _pairs(self, particle: float, wall: float) -> MatchMaker:
        return MatchMaker(matches=((self.particle, self.particle, particle), (self.particle, self.wall, wall)))

    def set_stiffness(self, fraction: float) -> None:
        """Use this fraction of the contact stiffnesses from now on, in old and new contacts."""
        pp, pw = ([self.scenario[f"contact.{pair}.{way}_stiffness"] * fraction for way in ("normal", "shear")]
                  for pair in ("particle_particle", "particle_wall"))
        self._linear.kn, self._linear.ks = self._pairs(pp[0], pw[0]), self._pairs(pp[1], pw[1])
        for i in O.interactions:
            if i.isReal:
                i.phys.kn, i.phys.ks = pw if self._is_wall(i) else pp

    def set_friction(self, particle: float, wall: float) -> None:
        """Use these coefficients of friction from now on, in old and new contacts."""
        self._linear.frictAngle = self._pairs(math.atan(particle), math.atan(wall))
        for i in O.interactions:
            if i.isReal:
                i.phys.tangensOfFrictionAngle = wall if self._is_wall(i) else particle

    def _is_wall(self, interaction) -> bool:
        return O.bodies[interaction.id1].material.id == self.wall

    def engines(self) -> list:
        """Collider and contact loop."""
        return [
            InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb(), Bo1_Wall_Aabb()], verletDist=VERLET_DISTANCE,
                                  label="collider"),
            # The relative velocity is that of the contact point, as in the paper and in LIGGGHTS.
            InteractionLoop([Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=False), Ig2_Box_Sphere_ScGeom(),
                             Ig2_Wall_Sphere_ScGeom(noRatch=False)],
                            [self._linear], [Law2_ScGeom_FrictPhys_CundallStrack()], label="contacts"),
        ]


def deviations(scenario) -> list[str]:
    """Where YADE's laws differ from the paper's, one sentence each."""
    return ["YADE has no eq. 3: in the step in which a contact closes the whole shear increment counts."]
