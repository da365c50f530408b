"""Each code's own contact models against the paper's laws, from one bed: does it matter?"""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from analysis.comparison.findings.agreement import CYCLES
from analysis.comparison.findings.influence import changes, one_thing_changed
from analysis.comparison.findings.members import Member
from analysis.comparison.run_quantities import last_cycle

STOCK_VARIANT = "stock"
COLUMNS = (
    "profile",
    "scenario",
    "reading",
    "code",
    "seed",
    "cycle",
    "quantity",
    "paper_law",
    "stock",
    "change_ratio",
    "scatter_ratio",
)


def stock_table(found: Iterable[Member], scatter: pd.DataFrame) -> pd.DataFrame:
    """Each run of the variant `stock` against the run that differs from it in nothing but the contact model (COLUMNS).

    paper_law, stock   settlement_m, lateral_mean_m, after CYCLES and after the last cycle that both have reached, m
    change_ratio       stock over paper_law, minus 1; nan where they have no common sign
    scatter_ratio      standard deviation between beds as a share of the mean, see `agreement.scatter_table`
    """
    found = list(found)
    rows = []
    for m in (m for m in found if STOCK_VARIANT in m.variants):
        others = tuple(v for v in m.variants if v != STOCK_VARIANT)
        bases = [b for b in found if (b.key, b.variants, b.run.seed) == (m.key, others, m.run.seed)]
        bases = [b for b in bases if one_thing_changed(b, m) and b.bed == m.bed]
        if not bases:
            continue
        base = max(bases, key=lambda b: last_cycle(b.run))
        last = min(last_cycle(base.run), last_cycle(m.run))
        for cycle in sorted({n for n in CYCLES if n < last} | {last}):
            rows += changes(base, m, cycle, scatter)
    table = pd.DataFrame(rows).rename(columns={"base": "paper_law", "changed": "stock"})
    return table.reindex(columns=COLUMNS)
