"""What the demo says: each run's settlement, how far the two codes differ, and the full bed beside it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from analysis.comparison.findings.find import Findings
from analysis.comparison.findings.members import READINGS, SAME_BED_VARIANT, Member
from analysis.comparison.quantities import last_cycle
from analysis.formats.quantities import CODES
from analysis.report.answer import only
from analysis.report.labels import READING_NAMES, short_name
from analysis.report.sentences import lines
from analysis.report.tables import Column, Table, number, quantity_name

PROFILE = "demo"
AIM_RATIO = 0.15
"""Assumed: two codes that load one bed by the same equations settle alike to within this share of their mean."""


@dataclass(frozen=True)
class Outcome:
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


def of_the_demo(members: Iterable[Member]) -> list[Member]:
    """Runs of the demo, also of a bed that both codes load; none with anything else changed."""
    return [m for m in members if m.run.profile == PROFILE and not set(m.others) - {SAME_BED_VARIANT}]


def outcomes(found: Findings) -> list[Outcome]:
    """What each scenario and reading of the demo came to; of several runs of a code the one that shares its bed."""
    members, made = of_the_demo(found.members), []
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
            full = only(
                found.values,
                profile="full",
                scenario=scenario,
                reading=reading,
                code="liggghts",
                quantity="settlement_m",
                cycle=cycle,
            )["mean"]
            beds = {m.bed for m in chosen.values()}
            made.append(
                Outcome(
                    scenario,
                    reading,
                    cycle,
                    {
                        code: float(chosen[code].run.cycles.set_index("cycle").at[cycle, "settlement_m"])
                        for code in CODES
                        if code in chosen
                    },
                    len(chosen) == len(CODES) and len(beds) == 1 and "" not in beds,
                    float(full.iloc[0]) if len(full) else math.nan,
                )
            )
    return made


def summary(found: Findings, page: str) -> list[str]:
    """The lines that `make demo` ends with; `page` is the report's first page."""
    return lines("demo.txt", outcomes=outcomes(found), aim=AIM_RATIO, page=page)


def outcome_table(made: Iterable[Outcome]) -> Table | None:
    """Settlement of both codes from one bed, and of the full bed, after the same cycle."""
    label, factor, _ = quantity_name("settlement_m", "m")
    table = Table(
        "Both codes on the demo bed, and LIGGGHTS on the full bed, after the same cycle",
        [
            Column("scenario"),
            Column("load"),
            Column("cycle", True),
            Column(f"{label}: LIGGGHTS", True),
            Column("YADE", True),
            Column("difference, %", True),
            Column("full bed", True),
        ],
    )
    for o in made:
        table.rows.append(
            [
                short_name(o.scenario),
                READING_NAMES[o.reading],
                str(o.cycle),
                *(number(o.settlement_m.get(code, math.nan), 3, factor) for code in ("liggghts", "yade")),
                number(o.difference_ratio, 2, 100),
                number(o.full_m, 3, factor),
            ]
        )
    table.note = "Difference: LIGGGHTS minus YADE over the mean of both."
    return table if table.rows else None
