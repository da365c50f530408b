"""The result of `make verify` as tables: comparisons that pass, by case and law, and the comparisons of a case."""

from __future__ import annotations

import functools
from collections.abc import Callable

import pandas as pd

from analysis.report.style import CODE_NAMES
from analysis.report.tables.table_html import Chip, Link, Shown, Table, frame_table

OWN_LAW = r"YADE has no|YADE counts|YADE's own|its own oracle|its own expected value"
"""What the reason of a comparison says where YADE is held to a law of its own instead of the paper's."""


def by_law(rows: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Comparisons by engine and by whose law an engine is held to; without what has none."""
    own = has_own_law(rows)
    parts = {
        "LIGGGHTS, the paper's law": rows[rows["code"] == "liggghts"],
        "YADE, the paper's law": rows[(rows["code"] == "yade") & ~own],
        "YADE, its own law": rows[own],
        "analysis": rows[~rows["code"].isin(CODE_NAMES)],
    }
    return {name: part for name, part in parts.items() if len(part)}


def has_own_law(rows: pd.DataFrame) -> pd.Series:
    """True for comparisons with a law of YADE's own."""
    return (rows["code"] == "yade") & rows["reason"].astype(str).str.contains(OWN_LAW)


def summary_table(rows: pd.DataFrame, title_of: Callable[[str], str]) -> Table | None:
    """How many comparisons of each case pass, by `by_law`; `title_of` gives the title of a case."""
    parts = by_law(rows)
    table = pd.DataFrame({"case": list(dict.fromkeys(rows["case"]))})
    for n, part in enumerate(parts.values()):
        counts = part.groupby("case")["passed"].agg(**{f"passed_{n}": "sum", f"total_{n}": "count"})
        table = table.join(counts, on="case")
    return frame_table(
        table,
        "Comparisons that pass",
        [
            Shown("case", text=lambda row: Link(title_of(row.case), f"#case-{row.case}"), number=False),
            *(
                Shown(f"passed_{n}", name, text=functools.partial(passed, n), number=False)
                for n, name in enumerate(parts)
            ),
        ],
    )


def passed(part: int, row) -> Chip | str:
    """How many comparisons of a case pass in the part of that number."""
    good, total = getattr(row, f"passed_{part}"), getattr(row, f"total_{part}")
    return "–" if total != total else Chip(f"{int(good)} of {int(total)}", "good" if good == total else "bad")


def case_table(rows: pd.DataFrame, title: str) -> Table | None:
    """Comparisons of one case."""
    return frame_table(
        rows,
        f"Comparisons, {title}",
        [
            "code",
            Shown("quantity", "quantity", text=lambda row: row.quantity, number=False),
            Shown("expected", digits=6),
            Shown("measured", digits=6),
            Shown("rel_error", digits=2),
            Shown("tolerance", digits=2),
            Shown("passed", "verdict", text=verdict, number=False),
            Shown("reason", number=False, wide=True),
        ],
    )


def verdict(row) -> Chip:
    """Whether a comparison passes."""
    return Chip("pass", "good") if row.passed else Chip("fail", "bad")
