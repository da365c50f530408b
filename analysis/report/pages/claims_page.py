"""The paper's claims: a card for each, with a verdict per code and reading."""

from __future__ import annotations

from analysis.comparison.claims import evidence
from analysis.report.report_data import ReportData
from analysis.report.tables.claim_tables import (
    labelled,
    missing_line,
    parts_table,
    readings_table,
    verdicts_of,
    where_of,
)


def claims_page(data: ReportData) -> dict:
    """Every claim with its verdicts in short, and folded away what they rest on."""
    grouped: dict[int, list] = {}
    for v in data.verdicts:
        grouped.setdefault(v.claim.number, []).append(v)
    cards: dict[str, list[dict]] = {}
    for n, found in sorted(grouped.items()):
        cards.setdefault(found[0].claim.about, []).append(card(n, found))
    return {
        "claims": cards.pop(evidence.PAPER, []),
        "others": cards.pop(evidence.CHEN, []),
        "own": [one for rest in cards.values() for one in rest],
        "readings": readings_table(data.findings.readings),
    }


def card(number: int, found: list) -> dict:
    """One claim: sentence, verdicts, criterion, and the parts that decide it."""
    claim = found[0].claim
    return {
        "id": number,
        "title": claim.sentence,
        "verdicts": verdicts_of(found),
        "criterion": labelled(f"{claim.where}. {claim.quantity} {claim.criterion}"),
        "because": [
            labelled(line) for line in dict.fromkeys(f"{where_of(v)}: {v.because}" for v in found if v.because)
        ],
        "missing": missing_line(found),
        "table": parts_table(found),
        "notes": [labelled(note) for note in dict.fromkeys(note for v in found for note in v.notes)],
    }
