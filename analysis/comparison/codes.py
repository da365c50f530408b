"""The two codes against each other, as tidy frames; bands over seeds.

Statistics are compared, never trajectories: packings are chaotic, so two codes that solve the same equations give the
same settlement after N cycles only within the scatter of seeds.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd
from scipy import stats

from analysis.comparison import quantities
from analysis.formats import file_columns

AGREEMENT = (
    "profile",
    "scenario",
    "quantity",
    "cycle",
    "unit",
    *(f"{code}_{what}" for code in file_columns.CODES for what in ("mean", "low", "high", "seeds")),
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
            for code in file_columns.CODES
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
    mean = seen.cycles.set_index("cycle")[[f"lateral_{k}_m" for k in file_columns.PLATES]].mean(axis=1, skipna=False)
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
        self.scenario, self.folder = run.scenario, run.folder
        self.cycles, self.microstructure = (t[t["cycle"] <= last] for t in (run.cycles, run.microstructure))
        self.history = run.history[run.history["cycle"] <= last + 1e-6]
        self._run = run

    @property
    def harmonics(self) -> pd.DataFrame:
        return self._run.harmonics


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
        for code in file_columns.CODES
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
            for code in file_columns.CODES
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
