"""How the bed is: kinetic energy, balance of forces, overlaps, sliding. One row per block, and contact files."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from yade.wrapper import Omega

from analysis.files import write_aside
from analysis.formats.file_columns import CONTACTS, RAW_STATE, header
from analysis.formats.growing_csv import append_text
from bond import is_bond

O = Omega()
LIMIT = 1 - 1e-6
"""A contact slides where its shear force is at least this share of its limit, to which YADE sets it up to rounding."""


@dataclass
class Contacts:
    """All real contacts, bonds aside, one array entry each. Body 1 is the wall of a wall contact."""

    body_1: np.ndarray
    body_2: np.ndarray
    point_m: np.ndarray
    normal: np.ndarray
    """Unit vectors from body 1 to body 2, n x 3."""
    overlap_m: np.ndarray
    normal_force_N: np.ndarray
    """On body 2, along the normal, including the dashpot where YADE keeps it."""
    shear_force_N: np.ndarray
    """Vectors, n x 3."""
    friction: np.ndarray

    @classmethod
    def now(cls) -> Contacts:
        """Read them from YADE: the forces of the last step."""
        rows = []
        for i in O.interactions:
            if i.isReal and not is_bond(i):
                geom, phys = i.geom, i.phys
                rows.append(
                    (
                        i.id1,
                        i.id2,
                        *geom.contactPoint,
                        *geom.normal,
                        geom.penetrationDepth,
                        *phys.normalForce,
                        *phys.shearForce,
                        phys.tangensOfFrictionAngle,
                    )
                )
        table = np.array(rows).reshape(-1, 16)
        ids = table[:, :2].astype(int)
        normal = table[:, 5:8]
        pressing = np.abs(np.sum(table[:, 9:12] * normal, axis=1))
        return cls(ids[:, 0], ids[:, 1], table[:, 2:5], normal, table[:, 8], pressing, table[:, 12:15], table[:, 15])

    @property
    def sliding(self) -> np.ndarray:
        """True where the shear force is at the slip limit."""
        limit = self.friction * self.normal_force_N
        return (limit > 0) & (np.linalg.norm(self.shear_force_N, axis=1) >= LIMIT * limit)


@dataclass
class StateRow:
    """One row of raw/state.csv, see the column names; at_limit_share is nan where the law has no such limit in YADE."""

    kinetic_energy_J: float
    unbalanced_ratio: float
    overlap_max_ratio: float
    overlap_mean_m: float
    contacts: int
    clumps: int
    at_limit_share: float
    sliding_share: float

    @classmethod
    def measure(cls, bed, model: str, gravity: float) -> StateRow:
        """State of the bed after the last step; `gravity` in m/s2, downward."""
        contacts = Contacts.now()
        overlap = contacts.overlap_m
        force = np.hypot(contacts.normal_force_N, np.linalg.norm(contacts.shear_force_N, axis=1))
        net = bed.contact_forces() - np.array([0.0, 0.0, bed.clump.mass_kg * gravity])
        mean_force = float(force.mean()) if len(force) else 0.0
        return cls(
            kinetic_energy_J=bed.kinetic_energy(),
            unbalanced_ratio=float(np.linalg.norm(net, axis=1).mean()) / mean_force if mean_force else float("inf"),
            overlap_max_ratio=float(overlap.max(initial=0.0)) / bed.clump.radius_m,
            overlap_mean_m=float(overlap.mean()) if len(overlap) else 0.0,
            contacts=len(overlap),
            clumps=bed.count(),
            at_limit_share=0.0 if model == "linear" else float("nan"),
            sliding_share=float(contacts.sliding.mean()) if len(overlap) else 0.0,
        )


def start_state_file(path) -> None:
    """Begin raw/state.csv with its header."""
    write_aside(path, header(RAW_STATE))


def write_state(path, row: StateRow, stage: str, step: int, time_s: float) -> None:
    """Append a row to raw/state.csv."""
    values = [stage, step, repr(time_s), *(repr(getattr(row, name)) for name in RAW_STATE[3:])]
    append_text(path, ",".join(map(str, values)) + "\n", sync=False)


def write_contacts(bed, path) -> None:
    """Write raw/contacts_*.csv. A wall is clump 0 and always second, so that the normal points out of the clump."""
    contacts = Contacts.now()
    numbers = bed.number_of_bodies()
    first, second = numbers[contacts.body_1], numbers[contacts.body_2]
    wall = first == 0
    first, second = np.where(wall, second, first), np.where(wall, 0, second)
    normal = np.where(wall[:, None], -contacts.normal, contacts.normal)
    shear, sliding = np.linalg.norm(contacts.shear_force_N, axis=1), contacts.sliding
    lines = []
    for k in range(len(first)):
        values = (*contacts.point_m[k], *normal[k], contacts.overlap_m[k], contacts.normal_force_N[k], shear[k])
        text = ",".join(repr(float(v)) for v in values)
        lines.append(f"{first[k]},{second[k]},{text},{int(sliding[k])}\n")
    write_aside(path, header(CONTACTS) + "".join(lines))
