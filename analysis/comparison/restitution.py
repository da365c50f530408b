"""What follows from eq. 16 alone, without any run."""

from __future__ import annotations

import math

import pandas as pd

from analysis import contact_laws


def restitution_table(restitutions=(0.0, 0.3, 0.6, 0.9, 1.0)) -> pd.DataFrame:
    """Nominal against effective restitution: damping_mode, nominal_restitution, damping_factor, effective_restitution.

    Effective is what comes out of a free impact, whatever mass, stiffness and speed. M_d = 0 has no value at e_n = 0.
    """
    rows = []
    for mode in (0, 1, 2):
        for nominal in restitutions:
            factor = contact_laws.damping_factor(mode, nominal) if (mode, nominal) != (0, 0.0) else math.nan
            rows.append(
                (mode, nominal, factor, math.nan if math.isnan(factor) else contact_laws.effective_restitution(factor))
            )
    return pd.DataFrame(
        rows, columns=["damping_mode", "nominal_restitution", "damping_factor", "effective_restitution"]
    )
