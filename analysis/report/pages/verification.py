"""The result of the verification: a figure and a table per case."""

from __future__ import annotations

import pandas as pd

from analysis.report.figures.verification import case_figure, case_name
from analysis.report.report_data import ReportData
from analysis.report.style import CODE_NAMES
from analysis.report.tables import Chip, Column, Table, number


def verification(data: ReportData) -> dict:
    """The result of `make verify`: a figure and a table per case."""
    rows = data.verification
    codes = sorted(set(rows["code"]), key=lambda code: (code not in CODE_NAMES, code))
    summary = Table("Comparisons that pass", [Column("case"), *(Column(CODE_NAMES.get(code, code)) for code in codes)])
    cases = []
    for case in dict.fromkeys(rows["case"]):
        part = rows[rows["case"] == case].sort_values("passed", kind="stable")
        title = case_name(case)
        figure = case_figure(data.gallery, data.verification_folder, case, part)
        passed = int(part["passed"].sum())
        cases.append(
            {"name": case, "title": title, "passed": passed, "total": len(part), "figure": figure}
            | {"failed": case_table(part[~part["passed"]]), "table": case_table(part[part["passed"]])}
        )
        engines = set(part["code"]) & set(CODE_NAMES)
        cells = []
        for code in codes:
            mine = part[part["code"] == code]
            if len(mine):
                count = f"{int(mine['passed'].sum())} of {len(mine)}"
                cells.append(Chip(count, "good" if mine["passed"].all() else "bad"))
            else:
                cells.append(Chip("not run", "open") if engines and code in CODE_NAMES else "–")
        summary.rows.append([title, *cells])
    total = len(rows)
    return {"rows": total > 0, "passed": int(rows["passed"].sum()), "total": total, "cases": cases, "summary": summary}


def case_table(rows: pd.DataFrame) -> Table:
    """Comparisons of one case."""
    columns = [Column("code"), Column("quantity"), Column("expected", True), Column("measured", True)]
    columns += [
        Column("relative error", True),
        Column("tolerance", True),
        Column("verdict"),
        Column("reason", wide=True),
    ]
    table = Table("", columns)
    for r in rows.itertuples():
        verdict = Chip("pass", "good") if r.passed else Chip("fail", "bad")
        numbers = [number(r.expected, 6), number(r.measured, 6), number(r.rel_error, 2), number(r.tolerance, 2)]
        table.rows.append([CODE_NAMES.get(r.code, r.code), r.quantity, *numbers, verdict, r.reason])
    return table
