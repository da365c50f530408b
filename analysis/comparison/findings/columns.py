"""What the columns of the findings mean: quantities by the registry, everything else here."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from analysis.formats.quantities import QUANTITIES

UNITS = ("N_m", "kPa", "Pa", "m_s2", "rad", "per_s", "s", "m3", "m", "J", "N", "hours", "ratio", "share")
"""Endings of column names that say the unit; `ratio` and `share` are pure numbers."""

ENDINGS = {
    "_mean": "mean over packed beds, in the row's unit or that of the name",
    "_beds": "number of packed beds",
    "_ratio": "as a share of what it is compared with",
    "_low": "least over packed beds",
    "_high": "largest over packed beds",
}

MEANINGS = {
    "run": "folder of the run",
    "profile": "size of the bed: full is the paper's",
    "scenario": "scenario of scenarios.toml, without its variants",
    "variant": "variants that are laid over it",
    "reading": "true load: the load as prescribed; servo: by PFC's servo",
    "code": "yade or liggghts",
    "seed": "packing seed",
    "model": "contact law: linear or hysteretic",
    "law": "contact law: linear or hysteretic",
    "bed": "first digits of the packed bed's checksum",
    "state": "of a run: finished, interrupted, failed; of a comparison: agrees, differs, cannot tell yet",
    "quantity": "what is compared; its unit is in its name or in the column unit",
    "unit": "SI unit of the row's values",
    "cycle": "number of complete load cycles",
    "cycles": "number of cycles that are there",
    "cycles_wanted": "number of cycles that the run was asked for",
    "first_cycle": "first cycle of a span",
    "last_cycle": "last cycle of a span",
    "worst_cycle": "cycle with the largest tracking error",
    "mean": "mean over the packed beds that reach the cycle",
    "low": "least of them",
    "high": "largest of them",
    "beds": "number of packed beds that reach the cycle",
    "degrees": "degrees of freedom of a pooled scatter",
    "difference": "LIGGGHTS minus YADE, in the row's unit",
    "difference_ratio": "difference over the mean of both; empty where they have no common sign",
    "low_ratio": "lower end of its 95 % interval",
    "high_ratio": "upper end of its 95 % interval",
    "within_ratio": "largest difference that the interval allows",
    "beds_needed": "packed beds per code that would narrow the interval enough",
    "scatter_ratio": "standard deviation between packed beds over their mean, pooled over scenarios",
    "differs": "the one thing in which two runs differ: code, time.step or ranks",
    "one": "one run of a pair",
    "other": "the other run of a pair",
    "codes_ratio": "largest difference between the codes, over their mean",
    "band_ratio": "largest difference by time step or rounding",
    "band_pairs": "pairs of runs that this band rests on",
    "bonds_made": "parallel bonds between particles that touched at the end of packing",
    "broken_share": "bonds broken so far over bonds made",
    "trend": "slowing, steady or growing, up to the end of the span",
    "gain": "gain factor of the servo",
    "lag_from": "what the lag was measured by",
    "contacts": "number of wall contacts that the measured amplitude takes",
    "paper_law": "value with the paper's contact laws, m",
    "stock": "value with the code's own contact model between particles, m",
    "base": "value without the change",
    "changed": "value with the change",
    "change_ratio": "changed over base, minus 1",
    "scatters": "size of the change in standard deviations between packed beds",
    "base_run": "run without the change",
    "met": "whether the load was met within the aim",
    "steps_per_cycle": "time steps of a load cycle",
    "kind": "what is missing: scenario, cycles, seeds, reference",
    "have": "how many are there",
    "want": "how many are wanted",
    "number": "of the claim",
    "about": "whose models the claim is about: paper; chen2015, judged from our own run of that model",
    "claim": "the claim in words",
    "verdict": "of the claim in a code and reading",
    "because": "why the verdict is what it is",
    "without_curve": "what the part says where the experiment's curve is pending",
    "check": "a part of the claim",
    "check_verdict": "of that part",
    "numbers": "measured values with their 95 % half-widths, in words",
    "margin": "by how much the values lie on the claim's side",
    "half_width": "half of the margin's 95 % interval",
    "missing": "what is missing to decide",
    "part": "of the claim; empty for the whole",
    "true_load": "verdict under the true load",
    "servo": "verdict by PFC's servo",
    "outcome": "which reading the claim holds in; empty where one is undecided",
}


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
    if name in MEANINGS:
        return MEANINGS[name]
    for stage in ("packed_", "preloaded_"):
        if name.startswith(stage) and name.removeprefix(stage) in QUANTITIES:
            return f"{QUANTITIES[name.removeprefix(stage)].meaning}; bed {stage.removesuffix('_')}"
    if name in QUANTITIES:
        return QUANTITIES[name].meaning
    words = name.replace("_", " ")
    return next((f"{words}: {text}" for ending, text in ENDINGS.items() if name.endswith(ending)), words)
