"""Beds: clump poses from the common bed file, the spheres they stand for, and whether a bed fits an apparatus."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from analysis.formats import bed_file, file_columns
from analysis.formats.errors import InputError
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario

DEEPEST_OVERLAP = 0.5
"""Of the spheres' radius. Packed beds have 0.02, the hardest loaded 0.1; deeper is two clumps in one place."""


def read_bed(path: Path) -> pd.DataFrame:
    """The bed file as a table (columns `file_columns.BED`) in the order of the clump ids.

    Raises InputError with one line where it is not a bed.
    """
    bed = pd.DataFrame([pose.row for pose in bed_file.read(path)], columns=list(file_columns.BED))
    return bed.sort_values("id", ignore_index=True)


def check_fits(path: Path, scenario: Scenario) -> int:
    """Number of clumps of a bed file that a run of `scenario` can start from.

    Raises InputError, naming the line, for a file that is no bed, a clump whose centre is outside the box or inside the
    sleeper, and two clumps that overlap deeper than DEEPEST_OVERLAP.
    """
    poses = bed_file.read(path)
    name, box, clump = Path(path).name, derived.apparatus(scenario), derived.clump(scenario)
    where = np.array([pose[1:4] for pose in poses])
    low, high = np.array([box.end_m, 0, 0]), np.array([box.length_m, box.width_m, box.height_m])
    outside = np.flatnonzero(((where < low) | (where > high)).any(axis=1))
    if len(outside):
        raise InputError(
            name,
            f"line {poses[outside[0]].line}",
            allowed=f"lies outside the box of {' x '.join(f'{v:g}' for v in high - low)} m; "
            "take a bed of the same profile and geometry",
        )
    inside = np.flatnonzero(((where > box.sleeper.low) & (where < box.sleeper.high)).all(axis=1))
    if len(inside):
        raise InputError(
            name, f"line {poses[inside[0]].line}", allowed="lies inside the sleeper; take a bed of the same geometry"
        )
    bed = pd.DataFrame([pose.row for pose in poses], columns=list(file_columns.BED))
    pair = _deep_pair(where, sphere_centres(bed, clump.half_distance_m), (2 - DEEPEST_OVERLAP) * clump.radius_m)
    if pair:
        first, second = (poses[k].line for k in pair)
        raise InputError(
            name,
            f"line {second}",
            allowed=f"overlaps the clump of line {first} by more than {DEEPEST_OVERLAP:g} of the radius "
            f"{clump.radius_m:.4g} m; take a bed of the same clump, packed and at rest",
        )
    return len(poses)


def _deep_pair(where: np.ndarray, centres: np.ndarray, reach: float) -> tuple[int, int] | None:
    """Two clumps with spheres nearer than `reach`, m, or in one and the same place; None without."""
    _, first, inverse = np.unique(where, axis=0, return_index=True, return_inverse=True)
    again = np.flatnonzero(first[inverse.ravel()] != np.arange(len(where)))
    if len(again):
        return int(first[inverse.ravel()][again[0]]), int(again[0])
    near, found = cKDTree(centres).query(centres, k=3, distance_upper_bound=reach)  # itself, its twin, and another
    other = (found // 2 != np.arange(len(centres))[:, None] // 2) & np.isfinite(near)
    spheres = np.flatnonzero(other.any(axis=1))
    if not len(spheres):
        return None
    sphere = spheres[0]
    one, two = sorted((int(sphere // 2), int(found[sphere][other[sphere]][0] // 2)))
    return one, two


def positions(bed: pd.DataFrame) -> np.ndarray:
    """Clump centres, shape (n, 3), m."""
    return bed[["x_m", "y_m", "z_m"]].to_numpy(dtype=float)


def quaternions(bed: pd.DataFrame) -> np.ndarray:
    """Unit quaternions w, x, y, z that rotate the body frame into space, shape (n, 4)."""
    q = bed[["qw", "qx", "qy", "qz"]].to_numpy(dtype=float)
    return q / np.sqrt(np.sum(q * q, axis=1))[:, None]


def axes(bed: pd.DataFrame) -> np.ndarray:
    """Unit vectors along the clumps (the body's z axis in space), shape (n, 3)."""
    w, x, y, z = quaternions(bed).T
    return np.column_stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])


def sphere_centres(bed: pd.DataFrame, half_distance_m: float) -> np.ndarray:
    """Centres of all spheres, shape (2 n, 3), m: those of clump k are rows 2 k and 2 k + 1."""
    offsets = half_distance_m * axes(bed)
    centres = positions(bed)
    return np.stack([centres - offsets, centres + offsets], axis=1).reshape(-1, 3)
