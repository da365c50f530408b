"""Raw CSV files that an engine is writing, or was writing when it was killed."""

from __future__ import annotations

import os
from pathlib import Path

from analysis.driver.folder import STAGES
from analysis.formats.growing_csv import GrowingCsv, Row

TAIL_BYTES = 65536


def last_rows(state_file: Path) -> dict[str, Row]:
    """The last row of each stage in raw/state.csv."""
    return {row["stage"]: row for row in GrowingCsv(state_file).new_rows()}


def last_step(path: Path, stage: str | None = None) -> int:
    """Step of the last whole row of a raw file, of a `stage` where the file tells stages apart; 0 without one."""
    try:
        with open(path, "rb") as file:
            columns = file.readline().decode("utf-8", "replace").strip().split(",")
            file.seek(max(file.tell(), file.seek(0, os.SEEK_END) - TAIL_BYTES))
            lines = file.read().decode("utf-8", "replace").split("\n")[:-1]
    except FileNotFoundError:
        return 0
    for line in reversed(lines):
        row = dict(zip(columns, line.split(","), strict=False))
        if len(row) == len(columns) and row.get("step", "").isdigit() and stage in (None, row.get("stage")):
            return int(row["step"])
    return 0


def start_stage(raw: Path, stage: str) -> None:
    """Drop the rows of `stage` and of those after it from raw/state.csv."""
    before = STAGES[: STAGES.index(stage)]
    GrowingCsv(raw / "state.csv").cut(lambda row: row["stage"] in before)


def cut_stage(raw: Path, stage: str, last_step: int | None) -> None:
    """Drop every row of `stage` in raw/ after `last_step`, or all of them where it is None or 0.

    At step 0 the engine writes the first row itself, so that one goes too.
    """
    state, loading = GrowingCsv(raw / "state.csv"), GrowingCsv(raw / f"{stage}.csv")
    if not last_step:
        loading.path.unlink(missing_ok=True)
        state.cut(lambda row: row["stage"] != stage)
    else:
        loading.cut(lambda row: int(row["step"]) <= last_step)
        state.cut(lambda row: row["stage"] != stage or int(row["step"]) <= last_step)
