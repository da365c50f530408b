"""Normalised tables as data frames, read strictly."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from analysis.formats import table_file
from analysis.formats.quantities import QUANTITIES


def empty_table(columns: Sequence[str]) -> pd.DataFrame:
    """A frame with these columns and no rows."""
    return pd.DataFrame({name: pd.Series(dtype="int64" if name == "cycle" else "float64") for name in columns})


def read_table(path: Path, columns: Sequence[str], whole: bool | None = True) -> pd.DataFrame:
    """A CSV table, with exactly `columns`; InputError where anything of it is damaged.

    whole   the column `cycle` holds whole numbers, one after the other; False: rising ones; None: there is none
    """
    frame = _undamaged(path, columns, whole)
    if frame is None:
        frame = pd.DataFrame(table_file.read(path, columns, whole), columns=list(columns), dtype=float)
    return frame.astype({"cycle": "int64"} if whole else {})


def _undamaged(path: Path, columns: Sequence[str], whole: bool | None) -> pd.DataFrame | None:
    """The table where every value is there and plausible, else None: much faster than looking closely."""
    try:
        content = path.read_bytes()
        if not content.endswith(b"\n") or content.split(b"\n", 1)[0].decode() != ",".join(columns):
            return None
        frame = pd.read_csv(io.BytesIO(content), dtype=float)
    except (OSError, ValueError):
        return None
    if list(frame) != list(columns) or len(frame) != content.count(b"\n") - 1:
        return None
    if len(frame) == 0 or not isinstance(frame.index, pd.RangeIndex):
        return None
    for name in columns:
        low, high = QUANTITIES[name].low, QUANTITIES[name].high
        if not ((frame[name] >= low) & (frame[name] <= high)).all():
            return None
    if whole is None:
        return frame
    step = np.diff(frame["cycle"])
    in_order = (step == 1).all() and frame["cycle"].iloc[0] in (0, 1) if whole else (step > 0).all()
    return frame if in_order else None
