"""What is measured: a code with a law and a step on one bed, ready to be timed as often as asked."""

from __future__ import annotations

import os
import re
import subprocess
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from analysis.driver.bench import stock_deck
from analysis.driver.bench.bench_beds import Preloaded, bench_scenario, write_widened
from analysis.driver.bench.meter import Speed, measure
from analysis.driver.engine import EngineError
from analysis.driver.engines import ENGINES
from analysis.driver.process import EngineProcess
from analysis.files import ROOT
from analysis.scenarios import derived

SHARES = {"liggghts": 1 / 8, "yade": 1 / 16}
"""Share of a cycle that is timed, of narrow beds more: YADE is the slower one."""
LARGEST_SHARE = 0.9
STOCK_STEPS = 400
"""Steps of the stock YADE script, which times itself."""
WHO = ("paper", "verified", "stock")
"""Ours with either step, and the stock deck or script with the paper's."""
STOCK_SCRIPT = "yade/stock.py"
STOCK_PRINTS = re.compile(r"(\d+) steps, ([\d.]+) s of processor time")


@dataclass
class TimedCase:
    """One thing to time."""

    code: str
    name: str
    """Of the scenario."""
    who: str
    """One of WHO."""
    bed: Preloaded
    work: Path
    profile: str = "full"
    width: float = 1.0
    ranks: int = 1
    clumps: int = field(default=0, init=False)

    @cached_property
    def scenario(self):
        """What the engine is told; the folder of work holds it."""
        self.folder.mkdir(parents=True, exist_ok=True)
        variant = "" if self.who == "verified" else "paper-step"
        return bench_scenario(self.name, variant, self.bed, self.width, self.folder, self.profile)

    @property
    def folder(self) -> Path:
        """Of its files."""
        return self.work / f"{self.code}-{self.name}-{self.who}-{self.width:g}"

    @property
    def law(self) -> str:
        """Contact law between particles, as in the tables: linear | nonlinear."""
        return "linear" if self.scenario["contact.model"] == "linear" else "nonlinear"

    @property
    def checkpoint(self) -> Path:
        """From which the engine starts."""
        return self.folder / "checkpoints" / f"cyclic_000000.{ENGINES[self.code].checkpoint_suffix}"

    @property
    def _stock_is_a_deck(self) -> bool:
        """Stock LIGGGHTS reads a deck that is written for the case; stock YADE runs a script, which times itself."""
        return self.code == stock_deck.CODE

    def prepare(self) -> None:
        """Make all files that timing needs, once: inputs, bed and checkpoint. EngineError where the engine fails."""
        ENGINES[self.code].write_inputs(self.scenario, self.folder, 1)
        packed = self.folder / "raw" / "bed_packed.csv"
        self.clumps = write_widened(self.bed.bed, self.scenario, self.width, packed)
        if self.who == "stock":
            if self._stock_is_a_deck:
                stock_deck.write_case(self.scenario, self.bed, self.folder)
        elif not self.checkpoint.exists():
            self._finish(ENGINES[self.code].command("preload", self.folder))

    def _finish(self, argv: list[str]) -> None:
        engine = EngineProcess(argv, self.folder / "log" / "preload.log")
        try:
            while (code := engine.wait(1.0)) is None:
                pass
        finally:
            engine.kill()
        if code:
            raise EngineError(f"{self.folder.name}: {engine.last_output().strip().splitlines()[-1]}")

    def argv(self) -> list[str]:
        """The command that is timed."""
        if self.who != "stock":
            return ENGINES[self.code].command("cyclic", self.folder, self.checkpoint, self.ranks)
        if self._stock_is_a_deck:
            return stock_deck.command(self.scenario, self.folder)
        packed = self.folder / "raw" / "bed_packed.csv"
        steps = str(STOCK_STEPS)
        return ["yade", f"-j{self.ranks}", "-n", "-x", STOCK_SCRIPT, str(self.folder), str(packed), steps]

    def time(self) -> Speed:
        """Time it once."""
        if self.who == "stock" and not self._stock_is_a_deck:
            return self._own_timing()
        rows = self.folder / (stock_deck.ROWS if self.who == "stock" else Path("raw") / "cyclic.csv")
        share = min(LARGEST_SHARE, SHARES[self.code] * max(1.0, 1 / self.width))  # processor time comes in ticks
        steps = int(share * derived.time_grid(self.scenario).steps_per_cycle) - 1
        (self.folder / "raw" / "state.csv").unlink(missing_ok=True)
        threads = ENGINES[self.code].parallel(self.ranks)["threads"]
        return measure(self.argv(), self.folder / "log" / "timed.log", rows, steps, threads)

    def _own_timing(self) -> Speed:
        modules = os.environ | {"PYTHONPATH": str(ROOT)}
        done = subprocess.run(self.argv(), cwd=ROOT, env=modules, capture_output=True, text=True)
        found = STOCK_PRINTS.search(done.stdout)
        if done.returncode or not found:
            raise EngineError(f"{STOCK_SCRIPT}: {(done.stdout + done.stderr).strip().splitlines()[-1]}")
        return Speed(int(found[1]), float(found[2]), float("nan"))
