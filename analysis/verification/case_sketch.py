"""What a case looks like at its start, seen along y: drawn from the probe that is run, not by hand."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analysis.scenarios import derived
from analysis.verification.probes import BLOCK_M, Probe

STRAIGHT = 0.2
"""A path is drawn as a line where it is longer than this share of the radius; else only its directions are."""


@dataclass(frozen=True)
class Disc:
    """A sphere seen from the side, m. A held one does not move; a hollow one is only measured in."""

    x: float
    z: float
    radius: float
    held: bool = False
    hollow: bool = False


@dataclass(frozen=True)
class Arrow:
    """A velocity at a place (m), in shares of the largest one."""

    x: float
    z: float
    along_x: float
    along_z: float


@dataclass(frozen=True)
class Sketch:
    """Discs and arrows in the plane x-z; lengths in m."""

    discs: tuple[Disc, ...]
    arrows: tuple[Arrow, ...] = ()
    """Of unit length at most."""
    spins: tuple[tuple[float, float], ...] = ()
    """Places of bodies that spin."""
    way: tuple[tuple[float, float], ...] = ()
    """Path of the first sphere, where it is long enough to be seen."""
    floor: bool = False
    """A wall at z = 0."""
    block: tuple[float, float] | None = None
    """Half the edges of a block about the origin."""
    lid_m: float | None = None
    """Height of the loaded plate above the floor."""
    weight: bool = False
    """Gravity acts."""


def sketch_of(probe: Probe) -> Sketch:
    """The start of a probe: its bodies, their velocities or the way they are moved, and the wall."""
    discs, moving, spins = [], [], []
    for ball in probe.balls:
        discs.append(Disc(ball.position[0], ball.position[2], ball.radius, ball.held))
        moving.append((ball.position, ball.velocity))
        spins += [(ball.position[0], ball.position[2])] if any(ball.spin) else []
    for body in probe.clumps:
        clump = derived.clump(probe.scenario)
        x, z = clump.half_distance_m * _axis(body.quaternion)
        for side in (-1, 1):
            discs.append(Disc(body.position[0] + side * x, body.position[2] + side * z, clump.radius_m))
        moving.append((body.position, body.velocity))
        spins += [(body.position[0], body.position[2])] if any(body.spin) else []
    way: list[tuple[float, float]] = []
    if probe.path:
        first = probe.balls[0]
        steps = np.array([count for _, count in probe.path])
        moves = np.array([velocity for velocity, _ in probe.path])[:, [0, 2]] * steps[:, None] * probe.step
        places = np.vstack([np.zeros(2), np.cumsum(moves, axis=0)]) + (first.position[0], first.position[2])
        if np.ptp(places, axis=0).max() > STRAIGHT * first.radius:
            way = [tuple(map(float, place)) for place in places]
        else:
            moving += [(first.position, velocity) for velocity, _ in probe.path]
        spins += [(first.position[0], first.position[2])] if any(any(spin) for spin in probe.spins) else []
    return Sketch(
        tuple(discs),
        _arrows(moving),
        tuple(dict.fromkeys(spins)),
        tuple(way),
        floor=probe.wall in ("linear", "hysteretic"),
        block=(BLOCK_M[0], BLOCK_M[2]) if probe.wall == "block" else None,
        weight=probe.gravity > 0,
    )


def _axis(quaternion: tuple[float, float, float, float]) -> np.ndarray:
    """Direction of a clump's axis in x and z: z turned by the quaternion (w, x, y, z)."""
    w, x, y, z = quaternion
    return np.array([2 * (x * z + w * y), w * w - x * x - y * y + z * z])


def _arrows(moving: list) -> tuple[Arrow, ...]:
    """One arrow for each place and direction, the longest of unit length."""
    found: dict[tuple, Arrow] = {}
    largest = max((math.hypot(v[0], v[2]) for _, v in moving), default=0.0)
    for place, velocity in moving:
        speed = math.hypot(velocity[0], velocity[2])
        if speed > 1e-3 * largest:
            along = (velocity[0] / largest, velocity[2] / largest)
            key = (place, round(along[0] * largest / speed, 1), round(along[1] * largest / speed, 1))
            found.setdefault(key, Arrow(place[0], place[2], *along))
    return tuple(found.values())
