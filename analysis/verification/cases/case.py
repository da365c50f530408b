"""What every case of the verification has: a name, a title, and a judgement of what the engine gave."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from analysis.verification.case_sketch import Sketch, sketch_of
from analysis.verification.engine_laws import ENGINE_LAWS
from analysis.verification.probes import Probe, Trajectory
from analysis.verification.results import Results


@dataclass(frozen=True)
class Account:
    """What a reader of the report is told of a case."""

    happens: str
    """What is done, in a sentence."""
    formula: str
    """What must come out."""
    source: str
    """Where the formula is from."""
    tolerance: str
    """How far a result may be off, and why so far."""
    curve: tuple[str, str] | None = None
    """Series and column of the curve that is drawn; None for a case without curves."""
    pictured: int = 0
    """Which of the probes the sketch shows."""


class Case(ABC):
    """A case; the class itself says what it is called, so that no case must be made to list them."""

    name: ClassVar[str]
    title: ClassVar[str]
    account: ClassVar[Account]

    @classmethod
    @abstractmethod
    def sketch(cls) -> Sketch:
        """What lies where at the start, for a drawing."""


class ProbedCase(Case):
    """A case of probes that are run in one engine.

    engine -- what to expect of that engine's laws
    """

    def __init__(self, code: str):
        self.engine = ENGINE_LAWS[code]

    @abstractmethod
    def probes(self) -> list[Probe]:
        """What is run."""

    @classmethod
    def sketch(cls) -> Sketch:
        """Of the probe that the account names; it lies the same in every engine."""
        return sketch_of(cls(next(iter(ENGINE_LAWS))).probes()[cls.account.pictured])

    @abstractmethod
    def judge(self, found: dict[str, Trajectory], results: Results) -> None:
        """Add rows and curves for the trajectories, which have the names of their probes."""


class StagedCase(Case):
    """A case that runs the stages of a full run in one engine, that of `code`."""

    def __init__(self, code: str):
        self.code = code

    @abstractmethod
    def run(self, folder: Path, workers: int) -> None:
        """Run it below `folder`, at most `workers` runs at a time. Raises EngineFailure."""

    @abstractmethod
    def judge(self, folder: Path, results: Results) -> None:
        """Add rows and curves for what lies in `folder`."""


class OwnCase(Case):
    """A case that needs no engine."""

    @abstractmethod
    def judge(self, results: Results) -> None:
        """Add its rows."""
