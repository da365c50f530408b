"""The driver: takes one scenario in one code from nothing, or from where it was left, to the end.

What has been done is read from the products in the run's folder, never from flags: packing from raw/bed_packed.csv,
preload from a good checkpoint, cyclic loading from cycles.csv.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import resource
import signal
import sys
import time
from collections.abc import Callable, Mapping

from analysis.arguments import Parser
from analysis.driver import bed_source, checkpoints, options, refusal
from analysis.driver.divergence import Diverged
from analysis.driver.engine import Engine, EngineError
from analysis.driver.engines import ENGINES
from analysis.driver.folder import NORMALISED, STAGES, cycles_asked, cycles_done
from analysis.driver.locks import Busy, Lock, hold
from analysis.driver.progress import Progress, duration
from analysis.driver.provenance import now
from analysis.driver.rawfiles import cut_stage, last_step, start_stage
from analysis.driver.record import Record, stored_record
from analysis.driver.settings import RunSettings, from_here
from analysis.driver.supervise import DISK_FULL, Interrupted, RunError, StopRequest, Supervisor
from analysis.formats.errors import InputError
from analysis.formats.run_record import DIVERGED
from analysis.scenarios import derived
from analysis.scenarios.scenario import ScenarioError


class Execution:
    """One scenario in one code with one seed: its folder, what has been done in it, and how to do the rest."""

    def __init__(self, settings: RunSettings, stop: StopRequest, engines: Mapping[str, Engine] = ENGINES):
        self.settings, self.stop, self.engines, self.engine = settings, stop, engines, engines[settings.code]
        self.scenario, self.folder, self.title = settings.scenario, settings.folder, settings.title
        self.grid, self.cycles = derived.time_grid(self.scenario), self.scenario["loading.cycles"]
        self.raw, self.kept = self.folder / "raw", self.folder / "checkpoints"
        self.bed_file = self.raw / "bed_packed.csv"
        self.progress = Progress(self.title, settings.lines)
        self.record: Record | None = None
        self.locks: list[Lock] = []

    @functools.cached_property
    def normaliser(self):
        """Imported only where it is needed: its libraries take a second to load."""
        from analysis.normalised.normalise import Normaliser

        return Normaliser(self.folder, self.scenario)

    # ------------------------------------------------------------------ the order of a run

    def go(self) -> None:
        """Do all that is missing, up to settings.until."""
        refusal.refuse_changes(self.settings)
        if self._is_finished():
            self.progress.say(f"finished already: {cycles_done(self.folder)} cycles in {self.folder}")
            return
        refusal.refuse_place(self.settings, self.engine)
        self.engine.version()  # refuse before a folder is made
        try:
            with hold(self.folder / "run.lock") as lock:
                self.locks.append(lock)
                self.pack()
                if self.settings.until == "packing":
                    self.progress.say(f"packed, in {self.folder}")
                    return
                refusal.refuse_loss(self.settings, self._resume_point())
                self._begin()
                self._guard(self._load)
        except Busy as busy:
            who = "process {pid} on {host}".format(**busy.holder) if busy.holder else "by another process"
            raise RunError(f"{self.title} | in progress already, {who}; `make status` shows it") from None

    def _is_finished(self) -> bool:
        """True where nothing is left to do; asks for nothing but the normalised files."""
        record = stored_record(self.folder)
        return bool(record) and record.state == "finished" and cycles_done(self.folder) >= self.cycles

    def pack(self) -> None:
        """Packing, unless it is done. Two runs may need the same bed: the second one waits for the first."""

        def waiting() -> bool:
            self.stop.check()
            self._renew()
            self.progress.update("waiting for another process that packs this bed")
            return not self.bed_file.exists()

        if self._has_bed():
            return
        refusal.refuse_place(self.settings, self.engine)
        try:
            with hold(self.folder / "packing.lock", waiting) as lock:
                self.locks.append(lock)
                if not self._has_bed():
                    refusal.refuse_new_bed(self.settings)
                    self._begin()
                    self._guard(self._make_bed)
        except Busy:
            pass  # it has been packed meanwhile

    def _renew(self) -> None:
        for lock in self.locks:
            lock.renew()

    def _has_bed(self) -> bool:
        """True where packing is done, or what came after it is."""
        return self.bed_file.exists() or self._resume_point(warn=False) is not None

    def _load(self) -> None:
        """Preload, cyclic loading and the normalised files, whatever of it is missing."""
        if self._resume_point(warn=False) is None:
            self._preload()
        if self.settings.until == "preload":
            self.record.save(state="interrupted", reason="paused after preload, as asked", end=now())
            self.progress.say(f"preloaded, in {self.folder}")
            return
        if cycles_done(self.folder) != self.cycles or not (self.raw / f"bed_cycle_{self.cycles:06d}.csv").exists():
            self._cyclic()
        self.normaliser.finish()
        self.record.save(state="finished", reason="", end=now())
        self.progress.say(f"finished: {self.cycles} cycles in {self.folder}")

    # ------------------------------------------------------------------ begin and end of a part

    def _begin(self) -> None:
        """Write the inputs, and the record with what earlier starts of it left."""
        refusal.refuse_changes(self.settings)
        refusal.refuse_fewer_cycles(self.settings)
        self.engine.version()
        self._drop_partial_files()
        self.engine.write_inputs(self.scenario, self.folder, self.settings.seed)
        self.record = Record(self.settings, self.engine)

    def _guard(self, work: Callable[[], None]) -> None:
        """Do `work` and leave in run.json how it ended, whatever happens."""
        try:
            work()
        except Interrupted:
            self.record.save(
                state="interrupted", reason=f"stopped by {signal.Signals(self.stop.signal).name}", end=now()
            )
            raise
        except Diverged as error:
            self._fail(f"{DIVERGED}{error}")
        except (RunError, EngineError, ValueError) as error:  # bad scenarios and bad raw files are ValueErrors
            self._fail(str(error))
        except OSError as error:
            self._fail(disk_full(self.settings) if error.errno in DISK_FULL else unusable(error))
        except BaseException as error:
            self._note_failure(f"{type(error).__name__}: {error}")
            raise

    def _fail(self, reason: str) -> None:
        self._note_failure(reason)
        raise RunError(f"{self.title} | failed: {reason}") from None

    def _note_failure(self, reason: str) -> None:
        self._drop_partial_files()
        with contextlib.suppress(OSError):  # a full disk: what is left says `running`, and status sees that nobody does
            self.record.save(state="failed", reason=reason, end=now())

    def _drop_partial_files(self) -> None:
        for path in (*self.folder.rglob("*.partial"), *self.kept.glob("partial_*")):
            path.unlink(missing_ok=True)

    # ------------------------------------------------------------------ the stages

    def _make_bed(self) -> None:
        """Pack, or take the bed that the command or packing.bed_from names."""
        if self.settings.bed:
            self._take_bed(self.settings.bed)
        elif self.scenario["packing.bed_from"]:
            source = Execution(self.settings.of_the_bed(), self.stop, self.engines)
            source.locks = self.locks
            source.pack()
            self._take_bed(source.bed_file)
        else:
            for old in (*self.raw.glob("*.csv"), *(self.folder / name for name in NORMALISED)):
                if old.name != "bed_start.csv":
                    old.unlink(missing_ok=True)
            checkpoints.forget_after(self.kept, None)
            self.record.body.steps.clear()
            self._stage("packing")
            if not self.bed_file.exists():
                raise RunError(f"{self.engine.name} ended without raw/bed_packed.csv; {self._read_log('packing')}")
        self.record.save(state="interrupted", reason="packed, not loaded yet", end=now())

    def _take_bed(self, path) -> None:
        clumps = bed_source.take(path, self.settings)
        self.progress.say(f"starts from a packed bed of {clumps} clumps, {self.settings.bed_name}")

    def _resume_point(self, warn: bool = True) -> checkpoints.Checkpoint | None:
        """The latest good checkpoint whose rows are there."""
        written = min(last_step(self.raw / "state.csv", "cyclic"), last_step(self.raw / "cyclic.csv"))
        return checkpoints.last_good(
            self.kept,
            self.cycles,
            self.progress.say if warn else lambda text: None,
            lambda checkpoint: checkpoint.step(self.grid) <= written,
        )

    def _preload(self) -> None:
        checkpoints.forget_after(self.kept, None)
        for stage in ("preload", "cyclic"):
            cut_stage(self.raw, stage, None)
            self.record.body.steps.pop(stage, None)
        for name in NORMALISED:
            (self.folder / name).unlink(missing_ok=True)
        self._say_what_is_not_measured()
        self._stage("preload")
        if not self._resume_point(warn=False):
            raise RunError(
                f"{self.engine.name} ended without checkpoints/cyclic_000000 and raw/bed_preloaded.csv; "
                f"{self._read_log('preload')}"
            )
        self.normaliser.before()

    def _say_what_is_not_measured(self) -> None:
        fits = derived.apparatus(self.scenario).measurement_fits
        if outside := [str(k) for k, inside in enumerate(fits, start=1) if not inside]:
            self.progress.say(
                f"measurement spheres that do not fit into the box: {', '.join(outside)}; their porosity stays empty"
            )

    def _cyclic(self) -> None:
        """Go on from the last good checkpoint as if nothing had been done after it."""
        start = self._resume_point(warn=False)
        if start is None:
            raise RunError(f"no checkpoint before cycle {self.cycles} is left; {refusal.START_OVER}")
        checkpoints.forget_after(self.kept, start)
        cut_stage(self.raw, "cyclic", start.step(self.grid))
        self.normaliser.rewind(start.cycle)
        refusal.refuse_step(self.settings)
        if "cyclic" in self.record.body.steps:
            self.record.body.resumes.append({"stage": "cyclic", "cycle": start.cycle, "block": start.block})
            self.progress.say(f"goes on from {start} of {self.cycles}")
        self._stage("cyclic", start)
        if cycles_done(self.folder) != self.cycles:
            raise RunError(
                f"{self.engine.name} ended after {cycles_done(self.folder)} of {self.cycles} cycles; "
                f"{self._read_log('cyclic')}"
            )

    def _read_log(self, stage: str) -> str:
        return f"read {self.folder}/log/{stage}.log"

    def _stage(self, stage: str, start: checkpoints.Checkpoint | None = None) -> None:
        """Run one stage in the engine."""
        self.stop.check()
        body = self.record.body
        if start is None and body.steps.get(stage):
            self.progress.say(f"{stage} begins again: it has no checkpoints")
        if start is None:
            start_stage(self.raw, stage)
        self.record.begin_part(stage, *((start.cycle, start.block) if start else ()))
        self.record.save(stage=stage)
        began, wall_before = time.monotonic(), body.timing.wall_s.get(stage, 0.0)
        cpu_before, steps_before = engine_cpu_s(), start.step(self.grid) if start else 0

        def heartbeat(stage: str, steps: int, clumps: int | None, steps_per_second: float) -> None:
            body.timing.wall_s[stage] = round(wall_before + time.monotonic() - began, 1)
            if steps_per_second:
                body.timing.steps_per_second[stage] = round(steps_per_second, 1)
            body.steps[stage] = steps
            self.record.save(clumps=body.clumps if clumps is None else clumps)

        supervisor = Supervisor(
            self.folder,
            self.scenario,
            stage,
            self.stop,
            self.progress,
            heartbeat=heartbeat,
            renew=self._renew,
            normaliser=self.normaliser if stage == "cyclic" else None,
            start=start,
        )
        try:
            supervisor.supervise(
                engine_command(self.engine, stage, self.settings, start.path if start else None),
                threads=self.engine.parallel(self.settings.ranks)["threads"],
            )
        finally:
            body.timing.add_cpu(stage, engine_cpu_s() - cpu_before, body.steps.get(stage, 0) - steps_before)
        if stage != "cyclic":
            self.progress.say(f"{stage} done in {duration(time.monotonic() - began)}, {supervisor.clumps()} clumps")


def engine_cpu_s() -> float:
    """Processor time of all engines that this process has started and waited for, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def engine_command(engine: Engine, stage: str, settings: RunSettings, checkpoint=None) -> list[str]:
    """Command line of a stage of a run, to be started in the repository's root."""
    places = [refusal.path_for_engine(path) if path else None for path in (settings.folder, checkpoint)]
    return engine.command(stage, *places, settings.ranks)


def disk_full(settings: RunSettings) -> str:
    """One line for a full disk."""
    return f"no space left for {settings.folder}; free some and give the same command again to go on"


def unusable(error: OSError) -> str:
    """One line for a file or folder that the system refuses."""
    remedy = {
        "PermissionError": "give yourself the right to write there, or another RESULTS",
        "FileNotFoundError": "it was removed while the run went on: give the same command again",
    }.get(type(error).__name__, "see to it, then give the same command again")
    return f"{error.filename or 'a file'}: {error.strerror or error}; {remedy}"


def run(settings: RunSettings, engines: Mapping[str, Engine] = ENGINES) -> int:
    """Do a run, or what is missing of it; errors are printed, one line each.

    Returns the exit code: 0 done, 1 failed, 128 + the signal's number (130, 143, 129) stopped.
    """
    stop = StopRequest()
    try:
        if settings.cycles is None and (asked := cycles_asked(settings.folder)) > settings.scenario["loading.cycles"]:
            settings = settings.with_cycles(asked)  # the same command without CYCLES goes on to where the run was going
        Execution(settings, stop, engines).go()
    except (EngineError, RunError, InputError, ScenarioError) as error:
        print(error, file=sys.stderr)
        return 1
    except Interrupted:
        print(f"{settings.title} | stopped; to go on: {settings.command_line(from_here)}", file=sys.stderr)
        return 128 + stop.signal
    except OSError as error:
        print(disk_full(settings) if error.errno in DISK_FULL else unusable(error), file=sys.stderr)
        return 1
    return 0


def add_arguments(parser: Parser) -> None:
    """Arguments of `ballast run`."""
    options.add_run(parser)
    parser.add_argument("--until", choices=STAGES[:2], help="pause after this stage")
    parser.add_argument("--redo", action="store_true", help="compute finished cycles again whose checkpoints are gone")
    parser.add_argument(
        "--progress",
        choices=("line", "lines"),
        default="line",
        help="line: one line that is renewed (default); lines: a log",
    )


def execute(chosen: argparse.Namespace, engines: Mapping[str, Engine] = ENGINES) -> int:
    """`ballast run`."""
    try:
        settings = options.settings(chosen, until=chosen.until, redo=chosen.redo, lines=chosen.progress == "lines")
    except ScenarioError as error:
        print(error, file=sys.stderr)
        return 1
    return run(settings, engines)
