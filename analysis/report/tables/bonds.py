"""Bonds of the bonded model: made and broken."""

from __future__ import annotations

import pandas as pd

from analysis.report.labels import short_name
from analysis.report.style import CODE_NAMES
from analysis.report.tables.base import Shown, Table, frame_table
from analysis.scenarios.scenario import Scenario


def bonds_table(rows: pd.DataFrame, setup: Scenario) -> Table | None:
    """Bonds made and broken by cycle; which reading of the units breaks any. `setup` has the bonds' parameters."""
    stiffness, strength = (
        " and ".join(f"{setup[f'contact.bond.{way}_{what}']:g}" for way in ("normal", "shear"))
        for what in ("stiffness", "strength")
    )
    return frame_table(
        rows,
        "Bonds made and broken",
        [
            Shown("run", "run", text=run_of, number=False),
            "reading",
            Shown("cycle", "after cycle"),
            Shown("bonds_made", "bonds made", text=lambda row: str(row.bonds_made)),
            Shown("bonds_broken_tension", "broken in tension", text=lambda row: str(row.bonds_broken_tension)),
            Shown("bonds_broken_shear", "broken in shear", text=lambda row: str(row.bonds_broken_shear)),
            Shown("broken_share", "broken"),
        ],
        "Table 3 prints bond stiffness in N/m and strength in N, which a parallel bond does not have. Here they are "
        f"read per area (assumed): {stiffness} Pa/m, {strength} Pa; “bonds in N/m” reads them as printed. Cycle 0 is "
        "the end of preload.",
    )


def run_of(row) -> str:
    """A scenario with its variants, code and seed, in words."""
    seed = f", seed {row.seed}" if row.seed != 1 else ""
    name = short_name("+".join(filter(None, (row.scenario, row.variant))))
    return f"{name}, {CODE_NAMES.get(row.code, row.code)}{seed}"
