"""Runs as tidy data frames.

A damaged file is refused in one line, and nothing of it is used; the other files and the other runs stay usable. A run
whose run.json cannot be read is left out: what it was is not guessed.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path

import pandas as pd

from analysis.formats import file_columns, table_file
from analysis.formats.errors import InputError, one_line
from analysis.formats.run_record import RunRecord
from analysis.normalised import beds, bonds, harmonics, microstructure, plates, stages
from analysis.normalised.frames import empty_table, read_table
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, ScenarioError, join_id, load_scenario, split_id, split_variants
from analysis.scenarios.schema import KEYS

IDENTITY = ("profile", "scenario", "code", "seed")
UNLOADED = "unload.csv"
"""What springs back when a copy of a run is slowly unloaded to the least stress (`make unload`)."""
TRIALS = CALIBRATION, TIMESTEP = "calibration", "timestep"
"""Folders of results whose runs have a scenario's name but not its parameters."""


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
    found, refused, others = [], [], set()
    for folder in _run_folders(Path(results_dir)):
        try:
            run = Run(folder, Path(results_dir), quiet)
        except InputError as error:
            refused.append(f"{_id(folder, Path(results_dir))}/{error}; the run is left out")
            if not quiet:
                print(f"warning: {refused[-1]}", file=sys.stderr)
            continue
        others.add((run.profile, run.scenario_name, run.code))
        if profile in (None, run.profile) and scenario in (None, run.scenario_name) and code in (None, run.code):
            run.read()
            found.append(run)
    if others and not found and not quiet:
        _say_what_is_there(results_dir, others)
    return Runs(found, refused)


def _say_what_is_there(results_dir, others: Iterable[tuple[str, str, str]]) -> None:
    there = "; ".join(" ".join(names) for names in sorted(others))
    print(
        f"load_runs: no run of that profile, scenario and code below {results_dir}; there are: {there}",
        file=sys.stderr,
    )


def _run_folders(results_dir: Path) -> list[Path]:
    """Folders that hold a run.json or a cycles.csv, in the order of their paths; raw output is not searched, nor are
    the runs of `make calibrate` and `make timestep`, which have the scenario's name but not its parameters.
    """
    found = []
    for folder, below, files in os.walk(results_dir):
        if {"run.json", "cycles.csv"} & set(files):
            found.append(Path(folder))
            below[:] = []
        below[:] = sorted(name for name in below if name not in TRIALS and not name.startswith("."))
    return sorted(found)


class Run:
    """One run: `.cycles`, `.history`, `.microstructure` (data frames), `.info` (run.json), `.scenario`, `.problems`.

    Frames always have all columns of `analysis.formats.file_columns`; of a damaged file they have no rows.
    """

    def __init__(self, folder: Path, results_dir: Path | None = None, quiet: bool = False):
        """InputError where run.json is missing or cannot be used."""
        self.folder, self.problems, self._quiet = Path(folder), [], quiet
        self.id = _id(self.folder, results_dir or self.folder.parents[2])
        try:
            record = RunRecord.read(self.folder)
        except FileNotFoundError:
            raise InputError("run.json", allowed="is missing; copy the whole folder of the run") from None
        body = record.to_dict()
        self.info = body.pop("timing") | body
        self.profile, self.code, self.seed = record.profile, record.code, record.seed
        self.scenario_name: str = join_id(record.scenario, split_variants(record.variant))

    @property
    def base_name(self) -> str:
        """The scenario without its variants; `scenario_name` is both: nonlinear-en1.0+same-bed+servo."""
        return split_id(self.scenario_name)[0]

    @property
    def variants(self) -> tuple[str, ...]:
        """Variants that are laid over the scenario, in the order of the alphabet."""
        return split_id(self.scenario_name)[1]

    def __repr__(self) -> str:
        return f"<Run {self.id}: {self.info['state']}, {len(self.cycles)} cycles>"

    @property
    def identity(self) -> dict[str, str | int]:
        """Profile, scenario, code and seed, as in the first columns of the tidy frames."""
        return dict(zip(IDENTITY, (self.profile, self.scenario_name, self.code, self.seed), strict=True))

    def read(self) -> None:
        """Read what is small now, so that its problems are known at once."""
        _ = self.scenario, self.cycles, self.microstructure, self.stages

    @cached_property
    def cycles(self) -> pd.DataFrame:
        """One row per finished cycle, see `analysis.formats.file_columns.CYCLES`."""
        return self._table("cycles.csv", file_columns.CYCLES, whole=True)

    @cached_property
    def history(self) -> pd.DataFrame:
        """At least 40 rows per cycle, see `analysis.formats.file_columns.HISTORY`; `cycle` is fractional."""
        return self._table("history.csv", file_columns.HISTORY, whole=False)

    @cached_property
    def microstructure(self) -> pd.DataFrame:
        """One row per cycle, row 0 before loading, see `analysis.formats.file_columns.MICROSTRUCTURE`."""
        return self._table("microstructure.csv", file_columns.MICROSTRUCTURE, whole=True)

    @cached_property
    def bonds(self) -> pd.DataFrame:
        """One row per cycle, row 0 before loading, see `file_columns.BOND_COUNTS`; no rows for a run without bonds."""
        if not (self.folder / bonds.COUNTS).exists():
            return empty_table(file_columns.BOND_COUNTS)
        return self._table(bonds.COUNTS, file_columns.BOND_COUNTS, whole=True)

    @cached_property
    def bonds_broken(self) -> pd.DataFrame:
        """One row per broken bond, see `file_columns.BONDS_BROKEN`; no rows for a run without bonds."""
        broken = self._optional(bonds.BROKEN, bonds.read_broken)
        return pd.DataFrame(columns=file_columns.BONDS_BROKEN) if broken is None else broken

    @cached_property
    def harmonics(self) -> pd.DataFrame:
        """One row per cycle, see `analysis.normalised.harmonics`: of history.csv, of harmonics.csv in kept runs."""
        if (self.folder / "harmonics.csv").exists():
            return self._table("harmonics.csv", file_columns.HARMONICS, whole=True)
        return harmonics.of_history(self.history)

    @cached_property
    def plate_stresses(self) -> pd.DataFrame:
        """One row per cycle, see `file_columns.PLATE_STRESSES`: of history.csv, of plates.csv in kept runs; no rows for
        a kept run without it.
        """
        if (self.folder / "plates.csv").exists():
            return self._table("plates.csv", file_columns.PLATE_STRESSES, whole=True)
        return plates.of_history(self.history)

    @cached_property
    def loops(self) -> pd.DataFrame:
        """Rows of the first and the last whole cycle (columns `file_columns.LOOPS`): of history.csv, of loops.csv in
        kept runs.
        """
        if (self.folder / "loops.csv").exists():
            return self._table("loops.csv", file_columns.LOOPS, whole=False)
        rows = self.history[list(file_columns.LOOPS)]
        last = math.floor(rows["cycle"].max() + 1e-9) if len(rows) else 0
        return rows[(rows["cycle"] <= 1 + 1e-9) | rows["cycle"].between(last - 1 - 1e-9, last + 1e-9)]

    @cached_property
    def unloaded(self) -> pd.DataFrame:
        """One row per cycle after which a copy was unloaded, see `file_columns.UNLOAD`; no rows where none was."""
        if not (self.folder / UNLOADED).exists():
            return empty_table(file_columns.UNLOAD)
        return self._table(UNLOADED, file_columns.UNLOAD, whole=False)

    @cached_property
    def stages(self) -> stages.Stages:
        """The bed after packing and after preload, see `analysis.normalised.stages`; {} without stages.json."""
        try:
            return stages.read_stages(self.folder)
        except InputError as error:
            self._problem(stages.FILE, f"{_after_name(error)}; nothing of it is used")
            return {}

    @cached_property
    def scenario(self) -> Scenario | None:
        """The parameters kept with the run; today's scenario file where none were; None where they cannot be used."""
        path = self.folder / "scenario.json"
        if path.exists():
            try:
                return self._completed(Scenario.read(path))
            except ScenarioError as error:
                self._problem("scenario.json", _after_name(error))
                return None
        try:
            scenario = load_scenario(self.scenario_name, self.profile)
        except ScenarioError as error:
            self._problem("scenario.json", f"is missing, and {error}")
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

    def _table(self, name: str, columns: Sequence[str], whole: bool) -> pd.DataFrame:
        path = self.folder / name
        if not path.exists() and (self.info.get("stage") in ("packing", "preload") or name == "history.csv"):
            return empty_table(columns)
        try:
            frame = read_table(path, columns, whole)
            self._check_porosities(name, frame)
            if table_file.is_torn(path):
                self._problem(name, "ends in mid-line: that row does not count")
            return frame
        except InputError as error:
            self._problem(name, f"{_after_name(error)}; nothing of it is used")
            return empty_table(columns)

    def _check_porosities(self, name: str, frame: pd.DataFrame) -> None:
        """InputError where a porosity is missing whose measurement sphere fits into the box."""
        if self.scenario is None:
            return
        fits = derived.apparatus(self.scenario).measurement_fits
        for column in (f"porosity_{k}" for k, inside in zip(file_columns.SPHERES, fits, strict=True) if inside):
            if column in frame and frame[column].isna().any():
                cycle = frame.loc[frame[column].isna(), "cycle"].iloc[0]
                raise InputError(name, f"{column} of cycle {cycle}", "", "a number, its sphere fits into the box")

    def _optional(self, name: str, reader) -> pd.DataFrame | None:
        path = self.folder / name
        if not path.exists():
            return None
        try:
            return reader(path)
        except ValueError as error:
            self._problem(name, _after_name(error))
            return None


class Runs(list):
    """A list of runs with tidy frames over all of them: profile, scenario, code and seed come first in every row."""

    def __init__(self, runs: Iterable[Run] = (), refused: Sequence[str] = ()):
        """`refused` holds a line for each run that was left out."""
        super().__init__(runs)
        self.refused = list(refused)

    def __repr__(self) -> str:
        return f"<{len(self)} runs: {', '.join(run.id for run in self)}>" if self else "<no runs>"

    @property
    def problems(self) -> list[str]:
        """The problems of all runs, and of those left out, one line each."""
        return self.refused + [line for run in self for line in run.problems]

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


def _id(folder: Path, results_dir: Path) -> str:
    """The run's place below the results: demo/linear-mu0.8/yade."""
    return str(Path(os.path.relpath(folder, results_dir))).replace(os.sep, "/")


def _after_name(error: Exception) -> str:
    """A message without the file's name at its start, which the run's own lines begin with."""
    return one_line(error).partition(": ")[2]
