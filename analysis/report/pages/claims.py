"""The paper's claims with their verdicts."""

from __future__ import annotations

from analysis.comparison.claims import evidence
from analysis.report.report_data import ReportData
from analysis.report.style import CODE_NAMES
from analysis.report.tables import Chip, Column, Table

VERDICT_KIND = {evidence.HOLDS: "good", evidence.FAILS: "bad", evidence.OPEN: "open"}


def claims_page(data: ReportData) -> dict:
    """Every claim with its verdict per code, the numbers, and what is missing."""
    grouped: dict[int, list] = {}
    for v in data.verdicts:
        grouped.setdefault(v.claim.number, []).append(v)
    codes = list(dict.fromkeys(v.code for v in data.verdicts))
    summary = Table("Verdicts per code", [Column("claim"), *(Column(CODE_NAMES.get(code, code)) for code in codes)])
    entries = []
    for n, members in sorted(grouped.items()):
        claim = members[0].claim
        summary.rows.append([f"{n}. {claim.sentence}", *(Chip(v.verdict, VERDICT_KIND[v.verdict]) for v in members)])
        table = Table(
            "",
            [
                Column("code"),
                Column("part of the claim", wide=True),
                Column("verdict"),
                Column("numbers", wide=True),
                Column("missing", wide=True),
            ],
        )
        for v in members:
            for check in v.checks:
                table.rows.append(
                    [
                        CODE_NAMES.get(v.code, v.code),
                        check.what,
                        Chip(check.verdict, VERDICT_KIND[check.verdict]),
                        check.numbers.replace("+-", "±") or "–",
                        "; ".join(check.missing) or "–",
                    ]
                )
        bases = "; ".join(dict.fromkeys(f"{CODE_NAMES.get(v.code, v.code)}: {v.uncertainty}" for v in members))
        notes = list(dict.fromkeys(note for v in members for note in v.notes))
        table.note = f"Uncertainty: {bases}." + (
            " Runs used: " + ", ".join(dict.fromkeys(r for v in members for r in v.runs)) + "."
            if any(v.runs for v in members)
            else ""
        )
        entries.append(
            {
                "id": n,
                "title": claim.sentence,
                "where": f"{claim.where}. {claim.quantity}",
                "criterion": claim.criterion,
                "table": table,
                "notes": notes,
            }
        )
    return {"summary": summary, "claims": entries}
