"""The box of the test apparatus: planes, sleeper, plates, the fixed wall above them and the temporary lid."""

from __future__ import annotations

from dataclasses import dataclass

from yade import utils
from yade.wrapper import Omega

O = Omega()


@dataclass(frozen=True)
class WallIds:
    """Ids of YADE's bodies. Walls are always made first and in this order, so that the ids are known after a reload."""

    sleeper: int
    plates: tuple[int, ...]

    @classmethod
    def of(cls, box) -> WallIds:
        """Ids in a simulation with the apparatus `box` (analysis.scenarios.derived.Apparatus)."""
        return cls(4, tuple(range(5, 5 + len(box.plates))))


def build(box, law) -> WallIds:
    """Make the walls of `box`: end and side planes and the floor, then sleeper, plates and fixed wall as boxes; their
    materials and collision mask are those of the contact law `law`.
    """
    utilities = {"material": "wall", "mask": law.wall_mask}
    sides = utilities | {"material": law.side_material}
    O.bodies.append(
        [
            utils.wall(box.end_m, axis=0, sense=1, **utilities | {"material": law.end_material}),
            utils.wall(0.0, axis=1, sense=1, **sides),
            utils.wall(box.width_m, axis=1, sense=-1, **sides),
            utils.wall(0.0, axis=2, sense=1, **utilities),
        ]
    )
    for block in (box.sleeper, *box.plates, box.fixed_wall):
        centre = [(low + high) / 2 for low, high in zip(block.low, block.high, strict=True)]
        half = [(high - low) / 2 for low, high in zip(block.low, block.high, strict=True)]
        O.bodies.append(utils.box(centre, half, fixed=True, **utilities))
    for body in O.bodies:
        body.state.mass = 0.0  # the dashpot of a wall contact knows the clump's mass only
        body.state.isDamped = False
    return WallIds.of(box)


def close_lid(box, material: str, mask: int) -> int:
    """Close the box beside the sleeper at its full height, for packing; return the id of the lid."""
    return O.bodies.append(utils.wall(box.height_m, axis=2, sense=-1, material=material, mask=mask))
