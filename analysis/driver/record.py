"""Keeps run.json (analysis.formats.run_record) up to date while a run goes on."""

from __future__ import annotations

import os
import socket
from pathlib import Path

from analysis.driver.engine import Engine
from analysis.driver.folder import STAGES
from analysis.driver.provenance import git_state, is_repeatable, now, versions
from analysis.driver.rawfiles import last_rows
from analysis.driver.settings import RunSettings
from analysis.formats.errors import InputError, reason
from analysis.formats.run_record import FILE, RunRecord, Timing
from analysis.scenarios import deviations


class Record:
    """run.json of a run that goes on: begun from what earlier starts left, written again at every change."""

    def __init__(self, settings: RunSettings, engine: Engine):
        self.settings, self.folder, version = settings, settings.folder, engine.version()
        old, scenario = stored_record(self.folder), settings.scenario
        parallel = engine.parallel(settings.ranks)
        git = git_state(beside=("reference_data", "docs"))  # a run reads neither
        self._part = {**parallel, "engine": version, **git, "host": socket.gethostname()}
        steps = {stage: int(row["step"]) for stage, row in last_rows(self.folder / "raw" / "state.csv").items()}
        self.body = RunRecord(
            scenario=scenario.name,
            variant="+".join(scenario.variants),
            profile=scenario.profile,
            code=settings.code,
            scenario_hash=scenario.hash,
            title=scenario.title,
            versions=versions(version),
            command=settings.command_line(),
            seed=settings.seed,
            bed=settings.bed_name,
            **git,
            **parallel,
            state="running",
            reason="",
            stage=old.stage if old else "packing",
            steps=steps,
            clumps=old.clumps if old else None,
            deviations=[],
            resumes=old.resumes if old else [],
            parts=_parts(old),
            timing=_timing(old.timing if old else None),
        )
        self.save()

    def save(self, **changes) -> None:
        """Write run.json with some entries changed; `end` belongs to its timing."""
        self.body.timing.heartbeat = now()
        if "end" in changes:
            self.body.timing.end = changes.pop("end")
        for name, value in changes.items():
            setattr(self.body, name, value)
        self.body.repeatable = is_repeatable(self.body.parts)
        many = max((part["ranks"] * part["threads"] for part in self.body.parts), default=1)
        self.body.deviations = deviations.sentences(self.settings.scenario, self.settings.code)
        if many > 1:
            self.body.deviations.append(f"{many} ranks or threads: repeated runs differ in their last digits.")
        self.body.write(self.folder)

    def begin_part(self, stage: str, cycle: int = 0, block: int = 0) -> None:
        """Note that this program goes on from here: what came after this place was dropped, and its parts with it."""
        here = (STAGES.index(stage), cycle, block)
        kept = [p for p in self.body.parts if (STAGES.index(p["stage"]), p["cycle"], p["block"]) < here]
        self.body.parts = [*kept, {"stage": stage, "cycle": cycle, "block": block, **self._part}]


def _timing(old: Timing | None) -> Timing:
    """Timing of this start, which adds to what earlier ones took."""
    return Timing(
        start=old.start if old else now(),
        steps_per_second=old.steps_per_second if old else {},
        wall_s=old.wall_s if old else {},
        cpu_s=old.cpu_s if old else {},
        cpu_steps=old.cpu_steps if old else {},
        pid=os.getpid(),
        host=socket.gethostname(),
        heartbeat=now(),
    )


def _parts(old: RunRecord | None) -> list[dict]:
    """The parts of an earlier start; of a run that knows none, one that stands for all that was done."""
    if old is None or old.parts or not old.steps:
        return old.parts if old else []
    git = {"git_commit": old.git_commit, "git_dirty": old.git_dirty}
    where = {"stage": "packing", "cycle": 0, "block": 0, "ranks": old.ranks, "threads": old.threads}
    return [where | {"engine": old.versions.get("engine", "unknown"), **git, "host": old.timing.host}]


def stored_record(folder: Path) -> RunRecord | None:
    """run.json of a run, None without one; InputError, naming the folder, where it is damaged."""
    try:
        return RunRecord.read(folder)
    except FileNotFoundError:
        return None
    except InputError as error:
        raise InputError(f"{folder}/{error}") from None
    except OSError as error:
        raise InputError(
            f"{folder}/{FILE}", allowed=f"cannot be read ({reason(error)}); mend it or move it away"
        ) from None
