"""CSV files that grow while something runs, and survive being killed at any moment: append, cut, tail."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from analysis import files
from analysis.formats import numbers
from analysis.formats.errors import InputError

Row = dict[str, str]


class GrowingCsv:
    """A CSV file that one process appends to and others may read meanwhile.

    A row is there when its line is complete, newline included; `append` writes rows whole or not at all. `new_rows`
    gives the rows since the last look; `cut` removes rows, for an engine that resumes.
    """

    def __init__(self, path: Path, columns: Sequence[str] = (), cell: Callable[[float], str] = numbers.exact):
        """`columns` must be there when reading, none means all; they are the header when writing. `cell` formats."""
        self.path, self.columns, self.cell = Path(path), tuple(columns), cell
        self.forget()

    # ------------------------------------------------------------------ writing

    @property
    def header(self) -> str:
        """The first line of the file."""
        return ",".join(self.columns) + "\n"

    def start(self) -> None:
        """Make the file anew, with its header only."""
        files.write_aside(self.path, self.header)
        self.forget()

    def append(self, rows: Iterable[Sequence], sync: bool = True) -> None:
        """Add rows, values in the order of the columns, a text as it is; see them to the disk where `sync`.

        On a full disk nothing of them stays, and OSError is raised.
        """
        text = "".join(",".join(v if isinstance(v, str) else self.cell(v) for v in row) + "\n" for row in rows)
        append_text(self.path, text, sync)

    def cut(self, wanted: Callable[[Row], bool]) -> None:
        """Keep the wanted rows only; rows that are torn or cannot be read go. Nothing without the file."""
        if not self.path.exists():
            return
        with open(self.path, encoding="utf-8", errors="replace", newline="") as file:
            header, *lines = file.read().splitlines(keepends=True) or [""]
        if not header.endswith("\n"):  # killed before the header was out: there is no row to keep
            self.path.unlink()
            return
        names = header.rstrip("\n").split(",")
        files.write_aside(self.path, header + "".join(line for line in lines if _is_wanted(line, names, wanted)))
        self.forget()

    # ------------------------------------------------------------------ reading

    def forget(self) -> None:
        """Read from the start again: after the file was cut or replaced."""
        self._offset, self._places, self._width = 0, {}, 0

    def new_rows(self) -> list[Row]:
        """Complete rows since the last look, as texts by column; lines of another width were torn and are passed over.

        A file that became shorter was replaced, and is read from the start. InputError where a column is missing.
        """
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
                raise InputError(self.path.name, allowed=f"column {name} is missing; the engine must write {needed}")
        self._places, self._width = {name: header.index(name) for name in self.columns or header}, len(header)


def _is_wanted(line: str, names: list[str], wanted: Callable[[Row], bool]) -> bool:
    values = line.rstrip("\n").split(",")
    if not line.endswith("\n") or len(values) != len(names):
        return False
    try:
        return wanted(dict(zip(names, values, strict=True)))
    except ValueError:  # a number that was torn
        return False


def append_text(path: Path, text: str, sync: bool = True) -> None:
    """Add whole lines to a file: all of them or, with OSError, none. `write` may write half of a row on a full disk."""
    with open(path, "ab", buffering=0) as file:
        end, left = file.seek(0, os.SEEK_END), memoryview(text.encode())
        try:
            while left:
                left = left[file.write(left) :]
            if sync:
                os.fsync(file.fileno())
        except OSError:
            file.truncate(end)
            raise


class RowsByStep(GrowingCsv):
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
        self._untaken: list[Row] = []

    def take(self) -> list[Row]:
        """Read what is new; every row that was read since the last call, for whoever looks at each row once."""
        self.update()
        rows, self._untaken = self._untaken, []
        return rows

    def update(self) -> dict[int, Row]:
        """Read what is new; all rows kept so far."""
        for row in self.new_rows():
            self._untaken.append(row)
            if row["step"].strip().isdigit() and self._stage in (None, row.get("stage")):
                self.rows[int(row["step"])] = row
        return self.rows

    def drop_until(self, step: int, but: int | None = None) -> None:
        """Free the rows up to `step`, except the row of step `but`."""
        self.rows = {key: row for key, row in self.rows.items() if key > step or key == but}


class CycleTable(GrowingCsv):
    """A normalised table: rows of cycle n are those whose column `cycle` is above n - 1 and at most n.

    A line that a kill tore and every row after the last wanted cycle are cut off by `rewind`.
    """

    def __init__(self, path: Path, columns: Sequence[str], cell: Callable[[float], str] = numbers.exact):
        super().__init__(path, columns, cell)
        self._at = self.columns.index("cycle")

    def rewind(self, cycle: float) -> None:
        """Keep the header and the rows up to `cycle`; make the file where it is missing or its header is damaged."""
        try:
            content = self.path.read_bytes()
        except FileNotFoundError:
            content = b""
        if not content.startswith(self.header.encode()):
            self.start()
            return
        end = len(content) if content.endswith(b"\n") else content.rfind(b"\n") + 1
        while end > len(self.header):
            start = content.rfind(b"\n", 0, end - 1) + 1
            if self._is_row_until(content[start:end], cycle):
                break
            end = start
        if end < len(content):
            with open(self.path, "r+b") as file:
                file.truncate(end)

    def _is_row_until(self, line: bytes, cycle: float) -> bool:
        cells = line.rstrip(b"\n").split(b",")
        try:
            return len(cells) == len(self.columns) and float(cells[self._at]) <= cycle
        except ValueError:
            return False

    def last_cycle(self) -> int | None:
        """Cycle of the last row of a file that `rewind` has been through; None without rows."""
        last = self.path.read_bytes()[-4096:].splitlines()[-1]
        return None if last == self.header.rstrip().encode() else int(float(last.split(b",")[self._at]))
