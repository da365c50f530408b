"""A stock YADE script of the same test, to measure ours by: written as the manual does it, without anything of ours.

    PYTHONPATH=. yade -j1 -n -x yade/stock.py RUN_FOLDER BED STEPS        (from the top of the repository)

Takes the parameters of RUN_FOLDER/scenario.json and places the clumps of BED, a bed file, e.g. raw/bed_preloaded.csv of
the same run. Loads the sleeper for STEPS steps of the first cycle and prints steps and processor time; writes nothing.

Default collider, default clumps, servo in Python, one material for all spheres; walls follow the particles' law, Hertz
in the nonlinear model. Closer to the paper than that, and slower or faster, is what the other scripts are.
"""

import csv
import math
import sys
import time
from pathlib import Path

from yade import utils
from yade.minieigenHP import Quaternion, Vector3
from yade.wrapper import (
    Bo1_Box_Aabb,
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    ForceResetter,
    FrictMat,
    Ig2_Box_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_FrictMat_FrictMat_FrictPhys,
    Ip2_FrictMat_FrictMat_MindlinPhys,
    Law2_ScGeom_FrictPhys_CundallStrack,
    Law2_ScGeom_MindlinPhys_Mindlin,
    MatchMaker,
    NewtonIntegrator,
    Omega,
    PyRunner,
)

from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario

O = Omega()
WARM_UP = 100  # steps in which contacts form, not measured

run, bed, steps = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])
s = Scenario.from_json((run / "scenario.json").read_text())
clump, box, control = derived.clump(s), derived.apparatus(s), derived.load_control(s)
O.dt = derived.time_grid(s).step_s

# Materials and laws
linear = s["contact.model"] == "linear"
particle, wall = (s[f"contact.particle_{other}.friction"] for other in ("particle", "wall"))
shear, poisson = (s[f"contact.particle_particle.{key}"] for key in ("shear_modulus", "poisson_ratio"))
ball = O.materials.append(FrictMat(density=s["clump.density"], young=2 * shear * (1 + poisson), poisson=poisson))
plane = O.materials.append(FrictMat(density=s["clump.density"], young=2 * shear * (1 + poisson), poisson=poisson))


def by_pair(way: str) -> MatchMaker:
    """A stiffness for each pair of materials."""
    between, at_wall = (s[f"contact.particle_{other}.{way}_stiffness"] for other in ("particle", "wall"))
    return MatchMaker(matches=((ball, ball, between), (ball, plane, at_wall)))


friction = MatchMaker(matches=((ball, ball, math.atan(particle)), (ball, plane, math.atan(wall))))
if linear:
    contact = Ip2_FrictMat_FrictMat_FrictPhys(kn=by_pair("normal"), ks=by_pair("shear"), frictAngle=friction)
    law = Law2_ScGeom_FrictPhys_CundallStrack()
else:
    contact = Ip2_FrictMat_FrictMat_MindlinPhys(frictAngle=friction)
    law = Law2_ScGeom_MindlinPhys_Mindlin()

# Box, sleeper and plates
O.bodies.append(
    [
        utils.wall(box.end_m, axis=0, sense=1, material=plane),
        utils.wall(0.0, axis=1, sense=1, material=plane),
        utils.wall(box.width_m, axis=1, sense=-1, material=plane),
        utils.wall(0.0, axis=2, sense=1, material=plane),
    ]
)


def block(it) -> int:
    """A held box; its id."""
    centre = [(low + high) / 2 for low, high in zip(it.low, it.high, strict=True)]
    half = [(high - low) / 2 for low, high in zip(it.low, it.high, strict=True)]
    return O.bodies.append(utils.box(centre, half, fixed=True, material=plane))


sleeper, plates = block(box.sleeper), [block(plate) for plate in box.plates]
block(box.fixed_wall)

# Clumps
with open(bed, newline="", encoding="ascii") as file:
    for row in csv.DictReader(file):
        centre = Vector3(*(float(row[f"{axis}_m"]) for axis in "xyz"))
        turn = Quaternion(*(float(row[f"q{part}"]) for part in "wxyz"))
        half = turn * Vector3(0, 0, clump.half_distance_m)
        pair = [utils.sphere(centre + side * half, clump.radius_m, material=ball) for side in (-1, 1)]
        identity, _ = O.bodies.appendClumped(pair, discretization=0)
        state = O.bodies[identity].state
        axial = min(range(3), key=lambda axis: state.inertia[axis])
        moments = [clump.inertia_transverse_kgm2] * 3
        moments[axial] = clump.inertia_axial_kgm2
        state.mass, state.inertia = clump.mass_kg, Vector3(*moments)

# Servo: a mass with drag under the load, at every step
low, high, pressure = s["loading.stress_min"], s["loading.stress_max"], s["preload.plate_stress"]
omega, speeds = 2 * math.pi * s["loading.frequency"], {}


def servo() -> None:
    """Move sleeper and plates."""
    stress = (high + low) / 2 - (high - low) / 2 * math.cos(omega * (O.time - start))
    move(sleeper, 2, "sleeper", stress * box.sleeper_area_m2)
    for plate in plates:
        move(plate, 0, "plate", pressure * box.plate_area_m2)


def move(body: int, axis: int, kind: str, load: float) -> None:
    """One step of M dv/dt = load - contact force - c v along the load."""
    v = speeds.get(body, 0.0)
    v += O.dt * (load - O.forces.f(body)[axis] - control[f"{kind}_drag"] * v) / control[f"{kind}_mass"]
    speeds[body] = v
    velocity = [0.0, 0.0, 0.0]
    velocity[axis] = -v
    O.bodies[body].state.vel = Vector3(*velocity)


O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb(), Bo1_Wall_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
        [contact],
        [law],
    ),
    PyRunner(command="servo()", iterPeriod=1),
    NewtonIntegrator(damping=0.0, gravity=(0, 0, -s["packing.final_gravity"])),
]

start = 0.0
O.run(WARM_UP, True)
before = time.process_time()
O.run(steps, True)
spent = time.process_time() - before
print(
    f"stock {s['contact.model']}: {steps} steps, {spent:.2f} s of processor time, {steps / spent:.1f} steps per second"
)
