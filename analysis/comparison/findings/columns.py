"""What the columns of the findings mean: quantities by the registry, everything else here."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import pandas as pd

from analysis.formats.quantities import QUANTITIES, SHOWN_UNITS

UNITS = ("N_m", "kPa", "Pa", "m_s2", "rad", "per_s", "s", "m3", "m", "J", "N", "hours", "ratio", "share")
"""Endings of column names that say the unit; `ratio` and `share` are pure numbers."""

ENDINGS = {
    "_mean": "mean over packed beds, in the row's unit or that of the name",
    "_beds": "number of packed beds",
    "_ratio": "as a share of what it is compared with",
    "_low": "least over packed beds",
    "_high": "largest over packed beds",
}


@dataclass(frozen=True)
class Told:
    """What a column of the findings is, where formats/quantities.py does not say it.

    meaning   for columns.csv; by the ending of the name where it is empty
    label     heading, without its unit; the name in words where it is empty
    shown     unit and factor for people where they do not follow from the ending of the name
    """

    meaning: str = ""
    label: str = ""
    shown: tuple[str, float] | None = None


PERCENT, MICROSECONDS, MILLISECONDS, PLAIN = ("%", 100.0), ("µs", 1e6), ("ms", 1e3), ("", 1.0)
MICROMETRES = ("µm", 1e6)
STAGES = {"packed_": "packed", "preloaded_": "preloaded"}
"""What stands before the name of a quantity that is told of the bed after a stage."""

TOLD = {
    "run": Told("folder of the run"),
    "profile": Told("size of the bed: full is the paper's"),
    "scenario": Told("scenario of scenarios.toml, without its variants"),
    "variant": Told("variants that are laid over it", "changed"),
    "reading": Told("true load: the load as prescribed; servo: by PFC's servo", "load"),
    "code": Told("yade or liggghts"),
    "seed": Told("packing seed"),
    "model": Told("contact law: linear or hysteretic"),
    "law": Told("contact law: linear or hysteretic"),
    "bed": Told("first digits of the packed bed's checksum"),
    "state": Told(
        "of a run: finished, interrupted, failed; of a comparison: agrees, differs, cannot tell yet, another dashpot",
        "verdict",
    ),
    "quantity": Told("what is compared; its unit is in its name or in the column unit"),
    "unit": Told("SI unit of the row's values"),
    "cycle": Told("number of complete load cycles"),
    "cycles": Told("number of cycles that are there"),
    "cycles_wanted": Told("number of cycles that the run was asked for"),
    "first_cycle": Told("first cycle of a span"),
    "last_cycle": Told("last cycle of a span"),
    "worst_cycle": Told("cycle with the largest tracking error"),
    "mean": Told("mean over the packed beds that reach the cycle"),
    "low": Told("least of them"),
    "high": Told("largest of them"),
    "beds": Told("number of packed beds that reach the cycle", "beds"),
    "degrees": Told("degrees of freedom of a pooled scatter"),
    "difference": Told("LIGGGHTS minus YADE, in the row's unit"),
    "difference_ratio": Told("difference over the mean of both; empty where they have no common sign", "difference"),
    "low_ratio": Told("lower end of its 95 % interval"),
    "high_ratio": Told("upper end of its 95 % interval"),
    "within_ratio": Told("largest difference that the interval allows"),
    "beds_needed": Told("packed beds per code that would narrow the interval enough"),
    "scatter_ratio": Told(
        "standard deviation between packed beds over their mean, pooled over scenarios", "scatter between beds"
    ),
    "steps_ratio": Told(
        "standard deviation of settlement over time steps, over the mean of the study's", "over all time steps"
    ),
    "beds_ratio": Told("standard deviation of settlement over packed beds, over the same mean", "over packed beds"),
    "rounding_ratio": Told(
        "standard deviation of settlement by the number of ranks, over the same mean", "by rounding alone"
    ),
    "differs": Told(
        "the one thing in which two runs differ: code, time.step or ranks; or code and dashpot, where YADE has not the "
        "paper's"
    ),
    "one": Told("one run of a pair"),
    "other": Told("the other run of a pair"),
    "codes_ratio": Told("largest difference between the codes, over their mean", "largest difference of the codes"),
    "band_ratio": Told("largest difference by time step or rounding", "of time step and rounding"),
    "late_cycle": Told("the last cycle that the runs of both codes share", "later cycle"),
    "codes_late_ratio": Told("the same difference after that cycle", "codes after it"),
    "band_late_ratio": Told("largest difference by time step or rounding after that cycle", "band after it"),
    "band_pairs": Told("pairs of runs that this band rests on", "pairs"),
    "bonds_made": Told("parallel bonds between particles that touched at the end of packing"),
    "broken_share": Told("bonds broken so far over bonds made"),
    "trend": Told("slowing, steady or growing, up to the end of the span"),
    "gain": Told("gain factor of the servo", "gain"),
    "lag_from": Told("what the lag was measured by"),
    "contacts": Told("number of wall contacts that the measured amplitude takes", "contacts"),
    "paper_law": Told("value with the paper's contact laws, m", "the paper's law"),
    "stock": Told("value with the code's own contact model between particles, m", "the code's own"),
    "base": Told("value without the change", "as it is"),
    "changed": Told("value with the change", "changed"),
    "change_ratio": Told("changed over base, minus 1", "change"),
    "scatters": Told("size of the change in standard deviations between packed beds", "in scatters of a bed"),
    "base_run": Told("run without the change"),
    "met": Told("whether the load was met within the aim"),
    "steps_per_cycle": Told("time steps of a load cycle"),
    "kind": Told("what is missing: scenario, cycles, seeds, reference"),
    "have": Told("how many are there"),
    "want": Told("how many are wanted"),
    "about": Told("whose models the claim is about: paper; chen2015, judged from our own run of that model"),
    "name": Told("the claim in a few words", "claim"),
    "claim": Told("the claim in words"),
    "verdict": Told("of the claim in a code and reading"),
    "because": Told("why the verdict is what it is"),
    "without_curve": Told("what the part says where the experiment's curve is pending"),
    "numbers": Told("measured values with their 95 % half-widths, in words"),
    "margin": Told("by how much the values lie on the claim's side"),
    "half_width": Told("half of the margin's 95 % interval"),
    "missing": Told("what is missing to decide"),
    "part": Told("of the claim; empty for the whole"),
    "bed_stiffness_N_m": Told(label="stiffness of the bed"),
    "bed_loss_angle_rad": Told(label="loss angle of the bed"),
    "time_constant_s": Told(label="time constant", shown=MILLISECONDS),
    "amplitude_ratio": Told(label="amplitude"),
    "predicted_amplitude_ratio": Told(label="predicted amplitude"),
    "lag_rad": Told(label="lag"),
    "predicted_lag_rad": Told(label="predicted lag"),
    "true_load_stiffness_N_m": Told("dynamic stiffness of the same bed under the true load", "stiffness, true load"),
    "forecast_amplitude_ratio": Told("predicted with the stiffness under the true load", "forecast amplitude"),
    "forecast_lag_rad": Told("predicted with the stiffness under the true load", "forecast lag"),
    "elastic_m": Told(label="elastic"),
    "permanent_m": Told(label="permanent"),
    "liggghts_mean": Told(label="LIGGGHTS"),
    "yade_mean": Told(label="YADE"),
    "preload_settlement_m": Told(label="settlement in preload"),
    "step_s": Told(label="time step", shown=MICROSECONDS),
    "time_step_s": Told(label="time step", shown=MICROSECONDS),
    "steps_per_s": Told(label="steps per second", shown=PLAIN),
    "hours_per_1000_cycles": Told(label="hours for 1000 cycles"),
    "steps_per_cpu_s": Told(label="steps per second of processor time", shown=PLAIN),
    "steps_per_wall_s": Told(label="steps per second by the clock", shown=PLAIN),
    "ranks": Told(label="ranks or threads"),
    "share": Told(label="share", shown=PERCENT),
    "sleeper_work_J": Told(label="work of the sleeper per cycle"),
    "settlement_rate_m": Told(label="settlement per cycle", shown=MICROMETRES),
    "lateral_rate_m": Told(label="plates, per cycle", shown=MICROMETRES),
    "crib_heave_rate_m": Told(label="heave of cribs, per cycle", shown=MICROMETRES),
    "lattice_gap_m": Told(label="gap"),
    "clumps_over_reported": Told(label="of the paper's", shown=PERCENT),
    "tracking_worst_ratio": Told(label="tracking error"),
    "number": Told("of the claim", "claim"),
    "true_load": Told("verdict under the true load", "true load"),
    "servo": Told("verdict by PFC's servo", "PFC's servo"),
    "outcome": Told("which reading the claim holds in; empty where one is undecided", "the claim holds"),
    "check": Told("a part of the claim", "part of the claim"),
    "check_verdict": Told("of that part", "verdict"),
    "rel_error": Told(label="relative error", shown=PLAIN),
    "scenario_hash": Told(label="parameters"),
    "git_commit": Told(label="commit"),
    "best": Told("law that describes the curve best, by the Bayesian information criterion", "best law"),
    "exponential_start": Told("yes, no or undecided", "exponential start"),
    "reason": Told("why the law was chosen"),
    **{
        f"exponential_{name}_{end}": Told(f"{where} end of its 95 % interval")
        for name in "abcd"
        for end, where in (("low", "lower"), ("high", "upper"))
    },
    "plate_moved_low_m": Told("least displacement of a plate, outward since the end of preload"),
    "plate_moved_high_m": Told("largest of them"),
    "plate_mean_low_Pa": Told("least of the plates' mean stresses, over the cycles so far"),
    "plate_mean_high_Pa": Told("largest of them"),
    "plate_low_Pa": Told("least stress of any plate, over the cycles so far"),
    "plate_high_Pa": Told("largest of them"),
}


def label_of_column(name: str) -> tuple[str, str, float]:
    """(label, unit for people, factor from SI) of a column of any finding."""
    if name in QUANTITIES:
        quantity = QUANTITIES[name]
        return quantity.label, "" if quantity.unit == "cycles" else quantity.shown_unit, quantity.factor
    for start, stage in STAGES.items():
        if (told_of := name.removeprefix(start)) != name and told_of in QUANTITIES:
            label, unit, factor = label_of_column(told_of)
            return f"{label}, {stage}", unit, factor
    told = TOLD.get(name, Told())
    ending = next((unit for unit in ("ratio", "share") if name.endswith(f"_{unit}")), "")
    unit, factor = told.shown or (PERCENT if ending else SHOWN_UNITS.get(_unit(name), PLAIN))
    return told.label or name.replace("_", " "), unit, factor


def describe(frames: Iterable[pd.DataFrame]) -> pd.DataFrame:
    """A row per column of these tables: column, unit, meaning."""
    names = dict.fromkeys(str(name) for frame in frames for name in frame)
    rows = [{"column": name, "unit": _unit(name), "meaning": _meaning(name)} for name in names]
    return pd.DataFrame(rows, columns=["column", "unit", "meaning"])


def _unit(name: str) -> str:
    if name in QUANTITIES:
        return QUANTITIES[name].unit
    ending = next((unit for unit in UNITS if name.endswith(f"_{unit}")), "")
    return {"ratio": "-", "share": "-", "N_m": "N/m", "m_s2": "m/s2", "per_s": "1/s"}.get(ending, ending)


def _meaning(name: str) -> str:
    if name in TOLD and TOLD[name].meaning:
        return TOLD[name].meaning
    for start, stage in STAGES.items():
        if name.startswith(start) and name.removeprefix(start) in QUANTITIES:
            return f"{QUANTITIES[name.removeprefix(start)].meaning}; bed {stage}"
    if name in QUANTITIES:
        return QUANTITIES[name].meaning
    words = name.replace("_", " ")
    return next((f"{words}: {text}" for ending, text in ENDINGS.items() if name.endswith(ending)), words)
