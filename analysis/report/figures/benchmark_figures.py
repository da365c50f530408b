"""Speed against the number of clumps."""

from __future__ import annotations

import pandas as pd

from analysis.driver.bench.bench_tables import exponent
from analysis.report import style
from analysis.report.figure import Figure, Gallery
from analysis.report.style import CODE_NAMES, CODE_STYLES, marker_face


def sizes_figure(gallery: Gallery, sizes: pd.DataFrame) -> Figure | None:
    """Steps per processor second against clumps, on one rank, a line per code and law."""
    one = sizes[sizes["ranks"] == 1] if len(sizes) else sizes
    if one.empty or one["clumps"].nunique() < 2:
        return None
    c = style.canvas("benchmark-sizes", "Steps per second of processor time against the number of clumps", right=1.6)
    for (code, law), part in one.sort_values("clumps").groupby(["code", "law"], sort=False):
        hue = style.shade("linear" if law == "linear" else "nonlinear")
        look = CODE_STYLES[code] | {"color": hue, "markerfacecolor": marker_face(code, hue)}
        c.axes.plot(part["clumps"], part["steps_per_cpu_s"], **look)
        power = exponent(list(zip(part["clumps"], part["steps_per_cpu_s"], strict=True)))
        label = f"{CODE_NAMES[code]}, {law}: power {power:.2f}"
        c.labels.append((part["clumps"].iloc[-1], part["steps_per_cpu_s"].iloc[-1], label, hue))
    c.axes.set_xscale("log")
    c.axes.set_yscale("log")
    c.axes.set(xlabel="clumps", ylabel="steps per second of processor time")
    c.table = one
    return gallery.finish(
        "benchmark-sizes",
        "Speed against size",
        "Beds of other widths, cut out of the preloaded full bed or out of mirror images of it beside each other.",
        [c],
        [],
    )
