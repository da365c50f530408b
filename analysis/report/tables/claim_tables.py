"""The paper's claims: what the reading of the load decides, and the parts of each claim."""

from __future__ import annotations

import pandas as pd

from analysis.comparison.claims import evidence
from analysis.comparison.claims.verdicts import Verdict, to_frame
from analysis.report.labels import READING_NAMES, with_labels
from analysis.report.report_data import known_scenarios
from analysis.report.sentences import symbols
from analysis.report.style import CODE_NAMES
from analysis.report.tables.table_html import Chip, Shown, Table, frame_table

VERDICT_KIND = {evidence.HOLDS: "good", evidence.FAILS: "bad"}


def where_of(verdict) -> str:
    """Code and reading of a verdict, in words."""
    return f"{CODE_NAMES.get(verdict.code, verdict.code)}, {READING_NAMES[verdict.reading]}"


def chip_of(verdict: str) -> Chip:
    """A verdict as a coloured word: grey where nothing is decided."""
    return Chip(verdict, VERDICT_KIND.get(verdict, "calm"))


def labelled(text: str) -> str:
    """A text with scenarios by their labels, and signs as they are printed."""
    return with_labels(text, known_scenarios()).replace("+-", "±").replace("->", "→")


def verdicts_of(found: list) -> list[tuple[Chip, str]]:
    """Each verdict with the codes and readings that have it, what is decided first."""
    places: dict[str, list[str]] = {}
    for v in sorted(found, key=lambda v: v.verdict not in VERDICT_KIND):
        places.setdefault(v.verdict, []).append(where_of(v))
    everywhere = len(places) == 1 and len(found) == len(CODE_NAMES) * len(READING_NAMES)
    return [
        (chip_of(verdict), "in both codes, under either load" if everywhere else "; ".join(where))
        for verdict, where in places.items()
    ]


NAMED = 2
"""Scenarios without a run that the line of a card names; of more it says how many."""


def missing_line(found: list) -> str:
    """What the first verdict that is not decided lacks, and of how many more; empty where all are decided."""
    lacking = [(v, what) for v in found for what in v.missing]
    if not lacking:
        return ""
    verdict, what = lacking[0]
    names = what.removeprefix(evidence.RUN).split(evidence.AND) if what.startswith(evidence.RUN) else []
    text = f"full-size runs of {len(names)} scenarios" if len(names) > NAMED else labelled(what)
    more = len(lacking) - 1
    return f"Missing in {where_of(verdict)}: {text}{f'; and {more} more, see the evidence' if more else ''}."


def readings_table(readings: pd.DataFrame) -> Table | None:
    """Which claims the reading of the load decides, by code.

    readings   `compare_readings` of the verdicts
    """
    return frame_table(
        readings[(readings["outcome"] != "") & (readings["part"] == "")],
        "What the reading of the load decides",
        [
            Shown("number", text=lambda row: f"{row.number}. {symbols(row.claim)}", number=False),
            "code",
            Shown("true_load", text=lambda row: chip_of(row.true_load), number=False),
            Shown("servo", text=lambda row: chip_of(row.servo), number=False),
            Shown("outcome", number=False),
        ],
    )


def parts_table(found: list[Verdict]) -> Table | None:
    """The parts of one claim in each code and reading, with their verdicts and numbers."""
    bases = "; ".join(dict.fromkeys(f"{where_of(v)}: {v.uncertainty}" for v in found if any(v.runs)))
    runs = dict.fromkeys(run for v in found for run in v.runs)
    return frame_table(
        to_frame(found),
        f"Parts of claim {found[0].claim.number}",
        [
            Shown("reading", "code and load", text=where_of, number=False),
            Shown("check", text=lambda row: labelled(row.check), number=False, wide=True),
            Shown("check_verdict", text=lambda row: chip_of(row.check_verdict), number=False),
            Shown("numbers", text=lambda row: labelled(row.numbers or "–"), number=False, wide=True),
        ],
        f"Uncertainty: {bases}. Runs used: {', '.join(runs)}." if runs else "",
    )
