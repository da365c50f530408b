"""Runs against the reference curves, where these come from, and the damping modes' restitution."""

from __future__ import annotations

import functools

import pandas as pd

from analysis.comparison import against_published
from analysis.comparison.restitution import restitution_table
from analysis.normalised.readers import Runs
from analysis.reference.curves import References
from analysis.report.labels import MODE_NAMES, PUBLICATION_NAMES
from analysis.report.tables.table_html import Chip, Shown, Table, frame_table, label_of_column, number, run_of


def curve_of(row) -> str:
    """The reference curve of a row."""
    return f"{PUBLICATION_NAMES.get(row.source, row.source)}: {row.curve}"


NAMES = (
    Shown("run", "run", text=run_of, number=False),
    Shown("curve", "reference", text=curve_of, number=False),
)


def reference_tables(runs: Runs, references: References) -> list[Table | None]:
    """Where the reference curves come from, and how runs compare with them."""
    return [
        sources_table(references.sources),
        reference_scores(against_published.reference_table(runs, references)),
        lateral_scores(against_published.lateral_reference_table(runs, references)),
    ]


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
            Shown("sidecar", "file", number=False),
            Shown("status", "status", text=status, number=False),
            Shown("curves", "curves", text=lambda row: f"{row.digitised} of {row.curves}"),
            Shown("points", text=lambda row: str(row.points or "–")),
            Shown("error", number=False),
            Shown("digitised_by", "digitised by", text=digitiser, number=False),
            Shown("method", "how", number=False, wide=True),
            Shown("licence", number=False, wide=True),
        ],
        "The sidecars in reference_data/published say more; each page of the report takes these points and no others.",
    )


def status(row) -> Chip:
    """Whether the curves of a sidecar are there."""
    return Chip(row.status, "open" if row.status == "pending" else "good")


def digitiser(row) -> str:
    """Who digitised the curves of a sidecar, and when."""
    return f"{row.digitised_by}, {row.date}" if row.digitised_by else "–"


def law_table(laws: pd.DataFrame) -> Table | None:
    """Which law describes each settlement curve, and whether it has the exponential start.

    laws   `Findings.settlement_laws`
    """
    return frame_table(
        laws,
        "Does settlement start exponentially? S = a + b (1 − exp(−N/c)) + d N against a logarithm, a power law and a "
        "straight line",
        [
            Shown("run", "run", text=run_of, number=False),
            "cycles",
            Shown("best", "best law", number=False),
            Shown("exponential_start", text=start_chip, number=False),
            *(
                Shown(f"exponential_{name}", label, text=functools.partial(with_interval, f"exponential_{name}"))
                for name, label in (("b", "b"), ("c", "c, cycles"), ("d", "d"))
            ),
            Shown("reason", "why", number=False, wide=True),
        ],
        "Chosen by the Bayesian information criterion; brackets: 95 % confidence intervals of the exponential law, "
        "whichever law is best.",
    )


def start_chip(row) -> Chip:
    """Whether settlement starts exponentially."""
    return Chip(row.exponential_start, {"yes": "good", "no": "bad"}.get(row.exponential_start, "open"))


def with_interval(name: str, row) -> str:
    """A fitted parameter with its confidence interval."""
    ends = (getattr(row, name), getattr(row, f"{name}_low"), getattr(row, f"{name}_high"))
    value, low, high = (number(end, 3, label_of_column(name)[2]) for end in ends)
    return "–" if ends[0] != ends[0] else f"{value} ({low} to {high})"


def mode_of(row) -> str:
    """The damping mode of a row, in words."""
    return f"Md {row.damping_mode}, {MODE_NAMES[row.damping_mode]}"


def restitution_rows() -> Table | None:
    """Nominal against effective restitution at the paper's values of e_n."""
    table = restitution_table()
    wide = table.pivot(index="damping_mode", columns="nominal_restitution", values="effective_restitution")
    nominal = list(wide)
    wide.columns = [f"out_{n}" for n in range(len(nominal))]
    return frame_table(
        wide.reset_index(),
        "What comes out of a free impact at the paper's nominal restitutions",
        [
            Shown("damping_mode", text=mode_of, number=False),
            *(Shown(f"out_{n}", f"eₙ = {e:g}", digits=4) for n, e in enumerate(nominal)),
        ],
    )
