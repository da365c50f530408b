"""What a figure is, and the gallery that keeps them alike: one hue for a scenario, one line style for a code.

A figure is a few panels with one caption. Runs of one scenario and code with several seeds become one curve, the
longest of them, with a band.
"""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from analysis.normalised.readers import Run, Runs
from analysis.reference.curves import References
from analysis.report import style
from analysis.report.labels import basis_of, is_reading, is_varied, of_any_bed, short_name
from analysis.report.style import CODE_NAMES, CODE_SIGNS, CODE_STYLES, OTHER_STYLE, Canvas, Panel
from analysis.scenarios.scenario import Scenario, ScenarioError, load_scenario


@dataclass
class Figure:
    """Panels with a caption; `pending` names the reference curves that would be drawn, were they there."""

    name: str
    title: str
    caption: str
    panels: list[Panel]
    runs: list[str] = field(default_factory=list)
    key: list[dict] = field(default_factory=list)
    pending: list[str] = field(default_factory=list)
    layout: str = ""


@dataclass
class Curve:
    """All runs of one scenario and code, one per seed, and how they are drawn."""

    scenario: str
    code: str
    runs: list[Run]
    colour: str
    look: dict
    label: str
    """In full, for hovering."""
    tag: str
    """Short, beside the curve: the code is a sign."""
    family: str

    @property
    def setup(self) -> Scenario | None:
        return self.runs[0].scenario

    @property
    def main(self) -> Run:
        """The longest run, of equals that with the lowest seed."""
        return max(self.runs, key=lambda run: (run.cycles["cycle"].max(), -run.seed))

    def column(self, name: str, table: str = "cycles") -> pd.DataFrame:
        """Mean over the runs against `cycle` as far as all reach, with the lowest and highest of them, SI."""
        together = pd.DataFrame(self.seeds(name, table)).dropna()
        return pd.DataFrame({"value": together.mean(axis=1), "low": together.min(axis=1), "high": together.max(axis=1)})

    def seeds(self, name: str, table: str = "cycles") -> dict[int, pd.Series]:
        """The values of each run against `cycle`, SI, by seed."""
        return {run.seed: getattr(run, table).set_index("cycle")[name].dropna() for run in self.runs}


def family_of(scenario: Scenario | None) -> str:
    """Which hue a scenario gets: bonded, linear, nonlinear (e_n = 1), md0, md1, md2, or other where its parameters are
    unknown.
    """
    if scenario is None:
        return "other"
    if scenario["contact.bond.model"] != "none":
        return "bonded"
    if scenario["contact.model"] == "linear":
        return "linear"
    if scenario["contact.particle_particle.restitution"] == 1:
        return "nonlinear"
    return f"md{scenario['contact.particle_particle.damping_mode']}"


class Gallery:
    """Draws figures into `folder`, with the same look for the same scenario and code throughout."""

    def __init__(
        self,
        folder: Path,
        stamp: str,
        runs: Runs,
        references: References,
        order: Sequence[str],
        problems: list[str] | None = None,
    ):
        """`problems` collects what could not be drawn, one line each."""
        self.folder, self.stamp, self.references = folder, stamp, references
        folder.mkdir(parents=True, exist_ok=True)
        self.figures: list[Figure] = []
        self.problems = [] if problems is None else problems
        self._levels = self._shades(runs, order)

    @staticmethod
    def _shades(runs: Runs, order: Sequence[str]) -> dict[str, tuple[str, float]]:
        """Scenario -> (family, level): members of a family go from pale to deep in the order of the scenario file.

        A reading of the load looks like its scenario, whatever bed it began from; other variants share a family of
        their own, so that they do not crowd the others.
        """
        families: dict[str, list[str]] = {}
        setups = {run.scenario_name: run.scenario for run in runs}
        added = {of_any_bed(name) for name in setups} - set(order)
        for name in [*order, *sorted(name for name in added if not is_reading(name))]:
            if is_varied(name):
                family = "other"
            else:
                family = _family_by_name(name) if setups.get(name) is None else family_of(setups[name])
            families.setdefault(family, []).append(name)
        levels = {}
        for family, names in families.items():
            names = _far_apart(names) if family == "other" else names
            for n, name in enumerate(names):
                levels[name] = (family, 0.0 if len(names) == 1 else -1 + 2 * n / (len(names) - 1))
        return levels

    def complain(self, line: str) -> None:
        """Say once what could not be drawn."""
        if line not in self.problems:
            self.problems.append(line)
            print(f"warning: {line}", file=sys.stderr)

    def look(self, scenario: str) -> tuple[str, str]:
        """(colour, family) of a scenario."""
        known = of_any_bed(scenario)
        known = basis_of(known) if is_reading(known) else known
        family, level = self._levels.get(known, ("other", 0.0))
        return style.shade(family, level), family

    def curves(self, runs: Iterable[Run]) -> list[Curve]:
        """Runs with at least one cycle, gathered by scenario and code."""
        groups: dict[tuple[str, str], list[Run]] = {}
        for run in runs:
            if len(run.cycles):
                groups.setdefault((run.scenario_name, run.code), []).append(run)
        codes = {code for _, code in groups}
        one_reading = all(is_reading(scenario) for scenario, _ in groups)
        found = []
        for (scenario, code), members in groups.items():
            colour, family = self.look(scenario)
            sign = f" {CODE_SIGNS.get(code, '◆')}" if len(codes) > 1 else ""
            alone = (of_any_bed(scenario), code) not in groups
            called = short_name(basis_of(scenario) if one_reading else of_any_bed(scenario) if alone else scenario)
            label = f"{called} {CODE_NAMES.get(code, code)}" + (
                f", mean of {len(members)} beds" if len(members) > 1 else ""
            )
            found.append(
                Curve(
                    scenario,
                    code,
                    members,
                    colour,
                    CODE_STYLES.get(code, OTHER_STYLE),
                    label,
                    called + sign,
                    family,
                )
            )
        rank = {name: n for n, name in enumerate(self._levels)}
        return sorted(found, key=lambda c: (rank.get(c.scenario, rank.get(basis_of(c.scenario), len(rank))), c.code))

    def finish(
        self,
        name: str,
        title: str,
        caption: str,
        drawn: Iterable[Canvas | None],
        runs: Iterable[Run],
        curves: Sequence[Curve] = (),
        pending: Sequence[str] = (),
        layout: str = "",
    ) -> Figure | None:
        """Save the panels and keep the figure; None where nothing was drawn."""
        drawn = [c for c in drawn if c is not None]
        if not drawn:
            return None
        ids = list(dict.fromkeys(run_id(run) for run in runs))
        stamp = self.stamp + ("\n" + _shortened(ids) if ids else "")
        codes = sorted({curve.code for curve in curves} & set(CODE_SIGNS))
        panels = [style.save(c, self.folder, stamp, codes) for c in drawn]
        figure = Figure(name, title, caption, panels, ids, _key(curves), list(pending), layout)
        self.figures.append(figure)
        return figure


def _far_apart(names: Sequence[str]) -> list[str]:
    """Names in an order in which neighbours are half the list apart: variants of one scenario are drawn together."""
    return [*names[::2], *names[1::2]]


def run_id(run: Run) -> str:
    """What a run is, in one word: its folder and the hash of its parameters."""
    known = run.info.get("scenario_hash") or (run.scenario.hash if run.scenario else "unknown")
    return f"{run.id}@{known[:8]}"


def _shortened(ids: list[str], room: int = 230) -> str:
    text = "runs: " + ", ".join(ids)
    if len(text) <= room:
        return "\n".join(textwrap.wrap(text, 118, break_long_words=False, break_on_hyphens=False))
    return f"{len(ids)} runs, listed under the figure in the report"


def _family_by_name(name: str) -> str:
    """The family of a scenario that no run has, by the scenario file."""
    try:
        return family_of(load_scenario(name, "full"))
    except ScenarioError:
        return family_of(None)


def _key(curves: Sequence[Curve]) -> list[dict]:
    """What the line styles mean: one entry per code, where there is more than one."""
    codes = sorted({c.code for c in curves})
    if len(codes) < 2:
        return [{"label": f"all {CODE_NAMES.get(code, code)}", "code": code} for code in codes]
    return [{"label": CODE_NAMES.get(code, code), "code": code} for code in codes]
