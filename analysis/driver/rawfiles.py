"""Raw CSV files that an engine is writing, or was writing when it was killed."""

from __future__ import annotations

from pathlib import Path

from analysis.formats.growing_csv import GrowingCsv, Row


def last_rows(state_file: Path) -> dict[str, Row]:
    """The last row of each stage in raw/state.csv."""
    return {row["stage"]: row for row in GrowingCsv(state_file).new_rows()}


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
