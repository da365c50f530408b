"""The clumps: two overlapping spheres each, rigid, with the exact mass and inertia of their union.

The common bed file gives a clump's centre and a unit quaternion that turns its own frame, with z along the line of the
two sphere centres, into space.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from yade import utils
from yade.minieigenHP import Quaternion, Vector3
from yade.wrapper import Omega

from analysis.formats import bed_file
from analysis.scenarios import derived

O = Omega()


class Bed:
    """All clumps of the simulation.

    numbers -- id of each clump in the bed files, in the order of YADE's clump bodies
    """

    def __init__(self, scenario, numbers: list[int] | None = None):
        """An empty bed, or the bed of a simulation that was just loaded, whose clumps have these `numbers`."""
        self.clump, self._space = derived.clump(scenario), derived.simulated_space(scenario)
        self._dashpot_mass = self.clump.mass_kg * scenario["contact.dashpot_mass_share"]
        self.numbers = list(numbers or [])
        self._find_bodies()

    def _find_bodies(self) -> None:
        self._bodies = [body for body in O.bodies if body and body.isClump]
        self._states = [body.state for body in self._bodies]
        self._members = [list(body.shape.members) for body in self._bodies]
        inertia = np.array([tuple(state.inertia) for state in self._states]).reshape(-1, 3)
        self._inertia = inertia

    def place(self, path: Path, shells: tuple) -> None:
        """Make clumps at the poses of a bed file.

        shells -- (material label, collision mask) of each pair of spheres that a clump gets, see contact.py
        """
        clump, placed = self.clump, []
        for pose in bed_file.read(path):
            centre, orientation = Vector3(pose.x_m, pose.y_m, pose.z_m), orientation_of(pose)
            half = orientation * Vector3(0, 0, clump.half_distance_m)
            members = [
                utils.sphere(centre + side * half, clump.radius_m, material=material, mask=mask)
                for material, mask in shells
                for side in (-1, 1)
            ]
            identity, ids = O.bodies.appendClumped(members, discretization=0)
            body = O.bodies[identity]
            # YADE counts the overlap twice: put in the exact values. The axial moment is the smallest of the three.
            rough = list(body.state.inertia)
            exact = [clump.inertia_transverse_kgm2] * 3
            exact[rough.index(min(rough))] = clump.inertia_axial_kgm2
            body.state.mass, body.state.inertia = clump.mass_kg, Vector3(*exact)
            # YADE turns the body frame to principal axes of its own choice; refOri keeps the turn back to ours.
            body.state.refOri = body.state.ori.conjugate() * orientation
            for i in ids:
                O.bodies[i].state.mass = self._dashpot_mass  # by default the whole clump's
            placed.append(pose.id)
        self.numbers += placed
        self._find_bodies()

    def remove_outside(self, box) -> int:
        """Delete the clumps whose centre is outside the box; return how many."""
        keep = []
        for body, number in zip(self._bodies, self.numbers, strict=True):
            x, y, z = body.state.pos
            if box.end_m <= x <= box.length_m and 0 <= y <= box.width_m and 0 <= z <= box.height_m:
                keep.append(number)
            else:
                O.bodies.erase(body.id, True)
        removed = len(self.numbers) - len(keep)
        self.numbers = keep
        self._find_bodies()
        return removed

    def contact_forces(self) -> np.ndarray:
        """Sum of the contact forces of the last step on each clump, N, n x 3."""
        force = O.forces.f
        return np.array([sum((force(i) for i in members), Vector3.Zero) for members in self._members]).reshape(-1, 3)

    def count(self) -> int:
        """Number of clumps; those outside of the simulated space are lost, as they are in LIGGGHTS."""
        low, high = self._space.low, (math.inf, self._space.high[1], math.inf)  # open above and behind the plates
        places = np.array([tuple(state.pos) for state in self._states]).reshape(-1, 3)
        return int(((places >= low) & (places <= high)).all(axis=1).sum())

    def kinetic_energy(self) -> float:
        """Mean over the clumps, translation and rotation, J."""
        if not self._states:
            return 0.0
        velocity = np.array([tuple(state.vel) for state in self._states])
        spin = np.array([tuple(state.ori.conjugate() * state.angVel) for state in self._states])
        energies = self.clump.mass_kg * (velocity**2).sum() + (self._inertia * spin**2).sum()
        return float(0.5 * energies / len(self._states))

    def number_of_bodies(self) -> np.ndarray:
        """Clump number of every YADE body, 0 for walls."""
        numbers = np.zeros(len(O.bodies), dtype=int)
        for number, members in zip(self.numbers, self._members, strict=True):
            numbers[members] = number
        return numbers

    def body_ids(self) -> list[int]:
        """YADE's ids of the clumps, in the order of `numbers`."""
        return [body.id for body in self._bodies]

    def write_bed(self, path: Path) -> None:
        """Write the common bed file."""
        rows = []
        for number, state in zip(self.numbers, self._states, strict=True):
            q = state.ori * state.refOri
            rows.append((number, *state.pos, q[3], q[0], q[1], q[2]))
        bed_file.write(path, rows)


def orientation_of(pose: bed_file.Pose) -> Quaternion:
    """Orientation of a clump as YADE's quaternion, of length 1."""
    return Quaternion(pose.qw, pose.qx, pose.qy, pose.qz).normalized()
