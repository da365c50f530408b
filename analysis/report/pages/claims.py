"""The paper's claims: a card for each, with a verdict per code and reading."""

from __future__ import annotations

from analysis.comparison.claims import evidence
from analysis.comparison.claims.verdicts import compare_readings
from analysis.report.labels import READING_NAMES, with_labels
from analysis.report.report_data import ReportData, known_scenarios
from analysis.report.sentences import symbols
from analysis.report.style import CODE_NAMES
from analysis.report.tables.base import Chip, Column, Table

VERDICT_KIND = {evidence.HOLDS: "good", evidence.FAILS: "bad"}


def claims_page(data: ReportData) -> dict:
    """Every claim with its verdicts in short, and folded away what they rest on."""
    grouped: dict[int, list] = {}
    for v in data.verdicts:
        grouped.setdefault(v.claim.number, []).append(v)
    return {
        "claims": [card(n, found) for n, found in sorted(grouped.items()) if found[0].claim.about == evidence.PAPER],
        "others": [card(n, found) for n, found in sorted(grouped.items()) if found[0].claim.about != evidence.PAPER],
        "readings": readings_table(data.verdicts),
    }


def where_of(verdict) -> str:
    """Code and reading of a verdict, in words."""
    return f"{CODE_NAMES.get(verdict.code, verdict.code)}, {READING_NAMES[verdict.reading]}"


def chip_of(verdict: str) -> Chip:
    """A verdict as a coloured word: grey where nothing is decided."""
    return Chip(verdict, VERDICT_KIND.get(verdict, "calm"))


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


def readings_table(found: list) -> Table | None:
    """Which claims the reading of the load decides, by code."""
    rows = compare_readings(found)
    rows = rows[(rows["outcome"] != "") & (rows["part"] == "")]
    table = Table(
        "What the reading of the load decides",
        [Column("claim"), Column("code"), Column("true load"), Column("PFC's servo"), Column("the claim holds")],
    )
    for r in rows.itertuples():
        title = f"{r.number}. {symbols(r.claim)}"
        table.rows.append([title, CODE_NAMES[r.code], chip_of(r.true_load), chip_of(r.servo), r.outcome])
    return table if table.rows else None


def labelled(text: str) -> str:
    """A text with scenarios by their labels, and signs as they are printed."""
    return with_labels(text, known_scenarios()).replace("+-", "±").replace("->", "→")


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


def card(number: int, found: list) -> dict:
    """One claim: sentence, verdicts, criterion, and the parts that decide it."""
    claim = found[0].claim
    table = Table(
        f"Parts of claim {number}",
        [
            Column("code and load"),
            Column("part of the claim", wide=True),
            Column("verdict"),
            Column("numbers", wide=True),
        ],
    )
    for v in found:
        for check in v.checks:
            numbers = check.numbers or "–"
            table.rows.append([where_of(v), labelled(check.what), chip_of(check.verdict), labelled(numbers)])
    bases = "; ".join(dict.fromkeys(f"{where_of(v)}: {v.uncertainty}" for v in found if any(v.runs)))
    runs = dict.fromkeys(run for v in found for run in v.runs)
    table.note = f"Uncertainty: {bases}. Runs used: {', '.join(runs)}." if runs else ""
    return {
        "id": number,
        "title": claim.sentence,
        "verdicts": verdicts_of(found),
        "criterion": labelled(f"{claim.where}. {claim.quantity} {claim.criterion}"),
        "because": [
            labelled(line) for line in dict.fromkeys(f"{where_of(v)}: {v.because}" for v in found if v.because)
        ],
        "missing": missing_line(found),
        "table": table,
        "notes": [labelled(note) for note in dict.fromkeys(note for v in found for note in v.notes)],
    }
