"""What bonded spheres should do: forces along a prescribed motion, and a chain of bonded spheres as a linear system.

The laws come from `analysis.contact_laws` and `analysis.bond_law`; all else is independent of the engines. SI units.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis import bond_law, contact_laws


@dataclass(frozen=True)
class Loads:
    """Bond and contact of two spheres after each step: force and torque on sphere 1, shape (n, 3), and the bond."""

    force: np.ndarray
    torque: np.ndarray
    bond_energy: np.ndarray
    contact_energy: np.ndarray
    """Of the normal spring alone: for contacts without friction."""
    tensile_stress: np.ndarray
    shear_stress: np.ndarray
    broken_at: int
    """Index of the step in which the bond broke, -1 where it did not."""
    mode: str


def loads_along(bond, contact, radii, places, velocities, spins, step: float) -> Loads:
    """Bond and linear contact of two spheres that are moved in a prescribed way.

    bond, contact -- bond_law.Bond, made before the first step, and oracle.Linear without dashpot
    radii -- of both spheres, m
    places -- centres before the first step and after each, shape (n + 1, 2, 3), m
    velocities, spins -- in each step, shape (n, 2, 3), m/s and rad/s
    """
    steps = len(velocities)
    force, torque = np.zeros((steps, 3)), np.zeros((steps, 3))
    bond_energy, contact_energy, stress = np.zeros(steps), np.zeros(steps), np.zeros((steps, 2))
    apart = places[:, 0] - places[:, 1]
    distances = np.linalg.norm(apart, axis=1)
    normals = apart / distances[:, None]
    overlaps = sum(radii) - distances
    state = bond_law.BondState(distances[0])
    slip_force, broken_at = np.zeros(3), -1
    for n in range(steps):
        normal, overlap = normals[n + 1], overlaps[n + 1]
        arms = [radius - overlap / 2 for radius in radii]
        first, second = spins[n]
        relative = velocities[n, 0] - velocities[n, 1]
        relative = relative - np.cross(first, arms[0] * normal) - np.cross(second, arms[1] * normal)
        mean_turn = (first + second) / 2 * step
        was_broken = bool(state.broken)
        bond_law.advance(bond, state, distances[n + 1], normal, relative * step, (first - second) * step, mean_turn)
        if state.broken and not was_broken:
            broken_at = n
        shear, normal_force = state.shear_force.copy(), state.normal_force
        if overlap > 0:
            elastic = contact.elastic(overlap)
            sliding = (relative - np.dot(relative, normal) * normal) * step
            old = bond_law.carried(slip_force, normal, mean_turn)
            slip_force = _slip_force(contact, old, sliding, overlap, overlaps[n])
            normal_force += elastic
            shear += slip_force
            contact_energy[n] = elastic * overlap / 2
        moment = state.twisting_moment * normal + state.bending_moment
        force[n] = normal_force * normal + shear
        torque[n] = np.cross(-arms[0] * normal, shear) + moment
        bond_energy[n] = bond_law.elastic_energy(bond, state)
        stress[n] = bond_law.stresses(bond, state)
    return Loads(force, torque, bond_energy, contact_energy, stress[:, 0], stress[:, 1], broken_at, state.broken)


def _slip_force(contact, old: np.ndarray, sliding: np.ndarray, overlap: float, before: float) -> np.ndarray:
    """Shear force (3) of the contact after a step: `old`, turned with the contact, and what `sliding` (m) adds; a
    contact that closes, with no overlap `before`, begins from nothing.
    """
    if before <= 0:
        old, sliding = np.zeros(3), sliding * contact_laws.closing_share(overlap, before)
    trial = contact_laws.trial_shear_force(old, contact.shear_stiffness, sliding)
    return contact_laws.slip(trial, contact_laws.shear_strength(contact.friction, contact.elastic(overlap)))


@dataclass(frozen=True)
class Chain:
    """Spheres in a row, bonded, the first held: small motions in a plane, each with deflection w and rotation.

    A bond of length L between spheres i and j sees the slide w_j - w_i - L (t_i + t_j)/2 and the bend t_j - t_i.
    """

    bond: bond_law.Bond
    length: float
    """Distance of neighbours, m."""
    mass: float
    inertia: float
    free: int
    """Number of spheres that move."""

    def stiffness(self) -> np.ndarray:
        """Matrix of w and t of each free sphere in turn, N/m, N and N m."""
        shear = self.bond.shear_stiffness * self.bond.area
        bend = self.bond.normal_stiffness * self.bond.moment_of_inertia
        total = np.zeros((2 * self.free + 2, 2 * self.free + 2))
        for i in range(self.free):
            slide = np.array([-1.0, -self.length / 2, 1.0, -self.length / 2])
            turn = np.array([0.0, -1.0, 0.0, 1.0])
            part = shear * np.outer(slide, slide) + bend * np.outer(turn, turn)
            total[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += part
        return total[2:, 2:]

    def under_weight(self, gravity: float, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Deflections (m) along gravity of all free spheres: at rest, shape (free,), and at `times` after gravity acts
        on the chain at rest, shape (len(times), free): the sum of all modes."""
        masses = np.tile([self.mass, self.inertia], self.free)
        root = np.sqrt(masses)
        squares, shapes = np.linalg.eigh(self.stiffness() / np.outer(root, root))
        load = np.tile([self.mass * gravity, 0.0], self.free)
        static = np.linalg.solve(self.stiffness(), load)
        share = shapes.T @ (root * static)
        moving = shapes @ (share[:, None] * (1 - np.cos(np.sqrt(squares)[:, None] * times)))
        return static[0::2], (moving / root[:, None])[0::2].T

    def first_frequency(self) -> float:
        """Lowest natural frequency, rad/s."""
        root = np.sqrt(np.tile([self.mass, self.inertia], self.free))
        return float(np.sqrt(np.linalg.eigvalsh(self.stiffness() / np.outer(root, root))[0]))


def beam_deflection(rigidity: float, shear_rigidity: float, length: float, load: float, tip: float) -> float:
    """Tip deflection (m) of Timoshenko's cantilever under an even load w (N/m) and a weight P at its tip (N):
    w L^4 / 8 EI + w L^2 / 2 GA + P L^3 / 3 EI + P L / GA.

    rigidity -- E I, N m2: of a bonded row, bond stiffness in bending times distance
    shear_rigidity -- G A, N: bond stiffness in shear times distance
    """
    even = load * length**4 / (8 * rigidity) + load * length**2 / (2 * shear_rigidity)
    return even + tip * length**3 / (3 * rigidity) + tip * length / shear_rigidity
