"""Files that survive a kill: written aside, forced to the disk, then renamed.

Standard library only.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
"""The repository."""

PUBLISHED = ROOT / "reference_data" / "published"
"""What others measured: a folder per source."""
CLAIMS_FILE = ROOT / "reference_data" / "claims.toml"
"""What the paper claims."""
KEPT_RUNS = ROOT / "reference_data" / "runs"
"""What we computed: the kept runs, and the tables of calibration, time steps and benchmark."""
KEPT_VERIFICATION = ROOT / "reference_data" / "verification"
"""What we computed: the result of the verification."""


def write_aside(path: Path, content: str | bytes) -> None:
    """Write `path` whole or not at all: a .partial file first, forced to the disk, then a rename. Texts are UTF-8."""
    partial = path.with_name(path.name + ".partial")
    try:
        with open(partial, "wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)
    except OSError:
        partial.unlink(missing_ok=True)  # on a full disk, half a file is only in the way
        raise


def write_csv(path: Path, rows: Iterable[Sequence]) -> None:
    """Write rows, the header first, in the same way; makes the folder where it is missing."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_aside(path, text.getvalue())


def sync(*paths: Path) -> None:
    """Force files to the disk, so that what is renamed afterwards can be trusted after a power cut."""
    for path in paths:
        if path.exists():
            handle = os.open(path, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)
