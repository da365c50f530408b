"""Small cases with known answers, many in one YADE process.

analysis/verification/probes.py makes them and reads what they give.

    yade/launch.sh -j1 -n -x yade/verify.py PROBES.json OUTPUT_FOLDER        (from the top of the repository)

Contacts come from contact.py and clumps from bed.py, as in a full run. Row n of OUTPUT_FOLDER/<name>.npy holds the
numbers of contacts and of bonds, and for every sphere centre, velocity (half a step earlier), spin, force and torque of
contacts and bonds after n steps;
OUTPUT_FOLDER/<name>_contacts.json the properties of the contacts at the end.
"""

import json
import sys
import traceback
from pathlib import Path

import numpy as np
from yade import utils
from yade.minieigenHP import Vector3
from yade.wrapper import ForceResetter, NewtonIntegrator, Omega, PyRunner, Wall

import __main__
from analysis.formats import bed_file
from analysis.scenarios.scenario import Parameter, Scenario
from bed import Bed
from bond import Bonds, is_bond
from contact import MEETS_PARTICLES, ContactLaw
from temporary import remove_own_folder

O = Omega()


def add_ball(ball: dict, shells: tuple) -> tuple[int, list[int]]:
    """Make a sphere; return the id of the body that moves, and those of the spheres that feel contacts."""
    spheres = [
        utils.sphere(ball["position"], ball["radius"], material=material, mask=mask) for material, mask in shells
    ]
    if len(spheres) == 1:
        body = O.bodies.append(spheres[0])
        members = [body]
    else:
        body, members = O.bodies.appendClumped(spheres, discretization=0)
    inertia = 0.4 * ball["mass"] * ball["radius"] ** 2
    for i in {body, *members}:
        O.bodies[i].state.mass, O.bodies[i].state.inertia = ball["mass"], Vector3(inertia, inertia, inertia)
    if ball["held"]:
        O.bodies[body].dynamic = False
    set_motion(body, ball["velocity"], ball["spin"])
    return body, members


def set_motion(body: int, velocity, spin) -> None:
    """Give a body its velocity and spin. YADE integrates the angular momentum of bodies that are not round."""
    state = O.bodies[body].state
    state.vel, state.angVel = Vector3(*velocity), Vector3(*spin)
    turn = state.ori.toRotationMatrix()
    own = turn.transpose() * Vector3(*spin)
    state.angMom = turn * Vector3(*(moment * speed for moment, speed in zip(state.inertia, own, strict=True)))


def add_clumps(scenario, clumps: list, shells: tuple, folder: Path) -> list[list[int]]:
    """Make clumps through a bed file, as a full run does; return the spheres of each end of each clump."""
    if not clumps:
        return []
    path = folder / "bed.csv"
    bed_file.write(path, [(n, *clump["position"], *clump["quaternion"]) for n, clump in enumerate(clumps, start=1)])
    first = len(O.bodies)  # a ball of several shells is a clump of YADE's too
    Bed(scenario).place(path, shells)
    ends = []
    bodies = [body for body in O.bodies if body.isClump and body.id >= first]
    for body, clump in zip(bodies, clumps, strict=True):
        set_motion(body.id, clump["velocity"], clump["spin"])
        members = sorted(body.shape.members)
        ends += [members[0::2], members[1::2]]
    return ends


class Recorder:
    """Keeps a row each time it is called and moves the first ball along its path."""

    def __init__(self, probe: dict, spheres: list[list[int]], driven: int | None, bonds: Bonds | None):
        self.spheres, self.rows = spheres, []
        self.driven = O.bodies[driven].state if driven is not None else None
        self.bonds = bonds
        self.velocities = [Vector3(*velocity) for velocity, steps in probe["path"] for _ in range(steps)]
        spins = probe["spins"] or [probe["balls"][0]["spin"] for _ in probe["path"]] if probe["path"] else []
        self.spins = [
            Vector3(*spin) for spin, (_, steps) in zip(spins, probe["path"], strict=True) for _ in range(steps)
        ]
        __main__.verify_step = self.step  # where PyRunner looks names up

    def step(self) -> None:
        """Stands between the contact loop and the integrator."""
        if self.bonds:
            row = [sum(i.isReal and not is_bond(i) for i in O.interactions), self.bonds.count()]
        else:
            row = [O.interactions.countReal(), 0]
        for ids in self.spheres:
            state = O.bodies[ids[0]].state
            force, torque = Vector3.Zero, Vector3.Zero
            for i in ids:
                force += O.forces.f(i)
                torque += O.forces.t(i)
            row += [*state.pos, *state.vel, *state.angVel, *force, *torque]
        self.rows.append(row)
        if self.velocities:
            now = min(O.iter, len(self.velocities) - 1)
            self.driven.vel, self.driven.angVel = self.velocities[now], self.spins[now]


def run(probe: dict, folder: Path) -> None:
    """Run one case and write its rows."""
    O.reset()
    # as it is: a case may have values that no run may have, such as friction without end
    parameters = {key: Parameter(**entry) for key, entry in probe["scenario"].items()}
    scenario = Scenario(probe["name"], "", "", parameters)
    law = ContactLaw(scenario, scenario["contact.model"])
    if probe["wall"]:
        if probe["wall"] == "block":
            wall = utils.box((0, 0, 0), probe["block"], fixed=True, material="wall", mask=law.wall_mask)
        elif probe["wall"] == "hysteretic":
            law.add_plane()
            wall = utils.wall(0.0, axis=2, sense=1, material="plane", mask=MEETS_PARTICLES)
        else:
            wall = utils.wall(0.0, axis=2, sense=1, material="wall", mask=law.wall_mask)
        O.bodies.append(wall)
        O.bodies[0].state.mass = 0.0
    balls = [add_ball(ball, law.shells) for ball in probe["balls"]]
    spheres = [members for _, members in balls] + add_clumps(scenario, probe["clumps"], law.shells, folder)
    driven = balls[0][0] if probe["path"] else None
    if driven is not None:
        O.bodies[driven].dynamic = False
    bonds = Bonds(scenario) if law.bonded else None
    recorder = Recorder(probe, spheres, driven, bonds)
    O.dt = probe["step"]
    O.engines = [
        ForceResetter(),
        *law.engines(),
        PyRunner(command="verify_step()", iterPeriod=probe["every"], initRun=True),
        NewtonIntegrator(damping=0.0, gravity=(0, 0, -probe["gravity"])),
    ]
    if bonds:
        bonds.make()
    O.run(probe["steps"] + 1, True)
    np.save(folder / f"{probe['name']}.npy", np.array(recorder.rows))
    (folder / f"{probe['name']}_contacts.json").write_text(json.dumps(contacts()))


def contacts() -> list[dict]:
    """What YADE made of the scenario's parameters in each contact of the last step: its `phys`, and a sphere's mass."""
    found = []
    for i in O.interactions:
        if i.isReal and not is_bond(i):
            wall = isinstance(O.bodies[i.id1].shape, Wall)
            values = {name: value for name, value in i.phys.dict().items() if isinstance(value, float)}
            found.append({"pair": "pw" if wall else "pp", "mass": O.bodies[i.id2].state.mass, "dt": O.dt, **values})
    return found


def main() -> None:
    """Run every case of the file; one that fails says so and does not stop the others."""
    probes, folder = json.loads(Path(sys.argv[1]).read_text()), Path(sys.argv[2])
    failed = False
    remove_own_folder()
    for probe in probes:
        try:
            run(probe, folder)
        except Exception as error:
            traceback.print_exc()
            print(f"ERROR: {probe['name']}: {type(error).__name__}: {error}", flush=True)
            failed = True
    sys.exit(1 if failed else 0)


main()
