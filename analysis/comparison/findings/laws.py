"""Which law describes the settlement of each run, and whether it starts exponentially."""

from __future__ import annotations

import math
from collections.abc import Iterable

import pandas as pd

from analysis.comparison import settlement_fits
from analysis.comparison.findings.members import IDENTITY, Member
from analysis.comparison.run_quantities import last_cycle

PARAMETERS = settlement_fits.LAWS["exponential"].parameters
LAWS = ("cycles", "best", "exponential_start", "reason")
LAWS += tuple(f"exponential_{name}{end}" for name in PARAMETERS for end in ("", "_low", "_high"))


def laws_table(found: Iterable[Member]) -> pd.DataFrame:
    """Plain runs of the first packed bed: IDENTITY and LAWS, the parameters of the exponential law with their 95 %
    intervals; nan where the curve is too short for any law.
    """
    rows = []
    for m in found:
        if not m.plain or m.run.seed != 1:
            continue
        choice = settlement_fits.choose(m.run.cycles["cycle"], m.run.cycles["settlement_m"])
        row = {"cycles": last_cycle(m.run), "best": choice.best or ""}
        row |= {"exponential_start": choice.exponential_start, "reason": choice.reason}
        law = choice.fits.get("exponential")
        for name in PARAMETERS:
            low, high = law.intervals[name] if law else (math.nan, math.nan)
            row |= {f"exponential_{name}": law.values[name] if law else math.nan}
            row |= {f"exponential_{name}_low": low, f"exponential_{name}_high": high}
        rows.append(m.identity | row)
    return pd.DataFrame(rows, columns=[*IDENTITY, *LAWS])
