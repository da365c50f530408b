"""Files that survive a kill: written aside and renamed, forced to the disk, and CSV files that are still growing.

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

Row = dict[str, str]


def write_aside(path: Path, text: str) -> None:
    """Write `path` whole or not at all: a .partial file first, forced to the disk, then a rename."""
    partial = path.with_name(path.name + ".partial")
    with open(partial, "w", encoding="utf-8", newline="\n") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(partial, path)


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


class GrowingCsv:
    """The complete rows of a CSV file that an engine is still writing: each look reads only what is new.

    A line without its newline is not there yet; a line of another length was torn by a kill and is passed over. A file
    that became shorter was replaced, and is read from the start.
    """

    def __init__(self, path: Path, columns: Sequence[str] = (), skip: bool = False):
        """`columns` are those that are kept and must be there, none means all; with `skip`, rows that exist already
        are passed over.
        """
        self.path, self.columns = Path(path), tuple(columns)
        self.forget()
        if skip:
            self.new_rows()

    def forget(self) -> None:
        """Read from the start again: after the file was cut or replaced."""
        self._offset, self._places, self._width = 0, {}, 0

    def new_rows(self) -> list[Row]:
        """Complete rows since the last look, as texts by column. Raises ValueError where a column is missing."""
        try:
            with open(self.path, "rb") as file:
                if file.seek(0, os.SEEK_END) < self._offset:
                    self.forget()
                file.seek(self._offset)
                new = file.read()
        except FileNotFoundError:
            return []
        new = new[: new.rfind(b"\n") + 1]
        self._offset += len(new)
        lines = new.decode("utf-8", "replace").splitlines()
        if not self._width and lines:
            self._read_header(lines.pop(0))
        rows = (line.split(",") for line in lines)
        return [{name: cells[k] for name, k in self._places.items()} for cells in rows if len(cells) == self._width]

    def _read_header(self, line: str) -> None:
        header = [name.strip() for name in line.split(",")]
        for name in self.columns:
            if name not in header:
                self.forget()
                needed = ",".join(self.columns)
                raise ValueError(f"{self.path.name}: column {name} is missing; the engine must write {needed}")
        self._places, self._width = {name: header.index(name) for name in self.columns or header}, len(header)


class GrowingTable(GrowingCsv):
    """The rows of such a file by `step`, of which one that was written twice (an engine that resumed) counts as last
    written.
    """

    def __init__(self, path: Path, columns: Sequence[str], stage: str | None = None):
        """`stage` keeps the rows with that text in the column `stage`."""
        self._stage = stage
        super().__init__(path, columns)

    def forget(self) -> None:
        super().forget()
        self.rows: dict[int, Row] = {}

    def update(self) -> dict[int, Row]:
        """Read what is new; all rows kept so far."""
        for row in self.new_rows():
            if row["step"].strip().isdigit() and self._stage in (None, row.get("stage")):
                self.rows[int(row["step"])] = row
        return self.rows

    def drop_until(self, step: int, but: int | None = None) -> None:
        """Free the rows up to `step`, except the row of step `but`."""
        self.rows = {key: row for key, row in self.rows.items() if key > step or key == but}
