"""Parallel bonds: how many were made, and how many broke by which cycle."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from analysis.comparison.findings.members import Member

SHOWN = (0, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
"""Cycles of the table; 0 is the end of preload."""

COLUMNS = ("run", "profile", "scenario", "variant", "reading", "code", "seed")
COLUMNS += ("cycle", "bonds_made", "bonds", "bonds_broken_tension", "bonds_broken_shear", "broken_share")


def bonds_table(listed: Iterable[Member]) -> pd.DataFrame:
    """A row per run with bonds and shown cycle, its last one included; numbers of bonds, and broken over made."""
    rows = []
    for m in listed:
        counts = m.run.bonds.set_index("cycle").astype(int)
        for cycle in sorted({n for n in (*SHOWN, counts.index.max()) if n in counts.index}):
            row = counts.loc[cycle]
            made = int(row.sum())
            share = (made - row["bonds"]) / made if made else float("nan")
            rows.append({**m.identity, "cycle": cycle, "bonds_made": made, **row.to_dict(), "broken_share": share})
    return pd.DataFrame(rows, columns=COLUMNS)
