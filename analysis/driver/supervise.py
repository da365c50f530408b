"""Looks after one engine process: watches its output, finishes cycles, certifies checkpoints, reports progress."""

from __future__ import annotations

import errno
import math
import os
import re
import signal
import time
from collections.abc import Callable
from pathlib import Path

from analysis.driver import checkpoints
from analysis.driver.divergence import Diverged, Watch
from analysis.driver.process import STOPPED, EngineProcess
from analysis.driver.progress import Meter, Progress, duration
from analysis.formats.growing_csv import GrowingCsv
from analysis.scenarios import derived

POLL_S = 0.2
SIGNAL_S = 0.02  # so soon is a request to stop passed on
HEARTBEAT_S = 10.0
STALL_S = 1800.0  # an engine without output for so long hangs: the longest block takes minutes
FREE_BYTES = 65536  # less is free only where a file did not fit. YADE then tries for ever to write its checkpoint
DISK_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


class RunError(RuntimeError):
    """A run that cannot go on; the message is one line with the remedy."""


class Interrupted(Exception):
    """The run was asked to stop and did."""


class StopRequest:
    """Notes SIGINT, SIGTERM and SIGHUP (a closed terminal). The first asks the engine to stop; a further Ctrl-C kills.

    A batch system may well deliver SIGTERM twice, to the driver and through its parent. Under `nohup` SIGHUP stays
    ignored.
    """

    def __init__(self):
        self.signal, self.kill = 0, False
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self._note)

    def _note(self, number: int, _frame) -> None:
        self.kill = bool(self.signal) and number == signal.SIGINT
        self.signal = self.signal or number

    def check(self) -> None:
        """Raise Interrupted once a stop is wanted."""
        if self.signal:
            raise Interrupted


class Supervisor:
    """Supervises `stage` in the folder of a run; `start` is the checkpoint that the cyclic stage starts from."""

    def __init__(
        self,
        folder: Path,
        scenario,
        stage: str,
        stop: StopRequest,
        progress: Progress,
        *,
        heartbeat: Callable[[str, int, int | None, float], None],
        renew: Callable[[], None],
        normaliser=None,
        start: checkpoints.Checkpoint | None = None,
    ):
        """`heartbeat(stage, steps, clumps, steps_per_second)` is called every few seconds and at the end, `renew` at
        every look.
        """
        self.folder, self.scenario, self.stage, self.stop = folder, scenario, stage, stop
        self.progress, self.heartbeat, self.renew, self.normaliser = progress, heartbeat, renew, normaliser
        self.raw, self.kept = folder / "raw", folder / "checkpoints"
        self.grid = derived.time_grid(scenario)
        self.cycles = start.cycle if start else 0
        # At step 0 the engine still has to write the first row.
        self.row_step = self.state_step = (start.step(self.grid) if start else 0) or None
        self.watch = Watch(scenario, stage, self.row_step, self._clumps_after_preload() if start else None)
        # Each row is read once: in cyclic loading the normaliser keeps those that it needs for its tables.
        if normaliser:
            self._new_states, self._new_loads = normaliser.state.take, normaliser.loading.take
        else:
            files = (GrowingCsv(self.raw / name) for name in ("state.csv", f"{stage}.csv"))
            self._new_states, self._new_loads = (file.new_rows for file in files)
        self._new_states(), self._new_loads()  # rows of earlier starts and stages
        self._meter, self._last = Meter(), {}
        self._seen = self._beat = time.monotonic()

    def supervise(self, argv: list[str], threads: int = 1) -> None:
        """Run the engine to its end. Raises Diverged, RunError or Interrupted; the engine never outlives this call."""
        engine, asked = EngineProcess(argv, self.folder / "log" / f"{self.stage}.log", threads), False
        try:
            while (code := self._wait(engine, asked)) is None:
                if self.stop.signal and not asked:
                    asked = True
                    engine.ask_to_stop()
                    what = (
                        "the checkpoint" if self.stage == "cyclic" else f"{self.stage} to stop, which will begin again"
                    )
                    self.progress.say(f"asked to stop: waiting for {what}; another Ctrl-C kills")
                self.look()
                self.renew()
                self._check_disk()
                self._check_stall()
                self._show()
                if self.stop.kill:
                    engine.kill()
            self.look()
        except BaseException:
            engine.kill()
            raise
        finally:
            self._report()
        self._judge(engine, code)

    def _wait(self, engine: EngineProcess, asked: bool) -> int | None:
        """Exit code, or None after POLL_S; at once where a stop is requested that the engine has not been asked for."""
        end = time.monotonic() + POLL_S
        while (code := engine.wait(SIGNAL_S)) is None and time.monotonic() < end:
            if self.stop.signal and not asked:
                break
        return code

    # ------------------------------------------------------------------ output

    def look(self) -> None:
        """Take in all output since the last look. What came before a divergence is still finished and certified."""
        diverged = None
        try:
            for row in (rows := self._new_states()):
                self.watch.state(row)
                self.state_step, self._last = int(row["step"]), row
            if rows:
                self._meter.add(self.state_step)
                self._seen = time.monotonic()
        except Diverged as error:
            diverged = error
        try:
            for row in self._new_loads():
                self.watch.load(row)
                self.row_step = int(row["step"])
        except Diverged as error:
            diverged = diverged or error
        if self.stage == "cyclic":
            self._finish_cycles()
            self._certify()
        if diverged:
            raise diverged

    def _clumps_after_preload(self) -> int:
        with open(self.raw / "bed_preloaded.csv", "rb") as file:
            return sum(1 for line in file if line.strip()) - 1

    def _check_disk(self) -> None:
        disk = os.statvfs(self.folder)
        if disk.f_bavail * disk.f_frsize < FREE_BYTES:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def _check_stall(self) -> None:
        silent = time.monotonic() - self._seen
        if silent > STALL_S:
            raise RunError(f"the engine has written nothing for {duration(silent)}; it hangs, or runs far too slowly")

    def _has_output_to(self, step: int) -> bool:
        return min(self.row_step or 0, self.state_step or 0) >= step

    def _finish_cycles(self) -> None:
        """Add each cycle that is complete on the disk, and has passed the watch, to the normalised files.

        The checkpoints before a cycle are certified before it is added: so a kill costs no more cycles where the driver
        fell behind.
        """
        while self._has_output_to((self.cycles + 1) * self.grid.steps_per_cycle) and self.normaliser.ready(
            self.cycles + 1
        ):
            self._certify()
            self.normaliser.cycle(self.cycles + 1)
            self.cycles += 1

    def _certify(self) -> None:
        """Checksums for checkpoints whose output up to that moment has arrived and passed the watch."""
        for checkpoint in checkpoints.listed(self.kept):
            if (
                not checkpoint.is_certified()
                and checkpoint.cycle <= self.cycles
                and self._has_output_to(checkpoint.step(self.grid))
            ):
                self._certify_one(checkpoint)
                checkpoints.prune(self.kept)

    def _certify_one(self, checkpoint: checkpoints.Checkpoint) -> None:
        checkpoint.certify(
            self.grid,
            self.raw / "state.csv",
            self.raw / f"{self.stage}.csv",
            self.folder / "cycles.csv",
            self.folder / "microstructure.csv",
        )

    # ------------------------------------------------------------------ progress

    def _show(self) -> None:
        rate = self._meter.recent()
        parts = [f"{self.stage}, step {self.state_step or 0}"]
        if self.stage == "cyclic":
            total = self.scenario["loading.cycles"] * self.grid.steps_per_cycle
            parts = [f"cyclic, cycle {self.cycles} of {self.scenario['loading.cycles']}"]
            parts += [f"{duration((total - self.state_step) / rate)} left"] if rate and self.state_step else []
        elif self._last:
            ratio = float(self._last["unbalanced_ratio"])
            rest = f"unbalanced ratio {ratio:.1e}" if math.isfinite(ratio) else "no contacts yet"
            parts.append(f"{rest}, kinetic energy {float(self._last['kinetic_energy_J']):.1e} J")
        self.progress.update(" | ".join(parts + ([f"{rate:.0f} steps/s"] if rate else [])))
        if time.monotonic() - self._beat > HEARTBEAT_S:
            self._report()

    def _report(self) -> None:
        self._beat = time.monotonic()
        self.heartbeat(self.stage, self.state_step or 0, self.clumps(), self._meter.mean())

    def clumps(self) -> int | None:
        """Clumps in the bed at the last report, None before the first."""
        return int(float(self._last["clumps"])) if self._last else None

    # ------------------------------------------------------------------ the end

    def _judge(self, engine: EngineProcess, code: int) -> None:
        if code == 0:
            if self.stage == "preload" and (self.raw / "bed_preloaded.csv").exists():
                for checkpoint in checkpoints.listed(self.kept):
                    self._certify_one(checkpoint)
            return
        if self.stop.signal or code == STOPPED:
            self.stop.signal = self.stop.signal or signal.SIGTERM
            raise Interrupted
        self._check_disk()
        output = engine.last_output()
        if code == -signal.SIGXFSZ or any(os.strerror(number) in output for number in DISK_FULL):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        errors = re.findall(r"ERROR.*", output)  # LIGGGHTS' table may stand before it on its line
        how = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        raise RunError(
            errors[-1] if errors else f"the engine {how}; read {self.stage}.log in the folder log of the run"
        )
