"""Runs as tidy data frames, whatever state their files are in.

A damaged file costs what is damaged and one clear line per kind of damage; everything else stays usable. Nothing is
guessed: a value that cannot be physics, or cannot be read, is nan; a row that cannot be placed is dropped.
"""

from __future__ import annotations

import bisect
import csv
import io
import json
import os
import sys
from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from analysis.formats import file_columns
from analysis.formats.quantities import QUANTITIES
from analysis.normalised import beds, microstructure, stages
from analysis.scenarios.scenario import Scenario, ScenarioError, join_id, load_scenario, split_id, split_variants
from analysis.scenarios.schema import KEYS

IDENTITY = ("profile", "scenario", "code", "seed")
CALIBRATION = "calibration"
"""Folder of the beds that `make calibrate` tries."""

_INFO_TYPES = {
    "scenario": str,
    "variant": str,
    "profile": str,
    "code": str,
    "scenario_hash": str,
    "title": str,
    "versions": dict,
    "command": str,
    "seed": int,
    "bed": str,
    "git_commit": str,
    "git_dirty": (bool, type(None)),
    "host": str,
    "ranks": int,
    "threads": int,
    "start": str,
    "end": (str, type(None)),
    "state": str,
    "reason": str,
    "stage": str,
    "steps": (int, dict),
    "steps_per_second": dict,
    "clumps": (int, type(None)),
    "deviations": list,
    "resumes": list,
    "heartbeat": (str, type(None)),
    "pid": (int, type(None)),
}


def load_runs(
    results_dir="results",
    profile: str | None = None,
    scenario: str | None = None,
    code: str | None = None,
    quiet: bool = False,
) -> Runs:
    """All runs below `results_dir` (also reference_data/runs), optionally of one profile, scenario or code.

    Every problem of a file is one line, kept in `problems` and printed to stderr unless `quiet`.

    >>> from analysis import load_runs
    >>> runs = load_runs("results", profile="demo")
    >>> runs
    <2 runs: demo/linear-mu0.8/liggghts, demo/linear-mu0.8/yade>
    >>> table = runs.cycles                          # all runs below each other, units in the names
    >>> last = table.groupby(["scenario", "code"])[["settlement_m", "lateral_3_m"]].last()
    >>> print((1000 * last).round(2))                # in mm
                           settlement_m  lateral_3_m
    scenario     code
    linear-mu0.8 liggghts          5.46          5.0
                 yade              5.59          5.0
    >>> run = runs[0]
    >>> run.code, run.info["state"], run.scenario["contact.particle_particle.friction"], run.problems
    ('liggghts', 'finished', 0.8, [])
    >>> run.history[["cycle", "sleeper_stress_Pa"]].max().tolist()
    [20.0, 460000.0]
    """
    found, others = [], set()
    for folder in _run_folders(Path(results_dir)):
        run = Run(folder, Path(results_dir), quiet)
        others.add((run.profile, run.scenario_name, run.code))
        if profile in (None, run.profile) and scenario in (None, run.scenario_name) and code in (None, run.code):
            run.read()
            found.append(run)
    if others and not found and not quiet:
        there = "; ".join(" ".join(names) for names in sorted(others))
        print(
            f"load_runs: no run of that profile, scenario and code below {results_dir}; there are: {there}",
            file=sys.stderr,
        )
    return Runs(found)


def _run_folders(results_dir: Path) -> list[Path]:
    """Folders that hold a run.json or a cycles.csv, in the order of their paths; raw output is not searched, nor are
    the beds that `make calibrate` tries, which have the scenario's name but not its parameters.
    """
    found = []
    for folder, below, files in os.walk(results_dir):
        if {"run.json", "cycles.csv"} & set(files):
            found.append(Path(folder))
            below[:] = []
        below[:] = sorted(name for name in below if name != CALIBRATION and not name.startswith("."))
    return sorted(found)


class Run:
    """One run: `.cycles`, `.history`, `.microstructure` (data frames), `.info` (run.json), `.scenario`, `.problems`.

    Frames always have all columns of `analysis.formats.file_columns`; what a file lacks is nan.
    """

    def __init__(self, folder: Path, results_dir: Path | None = None, quiet: bool = False):
        self.folder, self.problems, self._quiet = Path(folder), [], quiet
        self.id = str(Path(os.path.relpath(self.folder, results_dir or self.folder.parents[2]))).replace(os.sep, "/")
        self.info = self._read_info()
        parts = (["", "", ""] + self.id.split("/"))[-3:]
        name, _, seed = parts[2].partition("-seed")
        self.profile: str = self.info.get("profile") or parts[0]
        self.scenario_name: str = join_id(
            self.info.get("scenario") or parts[1], split_variants(self.info.get("variant", ""))
        )
        self.code: str = self.info["code"] if self.info.get("code") in file_columns.CODES else name
        self.seed: int = self.info.get("seed", int(seed) if seed.isdigit() else 1)

    @property
    def base_name(self) -> str:
        """The scenario without its variants; `scenario_name` is both: nonlinear-en1.0+same-bed+servo."""
        return split_id(self.scenario_name)[0]

    @property
    def variants(self) -> tuple[str, ...]:
        """Variants that are laid over the scenario, in the order of the alphabet."""
        return split_id(self.scenario_name)[1]

    def __repr__(self) -> str:
        return f"<Run {self.id}: {self.info.get('state', 'state unknown')}, {len(self.cycles)} cycles>"

    @property
    def identity(self) -> dict[str, str | int]:
        """Profile, scenario, code and seed, as in the first columns of the tidy frames."""
        return dict(zip(IDENTITY, (self.profile, self.scenario_name, self.code, self.seed), strict=True))

    def read(self) -> None:
        """Read what is small now, so that its problems are known at once."""
        _ = self.scenario, self.cycles, self.microstructure, self.stages

    @cached_property
    def cycles(self) -> pd.DataFrame:
        """One row per finished cycle, see `analysis.normalised.file_columns.CYCLES`."""
        return self._table("cycles.csv", file_columns.CYCLES, whole=True)

    @cached_property
    def history(self) -> pd.DataFrame:
        """At least 40 rows per cycle, see `analysis.normalised.file_columns.HISTORY`; `cycle` is fractional."""
        return self._table("history.csv", file_columns.HISTORY, whole=False)

    @cached_property
    def microstructure(self) -> pd.DataFrame:
        """One row per cycle, row 0 before loading, see `analysis.normalised.file_columns.MICROSTRUCTURE`."""
        return self._table("microstructure.csv", file_columns.MICROSTRUCTURE, whole=True)

    @cached_property
    def stages(self) -> stages.Stages:
        """The bed after packing and after preload, see `analysis.normalised.stages`; {} without stages.json."""
        return stages.read_stages(self.folder, lambda what: self._problem(stages.FILE, what))

    @cached_property
    def scenario(self) -> Scenario | None:
        """The parameters: those kept with the run, else today's scenario file; None where neither can be read."""
        path = self.folder / "scenario.json"
        if path.exists():
            try:
                return self._completed(_checked(Scenario.from_json(path.read_text(encoding="utf-8"))))
            except (ValueError, KeyError, TypeError, AttributeError, RecursionError, OSError) as error:
                self._problem("scenario.json", f"is damaged ({_one_line(error)}); the scenario file is used instead")
        try:
            scenario = load_scenario(self.scenario_name, self.profile)
        except ScenarioError as error:
            self._problem("scenario.json", f"is of no use, and {_one_line(error)}")
            return None
        known = self.info.get("scenario_hash")
        if known and scenario.hash != known:
            self._problem(
                "run.json",
                f"scenario_hash {known} is not that of today's scenario file: its parameters may differ from the run's",
            )
        return scenario

    def _completed(self, scenario: Scenario) -> Scenario:
        """Parameters that are newer than the run come from today's scenario file."""
        newer = [key for key, known in KEYS.items() if known.since and key not in scenario.parameters]
        if newer:
            today = load_scenario(self.scenario_name, self.profile)
            scenario.parameters.update({key: today.parameters[key] for key in newer})
            self._problem("scenario.json", f"is older than {', '.join(newer)}: taken from today's scenario file")
        return scenario

    def bed(self, label: str = "before") -> pd.DataFrame | None:
        """The bed "before" or "after" loading, or of a kept cycle (a number); None where it is not there."""
        name = f"bed_{label}.csv" if label in ("before", "after") else f"raw/bed_cycle_{int(label):06d}.csv"
        return self._optional(name, beds.read_bed)

    def contacts(self, label) -> pd.DataFrame | None:
        """Contacts of the "packed" or "preloaded" bed or of a kept cycle (a number); None where they are not there."""
        name = f"contacts_{label}" if label in ("packed", "preloaded") else f"contacts_cycle_{int(label):06d}"
        return self._optional(f"raw/{name}.csv", microstructure.read_contacts)

    def last_error(self) -> str | None:
        """Last line that starts with ERROR in the logs of the run, of whatever encoding; None without."""
        found = None
        for stage in ("packing", "preload", "cyclic"):
            try:
                text = (self.folder / "log" / f"{stage}.log").read_bytes().decode("utf-8", "replace")
            except OSError:
                continue
            lines = [line.strip() for line in text.splitlines() if line.startswith("ERROR")]
            found = lines[-1] if lines else found
        return found

    # ------------------------------------------------------------------ files

    def _problem(self, name: str, what: str) -> None:
        line = f"{self.id}/{name}: {what}"
        if line not in self.problems:
            self.problems.append(line)
            if not self._quiet:
                print(f"warning: {line}", file=sys.stderr)

    def _read_info(self) -> dict:
        path = self.folder / "run.json"
        try:
            info = json.loads(path.read_bytes().decode("utf-8"))
        except FileNotFoundError:
            self._problem("run.json", "is missing; what the run was is taken from the folder's name")
            return {}
        except (OSError, ValueError, RecursionError) as error:
            self._problem(
                "run.json", f"is damaged ({_one_line(error)}); what the run was is taken from the folder's name"
            )
            return {}
        if not isinstance(info, dict):
            self._problem("run.json", "is no table; what the run was is taken from the folder's name")
            return {}
        if isinstance(info.get("timing"), dict):  # kept apart in the file, because it differs between equal runs
            info = info.pop("timing") | info
        wrong = [
            key
            for key, kind in _INFO_TYPES.items()
            if key in info and (not isinstance(info[key], kind) or (kind is int and isinstance(info[key], bool)))
        ]
        if wrong:
            self._problem("run.json", f"{', '.join(wrong)} of the wrong type: not used")
        return {key: value for key, value in info.items() if key not in wrong}

    def _table(self, name: str, columns: Sequence[str], whole: bool) -> pd.DataFrame:
        path = self.folder / name
        if not path.exists() and (self.info.get("stage") in ("packing", "preload") or name == "history.csv"):
            return empty_table(columns)
        frame, problems = read_table(path, columns, whole)
        for what in problems:
            self._problem(name, what)
        return frame

    def _optional(self, name: str, reader) -> pd.DataFrame | None:
        path = self.folder / name
        if not path.exists():
            return None
        try:
            return reader(path)
        except ValueError as error:
            self._problem(name, _one_line(error).partition(": ")[2])
            return None


class Runs(list):
    """A list of runs with tidy frames over all of them: profile, scenario, code and seed come first in every row."""

    def __init__(self, runs: Iterable[Run] = ()):
        super().__init__(runs)

    def __repr__(self) -> str:
        return f"<{len(self)} runs: {', '.join(run.id for run in self)}>" if self else "<no runs>"

    @property
    def problems(self) -> list[str]:
        """The problems of all runs, one line each."""
        return [line for run in self for line in run.problems]

    @property
    def cycles(self) -> pd.DataFrame:
        """`Run.cycles` of all runs."""
        return self._together("cycles", file_columns.CYCLES)

    @property
    def history(self) -> pd.DataFrame:
        """`Run.history` of all runs."""
        return self._together("history", file_columns.HISTORY)

    @property
    def microstructure(self) -> pd.DataFrame:
        """`Run.microstructure` of all runs."""
        return self._together("microstructure", file_columns.MICROSTRUCTURE)

    def select(self, **identity) -> Runs:
        """The runs of the given profile, scenario, code, seed."""
        return Runs(run for run in self if all(run.identity[key] == value for key, value in identity.items()))

    def _together(self, name: str, columns: Sequence[str]) -> pd.DataFrame:
        frames = [getattr(run, name).assign(**run.identity)[[*IDENTITY, *columns]] for run in self]
        frames = [frame for frame in frames if len(frame)]
        return pd.concat(frames, ignore_index=True) if frames else empty_table([*IDENTITY, *columns])


# ---------------------------------------------------------------------- tables


def empty_table(columns: Sequence[str]) -> pd.DataFrame:
    """A frame with these columns and no rows."""
    return pd.DataFrame({name: pd.Series(dtype="int64" if name == "cycle" else "float64") for name in columns})


def read_table(path: Path, columns: Sequence[str], whole: bool = True) -> tuple[pd.DataFrame, list[str]]:
    """Read a CSV table with a column `cycle`; return it with exactly `columns`, and a line per kind of damage.

    whole   cycles are whole numbers (not so in the history)
    """
    problems: list[str] = []
    frame = _undamaged(path, columns)
    if frame is not None:
        frame.index += 2  # line numbers, for the messages
        return _ordered(frame, whole, problems), problems
    text = _decode(path, problems)
    lines = text.split("\n")
    if lines.pop().strip() and lines:
        problems.append("ends in mid-line: the last line is dropped")
    if not lines:
        if not problems:
            problems.append("is empty")
        return empty_table(columns), problems

    header = [name.strip().strip('"') for name in lines[0].split(",")]
    missing = [name for name in columns if name not in header]
    if "cycle" in missing:
        problems.append("has no column cycle: nothing of it is used")
        return empty_table(columns), problems
    if missing:
        problems.append(f"{_names(missing, 'column')} missing: nan")

    numbers = np.array([k for k, line in enumerate(lines) if k and line.strip()], dtype=int)
    width = np.array([lines[k].count(",") + 1 for k in numbers], dtype=int) == len(header)
    if not width.all():
        problems.append(
            f"{_count(~width, 'line')} with another number of values dropped, "
            f"the first is line {numbers[~width][0] + 1}"
        )
    numbers = numbers[width]
    if len(numbers) == 0:
        return empty_table(columns), problems
    cells = pd.read_csv(
        io.StringIO("\n".join(lines[k] for k in numbers)),
        header=None,
        dtype=str,
        keep_default_na=False,
        quoting=csv.QUOTE_NONE,
        skip_blank_lines=False,
    )
    frame = pd.DataFrame({name: _numbers(cells[header.index(name)]) if name in header else np.nan for name in columns})
    frame.index = numbers + 1  # line numbers, for the messages
    _drop_nonsense(frame, cells, header, problems)
    return _ordered(frame, whole, problems), problems


def _undamaged(path: Path, columns: Sequence[str]) -> pd.DataFrame | None:
    """The table where every value is there and plausible, else None: much faster than looking closely."""
    try:
        content = path.read_bytes()
        if not content.endswith(b"\n") or content.split(b"\n", 1)[0].decode() != ",".join(columns):
            return None
        frame = pd.read_csv(io.BytesIO(content), dtype=float)
    except (OSError, ValueError):
        return None
    if list(frame) != list(columns) or len(frame) == 0 or not isinstance(frame.index, pd.RangeIndex):
        return None
    for name in columns:
        low, high = QUANTITIES[name].low, QUANTITIES[name].high
        if not ((frame[name] >= low) & (frame[name] <= high)).all():
            return None
    return frame


def _decode(path: Path, problems: list[str]) -> str:
    try:
        content = path.read_bytes()
    except OSError as error:
        problems.append("is missing" if isinstance(error, FileNotFoundError) else f"cannot be read ({error.strerror})")
        return ""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        problems.append("is UTF-16, not UTF-8")
        text = content.decode("utf-16", "replace")
    else:
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            problems.append("is not UTF-8: read as Latin-1")
            text = content.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", " ").replace("\0", " ").replace("\x0b", " ").replace("\x0c", " ")


def _numbers(cells: pd.Series) -> np.ndarray:
    """Cells as floats; what is no number is nan."""
    return pd.to_numeric(cells.str.strip().str.replace("_", "x", regex=False), errors="coerce").to_numpy(dtype=float)


def _drop_nonsense(frame: pd.DataFrame, cells: pd.DataFrame, header: list[str], problems: list[str]) -> None:
    """Replace values outside their plausible range by nan; say so, and what was no number to begin with."""
    for name in frame:
        if name not in header:
            continue
        values = frame[name].to_numpy(copy=True)
        unread = np.isnan(values)
        if unread.any():
            texts = cells[header.index(name)][unread].str.strip()
            unread[unread] = ~(texts.eq("") | texts.str.lower().isin(["nan", "-nan"])).to_numpy()
        low, high = QUANTITIES[name].low, QUANTITIES[name].high
        with np.errstate(invalid="ignore"):
            absurd = (values < low) | (values > high)
        if unread.any():
            first = np.flatnonzero(unread)[0]
            problems.append(
                f"{_count(unread, 'value')} of {name} no number: nan, the first in line {frame.index[first]}"
            )
        if absurd.any():
            first = np.flatnonzero(absurd)[0]
            problems.append(
                f"{_count(absurd, 'value')} of {name} outside {low:g} to {high:g}: nan, the first is "
                f"{values[first]:g} in line {frame.index[first]}"
            )
            values[absurd] = np.nan
            frame[name] = values


def _ordered(frame: pd.DataFrame, whole: bool, problems: list[str]) -> pd.DataFrame:
    """Drop rows without a cycle, and those that do not rise: the longest rising sequence of cycles is kept."""
    cycle = frame["cycle"].to_numpy()
    good = np.isfinite(cycle)
    if whole:
        good[good] = cycle[good] % 1 == 0
    if not good.all():
        problems.append(
            f"{_count(~good, 'row')} without a usable cycle dropped, the first is line {frame.index[~good][0]}"
        )
        frame = frame[good]
    rising = _rising(frame["cycle"].to_numpy())
    if len(rising) < len(frame):
        out = np.setdiff1d(np.arange(len(frame)), rising)
        problems.append(
            f"{_count(out, 'row', len(out))} whose cycle does not rise dropped, the first is line {frame.index[out[0]]}"
        )
        frame = frame.iloc[rising]
    return frame.astype({"cycle": "int64"} if whole else {}).reset_index(drop=True)


def _rising(values: np.ndarray) -> np.ndarray:
    """Positions of a longest strictly rising subsequence."""
    if (np.diff(values) > 0).all():
        return np.arange(len(values))
    tails, tail_at, before = [], [], np.full(len(values), -1)
    for k, value in enumerate(values):
        place = bisect.bisect_left(tails, value)
        tails[place : place + 1], tail_at[place : place + 1] = [value], [k]
        before[k] = tail_at[place - 1] if place else -1
    chain, k = [], tail_at[-1]
    while k >= 0:
        chain.append(k)
        k = before[k]
    return np.array(chain[::-1])


def _checked(scenario: Scenario) -> Scenario:
    for key, known in KEYS.items():
        if key in scenario.parameters and not known.accepts(scenario[key]):
            raise ValueError(f"{key} = {scenario[key]!r} is not {known.allowed()}")
    return scenario


def _count(flags: np.ndarray, noun: str, number: int | None = None) -> str:
    number = int(np.sum(flags)) if number is None else number
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _names(names: list[str], noun: str) -> str:
    return f"{noun}{'' if len(names) == 1 else 's'} {', '.join(names)}"


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
