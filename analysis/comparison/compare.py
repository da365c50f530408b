"""Runs against each other and against reference curves, as tidy frames.

Statistics are compared, never trajectories: packings are chaotic, so two codes that solve the same equations give the
same settlement after N cycles only within the scatter of seeds.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import stats

from analysis.comparison import quantities
from analysis.normalised import tables

AGREEMENT = (
    "profile",
    "scenario",
    "quantity",
    "cycle",
    "unit",
    *(f"{code}_{what}" for code in tables.CODES for what in ("mean", "low", "high", "seeds")),
    "difference",
    "ratio",
    "seed_scatter",
    "within_scatter",
)


# ---------------------------------------------------------------------- seeds


def seed_bands(table: pd.DataFrame, columns: Sequence[str]) -> pd.DataFrame:
    """Mean, least and largest value over seeds, of a tidy frame (of `Runs.cycles`, say).

    Columns: profile, scenario, code, cycle, seeds, then NAME_mean, NAME_low, NAME_high for each of `columns`.
    `seeds` counts the runs that reach the cycle; with one run the band has no width.
    """
    keys = ["profile", "scenario", "code", "cycle"]
    grouped = table.groupby(keys, sort=True)
    parts = {"seeds": grouped["seed"].nunique()}
    for name in columns:
        parts |= {
            f"{name}_mean": grouped[name].mean(),
            f"{name}_low": grouped[name].min(),
            f"{name}_high": grouped[name].max(),
        }
    return pd.DataFrame(parts).reset_index()


# ---------------------------------------------------------------------- code against code


def last_common_cycle(runs: Iterable) -> int:
    """The last cycle that all `runs` have finished; 0 without."""
    return min((int(run.cycles["cycle"].max()) if len(run.cycles) else 0 for run in runs), default=0)


def agreement(runs: Iterable, cycles: Sequence[int] = quantities.CYCLES_SHOWN) -> pd.DataFrame:
    """The two codes next to each other (columns AGREEMENT), for each profile and scenario that both have run.

    Every quantity after those of `cycles` that all runs of both codes have finished, and after the last that they all
    have; quantities that are 0 in all runs are left out.
    CODE_mean, _low, _high, _seeds   over the seeds of a code
    difference, ratio   LIGGGHTS minus and over YADE, of the means
    seed_scatter        standard deviation between seeds, pooled over both codes; nan where each has but one
    within_scatter      whether the difference is within its 95 % confidence interval (Student's t); None where the
                        scatter is unknown
    """
    runs = list(runs)
    rows = []
    for profile, scenario in dict.fromkeys((run.profile, run.scenario_name) for run in runs):
        members = {
            code: [
                r for r in runs if (r.profile, r.scenario_name, r.code) == (profile, scenario, code) and len(r.cycles)
            ]
            for code in tables.CODES
        }
        if not all(members.values()):
            continue
        last = last_common_cycle(members["yade"] + members["liggghts"])
        shown = [*(n for n in cycles if n < last), last]
        values = {code: pd.concat([_values(run, shown, last) for run in found]) for code, found in members.items()}
        for (quantity, cycle, unit), _ in values["yade"].groupby(["quantity", "cycle", "unit"], sort=False):
            samples = {
                code: v.loc[(v["quantity"] == quantity) & (v["cycle"] == cycle), "value"].dropna().to_numpy(dtype=float)
                for code, v in values.items()
            }
            if all(len(s) for s in samples.values()) and any(s.any() for s in samples.values()):
                rows.append((profile, scenario, quantity, cycle, unit, *_compare(samples)))
    return pd.DataFrame(rows, columns=AGREEMENT)


def _values(run, shown: Sequence[int], last: int) -> pd.DataFrame:
    """The compared quantities of one run, nothing beyond cycle `last`: quantity, cycle, unit, value."""
    seen = _Until(run, last)
    table = quantities.after_cycles(seen, shown)
    mean = seen.cycles.set_index("cycle")[[f"lateral_{k}_m" for k in tables.PLATES]].mean(axis=1, skipna=False)
    further = [("lateral_mean_m", n, "m", mean.get(n, math.nan)) for n in shown]
    further.append(("tracking_worst_Pa", last, "Pa", seen.cycles["tracking_rms_Pa"].max()))
    further.append(
        (
            "late_slope_m",
            last,
            "m per cycle",
            quantities.late_slope(seen.cycles["cycle"], seen.cycles["settlement_m"])[0],
        )
    )
    columns = ["quantity", "cycle", "unit", "value"]
    return pd.concat([table.loc[table["cycle"].isin([0, *shown]), columns], pd.DataFrame(further, columns=columns)])


class _Until:
    """A run seen up to a cycle, so that longer and shorter runs are measured alike."""

    def __init__(self, run, last: int):
        self.scenario = run.scenario
        self.cycles, self.microstructure = (t[t["cycle"] <= last] for t in (run.cycles, run.microstructure))
        self.history = run.history[run.history["cycle"] <= last + 1e-6]


def _compare(samples: dict[str, np.ndarray]) -> tuple:
    means = {code: float(s.mean()) for code, s in samples.items()}
    difference = means["liggghts"] - means["yade"]
    ratio = means["liggghts"] / means["yade"] if means["yade"] else math.nan
    degrees = sum(len(s) - 1 for s in samples.values())
    scatter = (
        math.sqrt(sum(float(np.sum((s - s.mean()) ** 2)) for s in samples.values()) / degrees) if degrees else math.nan
    )
    error = scatter * math.sqrt(sum(1 / len(s) for s in samples.values()))
    within = None if math.isnan(scatter) else bool(abs(difference) <= stats.t.ppf(0.975, degrees) * error)
    bands = [
        x
        for code in tables.CODES
        for x in (means[code], float(samples[code].min()), float(samples[code].max()), len(samples[code]))
    ]
    return *bands, difference, ratio, scatter, within


def lateral_agreement(runs: Iterable, cycles: Sequence[int] = quantities.CYCLES_SHOWN) -> pd.DataFrame:
    """Shape of the lateral profiles of both codes: profile, scenario, cycle, rms_m, ratio, correlation.

    rms_m         rms difference of the plates' displacements (means over seeds)
    ratio         LIGGGHTS over YADE, of the displacement averaged over the plates
    correlation   of the five displacements
    """
    runs = list(runs)
    rows = []
    for profile, scenario in dict.fromkeys((run.profile, run.scenario_name) for run in runs):
        found = {
            code: [r for r in runs if (r.profile, r.scenario_name, r.code) == (profile, scenario, code)]
            for code in tables.CODES
        }
        last = last_common_cycle(found["yade"] + found["liggghts"])
        if not all(found.values()) or not last:
            continue
        for n in [*(n for n in cycles if n < last), last]:
            mean = {}
            for code, members in found.items():
                profiles = [quantities.lateral_profile(run, [n])["lateral_m"].to_numpy(dtype=float) for run in members]
                profiles = [p for p in profiles if len(p) == 5 and np.isfinite(p).all()]
                mean[code] = np.mean(profiles, axis=0) if profiles else None
            yade, liggghts = mean["yade"], mean["liggghts"]
            if yade is None or liggghts is None:
                continue
            spread = np.std(yade) * np.std(liggghts)
            rows.append(
                (
                    profile,
                    scenario,
                    n,
                    float(np.sqrt(np.mean((liggghts - yade) ** 2))),
                    float(liggghts.mean() / yade.mean()) if yade.mean() else math.nan,
                    float(np.mean((yade - yade.mean()) * (liggghts - liggghts.mean())) / spread)
                    if spread
                    else math.nan,
                )
            )
    return pd.DataFrame(rows, columns=["profile", "scenario", "cycle", "rms_m", "ratio", "correlation"])


# ---------------------------------------------------------------------- run against reference curve


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
    cycles, ours = _clean(cycles, settlement_m)
    order = np.argsort(reference_cycles, kind="stable")
    at, theirs = np.asarray(reference_cycles, dtype=float)[order], np.asarray(reference_m, dtype=float)[order]
    error = (
        np.broadcast_to(np.asarray(error_m, dtype=float), at.shape)[order]
        if np.ndim(error_m)
        else np.full(at.shape, float(error_m))
    )
    if not len(cycles):
        return None
    inside = np.isfinite(at) & np.isfinite(theirs) & (at >= cycles[0]) & (at <= cycles[-1])
    at, theirs, error = at[inside], theirs[inside], error[inside]
    if len(at) < 3:
        return None
    difference = np.interp(at, cycles, ours) - theirs
    shift = float(difference.mean())

    def within(d: np.ndarray) -> float:
        return float(np.mean(np.abs(d) <= error)) if np.isfinite(error).all() else math.nan

    late = at >= at[-1] / 2
    slopes = (
        [np.polyfit(at[late], v[late], 1)[0] for v in (np.interp(at, cycles, ours), theirs)]
        if late.sum() >= 2 and at[-1] >= 2 * quantities.LEAST_LATE_CYCLES
        else [math.nan] * 2
    )
    first = float(np.interp(at[0], cycles, ours) / theirs[0]) if at[0] <= 2 and theirs[0] else math.nan
    return AgainstReference(
        len(at),
        _rms(difference),
        shift,
        _rms(difference - shift),
        float(slopes[0] / slopes[1]) if slopes[1] else math.nan,
        first,
        within(difference),
        within(difference - shift),
    )


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
            ours = quantities.lateral_profile(run, [int(cycle)]).dropna()
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
