"""Rows that an engine is still writing: each call reads only what is new."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


class GrowingCsv:
    """The complete lines of a growing CSV file, keyed by the whole number in one of its columns.

    A step that was written twice (an engine that resumed) counts as last written; a line without its newline is not
    there yet; a line of another length was torn by a kill and is passed over. `only` = (column, text) keeps the lines
    with that text in that column.
    """

    def __init__(self, path: Path, columns: Sequence[str], key: str = "step", only: tuple[str, str] | None = None):
        self.path, self.columns = Path(path), tuple(columns)
        self._key = self.columns.index(key)
        self._only = (self.columns.index(only[0]), only[1]) if only else None
        self.forget()

    def forget(self) -> None:
        """Read from the start again: after the file was cut or replaced."""
        self._offset, self._order, self.rows = 0, None, {}

    def drop_until(self, step: int, but: int | None = None) -> None:
        """Free the rows up to `step`, except the row of step `but`."""
        self.rows = {key: row for key, row in self.rows.items() if key > step or key == but}

    def update(self) -> dict[int, list[str]]:
        """Read what is new; return {step: cells in the order of `columns`} of all rows kept so far.

        Raises ValueError with one line where the header is not the expected one.
        """
        try:
            with open(self.path, "rb") as file:
                if file.seek(0, 2) < self._offset:
                    self.forget()
                file.seek(self._offset)
                new = file.read()
        except FileNotFoundError:
            return self.rows
        new = new[: new.rfind(b"\n") + 1]
        self._offset += len(new)
        lines = new.decode("utf-8", "replace").splitlines()
        if self._order is None and lines:
            header = [name.strip() for name in lines.pop(0).split(",")]
            missing = [c for c in self.columns if c not in header]
            if missing:
                self.forget()
                raise ValueError(
                    f"{self.path.name}: column {missing[0]} is missing; the engine must write " + ",".join(self.columns)
                )
            self._order, self._width = [header.index(c) for c in self.columns], len(header)
        for line in lines:
            cells = line.split(",")
            if len(cells) != self._width:
                continue
            cells = [cells[i] for i in self._order]
            if (self._only is None or cells[self._only[0]] == self._only[1]) and cells[self._key].strip().isdigit():
                self.rows[int(cells[self._key])] = cells
        return self.rows
