"""Parallel bonds: how many were made, and how many broke by which cycle."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from analysis.comparison.findings.agreement import CYCLES
from analysis.comparison.findings.members import IDENTITY, Member

COLUMNS = (*IDENTITY, "cycle", "bonds_made", "bonds", "bonds_broken_tension", "bonds_broken_shear", "broken_share")


def bonds_table(listed: Iterable[Member]) -> pd.DataFrame:
    """A row per run with bonds for preload (cycle 0), those of CYCLES that it reached, and its last one."""
    rows = []
    for m in listed:
        counts = bond_counts(m.run)
        shown = counts["cycle"].isin((0, *CYCLES)) | (counts["cycle"] == counts["cycle"].max())
        rows += [m.identity | row for row in counts[shown].to_dict("records")]
    return pd.DataFrame(rows, columns=COLUMNS)


def bond_counts(run) -> pd.DataFrame:
    """`Run.bonds` with the number of bonds made, and the share of them that broke so far; nan where none was made."""
    counts = run.bonds.astype(int)
    made = counts.drop(columns="cycle").sum(axis=1)
    return counts.assign(bonds_made=made, broken_share=(made - counts["bonds"]) / made)
