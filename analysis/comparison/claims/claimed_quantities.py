"""Quantities of one run that claims are about."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from analysis.comparison import against_published, run_quantities, settlement_fits
from analysis.formats.file_columns import PLATES, SPHERES
from analysis.scenarios import derived


def _at(run, cycle: int) -> pd.Series | None:
    rows = run.cycles[run.cycles["cycle"] == cycle]
    return rows.iloc[0] if len(rows) else None


def settlement(run, cycle: int) -> float:
    """Settlement at minimum load after `cycle`, m."""
    row = _at(run, cycle)
    return math.nan if row is None else float(row["settlement_m"])


def lateral_profile(run, cycle: int) -> np.ndarray:
    """Lateral displacement of plates 1 (bottom) to 5 after `cycle`, m."""
    row = _at(run, cycle)
    return np.full(5, math.nan) if row is None else row[[f"lateral_{k}_m" for k in PLATES]].to_numpy(dtype=float)


def porosities(run, cycle: int) -> np.ndarray:
    """Porosity of spheres 1 to 3 after `cycle`; 0 is the end of preload."""
    table = run.microstructure if cycle == 0 else run.cycles
    rows = table.loc[table["cycle"] == cycle, [f"porosity_{k}" for k in SPHERES]]
    return rows.iloc[0].to_numpy(dtype=float) if len(rows) else np.full(3, math.nan)


def porosity_range(run, cycle: int) -> float:
    """Largest minus smallest porosity of each sphere from the end of preload to `cycle`, averaged over the spheres."""
    rows = run.cycles.loc[run.cycles["cycle"] <= cycle, [f"porosity_{k}" for k in SPHERES]].to_numpy(dtype=float)
    return float(np.ptp(np.vstack([porosities(run, 0), rows]), axis=0).mean())


def exponential_share(run, last: int, threshold: float) -> float:
    """Exponential part over the whole settlement after cycle `last`, both of the fitted law.

    0 where another law describes the curve better or settlement starts slower than it goes on. Where the curve leaves
    the law undecided (`settlement_fits.choose`): the share of the exponential law if that is below `threshold`, since
    whichever law is right the share then is, else nan.
    """
    table = run.cycles[run.cycles["cycle"] <= last]
    choice = settlement_fits.choose(table["cycle"], table["settlement_m"])
    if choice.best is None:
        return math.nan
    fit = choice.fits["exponential"]
    share = max(0.0, float(-fit.values["b"] * math.expm1(-last / fit.values["c"]) / fit.settlement([last])[0]))
    if choice.exponential_start == "yes":
        return share
    return 0.0 if choice.exponential_start == "no" else share if share < threshold else math.nan


def slope(cycles, values, first: int, last: int) -> float:
    """Least-squares slope over first <= cycle <= last, per cycle; nan with fewer than three values."""
    cycles, values = np.asarray(cycles, dtype=float), np.asarray(values, dtype=float)
    inside = (cycles >= first) & (cycles <= last) & np.isfinite(values)
    return float(np.polyfit(cycles[inside], values[inside], 1)[0]) if inside.sum() >= 3 else math.nan


def run_slope(run, first: int, last: int) -> float:
    """`slope` of a run's settlement, m per cycle."""
    return slope(run.cycles["cycle"], run.cycles["settlement_m"], first, last)


def seconds_per_cycle(run) -> float:
    """Computing time of one cycle of loading, s."""
    if run.scenario is None:
        return math.nan
    return derived.time_grid(run.scenario).steps_per_cycle / run_quantities.steps_per_second(run)


def settlement_difference(run, curve: pd.DataFrame, last: int, what: str) -> float:
    """A field of `against_published.against_reference` (rms_m, shift_m, rms_shifted_m), over the curve's points up to
    `last`.
    """
    points = curve[curve["cycle"] <= last]
    ours = run.cycles["cycle"], run.cycles["settlement_m"]
    result = against_published.against_reference(*ours, points["cycle"], points["value"])
    return getattr(result, what) if result else math.nan


def profile_error(run, curve: pd.DataFrame, cycle: int) -> float:
    """rms difference of the plates' lateral displacement from the reference's profile, over the mean of that profile.

    The profile is interpolated at the plates' mid-heights; plates that it does not reach do not count, three have to.
    """
    if run.scenario is None:
        return math.nan
    depth, half = run_quantities.plate_depths(run.scenario), run.scenario["geometry.plate_height"] / 2
    points = curve.sort_values("depth_m")
    covered = (depth >= points["depth_m"].min() - half) & (depth <= points["depth_m"].max() + half)
    if covered.sum() < 3:
        return math.nan
    theirs = np.interp(depth[covered], points["depth_m"], points["value"])
    return float(np.sqrt(np.mean((lateral_profile(run, cycle)[covered] - theirs) ** 2)) / np.abs(theirs).mean())
