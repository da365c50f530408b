"""The bed behind the settlement curve: contacts, rotations, displacements, fabric; one code for both engines.

Geometry comes from bed files alone (contacts are overlaps of spheres), forces from the contact files where they were
kept. Displacements and rotations are those since before loading.

Definitions
  coordination_number     contacts of a clump with others and with walls, sphere by sphere: (2 N_pp + N_pw) / N
  neighbours_mean         other clumps that a clump touches, however often
  overlap_mean_m          mean over contacts between clumps; overlap_max_ratio is the largest of all, over the sphere
                          radius
  rotation_*_rad          angle of the rotation from the first to the present orientation, 0 to pi
  bulge_volume_m3         volume swept by the plates: sum of lateral displacement x plate area
  shoulder_displacement_m mean outward displacement of clumps that began within two ball radii of the plates: the
                          bulge as the bed itself shows it, also where the plates are fixed or have lost touch
  downward_mean_m         mean downward displacement of all clumps
  downward_under_sleeper_m  the same of those that began under the sleeper
  crib_heave_m            mean upward displacement of the clumps that began beside the sleeper, above its base
  sleeper_contacts        spheres that touch the sleeper
  contact_anisotropy      sqrt(3/2 a:a) with a = 15/2 (<n n> - I/3) over contacts between clumps (Ouadfel and Rothenburg
                          2001); 0 where normals are isotropic
  force_anisotropy        the same with normals weighted by the normal force
  fabric_xx, _yy, _zz     diagonal of <n n>
  force_chain_share       share of contacts between clumps that carry more than the mean normal force (the strong
                          network of Radjai et al. 1998); force_chain_load_share is their share of the sum of forces
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from analysis.formats import file_columns
from analysis.normalised import beds
from analysis.normalised.frames import read_table
from analysis.scenarios import derived


def sphere_contacts(centres: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of overlapping spheres of different clumps, shape (n, 2), and their overlaps, m.

    Spheres 2 k and 2 k + 1 are one clump.
    """
    pairs = cKDTree(centres).query_pairs(2 * radius, output_type="ndarray")
    pairs = pairs[pairs[:, 0] // 2 != pairs[:, 1] // 2]
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]  # a fixed order, so that means are the same bit for bit
    overlap = 2 * radius - np.sqrt(np.sum((centres[pairs[:, 0]] - centres[pairs[:, 1]]) ** 2, axis=1))
    return pairs[overlap > 0], overlap[overlap > 0]


def wall_overlaps(
    centres: np.ndarray, radius: float, box: derived.Apparatus, sleeper_down_m: float, plates_out_m
) -> np.ndarray:
    """Overlaps (m) with floor, planes, sleeper, plates and fixed wall where these stand now, one entry per contact."""
    gaps = [centres[:, 2], centres[:, 0] - box.end_m, centres[:, 1], box.width_m - centres[:, 1]]
    blocks = [(box.sleeper, (0, 0, -sleeper_down_m)), (box.fixed_wall, (0, 0, 0))]
    blocks += [(plate, (out, 0, 0)) for plate, out in zip(box.plates, plates_out_m, strict=True)]
    gaps += [_distances(centres, block, moved) for block, moved in blocks]
    overlap = radius - np.concatenate(gaps)
    return overlap[overlap > 0]


def _distances(centres: np.ndarray, block: derived.Block, moved) -> np.ndarray:
    """Distances (m) of points from a block that has moved."""
    low, high = np.array(block.low) + moved, np.array(block.high) + moved
    return np.sqrt(np.sum((centres - np.clip(centres, low, high)) ** 2, axis=1))


def sleeper_contacts(centres: np.ndarray, radius: float, box: derived.Apparatus, sleeper_down_m: float) -> int:
    """Spheres that touch the sleeper where it stands now."""
    return int(np.count_nonzero(_distances(centres, box.sleeper, (0, 0, -sleeper_down_m)) < radius))


def contact_measures(
    centres: np.ndarray, radius: float, box: derived.Apparatus, sleeper_down_m=0.0, plates_out_m=(0.0,) * 5
) -> dict[str, float]:
    """Coordination number, neighbours and overlaps of a bed given by its sphere centres, shape (2 n, 3), m."""
    clumps = len(centres) // 2
    pairs, overlap = sphere_contacts(centres, radius)
    walls = wall_overlaps(centres, radius, box, sleeper_down_m, plates_out_m)
    touching = np.unique(pairs // 2 @ np.array([clumps, 1]))
    largest = max(overlap.max(initial=0.0), walls.max(initial=0.0))
    return {
        "coordination_number": (2 * len(pairs) + len(walls)) / clumps,
        "neighbours_mean": 2 * len(touching) / clumps,
        "overlap_mean_m": float(overlap.mean()) if len(overlap) else 0.0,
        "overlap_max_ratio": float(largest / radius),
    }


def rotation_angles(before: pd.DataFrame, after: pd.DataFrame) -> np.ndarray:
    """Rotation (rad, 0 to pi) of each clump between two beds of the same clumps; q and -q are the same orientation."""
    p, q = beds.quaternions(before), beds.quaternions(after)
    cosine = np.abs(np.sum(p * q, axis=1))
    # The vector part of conj(p) q: its length is the sine of half the angle, exact also for tiny rotations.
    vector = p[:, :1] * q[:, 1:] - q[:, :1] * p[:, 1:] - np.cross(p[:, 1:], q[:, 1:])
    return 2 * np.arctan2(np.sqrt(np.sum(vector**2, axis=1)), cosine)


def motion_measures(
    before: pd.DataFrame, after: pd.DataFrame, box: derived.Apparatus, ball_radius: float
) -> dict[str, float]:
    """Rotations and displacements of the clumps that are in both beds, matched by id."""
    common = np.intersect1d(before["id"], after["id"])
    first = before.set_index("id").loc[common].reset_index()
    last = after.set_index("id").loc[common].reset_index()
    angle = rotation_angles(first, last)
    start = beds.positions(first)
    moved = beds.positions(last) - start
    footprint = (
        (start[:, 1] > box.sleeper.low[1]) & (start[:, 1] < box.sleeper.high[1]) & (start[:, 0] < box.sleeper.high[0])
    )
    above = start[:, 2] > box.sleeper.low[2]
    shoulder = (start[:, 0] > box.length_m - 2 * ball_radius) & ~above
    return {
        "rotation_mean_rad": _mean(angle),
        "rotation_max_rad": float(angle.max(initial=0.0)),
        "shoulder_displacement_m": _mean(moved[shoulder, 0]),
        "downward_mean_m": _mean(-moved[:, 2]),
        "downward_under_sleeper_m": _mean(-moved[footprint & ~above, 2]),
        "crib_heave_m": _mean(moved[~footprint & above, 2]),
    }


def bulge_volume(lateral_m, box: derived.Apparatus) -> float:
    """Volume (m3) swept by the plates that moved outward by `lateral_m`."""
    return float(sum(lateral_m) * box.plate_area_m2)


def fabric(normals: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
    """Fabric tensor <n n>, shape (3, 3), trace 1, of unit normals, shape (n, 3), optionally weighted."""
    weights = np.ones(len(normals)) if weights is None else weights
    return np.einsum("n,ni,nj->ij", weights, normals, normals) / weights.sum()


def anisotropy(tensor: np.ndarray) -> float:
    """Scalar anisotropy sqrt(3/2 a:a), a = 15/2 (F - I/3), of a fabric tensor: 0 where isotropic."""
    a = 7.5 * (tensor - np.eye(3) / 3)
    return float(np.sqrt(1.5 * np.sum(a * a)))


def force_measures(contacts: pd.DataFrame) -> dict[str, float]:
    """Fabric, strong network and sliding share from a contact table (columns `file_columns.CONTACTS`)."""
    between = contacts[contacts["clump_2"] != 0]
    force = between["normal_force_N"].to_numpy(dtype=float)
    if len(force) == 0 or force.sum() <= 0:
        return {}
    normals = between[["nx", "ny", "nz"]].to_numpy(dtype=float)
    by_number, by_force = fabric(normals), fabric(normals, force)
    strong = force > force.mean()
    return {
        "normal_force_mean_N": float(force.mean()),
        "contact_anisotropy": anisotropy(by_number),
        "force_anisotropy": anisotropy(by_force),
        "fabric_xx": float(by_number[0, 0]),
        "fabric_yy": float(by_number[1, 1]),
        "fabric_zz": float(by_number[2, 2]),
        "force_chain_share": float(strong.mean()),
        "force_chain_load_share": float(force[strong].sum() / force.sum()),
    }


def sliding_share(contacts: pd.DataFrame) -> float:
    """Share of all contacts, walls included, at the slip limit; nan without contacts."""
    return _mean(contacts["sliding"].to_numpy(dtype=float))


def read_contacts(path: Path) -> pd.DataFrame:
    """A contact file as a table; InputError, one line, where it is not one."""
    return read_table(Path(path), file_columns.CONTACTS, None)


def _mean(values: np.ndarray) -> float:
    return float(np.mean(values)) if len(values) else np.nan
