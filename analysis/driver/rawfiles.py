"""Raw CSV files that an engine is writing, or was writing when it was killed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from analysis.files import GrowingCsv, Row


def last_rows(state_file: Path) -> dict[str, Row]:
    """The last row of each stage in raw/state.csv."""
    return {row["stage"]: row for row in GrowingCsv(state_file).new_rows()}


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
            if (
                line.endswith("\n")
                and len(values) == len(columns)
                and _is(wanted, dict(zip(columns, values, strict=True)))
            ):
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
