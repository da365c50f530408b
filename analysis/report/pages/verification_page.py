"""The result of the verification: a figure and a table per case."""

from __future__ import annotations

from analysis.files import KEPT_VERIFICATION
from analysis.report.figures.verification_figures import case_figure
from analysis.report.report_data import ReportData
from analysis.report.tables.verification_tables import by_law, case_table, has_own_law, summary_table
from analysis.verification.verify_command import CASES

KNOWN = {case.name: case for case in CASES}


def verification(data: ReportData) -> dict:
    """The result of `make verify`: a figure and a table per case; what is tested against the paper's law counts apart
    from what is tested against YADE's own.
    """
    rows = data.verification
    return {
        "rows": len(rows) > 0,
        "kept": data.verification_folder.is_relative_to(KEPT_VERIFICATION),
        "counts": [(name, int(found["passed"].sum()), len(found)) for name, found in by_law(rows).items()],
        "cases": [case_entry(data, case) for case in dict.fromkeys(rows["case"])],
        "summary": summary_table(rows, title_of),
    }


def title_of(case: str) -> str:
    """The title of a case; its name where this version has no such case."""
    return KNOWN[case].title if case in KNOWN else case


def case_entry(data: ReportData, case: str) -> dict:
    """One case: what it does, its figure, what fails and what passes."""
    part = data.verification[data.verification["case"] == case].sort_values("passed", kind="stable")
    known, title = KNOWN.get(case), title_of(case)
    return {
        "name": case,
        "title": title,
        "passed": int(part["passed"].sum()),
        "total": len(part),
        "figure": case_figure(data.gallery, data.verification_folder, case, title, known, part),
        "account": known and known.account,
        "own_law": bool(has_own_law(part).any()),
        "failed": case_table(part[~part["passed"]], f"{title}: fail"),
        "table": case_table(part[part["passed"]], f"{title}: pass"),
    }
