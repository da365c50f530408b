"""The common bed file: a row per clump, its id, centre and orientation (file_columns.BED); plain or gzipped.

Every reader of beds in Python goes through `read`. The quaternion's length may differ from 1 by QUATERNION_TOLERANCE,
which files of nine digits keep; readers normalise it. What a bed must be to fit a box is checked by who gives it one.
"""

from __future__ import annotations

import gzip
import math
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from analysis import files
from analysis.formats.errors import InputError, reason
from analysis.formats.file_columns import BED, header

QUATERNION_TOLERANCE = 1e-6
MOST_CLUMPS = 1_000_000
LARGEST_BYTES = 500_000_000
LARGEST_ID = 2**31 - 1
LARGEST_COORDINATE_M = 100.0
GZIP = b"\x1f\x8b"


class Pose(NamedTuple):
    """A clump: centre in m, unit quaternion w, x, y, z that turns the body's frame into space, line of the file."""

    id: int
    x_m: float
    y_m: float
    z_m: float
    qw: float
    qx: float
    qy: float
    qz: float
    line: int

    @property
    def row(self) -> tuple[float, ...]:
        """The values of file_columns.BED."""
        return self[:-1]


def read(path: Path) -> list[Pose]:
    """The clumps of a bed file in the order of its lines.

    Raises InputError, naming the line, for a file that is no bed: ids must be whole numbers from 1, each once;
    positions finite; quaternions of length 1.
    """
    path = Path(path)
    poses, seen = [], {}
    for number, line in _lines(path):
        pose = _pose(path, number, line)
        if pose.id in seen:
            raise InputError(
                path.name, f"line {number}", allowed=f"gives clump {pose.id} again, as line {seen[pose.id]} does"
            )
        seen[pose.id] = number
        poses.append(pose)
    if not poses:
        raise InputError(path.name, allowed="holds no clumps; make the bed again")
    return poses


def text(path: Path) -> str:
    """The text of a bed file, unpacked; InputError where it cannot be read."""
    path = Path(path)
    try:
        if path.stat().st_size > LARGEST_BYTES:
            raise InputError(path.name, allowed=f"is larger than {LARGEST_BYTES} bytes; give a bed file")
        with open(path, "rb") as file:
            packed = file.read(2) == GZIP
        with gzip.open(path) if packed else open(path, "rb") as file:
            content = file.read(LARGEST_BYTES + 1)
        if len(content) > LARGEST_BYTES:
            raise InputError(path.name, allowed=f"is larger than {LARGEST_BYTES} bytes; give a bed file")
        return content.decode("ascii")
    except UnicodeDecodeError:
        raise InputError(path.name, allowed=f"is no text; give a CSV with the columns {','.join(BED)}") from None
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(path.name, allowed=f"cannot be read ({reason(error)}); give a bed file") from None


def write(path: Path, rows: Iterable[tuple]) -> None:
    """Write rows (values of file_columns.BED) as a bed file; numbers read back as the same doubles."""
    lines = (f"{int(row[0])}," + ",".join(repr(float(value)) for value in row[1:]) + "\n" for row in rows)
    files.write_aside(Path(path), header(BED) + "".join(lines))


def _lines(path: Path) -> list[tuple[int, str]]:
    first, *lines = text(path).splitlines() or [""]
    if first.rstrip() + "\n" != header(BED):
        raise InputError(path.name, "line 1", allowed=f"is not {header(BED).rstrip()}; give a bed file")
    if len(lines) > MOST_CLUMPS:
        raise InputError(path.name, allowed=f"holds more than {MOST_CLUMPS} clumps; give a bed of this study's size")
    return [(number, line) for number, line in enumerate(lines, start=2) if line.strip()]


def _pose(path: Path, number: int, line: str) -> Pose:
    cells = line.strip().split(",")
    try:
        values = [float(cell) for cell in cells[1:]]
        whole = cells[0].strip().isdigit() and len(cells) == len(BED) and "_" not in line
        identity = int(cells[0]) if whole and len(cells[0]) < 12 else 0
    except ValueError:
        identity, values = 0, []
    if not 1 <= identity <= LARGEST_ID or len(values) != len(BED) - 1:
        raise InputError(
            path.name,
            f"line {number}",
            allowed=f"is no clump: {','.join(BED)} with a whole id from 1 and seven numbers are needed",
        )
    for name, value in zip(BED[1:4], values[:3], strict=True):
        if not abs(value) <= LARGEST_COORDINATE_M:
            raise InputError(
                path.name, f"line {number}: {name}", value, f"a position within {LARGEST_COORDINATE_M:g} m"
            )
    length = math.hypot(*values[3:])
    if not abs(length - 1) <= QUATERNION_TOLERANCE:
        raise InputError(
            path.name,
            f"line {number}",
            allowed=f"has a quaternion of length {length:.8g}; it must be 1 within {QUATERNION_TOLERANCE:g}",
        )
    return Pose(identity, *values, number)
