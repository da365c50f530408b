"""The driver: takes one scenario in one code from nothing, or from where it was left, to the end.

What has been done is read from the products in the run's folder, never from flags: packing from raw/bed_packed.csv,
preload from a good checkpoint, cyclic loading from cycles.csv and the bed of its last row.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import functools
import math
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import checkpoints, record
from analysis.driver.engines import CODES, STAGES, EngineError, command, versions, write_inputs
from analysis.driver.locks import Busy, hold
from analysis.driver.progress import Progress, duration
from analysis.driver.rawfiles import cut_stage, last_rows
from analysis.driver.supervise import DISK_FULL, Interrupted, RunError, StopRequest, Supervisor, deviations
from analysis.driver.watch import Diverged
from analysis.files import ROOT, write_aside
from analysis.formats import file_columns
from analysis.formats.growing_csv import GrowingCsv
from analysis.scenarios import derived
from analysis.scenarios.scenario import SCENARIO_FILE, Scenario, ScenarioError, load_scenario

BED_KEYS = ("geometry.", "clump.")  # a packed bed serves any scenario that has the same of these
NORMALISED = ("bed_before.csv", "stages.json", "cycles.csv", "microstructure.csv", "history.csv", "bed_after.csv")


def run_folder(results: Path, profile: str, scenario: str, code: str, seed: int) -> Path:
    """Folder of a run of a scenario, given by its id (variants included); the default seed 1 is not in its name."""
    return results / profile / scenario / (code if seed == 1 else f"{code}-seed{seed}")


def cycles_done(folder: Path) -> int:
    """Number of complete cycles in a run's cycles.csv."""
    try:
        with open(folder / "cycles.csv", newline="") as file:
            return max((int(row["cycle"]) for row in csv.DictReader(file)), default=0)
    except FileNotFoundError:
        return 0


def cycles_asked(folder: Path) -> int:
    """Number of cycles that a run was last asked for; 0 without a run."""
    try:
        return Scenario.from_json((folder / "scenario.json").read_text())["loading.cycles"]
    except (OSError, ScenarioError):
        return 0


class Run:
    """One scenario in one code with one seed: its folder, what has been done in it, and how to do the rest."""

    def __init__(self, scenario: Scenario, options: argparse.Namespace, stop: StopRequest):
        self.scenario, self.options, self.stop, self.code = scenario, options, stop, options.code
        self.grid, self.cycles = derived.time_grid(scenario), scenario["loading.cycles"]
        self.folder = run_folder(options.results, scenario.profile, scenario.id, self.code, options.seed)
        self.raw, self.kept = self.folder / "raw", self.folder / "checkpoints"
        self.bed_file = self.raw / "bed_packed.csv"
        self.title = f"{scenario.id} {self.code} {scenario.profile}" + (
            f" seed {options.seed}" if options.seed != 1 else ""
        )
        self.progress = Progress(self.title, options.progress == "lines")
        self.record: dict = {}

    @functools.cached_property
    def normaliser(self):
        """Imported only where it is needed: its libraries take a second to load."""
        from analysis.normalised.normalise import Normaliser

        return Normaliser(self.folder, self.scenario)

    # ------------------------------------------------------------------ the whole run

    def go(self) -> None:
        """Do all that is missing, up to options.until."""
        if not self.folder.exists():
            versions(self.code)  # refuse before a folder is made
        try:
            with hold(self.folder / "run.lock"):
                self.pack()
                if self.options.until == "packing":
                    self.progress.say(f"packed, in {self.folder}")
                    return
                self._refuse_changes()
                if (record.read(self.folder) or {}).get("state") == "finished" and cycles_done(
                    self.folder
                ) >= self.cycles:
                    self.progress.say(f"finished already: {cycles_done(self.folder)} cycles in {self.folder}")
                    return
                self._prepare()
                self._guard(self._load)
        except Busy as busy:
            who = "process {pid} on {host}".format(**busy.holder) if busy.holder else "by another process"
            raise RunError(f"{self.title} | in progress already, {who}; `make status` shows it") from None

    def pack(self) -> None:
        """Packing, unless it is done. Two runs may need the same bed: the second one waits for the first."""

        def waiting() -> bool:
            self.stop.check()
            self.progress.update("waiting for another process that packs this bed")
            return not self.bed_file.exists()

        if self.bed_file.exists():
            return
        try:
            with hold(self.folder / "packing.lock", waiting):
                if not self.bed_file.exists():
                    self._prepare()
                    self._guard(self._make_bed)
        except Busy:
            pass  # it has been packed meanwhile

    def _load(self) -> None:
        """Preload, cyclic loading and the normalised files, whatever of it is missing."""
        if not self._resume_point():
            self._preload()
        if self.options.until == "preload":
            self._save(state="interrupted", reason="paused after preload, as asked", end=record.now())
            self.progress.say(f"preloaded, in {self.folder}")
            return
        if cycles_done(self.folder) != self.cycles or not (self.raw / f"bed_cycle_{self.cycles:06d}.csv").exists():
            self._cyclic()
        self.normaliser.finish()
        self._save(state="finished", reason="", end=record.now())
        self.progress.say(f"finished: {self.cycles} cycles in {self.folder}")

    def _guard(self, work: Callable[[], None]) -> None:
        """Do `work` and leave in run.json how it ended, whatever happens."""
        try:
            work()
        except Interrupted:
            self._save(
                state="interrupted", reason=f"stopped by {signal.Signals(self.stop.signal).name}", end=record.now()
            )
            raise
        except Diverged as error:
            self._fail(f"diverged: {error}")
        except (RunError, EngineError, ValueError) as error:  # bad scenarios and bad raw files are ValueErrors
            self._fail(str(error))
        except OSError as error:
            self._fail(self.disk_full() if error.errno in DISK_FULL else f"{error.filename}: {error.strerror}")
        except BaseException as error:
            self._note_failure(f"{type(error).__name__}: {error}")
            raise

    def _fail(self, reason: str) -> None:
        self._note_failure(reason)
        raise RunError(f"{self.title} | failed: {reason}") from None

    def _note_failure(self, reason: str) -> None:
        self._drop_partial_files()
        with contextlib.suppress(OSError):  # a full disk: what is left says `running`, and status sees that nobody does
            self._save(state="failed", reason=reason, end=record.now())

    def disk_full(self) -> str:
        """One line for a full disk."""
        return f"no space left for {self.folder}; free some and give the same command again to go on"

    # ------------------------------------------------------------------ the folder

    def _prepare(self) -> None:
        """Write the inputs, and the record with what earlier starts of it left."""
        self._refuse_changes()
        done = cycles_done(self.folder)
        if done > self.cycles:
            raise RunError(
                f"{self.title} | {done} cycles are done already, more than the {self.cycles} asked for; "
                f"give CYCLES={done} or more"
            )
        engine = versions(self.code)
        self._drop_partial_files()
        write_inputs(self.scenario, self.folder, self.options.seed)
        old = record.read(self.folder) or {}
        timing, ranks = old.get("timing", {}), self.options.ranks
        states = last_rows(self.raw / "state.csv")
        self.record = {
            "scenario": self.scenario.name,
            "variant": "+".join(self.scenario.variants),
            "profile": self.scenario.profile,
            "code": self.code,
            "scenario_hash": self.scenario.hash,
            "title": self.scenario.title,
            "versions": record.versions(engine),
            "command": self.command_line(),
            "seed": self.options.seed,
            "bed": self._bed_name(),
            **record.git(),
            "ranks": ranks if self.code == "liggghts" else 1,
            "threads": ranks if self.code == "yade" else 1,
            "state": "running",
            "reason": "",
            "stage": old.get("stage", "packing"),
            "steps": {stage: int(row["step"]) for stage, row in states.items()},
            "clumps": old.get("clumps"),
            "deviations": [],
            "resumes": old.get("resumes", []),
            "timing": {
                "start": timing.get("start", record.now()),
                "end": None,
                "steps_per_second": timing.get("steps_per_second", {}),
                "wall_s": timing.get("wall_s", {}),
                "pid": os.getpid(),
                "host": record.host(),
            },
        }
        self._save()

    def _save(self, **changes) -> None:
        """Write run.json with some entries changed; `end` belongs to its timing."""
        self.record["timing"] |= {"heartbeat": record.now()} | ({"end": changes.pop("end")} if "end" in changes else {})
        many = self.options.ranks > 1
        self.record |= changes | {
            "deviations": deviations(self.raw)
            + many * [f"{self.options.ranks} ranks or threads: repeated runs differ in their last digits."]
        }
        record.write(self.folder, self.record)

    def _drop_partial_files(self) -> None:
        for path in (*self.folder.rglob("*.partial"), *self.kept.glob("partial_*")):
            path.unlink(missing_ok=True)

    def _refuse_changes(self) -> None:
        """A packed or loaded bed of other parameters is left alone; without one there is nothing to lose.

        As long as a bed is packed only, what packing does not read may change.
        """
        if not self.bed_file.exists():
            return
        try:
            stored = Scenario.from_json((self.folder / "scenario.json").read_text())
        except (OSError, ValueError, KeyError, TypeError):
            raise RunError(f"{self.folder}/scenario.json: cannot be read; {self._start_over()}") from None
        loaded = any(self.kept.glob("cyclic_*")) or (self.folder / "cycles.csv").exists()
        changes = stored.changes(self.scenario, "packing", "output" if loaded else "packing")
        bed = (record.read(self.folder) or {}).get("bed", self._bed_name())
        if bed != self._bed_name():
            changes.append(f"bed: {bed} -> {self._bed_name()}")
        if changes:
            raise RunError(
                f"{self.title} | has results of other parameters: {'; '.join(changes)}; {self._start_over()}"
            )

    def _start_over(self) -> str:
        return "give another SEED or RESULTS, move the folder away, or delete it with `make distclean-run`"

    def command_line(self, name: Callable[[Path], object] = record.relative) -> str:
        """The command that does this run again; `name` shortens paths, so that run.json holds no absolute one."""
        o = self.options
        values = {
            "SCENARIO": self.scenario.name,
            "VARIANT": "+".join(self.scenario.variants) or None,
            "CODE": o.code,
            "PROFILE": o.profile,
            "CYCLES": o.cycles,
            "SEED": o.seed if o.seed != 1 else None,
            "NP": o.ranks if o.ranks != 1 else None,
            "BED": o.bed and name(o.bed),
            "RESULTS": name(o.results) if o.results != ROOT / "results" else None,
            "SCENARIOS": name(o.scenarios) if o.scenarios != SCENARIO_FILE else None,
        }
        return "make run " + " ".join(f"{key}={value}" for key, value in values.items() if value is not None)

    # ------------------------------------------------------------------ the bed

    def _bed_name(self) -> str:
        if self.options.bed:
            return record.relative(self.options.bed)
        name = self.scenario["packing.bed_from"]
        if not name:
            return "own"
        folder = run_folder(Path("."), "", name, self._bed_code(), self.options.seed)
        return f"../../{folder}/raw/bed_packed.csv"

    def _bed_code(self) -> str:
        """The code that packs the bed that packing.bed_from names."""
        return self.scenario["packing.bed_code"] or self.code

    def _make_bed(self) -> None:
        """Pack, or take the bed that the command or packing.bed_from names."""
        if self.options.bed:
            self._take_bed(self.options.bed)
        elif name := self.scenario["packing.bed_from"]:
            options = argparse.Namespace(**vars(self.options) | {"cycles": None, "code": self._bed_code()})
            source = Run(load_scenario(name, options.profile, options.scenarios), options, self.stop)
            source.pack()
            self._take_bed(source.bed_file)
        else:
            for old in (*self.raw.glob("*.csv"), *(self.folder / name for name in NORMALISED)):
                if old.name != "bed_start.csv":
                    old.unlink(missing_ok=True)
            checkpoints.forget_after(self.kept, None)
            self.record["steps"].clear()
            self._stage("packing")
            if not self.bed_file.exists():
                raise RunError(f"{self.code} ended without raw/bed_packed.csv; read {self.folder}/log/packing.log")
        self._save(state="interrupted", reason="packed, not loaded yet", end=record.now())

    def _take_bed(self, path: Path) -> None:
        """Copy a packed bed after a look at it, and at the scenario of the run that it comes from."""

        def refuse(what: str) -> RunError:
            return RunError(f"{path}: {what}")

        columns = ",".join(file_columns.BED)
        try:
            text = path.read_text()
            header, *lines = text.splitlines() or [""]
            poses = [[float(value) for value in line.split(",")] for line in lines]
        except OSError as error:
            raise refuse(f"{error.strerror}; give BED=path of a bed file") from None
        except ValueError:
            raise refuse(f"is not a bed file; a bed has the columns {columns}, all numbers") from None
        if header != columns or not poses:
            raise refuse(f"is not a bed file; a bed has the columns {columns} and a row per clump")
        box = derived.apparatus(self.scenario)
        for line, pose in enumerate(poses, start=2):
            if len(pose) != len(file_columns.BED) or not math.isclose(math.hypot(*pose[4:]), 1, abs_tol=1e-6):
                raise refuse(f"line {line} is not a pose; it needs {columns} with a unit quaternion")
            if not all(
                0 <= value <= top
                for value, top in zip(pose[1:4], (box.length_m, box.width_m, box.height_m), strict=True)
            ):
                raise refuse(
                    f"line {line} lies outside the box of {box.length_m:g} x {box.width_m:g} x {box.height_m:g} m; "
                    "take a bed of the same profile and geometry"
                )
        made_with = path.parent.parent / "scenario.json"
        if made_with.exists():
            made = Scenario.from_json(made_with.read_text())
            changes = [line for line in made.changes(self.scenario) if line.startswith(BED_KEYS)]
            if changes:
                raise refuse(f"does not fit: {'; '.join(changes)}; take a bed with the same geometry and clump")
        write_aside(self.bed_file, text)
        self.progress.say(f"starts from a packed bed of {len(poses)} clumps, {self._bed_name()}")

    # ------------------------------------------------------------------ the stages

    def _resume_point(self) -> checkpoints.Checkpoint | None:
        return checkpoints.last_good(self.kept, self.cycles, self.progress.say)

    def _preload(self) -> None:
        checkpoints.forget_after(self.kept, None)
        for stage in ("preload", "cyclic"):
            cut_stage(self.raw, stage, None)
            self.record["steps"].pop(stage, None)
        for name in NORMALISED:
            (self.folder / name).unlink(missing_ok=True)
        self._stage("preload")
        if not self._resume_point():
            raise RunError(
                f"{self.code} ended without checkpoints/cyclic_000000 and raw/bed_preloaded.csv; "
                f"read {self.folder}/log/preload.log"
            )
        self.normaliser.before()

    def _cyclic(self) -> None:
        """Go on from the last good checkpoint as if nothing had been done after it."""
        start = self._resume_point()
        if start is None:
            raise RunError(f"no checkpoint before cycle {self.cycles} is left; {self._start_over()}")
        checkpoints.forget_after(self.kept, start)
        cut_stage(self.raw, "cyclic", start.step(self.grid))
        self.normaliser.rewind(start.cycle)
        if "cyclic" in self.record["steps"]:
            self.record["resumes"].append({"stage": "cyclic", "cycle": start.cycle, "block": start.block})
            self.progress.say(f"goes on from {start} of {self.cycles}")
        self._stage("cyclic", start)
        if cycles_done(self.folder) != self.cycles:
            raise RunError(
                f"{self.code} ended after {cycles_done(self.folder)} of {self.cycles} cycles; "
                f"read {self.folder}/log/cyclic.log"
            )

    def _stage(self, stage: str, start: checkpoints.Checkpoint | None = None) -> None:
        """Run one stage in the engine."""
        self.stop.check()
        if start is None and self.record["steps"].get(stage):
            self.progress.say(f"{stage} begins again: it has no checkpoints")
        if start is None:
            GrowingCsv(self.raw / "state.csv").cut(lambda row: STAGES.index(row["stage"]) < STAGES.index(stage))
        self._save(stage=stage)
        began, wall_before = time.monotonic(), self.record["timing"]["wall_s"].get(stage, 0.0)

        def heartbeat(stage: str, steps: int, clumps: int | None, steps_per_second: float) -> None:
            timing = self.record["timing"]
            timing["wall_s"][stage] = round(wall_before + time.monotonic() - began, 1)
            if steps_per_second:
                timing["steps_per_second"][stage] = round(steps_per_second, 1)
            self.record["steps"][stage] = steps
            self._save(clumps=self.record["clumps"] if clumps is None else clumps)

        def short(path: Path) -> Path:
            return path.relative_to(ROOT) if path.is_relative_to(ROOT) else path

        supervisor = Supervisor(
            self.folder,
            self.scenario,
            stage,
            self.stop,
            self.progress,
            heartbeat,
            self.normaliser if stage == "cyclic" else None,
            start,
        )
        supervisor.supervise(
            command(self.code, stage, short(self.folder), short(start.path) if start else None, self.options.ranks),
            threads=self.options.ranks if self.code == "yade" else 1,
        )
        if stage != "cyclic":
            self.progress.say(f"{stage} done in {duration(time.monotonic() - began)}, {supervisor.clumps()} clumps")


def _arguments(argv: list[str]) -> argparse.Namespace:
    def whole(text: str) -> int:
        if not text.isdigit() or int(text) == 0:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number above 0")
        return int(text)

    def path(text: str) -> Path:
        return Path(text).resolve()

    parser = Parser(prog="python -m analysis run", description="Simulate one scenario in one code, or go on with it.")
    parser.add_argument("scenario", help="a scenario of the scenario file")
    parser.add_argument("--variant", default="", help="variants of the scenario file, e.g. servo or servo,same-bed")
    parser.add_argument("--code", choices=CODES, required=True)
    parser.add_argument("--profile", default="demo", help="demo (default) or full")
    parser.add_argument("--cycles", type=whole, help="instead of loading.cycles; raise it to extend a finished run")
    parser.add_argument("--seed", type=whole, default=1, help="of the start orientations (default 1)")
    parser.add_argument("--bed", type=path, help="start from this packed bed (a common bed file) instead of packing")
    parser.add_argument("--ranks", type=whole, default=1, help="MPI ranks of LIGGGHTS or threads of YADE (default 1)")
    parser.add_argument("--until", choices=("packing", "preload"), help="pause after this stage")
    parser.add_argument("--results", type=path, default=ROOT / "results", help="folder of all results")
    parser.add_argument("--scenarios", type=path, default=SCENARIO_FILE, help="another scenario file")
    parser.add_argument("--progress", choices=("line", "lines"), default="line", help="one renewed line, or a log")
    return parser.parse_args(argv)


def main(argv: list[str]) -> int:
    """Command line of `make run`. Exit code 0 done, 1 failed, 130 or 143 stopped by Ctrl-C or SIGTERM."""
    options, stop = _arguments(argv), StopRequest()

    def resolved() -> Scenario:
        return load_scenario(options.scenario, options.profile, options.scenarios, options.cycles, options.variant)

    try:
        run = Run(resolved(), options, stop)
        if options.cycles is None and (asked := cycles_asked(run.folder)) > run.cycles:
            options.cycles = asked  # the same command without CYCLES goes on to where the run was going
            run = Run(resolved(), options, stop)
        run.go()
    except (ScenarioError, EngineError, RunError) as error:
        print(error, file=sys.stderr)
        return 1
    except Interrupted:
        print(f"{run.title} | stopped; to go on: {run.command_line(os.path.relpath)}", file=sys.stderr)
        return 128 + stop.signal
    except OSError as error:
        print(run.disk_full() if error.errno in DISK_FULL else f"{error.filename}: {error.strerror}", file=sys.stderr)
        return 1
    return 0
