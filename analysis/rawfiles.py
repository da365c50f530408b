"""Raw CSV files that an engine is writing, or was writing when it was killed."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

Row = dict[str, str]


class Tail:
    """Reads the rows that were added to a CSV file since the last look; a line without its end is left for later."""

    def __init__(self, path: Path, skip: bool = False):
        """With `skip`, rows that exist already are passed over."""
        self.path, self.columns, self._offset = path, [], 0
        if skip:
            self.new_rows()

    def new_rows(self) -> list[Row]:
        """Complete rows added since the last call, as texts by column."""
        try:
            with open(self.path, "rb") as file:
                file.seek(self._offset)
                content = file.read()
        except FileNotFoundError:
            return []
        content = content[: content.rfind(b"\n") + 1]
        self._offset += len(content)
        lines = content.decode(errors="replace").splitlines()
        if not self.columns and lines:
            self.columns = lines.pop(0).split(",")
        return [dict(zip(self.columns, line.split(","), strict=False)) for line in lines]


def last_rows(state_file: Path) -> dict[str, Row]:
    """The last row of each stage in raw/state.csv."""
    return {row["stage"]: row for row in Tail(state_file).new_rows()}


def keep_rows(path: Path, wanted: Callable[[Row], bool]) -> None:
    """Rewrite a CSV file with its wanted rows only; torn or unreadable lines go. Does nothing without the file."""
    if not path.exists():
        return
    partial = path.with_name(path.name + ".partial")
    with open(path, errors="replace") as old, open(partial, "w") as new:
        header = old.readline()
        columns = header.rstrip("\n").split(",")
        new.write(header)
        for line in old:
            values = line.rstrip("\n").split(",")
            if line.endswith("\n") and len(values) == len(columns) and _is(wanted, dict(zip(columns, values))):
                new.write(line)
    if header.endswith("\n"):
        partial.replace(path)
    else:  # killed before the header was out: there is no row to keep
        partial.unlink()
        path.unlink()


def _is(wanted: Callable[[Row], bool], row: Row) -> bool:
    try:
        return wanted(row)
    except ValueError:  # a number that was torn
        return False


def cut_stage(raw: Path, stage: str, last_step: int | None) -> None:
    """Drop every row of `stage` in raw/ after `last_step`, or all of them where it is None or 0.

    At step 0 the engine writes the first row itself, so that one goes too.
    """
    if not last_step:
        (raw / f"{stage}.csv").unlink(missing_ok=True)
        keep_rows(raw / "state.csv", lambda row: row["stage"] != stage)
    else:
        keep_rows(raw / f"{stage}.csv", lambda row: int(row["step"]) <= last_step)
        keep_rows(raw / "state.csv", lambda row: row["stage"] != stage or int(row["step"]) <= last_step)


def sync(*paths: Path) -> None:
    """Force files to the disk, so that what is renamed afterwards can be trusted after a power cut."""
    for path in paths:
        if path.exists():
            handle = os.open(path, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)


def write_text(path: Path, text: str) -> None:
    """Write a small file aside, force it to the disk and rename it into place."""
    partial = path.with_name(path.name + ".partial")
    with open(partial, "w") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    partial.replace(path)
