"""Runs against the reference curves, where these come from, and the damping modes' restitution."""

from __future__ import annotations

import math
from collections.abc import Iterable

import pandas as pd

from analysis.comparison import settlement_fits
from analysis.comparison.quantities import last_cycle
from analysis.comparison.restitution import restitution_table
from analysis.normalised.readers import Run
from analysis.report.labels import MODE_NAMES, SOURCE_NAMES
from analysis.report.report_data import name_of
from analysis.report.tables.base import Chip, Column, Shown, Table, frame_table, interval, label_of_column, run_of


def curve_of(row) -> str:
    """The reference curve of a row."""
    return f"{SOURCE_NAMES.get(row.source, row.source)}: {row.curve}"


NAMES = (
    Shown("run", "run", text=run_of, number=False),
    Shown("curve", "reference", text=curve_of, number=False),
)


def reference_scores(rows: pd.DataFrame) -> Table | None:
    """Settlement of runs against the reference curves that are there."""
    return frame_table(
        rows,
        "Settlement against the reference curves",
        [
            *NAMES,
            "points",
            Shown("rms_m", "rms"),
            Shown("shift_m", "shift"),
            Shown("rms_shifted_m", "rms after the shift"),
            Shown("late_slope_ratio", "late slope, ratio", like="ratio"),
            Shown("first_cycle_ratio", "first cycle, ratio", like="ratio"),
            Shown("within_error", "within its error", like="share"),
            Shown("within_error_shifted", "after the shift", like="share"),
        ],
        "Over the cycles that both have, at the points of the reference. Shift: run minus reference, mean; removed, it "
        "leaves the difference in shape.",
    )


def lateral_scores(rows: pd.DataFrame) -> Table | None:
    """Lateral displacement of runs against the reference profiles that are there."""
    return frame_table(
        rows,
        "Lateral displacement against the reference profiles",
        [
            *NAMES,
            "cycle",
            Shown("rms_m", "rms"),
            Shown("relative", "rms over the reference's mean", like="ratio"),
            Shown("ratio", "ratio of means"),
        ],
        "At the depths of the five plates that the reference covers.",
    )


def sources_table(rows: pd.DataFrame) -> Table | None:
    """Where each reference curve comes from: who digitised it, how, with what error; or that it is pending."""
    return frame_table(
        rows,
        "Where the reference curves come from",
        [
            Shown("sidecar", "file", text=lambda row: row.sidecar, number=False),
            Shown("status", "status", text=status, number=False),
            Shown("curves", "curves", text=lambda row: f"{row.digitised} of {row.curves}"),
            Shown("points", "points", text=lambda row: str(row.points or "–")),
            Shown("error", "error", text=lambda row: row.error or "–", number=False),
            Shown("digitised_by", "digitised by", text=digitiser, number=False),
            Shown("method", "how", text=lambda row: row.method or "–", number=False, wide=True),
            Shown("licence", "licence", text=lambda row: row.licence, number=False, wide=True),
        ],
        "The sidecars in reference_data/published say more; each page of the report takes these points and no others.",
    )


def status(row) -> Chip:
    """Whether the curves of a sidecar are there."""
    return Chip(row.status, "open" if row.status == "pending" else "good")


def digitiser(row) -> str:
    """Who digitised the curves of a sidecar, and when."""
    return f"{row.digitised_by}, {row.date}" if row.digitised_by else "–"


def law_table(runs: Iterable[Run]) -> Table | None:
    """Which law describes each settlement curve, and whether it has the exponential start."""
    fitted = [(name, *label_of_column(f"exponential_{name}")[1:]) for name in ("b", "c", "d")]
    columns = [Column("run"), Column("cycles", True), Column("best law"), Column("exponential start")]
    columns += [*(Column(f"{name}, {unit or 'cycles'}", True) for name, unit, _ in fitted), Column("why", wide=True)]
    rows = []
    for run in runs:
        choice = settlement_fits.choose(run.cycles["cycle"], run.cycles["settlement_m"])
        fit = choice.fits.get("exponential")
        start = Chip(choice.exponential_start, {"yes": "good", "no": "bad"}.get(choice.exponential_start, "open"))
        cells = [interval(fit, name, factor) for name, _, factor in fitted]
        rows.append([name_of(run), str(last_cycle(run)), choice.best or "–", start, *cells, choice.reason])
    title = (
        "Does settlement start exponentially? S = a + b (1 − exp(−N/c)) + d N against a logarithm, a power law and a "
        "straight line"
    )
    note = (
        "Chosen by the Bayesian information criterion; brackets: 95 % confidence intervals of the exponential law, "
        "whichever law is best."
    )
    return Table(title, columns, rows, note) if rows else None


def restitution_rows() -> Table:
    """Nominal against effective restitution at the paper's values of e_n."""
    table = restitution_table().set_index(["damping_mode", "nominal_restitution"])
    values = table["effective_restitution"].unstack()
    return Table(
        "What comes out of a free impact at the paper's nominal restitutions",
        [Column("damping mode"), *(Column(f"eₙ = {e:g}", True) for e in values)],
        [
            [f"Md {mode}, {MODE_NAMES[mode]}", *("–" if math.isnan(v) else f"{v:.4f}" for v in row)]
            for mode, row in zip(values.index, values.to_numpy(), strict=True)
        ],
    )
