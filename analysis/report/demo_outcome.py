"""What the demo says: each run's settlement, how far the two codes differ, and the full bed beside it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from analysis.comparison.findings.find import Findings
from analysis.comparison.findings.members import READINGS, SAME_BED_VARIANT, Member
from analysis.comparison.run_quantities import last_cycle, lateral_mean
from analysis.formats.quantities import CODES
from analysis.report.sentences import lines

PROFILE = "demo"
AIM_RATIO = 0.15
"""Assumed: two codes that load one bed by the same equations settle alike to within this share of their mean."""

ALIKE_FACTOR = 2.0
"""Assumed: so near to the full bed's settlement the demo bed's is meant to be."""


@dataclass(frozen=True)
class DemoOutcome:
    """A scenario in one reading: settlement by code after the cycle that all its runs have reached, SI units."""

    scenario: str
    reading: str
    cycle: int
    settlement_m: dict[str, float]
    one_bed: bool
    """Both codes loaded one packed bed."""
    full_m: float
    """Of the full bed after that cycle: LIGGGHTS, mean over its packed beds; nan without a run."""

    @property
    def difference_ratio(self) -> float:
        """LIGGGHTS minus YADE over their mean; nan with one code only."""
        if set(self.settlement_m) != set(CODES):
            return math.nan
        one, other = self.settlement_m["liggghts"], self.settlement_m["yade"]
        return 2 * (one - other) / (one + other) if one + other else math.nan


@dataclass(frozen=True)
class Beside:
    """LIGGGHTS on the demo bed and on the full bed after one cycle: settlement (m) of each packed bed."""

    scenario: str
    reading: str
    cycle: int
    demo_m: tuple[float, ...]
    full_m: tuple[float, ...]
    demo_plates_m: float
    """Mean way of the five plates outward, over the packed beds."""
    full_plates_m: float

    @property
    def ratio(self) -> float:
        """Mean of the demo beds over that of the full beds."""
        return (sum(self.demo_m) / len(self.demo_m)) / (sum(self.full_m) / len(self.full_m))

    @property
    def alike(self) -> bool:
        """Within the aim: neither more than `ALIKE_FACTOR` times the full bed's nor less than its inverse."""
        return 1 / ALIKE_FACTOR <= self.ratio <= ALIKE_FACTOR


def beside_full(members: Iterable[Member]) -> list[Beside]:
    """Each cycle of the demo that full beds have reached too, by scenario and reading."""
    runs: dict[tuple[str, str], dict[str, list[pd.DataFrame]]] = {}
    for m in members:
        if m.plain and m.run.code == "liggghts" and len(m.run.cycles):
            profiles = runs.setdefault((m.scenario, m.reading), {})
            cycles = m.run.cycles.assign(lateral_mean_m=lateral_mean(m.run.cycles)).set_index("cycle")
            profiles.setdefault(m.run.profile, []).append(cycles)
    made = []
    for (scenario, reading), profiles in runs.items():
        demo, full = profiles.get(PROFILE, []), profiles.get("full", [])
        for cycle in sorted({n for table in demo for n in table.index} & {n for table in full for n in table.index}):
            beds = [[table.loc[cycle] for table in tables if cycle in table.index] for tables in (demo, full)]
            settled = (tuple(float(row["settlement_m"]) for row in rows) for rows in beds)
            plates = (float(np.mean([row["lateral_mean_m"] for row in rows])) for rows in beds)
            made.append(Beside(scenario, reading, int(cycle), *settled, *plates))
    return made


def of_the_demo(members: Iterable[Member]) -> list[Member]:
    """Runs of the demo, also of a bed that both codes load; none with anything else changed."""
    return [m for m in members if m.run.profile == PROFILE and not set(m.others) - {SAME_BED_VARIANT}]


def outcomes(found: Findings) -> list[DemoOutcome]:
    """What each scenario and reading of the demo came to; of several runs of a code the one that shares its bed."""
    members, made = of_the_demo(found.members), []
    beside = {(b.scenario, b.reading, b.cycle): b.full_m for b in beside_full(found.members)}
    for scenario in dict.fromkeys(m.scenario for m in members):
        for reading in READINGS:
            chosen: dict[str, Member] = {}
            for m in members:
                here = (m.scenario, m.reading, m.run.seed) == (scenario, reading, 1)
                if here and (m.run.code not in chosen or SAME_BED_VARIANT in m.variants):
                    chosen[m.run.code] = m
            if not chosen:
                continue
            cycle = min(last_cycle(m.run) for m in chosen.values())
            full = beside.get((scenario, reading, cycle), ())
            beds = {m.bed for m in chosen.values()}
            made.append(
                DemoOutcome(
                    scenario,
                    reading,
                    cycle,
                    {
                        code: float(chosen[code].run.cycles.set_index("cycle").at[cycle, "settlement_m"])
                        for code in CODES
                        if code in chosen
                    },
                    len(chosen) == len(CODES) and len(beds) == 1 and "" not in beds,
                    float(np.mean(full)) if full else math.nan,
                )
            )
    return made


def summary(found: Findings, page: str) -> list[str]:
    """The lines that `make demo` ends with; `page` is the report's first page."""
    return lines("demo.txt", outcomes=outcomes(found), aim=AIM_RATIO, page=page)
