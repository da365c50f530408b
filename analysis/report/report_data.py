"""The runs of a report with everything that belongs to them, and what can be said of a single run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import pandas as pd

from analysis.comparison.claims import verdicts
from analysis.comparison.findings.find import Findings, find
from analysis.comparison.findings.members import TRUE_LOAD, member
from analysis.driver import status
from analysis.files import KEPT_RUNS
from analysis.formats import kept_tables
from analysis.formats.errors import InputError
from analysis.normalised.readers import Run, Runs
from analysis.reference.curves import References
from analysis.report.figure import Gallery
from analysis.report.labels import short_name
from analysis.report.paper import paper
from analysis.report.style import CODE_NAMES
from analysis.scenarios.scenario import ScenarioError, scenario_names
from analysis.scenarios.study_list import key_scenarios


def _named(ask: Callable[[], Sequence[str]]) -> tuple[str, ...]:
    """What the scenario file names; nothing where it cannot be read."""
    try:
        return tuple(ask())
    except ScenarioError:
        return ()


KEY_SCENARIOS = _named(key_scenarios)
"""The linear and the nonlinear one that the paper's discussion rests on."""
PAPER_SCENARIOS = _named(lambda: scenario_names(group="paper"))
CHEN_SCENARIOS = _named(lambda: scenario_names(group="chen2015"))
"""Our own runs of Chen et al.'s model."""


@dataclass
class ReportData:
    """Everything the pages are made of."""

    runs: Runs
    """The runs that are drawn: one for each profile, scenario, code and seed."""
    variants: Runs
    """Runs that serve one comparison (`is_variant`): shown on its page, not among the others."""
    left_out: list[tuple[Run, str]]
    references: References
    gallery: Gallery
    verification: pd.DataFrame
    verification_folder: Path
    problems: list[str]
    results: str
    kept: Path = KEPT_RUNS
    """Where runs and the tables of studies are kept."""
    turnable: str = ""
    """File of the bed that can be turned; empty without."""

    @cached_property
    def findings(self) -> Findings:
        """What the runs say, as tables."""
        found = find([*self.runs, *self.variants], self.references, PAPER_SCENARIOS, self.kept)
        for line in found.problems:
            self.gallery.complain(line)
        return found

    @cached_property
    def verdicts(self) -> list:
        """The paper's claims, judged on the drawn runs."""
        return verdicts.evaluate_claims(self.runs, self.references)

    def of(self, profile: str) -> Runs:
        """Drawn runs of a profile with at least one finished cycle."""
        return Runs(run for run in self.runs if run.profile == profile and len(run.cycles))

    @property
    def profiles(self) -> list[str]:
        """Profiles with a finished cycle; the paper's size first."""
        found = dict.fromkeys(run.profile for run in self.runs if len(run.cycles))
        return sorted(found, key=lambda p: (p != "full", p))


def code_of(run: Run) -> str:
    """Code of a run, and its seed where that is not the default."""
    return CODE_NAMES.get(run.code, run.code) + (f", seed {run.seed}" if run.seed != 1 else "")


def name_of(run: Run) -> str:
    """A run in words."""
    return f"{short_name(run.scenario_name)}, {code_of(run)}"


def bed_of(run: Run) -> str:
    """Where the packed bed came from."""
    bed = str(run.info.get("bed", "–"))
    return f"of {bed.split('/')[2]}" if bed.startswith("../../") else bed


def state_of(run: Run) -> tuple[str, str]:
    """State and reason; what says it is running but belongs to no process was interrupted."""
    state, reason = run.info.get("state", "unknown"), run.info.get("reason") or ""
    if state == "running":
        try:
            state, reason = status.state_of(run.folder, state, reason)
        except (KeyError, TypeError, ValueError, OSError):
            return "interrupted", "its run.json is incomplete"
    return state, reason


def timing(run: Run) -> dict:
    """The part of run.json that differs between equal runs."""
    found = run.info.get("timing")
    return (
        found
        if isinstance(found, dict)
        else {key: run.info.get(key) for key in ("start", "end", "steps_per_second", "host")}
    )


def speed(run: Run) -> float:
    """Steps per second of cyclic loading; nan where it is not known."""
    speeds = timing(run).get("steps_per_second")
    value = speeds.get("cyclic") if isinstance(speeds, dict) else None
    return float(value) if isinstance(value, (int, float)) else float("nan")


def tracking_percent(run: Run) -> float:
    """Worst tracking error of the run, rms over a cycle, % of the maximum stress; nan without values."""
    top = run.scenario["loading.stress_max"] if run.scenario else paper().stress_max_Pa
    values = run.cycles["tracking_rms_Pa"].dropna()
    return 100 * float(values.max()) / top if len(values) else float("nan")


def known_scenarios() -> list[str]:
    """Names in the scenario file; none where it cannot be read."""
    return list(_named(scenario_names))


def is_variant(run: Run) -> bool:
    """True for a run made for one comparison: of a variant other than the reading of the load, or from another code's
    bed.
    """
    return not member(run).plain


def key_runs(data: ReportData, profile: str, reading: str = TRUE_LOAD) -> Runs:
    """Plain runs of the key scenarios in one reading; of all scenarios where no key scenario has one."""
    runs = [run for run in data.of(profile) if member(run).reading == reading]
    return Runs([run for run in runs if run.base_name in KEY_SCENARIOS] or runs)


def verification_rows(folder: Path) -> tuple[pd.DataFrame, list[str]]:
    """verification.csv as a table (no rows where there is none), and a line per problem."""
    path = folder / "verification.csv"
    try:
        rows = pd.DataFrame(kept_tables.read(path, kept_tables.VERIFICATION))
    except InputError as error:
        there = path.exists() or path.is_symlink()
        return pd.DataFrame(columns=list(kept_tables.VERIFICATION.columns)), [str(error)] if there else []
    return rows.assign(passed=rows["passed"].eq("true")), []
