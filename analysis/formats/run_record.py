"""run.json: what a run is and how far it got. Everything that differs between two equal runs is under `timing`."""

from __future__ import annotations

import dataclasses
import json
import types
import typing
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from analysis.files import write_aside
from analysis.formats import json_file
from analysis.formats.errors import InputError
from analysis.formats.quantities import CODES

FILE = "run.json"
STATES = ("running", "finished", "interrupted", "failed")
STAGES = ("packing", "preload", "cyclic")
REMEDY = "restore the file, or move the run away and run it again"
DIVERGED = "diverged: "
"""How the reason of a run that left the physical begins."""


@dataclass(kw_only=True)
class Timing:
    """What differs between equal runs: times (ISO 8601, UTC), speeds in steps/s and wall time in s by stage.

    cpu_s, cpu_steps   processor time of the engine in s, and the steps that it made in that time, by stage; of those
                       parts of a run at whose end the driver was there
    """

    start: str
    end: str | None = None
    steps_per_second: dict[str, float] = field(default_factory=dict)
    wall_s: dict[str, float] = field(default_factory=dict)
    cpu_s: dict[str, float] = field(default_factory=dict)
    cpu_steps: dict[str, int] = field(default_factory=dict)
    pid: int
    host: str
    heartbeat: str

    def add_cpu(self, stage: str, seconds: float, steps: int) -> None:
        """Count a part of `stage` that has ended."""
        if steps > 0 and seconds > 0:
            self.cpu_s[stage] = round(self.cpu_s.get(stage, 0.0) + seconds, 1)
            self.cpu_steps[stage] = self.cpu_steps.get(stage, 0) + steps


@dataclass(kw_only=True)
class RunRecord:
    """The content of run.json, in its order.

    scenario, variant   name in the scenario file, and the variants laid over it, joined by `+`
    bed                 where the bed comes from: `own`, or a path
    git_commit          of the repository that ran it
    steps               done, by stage
    clumps              of the latest state; None before the first
    deviations          from the paper's law, a sentence each
    resumes             where cyclic loading went on: stage, cycle, block
    parts               what did which part: stage, cycle and block where it began, ranks, threads, engine, commit, host
    repeatable          whether the same command gives the same files bit for bit: each part on one core, by one program
    more                keys of a newer version, kept as they are
    """

    scenario: str
    variant: str = ""
    profile: str
    code: str
    scenario_hash: str
    title: str
    versions: dict[str, str]
    command: str
    seed: int
    bed: str
    git_commit: str | None
    git_dirty: bool | None
    ranks: int
    threads: int
    state: str
    reason: str
    stage: str
    steps: dict[str, int]
    clumps: int | None
    deviations: list[str]
    resumes: list[dict]
    parts: list[dict] = field(default_factory=list)
    repeatable: bool | None = None
    timing: Timing
    more: dict = field(default_factory=dict)

    @classmethod
    def read(cls, folder: Path) -> RunRecord:
        """run.json of a run; FileNotFoundError without it, InputError (one line) where it cannot be used."""
        return cls.from_dict(json_file.read(Path(folder) / FILE, dict, REMEDY))

    @classmethod
    def from_dict(cls, body: dict) -> RunRecord:
        """Check a parsed run.json. InputError for a key that is missing, of another type, or impossible."""
        body = dict(body)
        timing = body.pop("timing", None)
        if not isinstance(timing, dict):
            raise InputError(FILE, "timing", timing, f"a table; {REMEDY}")
        record = _build(cls, body, "", timing=_build(Timing, dict(timing), "timing."))
        for key, allowed in (("state", STATES), ("stage", STAGES), ("code", CODES)):
            if getattr(record, key) not in allowed:
                raise InputError(FILE, key, getattr(record, key), f"one of {', '.join(allowed)}; {REMEDY}")
        for key in ("seed", "ranks", "threads"):
            if getattr(record, key) < 1:
                raise InputError(FILE, key, getattr(record, key), f"a whole number from 1; {REMEDY}")
        for key in ("start", "end", "heartbeat"):
            _check_time(key, getattr(record.timing, key))
        return record

    def to_dict(self) -> dict:
        """The content in the order of the file; what was not known yet when it was written stays out."""
        body = {f.name: getattr(self, f.name) for f in dataclasses.fields(self) if f.name not in ("more", "timing")}
        for name, unknown in (("variant", ""), ("parts", []), ("repeatable", None)):
            if body[name] == unknown:
                del body[name]
        timing = dataclasses.asdict(self.timing)
        for name in ("cpu_s", "cpu_steps"):
            if not timing[name]:
                timing.pop(name)
        return body | self.more | {"timing": timing}

    def write(self, folder: Path) -> None:
        """Replace run.json in one go."""
        write_aside(Path(folder) / FILE, json.dumps(self.to_dict(), indent=1) + "\n")


def _build(cls, body: dict, prefix: str, **given):
    """An instance of a dataclass from a table, each value checked against the type of its field."""
    hints, values = typing.get_type_hints(cls), dict(given)
    for entry in dataclasses.fields(cls):
        name = entry.name
        if name in given or name == "more":
            continue
        if name not in body:
            if entry.default is dataclasses.MISSING and entry.default_factory is dataclasses.MISSING:
                raise InputError(FILE, prefix + name, allowed=f"is missing: damaged, or of another version; {REMEDY}")
            continue
        value = body.pop(name)
        if not _fits(value, hints[name]):
            raise InputError(FILE, prefix + name, value, f"{_words(hints[name])}; {REMEDY}")
        values[name] = value
    if "more" in hints:
        values["more"] = body
    return cls(**values)


def _fits(value, hint) -> bool:
    origin, parts = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        return any(_fits(value, part) for part in parts)
    if origin is dict:
        return isinstance(value, dict) and all(_fits(v, parts[1]) for v in value.values())
    if origin is list:
        return isinstance(value, list) and all(_fits(v, parts[0]) for v in value)
    if hint in (int, float) and isinstance(value, bool):
        return False
    if hint is int:
        return isinstance(value, int) and abs(value) < 2**63
    if hint is float:
        return isinstance(value, (int, float)) and abs(value) < 1e300
    return isinstance(value, hint)


def _words(hint) -> str:
    names = {str: "a text", int: "a whole number", float: "a number", bool: "true or false", type(None): "null"}
    origin, parts = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        return " or ".join(map(_words, parts))
    if origin is dict:
        return f"a table of {_words(parts[1])} each"
    if origin is list:
        return f"a list, {_words(parts[0])} each"
    return names.get(hint, "a table")


def _check_time(key: str, value: str | None) -> None:
    if value is None:
        return
    try:
        good = datetime.fromisoformat(value).tzinfo is not None
    except ValueError:
        good = False
    if not good:
        raise InputError(FILE, f"timing.{key}", value, f"a time such as 2026-03-01T12:00:00+00:00; {REMEDY}")
