"""`make torture`: runs that are killed and stopped at random moments end with the files of one that nobody disturbed.

    .venv/bin/python tests/torture.py --times 25            # both codes, both laws, the demo bed: an hour
    .venv/bin/python tests/torture.py --code yade --scenario linear-mu0.8 --seed 7

A disturbance is a signal (KILL, TERM, INT, HUP, or STOP and later CONT) to the driver, to its engine, or to both at
once. After each one the same command is given again. `make test` does a few of them on a smaller bed.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from driver import REAL, copy_run, drive, engines_of, results_of, run_folder, start, wait_until
from small_bed import write_scenarios

from analysis.driver.engines import CODES
from analysis.scenarios.study_list import key_scenarios

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGSTOP)
TARGETS = ("driver", "engine", "group")
ENDING_S = 1800
"""Real time that a driver may take to end after a signal: the longest block of a demo bed on a very busy machine."""


class Tormentor:
    """Disturbs runs of one kind at random moments.

    driver, arguments   the command, as tests/driver.py starts it
    folder              the run's folder
    expected            folder of the undisturbed run
    longest_s           the longest time (s) from the first output of a start to the disturbance
    """

    def __init__(self, driver, arguments: list, folder: Path, expected: Path, moments: random.Random, longest_s: float):
        self.driver, self.arguments, self.folder, self.expected = driver, arguments, folder, expected
        self.moments, self.longest_s, self.done = moments, longest_s, Counter()

    def until_done(self, most: int) -> None:
        """Disturb the run at most `most` times, then let it end; each time on, a little later, so that it does end."""
        for _ in range(most):
            if not self._start_and_disturb():
                break
            self.longest_s *= 1.05
        else:
            last = drive(self.driver, *self.arguments, limit_s=None)
            assert last.returncode == 0, last.stdout + last.stderr
        assert results_of(self.folder) == results_of(self.expected), self.report()

    def report(self) -> str:
        """What was done, e.g. `3 KILL to engine, 1 STOP to driver`."""
        return ", ".join(f"{n} {what}" for what, n in sorted(self.done.items()))

    def _start_and_disturb(self) -> bool:
        """Start the run, disturb it once; False where it ended before that."""
        before = self._written()
        process = start(self.driver, *self.arguments)
        end = time.monotonic() + ENDING_S
        while process.poll() is None and (self._written() == before or not engines_of(self.folder)):
            assert time.monotonic() < end, "the engine writes nothing"
            time.sleep(0.02)
        try:
            out, err = process.communicate(timeout=self.moments.uniform(0, self.longest_s))
        except subprocess.TimeoutExpired:
            number, target = self.moments.choice(SIGNALS), self.moments.choice(TARGETS)
            self.done[f"{number.name.removeprefix('SIG')} to {target}"] += 1
            self._send(process, number, target)
            if number != signal.SIGSTOP:
                out, err = self._end(process)
                wait_until(lambda: not engines_of(self.folder), "the engine lives on", seconds=120)
                assert process.returncode != 0 or self._is_finished(), out + err
                self._check_rows()
                return True
            out, err = self._end(process, ENDING_S * 10)
            assert process.returncode == 0, out + err  # nothing but time has passed
            return True
        assert process.returncode == 0, out + err
        return False

    def _end(self, process: subprocess.Popen, limit_s: float = ENDING_S) -> tuple[str, str]:
        """What the driver printed until it ended; one that hangs is killed, and says after which disturbance."""
        try:
            return process.communicate(timeout=limit_s)
        except subprocess.TimeoutExpired:
            alive = engines_of(self.folder)
            for pid in (process.pid, *alive):
                _kill(pid, signal.SIGKILL)
            raise AssertionError(f"no end {limit_s} s after {self.report()}; engines alive: {len(alive)}") from None

    def _send(self, process: subprocess.Popen, number: signal.Signals, target: str) -> None:
        pids = [process.pid] if target != "engine" else []
        pids += engines_of(self.folder) if target != "driver" else []
        for pid in pids:
            _kill(pid, number)
        if number == signal.SIGSTOP:
            time.sleep(self.moments.uniform(0.1, 2.0))
            for pid in pids:
                _kill(pid, signal.SIGCONT)

    def _written(self) -> int:
        state = self.folder / "raw" / "state.csv"
        return state.stat().st_size if state.exists() else 0

    def _is_finished(self) -> bool:
        return (self.folder / "bed_after.csv").exists()

    def _check_rows(self) -> None:
        """Whatever stands in cycles.csv is what the undisturbed run has there."""
        rows = self.folder / "cycles.csv"
        if rows.exists():
            whole = rows.read_bytes().rpartition(b"\n")[0]
            assert (self.expected / "cycles.csv").read_bytes().startswith(whole), self.report()


def _kill(pid: int, number: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, number)


def torment(code: str, scenario: str, options: argparse.Namespace, work: Path) -> str:
    """Disturb runs of a scenario in a code until there were enough disturbances; return what was done."""
    common = [scenario, "--code", code, "--profile", options.profile, "--cycles", options.cycles]
    if options.small:
        common += ["--scenarios", write_scenarios(work / "scenarios.toml")]
    base, calm = work / "preloaded", work / "calm"
    for results, until in ((base, ["--until", "preload"]), (calm, [])):
        target = run_folder(results, scenario, code, options.profile)
        if until == [] and not target.exists():
            copy_run(run_folder(base, scenario, code, options.profile), target)
        done = drive(REAL, *common, "--results", results, *until, limit_s=None)
        assert done.returncode == 0, done.stdout + done.stderr
    expected = run_folder(calm, scenario, code, options.profile)
    moments, done = random.Random(f"{options.seed} {code} {scenario}"), Counter()
    longest_s = options.longest or _seconds_per_cycle(expected) * 1.5
    while done.total() < options.times:
        disturbed = work / "disturbed"
        folder = run_folder(disturbed, scenario, code, options.profile)
        shutil.rmtree(folder, ignore_errors=True)
        copy_run(run_folder(base, scenario, code, options.profile), folder)
        tormentor = Tormentor(REAL, [*common, "--results", disturbed], folder, expected, moments, longest_s)
        tormentor.until_done(options.times - done.total())
        done += tormentor.done
        print(f"{scenario} {code}: {tormentor.report() or 'ended before it was disturbed'}: same files", flush=True)
    return f"{done.total()} disturbances ({', '.join(f'{n} {what}' for what, n in sorted(done.items()))}): same files"


def _seconds_per_cycle(folder: Path) -> float:
    body = json.loads((folder / "run.json").read_text())
    return body["timing"]["wall_s"]["cyclic"] / len((folder / "cycles.csv").read_text().splitlines()[1:])


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--code", choices=CODES, action="append", help="only this code")
    parser.add_argument("--scenario", action="append", help="only this scenario")
    parser.add_argument("--profile", default="demo")
    parser.add_argument(
        "--small", action="store_true", help="the small bed of the other tests: minutes instead of an hour"
    )
    parser.add_argument("--cycles", type=int, default=3)
    parser.add_argument("--times", type=int, default=25, help="disturbances per code and scenario (default 25)")
    parser.add_argument("--seed", default="1", help="of the random moments, signals and targets")
    parser.add_argument(
        "--longest", type=float, help="s from first output to disturbance; default one and a half cycles"
    )
    parser.add_argument("--work", type=Path, help="folder for the runs, kept; default a temporary one")
    options = parser.parse_args()
    failed = 0
    with tempfile.TemporaryDirectory(prefix="torture-") as temporary:
        work = (options.work or Path(temporary)).resolve()
        work.mkdir(parents=True, exist_ok=True)
        for scenario in options.scenario or key_scenarios():
            for code in options.code or CODES:
                try:
                    said = torment(code, scenario, options, work)
                except AssertionError as error:
                    said, failed = f"FAILED: {error}", 1
                print(f"{scenario} {code}: {said}", flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(main())
