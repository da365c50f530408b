"""The result of the verification: a figure and a table per case."""

from __future__ import annotations

import pandas as pd

from analysis.files import KEPT_VERIFICATION
from analysis.report.figures.verification import case_figure
from analysis.report.report_data import ReportData
from analysis.report.style import CODE_NAMES
from analysis.report.tables.base import Chip, Column, Link, Table, number
from analysis.verification.verify import CASES

OWN_LAW = r"YADE has no|YADE counts|YADE's own|its own oracle|its own expected value"
"""What the reason of a comparison says where YADE is held to a law of its own instead of the paper's."""


KNOWN = {case.name: case for case in CASES}


def verification(data: ReportData) -> dict:
    """The result of `make verify`: a figure and a table per case; what is tested against the paper's law counts apart
    from what is tested against YADE's own.
    """
    rows = data.verification
    own = (rows["code"] == "yade") & rows["reason"].astype(str).str.contains(OWN_LAW)
    columns = {
        "LIGGGHTS, the paper's law": rows[rows["code"] == "liggghts"],
        "YADE, the paper's law": rows[(rows["code"] == "yade") & ~own],
        "YADE, its own law": rows[own],
        "analysis": rows[~rows["code"].isin(CODE_NAMES)],
    }
    columns = {name: part for name, part in columns.items() if len(part)}
    summary = Table("Comparisons that pass", [Column("case"), *(Column(name) for name in columns)])
    cases = []
    for case in dict.fromkeys(rows["case"]):
        part = rows[rows["case"] == case].sort_values("passed", kind="stable")
        known = KNOWN.get(case)
        title = known.title if known else case
        figure = case_figure(data.gallery, data.verification_folder, case, title, known, part)
        passed = int(part["passed"].sum())
        cases.append(
            {"name": case, "title": title, "passed": passed, "total": len(part), "figure": figure}
            | {"account": known and known.account, "own_law": bool(own[part.index].any())}
            | {"failed": case_table(part[~part["passed"]], f"{title}: fail")}
            | {"table": case_table(part[part["passed"]], f"{title}: pass")}
        )
        summary.rows.append(
            [Link(title, f"#case-{case}"), *(count(found[found["case"] == case]) for found in columns.values())]
        )
    return {
        "rows": len(rows) > 0,
        "kept": data.verification_folder.is_relative_to(KEPT_VERIFICATION),
        "counts": [(name, int(found["passed"].sum()), len(found)) for name, found in columns.items()],
        "cases": cases,
        "summary": summary,
    }


def count(rows: pd.DataFrame) -> Chip | str:
    """How many comparisons pass."""
    passed = int(rows["passed"].sum())
    return Chip(f"{passed} of {len(rows)}", "good" if passed == len(rows) else "bad") if len(rows) else "–"


def case_table(rows: pd.DataFrame, title: str) -> Table:
    """Comparisons of one case."""
    columns = [Column("code"), Column("quantity"), Column("expected", True), Column("measured", True)]
    columns += [
        Column("relative error", True),
        Column("tolerance", True),
        Column("verdict"),
        Column("reason", wide=True),
    ]
    table = Table(f"Comparisons, {title}", columns)
    for r in rows.itertuples():
        verdict = Chip("pass", "good") if r.passed else Chip("fail", "bad")
        numbers = [number(r.expected, 6), number(r.measured, 6), number(r.rel_error, 2), number(r.tolerance, 2)]
        table.rows.append([CODE_NAMES.get(r.code, r.code), r.quantity, *numbers, verdict, r.reason])
    return table
