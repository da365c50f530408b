"""The contact laws of the paper in stock YADE: materials and functors; deviations.py in analysis/scenarios lists what
YADE does otherwise.

Between particles: linear springs (with a dashpot where damping_ratio > 0), or Hertz-Mindlin for the hysteretic model.
At walls: linear springs. YADE chooses a law by the materials of the two bodies, and no pair of materials gives one law
between particles and another one, or a dashpot, at walls. Where that is asked for every sphere is therefore doubled:
one shell of the clump meets particles only, the other walls only. Collision masks keep them apart. No class is used
that YADE has only with PARTIALSAT, which Debian 13 leaves out.
"""

from __future__ import annotations

import math
import sys

try:
    from yade.wrapper import (
        Bo1_Box_Aabb,
        Bo1_Sphere_Aabb,
        Bo1_Wall_Aabb,
        CohFrictPhys,
        FrictMat,
        FrictViscoMat,
        FrictViscoPhys,
        Ig2_Box_Sphere_ScGeom,
        Ig2_Sphere_Sphere_ScGeom,
        Ig2_Sphere_Sphere_ScGeom6D,
        Ig2_Wall_Sphere_ScGeom,
        InsertionSortCollider,
        InteractionLoop,
        Ip2_FrictMat_FrictMat_FrictPhys,
        Ip2_FrictMat_FrictMat_MindlinPhys,
        Ip2_FrictMat_FrictViscoMat_FrictViscoPhys,
        Ip2_FrictViscoMat_FrictViscoMat_FrictViscoPhys,
        Law2_ScGeom_FrictPhys_CundallStrack,
        Law2_ScGeom_FrictViscoPhys_CundallStrackVisco,
        Law2_ScGeom_MindlinPhys_Mindlin,
        MatchMaker,
        MindlinPhys,
        Omega,
    )
except ImportError as error:  # a YADE that was built without them
    print(f"ERROR: yade: {error}; install Debian's package yade", flush=True)
    sys.exit(1)

import bond
from analysis.scenarios import conversions, derived

O = Omega()
VERLET_DISTANCE = 0.0004
"""By how much the collider enlarges the spheres, m; 0.2-0.5 mm is fastest."""
SAME_REACH = -1
"""targetInterv: with a reach fitted to each sphere the collider runs every other step once a checkpoint was loaded."""
MEETS_PARTICLES, MEETS_WALLS, IS_WALL = 1, 2, 4


class ContactLaw:
    """Contact law `model` (linear | hysteretic) with the parameters of `scenario`.

    shells -- (material, collision mask) of each shell of spheres that a clump needs
    wall_mask -- collision mask of walls, whose material is "wall"
    side_material, end_material -- materials of the side walls and of the end wall, others only where their friction is
    """

    def __init__(self, scenario, model: str, packing: bool = False):
        """While `packing` there are no bonds, and the contacts are the paper's."""
        self.scenario, self.model = scenario, model
        self.stock = scenario["contact.origin"] == "engine" and not packing
        self._make_particles(scenario["clump.density"])
        self._make_walls(scenario["clump.density"])
        self.bonded = not packing and derived.bond(scenario) is not None
        if self.bonded:
            O.materials.append(bond.material(scenario["clump.density"]))
            self.shells += ((bond.MATERIAL, bond.MEETS_NOTHING),)
        self.set_stiffness(1.0)
        self.set_friction(scenario["contact.particle_particle.friction"], scenario["contact.particle_wall.friction"])

    def _make_particles(self, density: float) -> None:
        """The material of particles, and the functor of contacts between them."""
        scenario, damping = self.scenario, self.scenario["contact.particle_particle.damping_ratio"]
        if self.model == "hysteretic":
            shear = scenario["contact.particle_particle.shear_modulus"]
            poisson = scenario["contact.particle_particle.poisson_ratio"]
            particle = FrictMat(young=2 * shear * (1 + poisson), poisson=poisson)
            self._between = Ip2_FrictMat_FrictMat_MindlinPhys()
            if scenario["contact.origin"] == "engine":  # stock: e_n itself, by YADE's own polynomial
                restitution = scenario["contact.particle_particle.restitution"]
                if restitution < 1:
                    # es = 1: no dashpot in shear, which YADE would otherwise add
                    self._between.en = MatchMaker(algo="val", val=restitution)
                    self._between.es = MatchMaker(algo="val", val=1.0)
            elif (share := conversions.viscous_damping_ratio(scenario)) > 0:
                # not `en`: that polynomial is off near 1 and below 0.2. betas = 0: no dashpot in shear
                self._between.betan = MatchMaker(algo="val", val=share)
                self._between.betas = MatchMaker(algo="val", val=0.0)
        elif damping > 0:
            particle = FrictViscoMat(betan=damping)
            self._between = Ip2_FrictViscoMat_FrictViscoMat_FrictViscoPhys()
        else:
            particle = FrictMat()
            self._between = Ip2_FrictMat_FrictMat_FrictPhys()
        particle.density, particle.label = density, "particle"
        self.particle = O.materials.append(particle)

    def _make_walls(self, density: float) -> None:
        """The materials of walls, the shells of a clump, and the functor of contacts at walls."""
        scenario, wall_damping = self.scenario, self.scenario["contact.particle_wall.damping_ratio"]
        self.wall = self.side = O.materials.append(FrictMat(density=density, label="wall"))
        self.side_material = "wall"
        if scenario["contact.side_friction_share"] != 1:
            self.side, self.side_material = O.materials.append(FrictMat(density=density, label="side")), "side"
        self.end, self.end_material = self.side, self.side_material
        self._end_share = derived.apparatus(scenario).end_friction_share
        if self._end_share != 1:
            self.end, self.end_material = O.materials.append(FrictMat(density=density, label="end")), "end"
        if wall_damping > 0 or self.model == "hysteretic":
            self.touching = O.materials.append(FrictViscoMat(density=density, betan=wall_damping, label="wall_side"))
            self.shells = (("particle", MEETS_PARTICLES), ("wall_side", MEETS_WALLS))
            self.wall_mask = MEETS_WALLS | IS_WALL
            self._at_walls = Ip2_FrictMat_FrictViscoMat_FrictViscoPhys()
        else:
            self.touching = self.particle
            self.shells, self.wall_mask = (("particle", MEETS_PARTICLES),), MEETS_PARTICLES
            plain = isinstance(self._between, Ip2_FrictMat_FrictMat_FrictPhys)
            self._at_walls = self._between if plain else Ip2_FrictMat_FrictMat_FrictPhys()

    @property
    def _functors(self) -> list:
        return [self._between] if self._between is self._at_walls else [self._between, self._at_walls]

    def _pairs(self, particle: float, wall: float, side: float | None = None, end: float | None = None) -> MatchMaker:
        """A value for each pair of materials that can meet; side and end walls have the other walls' by default."""
        of_walls = {self.wall: wall}
        for material, value in ((self.side, side), (self.end, end)):
            of_walls.setdefault(material, wall if value is None else value)
        matches = [(self.particle, self.particle, particle)]
        matches += [(material, self.touching, value) for material, value in of_walls.items()]
        return MatchMaker(matches=matches)

    def add_plane(self) -> None:
        """A material "plane" for a wall that meets spheres by the hysteretic law; of verification only.

        YADE counts half the sphere's radius at planes (1/R + 1/R), where eq. 9 has the whole: moduli that are larger
        by sqrt(2) make up for it.
        """
        sphere = O.materials[self.particle]
        plane = O.materials.append(
            FrictMat(
                young=sphere.young / (math.sqrt(2) - 1), poisson=sphere.poisson, density=sphere.density, label="plane"
            )
        )
        friction = math.atan(self.scenario["contact.particle_particle.friction"])
        pairs = [(self.particle, other, friction) for other in (self.particle, plane)]
        self._between.frictAngle = MatchMaker(matches=pairs)

    def set_stiffness(self, fraction: float) -> None:
        """Use this fraction of the linear contacts' stiffness from now on, in old and new contacts."""
        s = self.scenario
        (kn, ks), (wall_kn, wall_ks) = (
            [s[f"contact.{pair}.{way}_stiffness"] * fraction for way in ("normal", "shear")]
            for pair in ("particle_particle", "particle_wall")
        )
        for functor in self._functors:
            if isinstance(functor, Ip2_FrictMat_FrictMat_MindlinPhys):
                continue
            functor.kn = self._pairs(kn, wall_kn)
            if isinstance(functor, Ip2_FrictMat_FrictMat_FrictPhys):
                functor.ks = self._pairs(ks, wall_ks)
            else:
                functor.kRatio = self._pairs(ks / kn, wall_ks / wall_kn)
        for i in O.interactions:
            if i.isReal and not isinstance(i.phys, (MindlinPhys, CohFrictPhys)):
                new = (wall_kn, wall_ks) if self._is_wall(i) else (kn, ks)
                if isinstance(i.phys, FrictViscoPhys):
                    i.phys.cn *= math.sqrt(new[0] / i.phys.kn)
                i.phys.kn, i.phys.ks = new

    def set_friction(self, particle: float, wall: float) -> None:
        """Use these coefficients of friction from now on, in old and new contacts."""
        side = wall * self.scenario["contact.side_friction_share"]
        end = side * self._end_share
        of_material = {self.end: end, self.side: side, self.wall: wall}  # one of two walls that share a material
        for functor in self._functors:
            functor.frictAngle = self._pairs(*map(math.atan, (particle, wall, side, end)))
        for i in O.interactions:
            if i.isReal and not bond.is_bond(i):
                first = O.bodies[i.id1].material.id  # YADE puts the wall first
                i.phys.tangensOfFrictionAngle = of_material.get(first, particle)

    def _is_wall(self, interaction) -> bool:
        return O.bodies[interaction.id1].material.id in (self.wall, self.side, self.end)

    def engines(self) -> list:
        """Collider and contact loop; with bonds, what watches them."""
        between, making, acting = Ig2_Sphere_Sphere_ScGeom, self._functors, []
        if self.bonded:
            between, (makes_bonds, bond_law) = Ig2_Sphere_Sphere_ScGeom6D, bond.functors()
            making, acting = [*making, makes_bonds], [bond_law]
        return [
            InsertionSortCollider(
                [Bo1_Sphere_Aabb(), Bo1_Box_Aabb(), Bo1_Wall_Aabb()],
                verletDist=VERLET_DISTANCE,
                targetInterv=SAME_REACH,
                avoidSelfInteractionMask=MEETS_WALLS,
                label="collider",
            ),
            # The relative velocity is that of the contact point, as in the paper and in LIGGGHTS; YADE's own contacts
            # avoid granular ratcheting.
            InteractionLoop(
                [
                    between(avoidGranularRatcheting=self.stock),
                    Ig2_Box_Sphere_ScGeom(),
                    Ig2_Wall_Sphere_ScGeom(noRatch=False),
                ],
                making,
                [
                    Law2_ScGeom_FrictPhys_CundallStrack(),
                    Law2_ScGeom_FrictViscoPhys_CundallStrackVisco(),
                    Law2_ScGeom_MindlinPhys_Mindlin(),
                    *acting,
                ],
                label="contacts",
            ),
            *([bond.Bonds.engine()] if self.bonded else []),
        ]
