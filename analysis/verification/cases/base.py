"""What every case of the verification has: a name, a title, and a judgement of what the engine gave."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import ClassVar

from analysis.verification.engine_laws import ENGINE_LAWS
from analysis.verification.probes import Probe, Trajectory
from analysis.verification.results import Results


class Case(ABC):
    """A case; the class itself says what it is called, so that no case must be made to list them."""

    name: ClassVar[str]
    title: ClassVar[str]


class ProbedCase(Case):
    """A case of probes that are run in one engine.

    engine -- what to expect of that engine's laws
    """

    def __init__(self, code: str):
        self.engine = ENGINE_LAWS[code]

    @abstractmethod
    def probes(self) -> list[Probe]:
        """What is run."""

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
