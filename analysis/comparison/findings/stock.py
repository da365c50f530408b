"""Each code's own contact models against the paper's laws, from one bed: does it matter?"""

from __future__ import annotations

import math
from collections.abc import Iterable

import pandas as pd

from analysis.comparison.findings.influence import at, one_thing_changed, spread_between_beds
from analysis.comparison.findings.members import Member
from analysis.comparison.quantities import last_cycle
from analysis.formats.file_columns import PLATES

STOCK_VARIANT = "stock"
CYCLES = (1, 2, 5, 10, 20, 50, 100)
"""After which the two are compared, and after the last that both have reached."""

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
QUANTITIES = {"settlement_m": ("settlement_m",), "lateral_mean_m": tuple(f"lateral_{k}_m" for k in PLATES)}
"""What is compared: the mean of these columns of cycles.csv."""


def stock_table(found: Iterable[Member], scatter: pd.DataFrame) -> pd.DataFrame:
    """Each run of the variant `stock` against the run that differs from it in nothing but the contact model (COLUMNS).

    paper_law, stock   settlement_m, lateral_mean_m, after CYCLES, m
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
            for quantity, columns in QUANTITIES.items():
                one, other = (sum(at(run, cycle, c) for c in columns) / len(columns) for run in (base.run, m.run))
                rows.append(
                    {
                        "profile": m.run.profile,
                        "scenario": m.scenario,
                        "reading": m.reading,
                        "code": m.run.code,
                        "seed": m.run.seed,
                        "cycle": cycle,
                        "quantity": quantity,
                        "paper_law": one,
                        "stock": other,
                        "change_ratio": other / one - 1 if one * other > 0 else math.nan,
                        "scatter_ratio": spread_between_beds(scatter, m, quantity, cycle),
                    }
                )
    return pd.DataFrame(rows, columns=COLUMNS)
