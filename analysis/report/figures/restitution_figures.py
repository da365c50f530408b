"""The damping modes of eq. 16, which need no run."""

from __future__ import annotations

import numpy as np
import pandas as pd

from analysis import contact_laws
from analysis.report import style
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import MODE_NAMES
from analysis.report.style import SOFT


def restitution_figure(gallery: Gallery) -> Figure:
    """The paper's Figure 9 and what follows from it: damping factor and effective restitution against nominal e_n."""
    factor = style.canvas(
        "figure9-damping-factor", "Damping factor D against nominal restitution for the three damping modes", right=1.5
    )
    effect = style.canvas("figure9-restitution", "Restitution of a free impact against nominal restitution", right=1.5)
    modes = {mode: _of_mode(mode) for mode in (0, 1, 2)}
    for mode, values in modes.items():
        colour, text = style.shade(f"md{mode}"), f"Md {mode}, {MODE_NAMES[mode].split('–')[0]}"
        for c, column in ((factor, "damping_factor"), (effect, "effective_restitution")):
            c.axes.plot(values["nominal_restitution"], values[column], color=colour)
            c.labels.append((0.0, 0.0, text, colour))
            c.leaders = False
    factor.axes.set(xlabel="nominal restitution eₙ", ylabel="damping factor D", xlim=(0, 1), ylim=(0, 6))
    effect.axes.plot([0, 1], [0, 1], color=SOFT, linewidth=0.9, linestyle=(0, (2, 2)))
    effect.axes.text(0.46, 0.40, "out = in", color=SOFT, fontsize=style.SMALL, rotation=33, rotation_mode="anchor")
    effect.axes.set(xlabel="nominal restitution eₙ", ylabel="restitution of a free impact", xlim=(0, 1), ylim=(0, 1.02))
    factor.table = effect.table = pd.concat(modes.values(), ignore_index=True)
    return gallery.finish(
        "figure9",
        "Figure 9 remade: the three damping modes",
        "Left: the damping factor D of eq. 16 in the forms that two independent sources give (the equation is damaged "
        "in the "
        "text). Right: the restitution that comes out of a free impact, D (1 + e′) = ln((1 + D)/(1 − D e′)), whatever "
        "mass, "
        "stiffness and speed. At eₙ = 1 all three modes are the same undamped Hertz law, so the paper's best case "
        "says nothing "
        "about the damping mode; for Md 1, eₙ = 0 still gives 0.66.",
        [factor, effect],
        [],
    )


def _of_mode(mode: int) -> pd.DataFrame:
    """Damping factor and effective restitution of a mode over nominal restitution; mode 0 has no factor at 0."""
    nominal = np.linspace(0, 1, 101)[1 if mode == 0 else 0 :]
    factors = np.array([contact_laws.damping_factor(mode, float(v)) for v in nominal])
    effective = np.array([contact_laws.effective_restitution(float(v)) for v in factors])
    return pd.DataFrame(
        {
            "damping_mode": mode,
            "nominal_restitution": nominal,
            "damping_factor": factors,
            "effective_restitution": effective,
        }
    )
