"""A run's folder without a run: run.json, scenario.json and cycles.csv, for what only looks at these."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from analysis.driver import provenance
from analysis.formats.file_columns import CYCLES, header
from analysis.formats.run_record import RunRecord, Timing
from analysis.scenarios.scenario import Scenario


def bare_record(scenario: Scenario, code: str, speed: float = 0.0, **changes) -> RunRecord:
    """run.json of a finished run; `speed` in steps per second of the cyclic stage, `changes` to the record."""
    now = provenance.now()
    record = RunRecord(
        scenario=scenario.name,
        variant="+".join(scenario.variants),
        profile=scenario.profile,
        code=code,
        scenario_hash=scenario.hash,
        title=scenario.title,
        versions={"engine": "fake 1"},
        command="make run",
        seed=1,
        bed="own",
        git_commit="0" * 40,
        git_dirty=False,
        ranks=1,
        threads=1,
        state="finished",
        reason="",
        stage="cyclic",
        steps={},
        clumps=380,
        deviations=[],
        resumes=[],
        timing=Timing(start=now, steps_per_second={"cyclic": speed}, pid=1, host="here", heartbeat=now),
    )
    return dataclasses.replace(record, **changes)


def write_run(folder: Path, scenario: Scenario, code: str, rows: list[dict], **changes) -> Path:
    """Write the folder of a run with these rows of cycles.csv (columns that a row lacks are 0) and such a record."""
    folder.mkdir(parents=True)
    bare_record(scenario, code, **changes).write(folder)
    (folder / "scenario.json").write_text(scenario.to_json())
    lines = [",".join(str(row.get(name, 0.0)) for name in CYCLES) + "\n" for row in rows]
    (folder / "cycles.csv").write_text(header(CYCLES) + "".join(lines))
    return folder
