"""Runs against published curves, as tidy frames; empty while all curves are pending."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from analysis.comparison import run_quantities


@dataclass(frozen=True)
class AgainstReference:
    """A run's settlement against a reference curve, over the cycles that both have.

    points             reference points compared
    rms_m              rms difference, as it is
    shift_m            vertical shift that makes the rms difference least: mean of run minus reference
    rms_shifted_m      rms difference after that shift: the difference in shape
    late_slope_ratio   run over reference, slope of the later half; nan where they share fewer than 20 cycles
    first_cycle_ratio  run over reference, settlement after the first cycle; nan where the reference has no point by
                       cycle 2
    within_error       share of points at which the run is within the reference's error; nan where no error is stated
    within_error_shifted   the same after the shift
    """

    points: int
    rms_m: float
    shift_m: float
    rms_shifted_m: float
    late_slope_ratio: float
    first_cycle_ratio: float
    within_error: float
    within_error_shifted: float


def against_reference(cycles, settlement_m, reference_cycles, reference_m, error_m=math.nan) -> AgainstReference | None:
    """Compare a settlement curve with a reference, at the reference's points; None with fewer than three of them.

    error_m   of the reference: one number or one for each point
    """
    cycles, settlement_m = _clean(cycles, settlement_m)
    if not len(cycles):
        return None
    at, theirs, error = _between(reference_cycles, reference_m, error_m, cycles[0], cycles[-1])
    if len(at) < 3:
        return None
    ours = np.interp(at, cycles, settlement_m)
    difference = ours - theirs
    shift = float(difference.mean())

    def within(d: np.ndarray) -> float:
        return float(np.mean(np.abs(d) <= error)) if np.isfinite(error).all() else math.nan

    return AgainstReference(
        len(at),
        _rms(difference),
        shift,
        _rms(difference - shift),
        _late_slope_ratio(at, ours, theirs),
        float(ours[0] / theirs[0]) if at[0] <= 2 and theirs[0] else math.nan,
        within(difference),
        within(difference - shift),
    )


def _between(cycles, values, errors, first: float, last: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cycles, values and errors of a reference from `first` to `last`, in the order of the cycles."""
    order = np.argsort(cycles, kind="stable")
    at, value = np.asarray(cycles, dtype=float)[order], np.asarray(values, dtype=float)[order]
    error = np.broadcast_to(np.asarray(errors, dtype=float), at.shape)
    inside = np.isfinite(at) & np.isfinite(value) & (at >= first) & (at <= last)
    return at[inside], value[inside], error[order][inside]


def _late_slope_ratio(at: np.ndarray, ours: np.ndarray, theirs: np.ndarray) -> float:
    """Slopes of the later half over each other; nan where it is too short."""
    late = at >= at[-1] / 2
    if late.sum() < 2 or at[-1] < 2 * run_quantities.LEAST_LATE_CYCLES:
        return math.nan
    own, other = (np.polyfit(at[late], values[late], 1)[0] for values in (ours, theirs))
    return float(own / other) if other else math.nan


def reference_table(runs: Iterable, references) -> pd.DataFrame:
    """Every run against every settlement curve of `reference.References`: identity, source, curve and the fields above.

    A curve of a named scenario (the paper's own) is compared with runs of that scenario only. Empty while all curves
    are pending.
    """
    rows = []
    curves = references.curves[references.curves["quantity"] == "settlement"]
    for run in runs:
        for (source, curve, scenario), points in curves.fillna({"scenario": ""}).groupby(
            ["source", "curve", "scenario"], sort=True
        ):
            if scenario not in ("", run.scenario_name):
                continue
            result = against_reference(
                run.cycles["cycle"],
                run.cycles["settlement_m"],
                points["cycle"].to_numpy(),
                points["value"].to_numpy(),
                points["error"].to_numpy(),
            )
            if result:
                rows.append(
                    {
                        "profile": run.profile,
                        "scenario": run.scenario_name,
                        "code": run.code,
                        "seed": run.seed,
                        "source": source,
                        "curve": curve,
                        **result.__dict__,
                    }
                )
    return pd.DataFrame(
        rows, columns=["profile", "scenario", "code", "seed", "source", "curve", *AgainstReference.__dataclass_fields__]
    )


def lateral_reference_table(runs: Iterable, references) -> pd.DataFrame:
    """Every run against every lateral profile whose cycle it has reached, at the plates' depths that both have.

    Columns: scenario, code, seed, source, curve, cycle, rms_m, relative (rms over the reference's mean), ratio (of the
    means). Empty while all profiles are pending.
    """
    rows = []
    curves = references.curves[references.curves["quantity"] == "lateral_displacement"]
    for run in runs:
        for (source, curve, scenario, cycle), points in curves.fillna({"scenario": ""}).groupby(
            ["source", "curve", "scenario", "cycle"], sort=True
        ):
            ours = run_quantities.lateral_profile(run, [int(cycle)]).dropna()
            if scenario not in ("", run.scenario_name) or ours.empty:
                continue
            points = points.sort_values("depth_m")
            ours = ours[ours["depth_m"].between(points["depth_m"].iloc[0], points["depth_m"].iloc[-1])]
            if ours.empty:
                continue
            theirs = np.interp(ours["depth_m"], points["depth_m"], points["value"])
            rms, mean = _rms(ours["lateral_m"].to_numpy() - theirs), float(theirs.mean())
            rows.append(
                {
                    "scenario": run.scenario_name,
                    "code": run.code,
                    "seed": run.seed,
                    "source": source,
                    "curve": curve,
                    "cycle": int(cycle),
                    "rms_m": rms,
                    "relative": rms / abs(mean) if mean else math.nan,
                    "ratio": float(ours["lateral_m"].mean()) / mean if mean else math.nan,
                }
            )
    return pd.DataFrame(
        rows, columns=["scenario", "code", "seed", "source", "curve", "cycle", "rms_m", "relative", "ratio"]
    )


def _clean(cycles, values) -> tuple[np.ndarray, np.ndarray]:
    cycles, values = np.asarray(cycles, dtype=float), np.asarray(values, dtype=float)
    usable = np.isfinite(cycles) & np.isfinite(values)
    return cycles[usable], values[usable]


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
