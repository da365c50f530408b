"""What a run is asked to be: one frozen record for the command line, the calibration and the benchmark."""

from __future__ import annotations

import dataclasses
import os
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from analysis.driver.folder import run_folder
from analysis.files import ROOT
from analysis.scenarios.scenario import SCENARIO_FILE, Scenario, load_scenario

RESULTS = ROOT / "results"


@dataclass(frozen=True)
class RunSettings:
    """One scenario in one code.

    scenario    all parameters
    code        name of the engine
    seed        of the start orientations
    ranks       MPI ranks or threads
    bed         packed bed to start from, instead of packing; None: as the scenario says
    until       stage after which the run pauses; None: to the end
    redo        cycles that no checkpoint leads to any more may be dropped and computed again
    results     folder of all results
    scenarios   the scenario file
    cycles      as the command gave it; None: the scenario's
    lines       progress as a log instead of one renewed line
    """

    scenario: Scenario
    code: str
    seed: int = 1
    ranks: int = 1
    bed: Path | None = None
    until: str | None = None
    redo: bool = False
    results: Path = RESULTS
    scenarios: Path = SCENARIO_FILE
    cycles: int | None = None
    lines: bool = False

    @property
    def folder(self) -> Path:
        """The run's folder."""
        return run_folder(self.results, self.scenario.profile, self.scenario.id, self.code, self.seed)

    @property
    def title(self) -> str:
        """The run as messages call it."""
        seed = f" seed {self.seed}" if self.seed != 1 else ""
        return f"{self.scenario.id} {self.code} {self.scenario.profile}{seed}"

    def with_cycles(self, cycles: int) -> RunSettings:
        """The same run with another number of cycles."""
        s = self.scenario
        scenario = load_scenario(s.id, s.profile, self.scenarios, cycles)
        return dataclasses.replace(self, scenario=scenario, cycles=cycles)

    @property
    def packing_code(self) -> str:
        """The code that packs the bed that packing.bed_from names."""
        return self.scenario["packing.bed_code"] or self.code

    @property
    def bed_name(self) -> str:
        """Where the bed comes from, as run.json has it."""
        if self.bed:
            return relative(self.bed)
        if not (name := self.scenario["packing.bed_from"]):
            return "own"
        return f"../../{run_folder(Path('.'), '', name, self.packing_code, self.seed)}/raw/bed_packed.csv"

    def of_the_bed(self) -> RunSettings:
        """The run that packs the bed that packing.bed_from names."""
        scenario = load_scenario(self.scenario["packing.bed_from"], self.scenario.profile, self.scenarios)
        return dataclasses.replace(self, scenario=scenario, code=self.packing_code, cycles=None, until="packing")

    def command_line(self, name: Callable[[Path], str] | None = None) -> str:
        """The command that does this run again; `name` shortens paths, so that run.json holds no absolute one."""
        name = name or relative
        values = {
            "SCENARIO": self.scenario.name,
            "VARIANT": "+".join(self.scenario.variants) or None,
            "CODE": self.code,
            "PROFILE": self.scenario.profile,
            "CYCLES": self.cycles,
            "SEED": self.seed if self.seed != 1 else None,
            "NP": self.ranks if self.ranks != 1 else None,
            "BED": name(self.bed) if self.bed else None,
            "RESULTS": name(self.results) if self.results != RESULTS else None,
            "SCENARIOS": name(self.scenarios) if self.scenarios != SCENARIO_FILE else None,
        }
        return "make run " + " ".join(
            f"{key}={shlex.quote(str(value))}" for key, value in values.items() if value is not None
        )


def relative(path: Path) -> str:
    """A path as run.json may hold it: relative to the repository, or outside of it the name alone."""
    path = path.resolve()
    return str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else path.name


def from_here(path: Path) -> str:
    """A path relative to where the command was given, as people type it."""
    return os.path.relpath(path)
