"""What is measured: a code with a law and a step on one bed, ready to be timed as often as asked."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Protocol

from analysis.driver.bench.bench_beds import Preloaded, bench_scenario, write_widened
from analysis.driver.bench.meter import Speed, measure
from analysis.driver.bench.stock_deck import StockDeck
from analysis.driver.bench.stock_script import StockScript
from analysis.driver.engine import EngineError
from analysis.driver.engines import ENGINES
from analysis.driver.process import EngineProcess
from analysis.scenarios import derived

SHARES = {"liggghts": 1 / 8, "yade": 1 / 16}
"""Share of a cycle that is timed, of narrow beds more: YADE is the slower one."""
LARGEST_SHARE = 0.9
WHO = ("paper", "verified", "stock")
"""Ours with either step, and the stock deck or script with the paper's."""


class Contender(Protocol):
    """What can be timed on the bed of a case."""

    def prepare(self, case: TimedCase) -> None:
        """Make the files that timing needs, once. Raises EngineError where the engine fails."""

    def argv(self, case: TimedCase) -> list[str]:
        """The command that is timed."""

    def time(self, case: TimedCase) -> Speed:
        """Time it once."""


class Ours:
    """The engine's own stage `cyclic`, from a checkpoint at the end of preload."""

    def prepare(self, case: TimedCase) -> None:
        """Preload the bed."""
        if not case.checkpoint.exists():
            _finish(ENGINES[case.code].command("preload", case.folder), case.folder)

    def argv(self, case: TimedCase) -> list[str]:
        """The command that is timed."""
        return ENGINES[case.code].command("cyclic", case.folder, case.checkpoint, case.ranks)

    def time(self, case: TimedCase) -> Speed:
        """Time it once."""
        return case.timed(self.argv(case), Path("raw") / "cyclic.csv")


STOCK: dict[str, Contender] = {"liggghts": StockDeck(), "yade": StockScript()}


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
    def contender(self) -> Contender:
        """What runs on the bed."""
        return STOCK[self.code] if self.who == "stock" else Ours()

    def prepare(self) -> None:
        """Make all files that timing needs, once: inputs, bed and checkpoint. EngineError where the engine fails."""
        ENGINES[self.code].write_inputs(self.scenario, self.folder, 1)
        self.clumps = write_widened(self.bed.bed, self.scenario, self.width, self.packed)
        self.contender.prepare(self)

    @property
    def packed(self) -> Path:
        """The bed that is loaded."""
        return self.folder / "raw" / "bed_packed.csv"

    def argv(self) -> list[str]:
        """The command that is timed."""
        return self.contender.argv(self)

    def time(self) -> Speed:
        """Time it once."""
        return self.contender.time(self)

    def timed(self, argv: list[str], rows: Path) -> Speed:
        """Steps per second of a command that adds to the file `rows` of the folder while it runs."""
        share = min(LARGEST_SHARE, SHARES[self.code] * max(1.0, 1 / self.width))  # processor time comes in ticks
        steps = int(share * derived.time_grid(self.scenario).steps_per_cycle) - 1
        (self.folder / "raw" / "state.csv").unlink(missing_ok=True)
        threads = ENGINES[self.code].parallel(self.ranks)["threads"]
        return measure(argv, self.folder / "log" / "timed.log", self.folder / rows, steps, threads)


def _finish(argv: list[str], folder: Path) -> None:
    engine = EngineProcess(argv, folder / "log" / "preload.log")
    try:
        while (code := engine.wait(1.0)) is None:
            pass
    finally:
        engine.kill()
    if code:
        raise EngineError(f"{folder.name}: {engine.last_output().strip().splitlines()[-1]}")
