"""Bonds of the bonded model: made and broken."""

from __future__ import annotations

import pandas as pd

from analysis.report.tables.table_html import Shown, Table, frame_table, number, run_of
from analysis.scenarios.scenario import Scenario


def bonds_table(rows: pd.DataFrame, setup: Scenario) -> Table | None:
    """Bonds made and broken by cycle; which reading of the units breaks any. `setup` has the bonds' parameters."""
    stiffness, strength = (
        " and ".join(number(setup[f"contact.bond.{way}_{what}"]) for way in ("normal", "shear"))
        for what in ("stiffness", "strength")
    )
    return frame_table(
        rows,
        "Bonds made and broken",
        [
            Shown("run", "run", text=run_of, number=False),
            "reading",
            Shown("cycle", "after cycle"),
            Shown("bonds_made", "bonds made"),
            Shown("bonds_broken_tension", "broken in tension"),
            Shown("bonds_broken_shear", "broken in shear"),
            Shown("broken_share", "broken"),
        ],
        "Table 3 prints bond stiffness in N/m and strength in N, which a parallel bond does not have. Here they are "
        f"read per area (assumed): {stiffness} Pa/m, {strength} Pa; “bonds in N/m” reads them as printed. Cycle 0 is "
        "the end of preload.",
    )
