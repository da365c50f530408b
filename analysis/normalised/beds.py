"""Beds: clump poses from the common bed file, and the spheres they stand for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from analysis.formats import file_columns


def read_bed(path: Path) -> pd.DataFrame:
    """The bed file as a table (columns `file_columns.BED`) in the order of the clump ids.

    Raises ValueError with one line where it is not a bed.
    """
    path = Path(path)
    try:
        bed = pd.read_csv(path)
    except (OSError, ValueError) as error:
        raise ValueError(
            f"{path.name}: cannot be read as a bed ({error}); give a CSV with {','.join(file_columns.BED)}"
        ) from None
    missing = [c for c in file_columns.BED if c not in bed]
    if missing:
        raise ValueError(f"{path.name}: column {missing[0]} is missing; a bed has {','.join(file_columns.BED)}")
    numbers = bed[list(file_columns.BED)].apply(pd.to_numeric, errors="coerce").to_numpy()
    if len(bed) == 0 or not np.isfinite(numbers).all():
        bad = (
            "no clumps"
            if len(bed) == 0
            else f"a value that is no number for clump {bed['id'][~np.isfinite(numbers).all(axis=1)].iloc[0]}"
        )
        raise ValueError(f"{path.name}: {bad}; give a bed with a finite pose for every clump")
    return bed[list(file_columns.BED)].sort_values("id", ignore_index=True)


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
