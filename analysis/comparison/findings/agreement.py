"""LIGGGHTS against YADE: each code from beds of its own, and both from one bed.

A difference is judged by its confidence interval. The scatter between seeds is pooled as a share of the mean over all
scenarios of one contact model and reading, so that it is known better than from one scenario's two or three seeds; a
code with one bed is taken to scatter as much as the other.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import pandas as pd
from scipy import stats

from analysis.comparison import run_quantities, same_bed
from analysis.comparison.findings.members import TRUE_LOAD, Member, groups
from analysis.formats.quantities import CODES, COMPARED

CYCLES = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
"""After which runs are compared, where they reach them."""

AGREES, DIFFERS, OPEN = "agrees", "differs", "cannot tell yet"

AGREES_WITHIN = 0.25
"""Two codes agree where the whole interval of their difference is within this share of their mean. Assumed: half of
what beds of one recipe differ by."""

POROSITY_AGREES_WITHIN = 0.05
"""The same for porosities, which all lie between 0.32 and 0.42: a share of 0.25 could not fail. Assumed: a fifth of the
range from dense to loose ballast."""

RESTATED = ("secant_stiffness_N_m", "bulge_volume_m3")
"""Quantities that restate another one, stroke and mean lateral displacement: they are shown, and not counted again."""

VALUES = ("profile", "scenario", "reading", "code", "quantity", "cycle", "unit", "mean", "low", "high", "beds")


def run_values(member: Member, cycles: Sequence[int] = CYCLES) -> pd.DataFrame:
    """The compared quantities of one run after those of `cycles` that it reached: quantity, cycle, unit, value."""
    reached = [n for n in cycles if n <= run_quantities.last_cycle(member.run)]
    table = run_quantities.after_cycles(member.run, reached)
    table = table[table["quantity"].isin(COMPARED) & table["cycle"].isin(reached)]
    return table[["quantity", "cycle", "unit", "value"]].dropna(subset=["value"])


def seed_values(found: Iterable[Member]) -> pd.DataFrame:
    """`run_values` of all plain runs, one row per run, quantity and cycle, with profile, scenario, reading, code, seed
    and contact model.
    """
    frames = []
    for (profile, scenario, reading, code), group in groups(found).items():
        for m in group:
            model = m.run.scenario["contact.model"] if m.run.scenario is not None else ""
            frames.append(
                run_values(m).assign(
                    profile=profile, scenario=scenario, reading=reading, code=code, seed=m.run.seed, model=model
                )
            )
    columns = ["profile", "scenario", "reading", "code", "seed", "model", "quantity", "cycle", "unit", "value"]
    return pd.concat(frames, ignore_index=True)[columns] if frames else pd.DataFrame(columns=columns)


def band_table(values: pd.DataFrame) -> pd.DataFrame:
    """Mean, least and largest value over the beds that reach a cycle (columns VALUES)."""
    keys = ["profile", "scenario", "reading", "code", "quantity", "cycle", "unit"]
    if values.empty:
        return pd.DataFrame(columns=VALUES)
    found = values.groupby(keys, sort=False)["value"].agg(mean="mean", low="min", high="max", beds="count")
    return found.reset_index()[list(VALUES)]


def scatter_table(values: pd.DataFrame) -> pd.DataFrame:
    """Standard deviation between beds as a share of the mean, pooled over the scenarios and codes of one contact model
    and reading: profile, model, reading, quantity, cycle, scatter_ratio, degrees.
    """
    columns = ["profile", "model", "reading", "quantity", "cycle", "scatter_ratio", "degrees"]
    if values.empty:
        return pd.DataFrame(columns=columns)
    keys = ["profile", "model", "reading", "quantity", "cycle"]
    inner = values.groupby([*keys, "scenario", "code"])["value"].agg(["mean", "count", "var"]).reset_index()
    inner = inner[(inner["count"] > 1) & (inner["mean"] != 0)]
    inner["degrees"] = inner["count"] - 1
    inner["squares"] = inner["var"] * inner["degrees"] / inner["mean"] ** 2
    pooled = inner.groupby(keys)[["squares", "degrees"]].sum().reset_index()
    pooled["scatter_ratio"] = np.sqrt(pooled["squares"] / pooled["degrees"])
    return pooled[columns]


def agrees_within(quantity: str) -> float:
    """The share of their mean within which two codes agree in a quantity."""
    return POROSITY_AGREES_WITHIN if quantity.startswith("porosity_") else AGREES_WITHIN


def judge(
    one: float, other: float, scatter: float, degrees: float, beds: tuple[int, int], within: float = AGREES_WITHIN
) -> dict:
    """The difference of two means over their mean, its 95 % interval, and the state.

    scatter   standard deviation between beds, as a share of the mean; nan where no code has a second bed
    degrees   of freedom of that scatter
    within    share of the mean within which they agree
    Without a common sign there is no ratio: the state is open.
    """
    mean = (one + other) / 2
    row = {"difference": one - other, "difference_ratio": math.nan, "low_ratio": math.nan, "high_ratio": math.nan}
    row |= {"within_ratio": math.nan, "beds_needed": math.nan, "state": OPEN}
    if one * other <= 0 or not math.isfinite(mean):
        return row
    ratio = (one - other) / mean
    row["difference_ratio"] = ratio
    if not (math.isfinite(scatter) and degrees > 0):
        return row
    quantile = float(stats.t.ppf(0.975, degrees))
    half = quantile * scatter * math.sqrt(1 / beds[0] + 1 / beds[1])
    row |= {"low_ratio": ratio - half, "high_ratio": ratio + half, "within_ratio": abs(ratio) + half}
    if row["within_ratio"] <= within:
        row["state"] = AGREES
    elif half < abs(ratio):
        row["state"] = DIFFERS
    else:
        row["beds_needed"] = math.ceil(2 * (quantile * scatter / within) ** 2)
    return row


def agreement_table(values: pd.DataFrame, scatter: pd.DataFrame) -> pd.DataFrame:
    """Both codes next to each other at equal cycles, each from its own beds: a row per scenario, reading, quantity and
    cycle that a run of each code has reached, see `judge`.
    """
    known = scatter.set_index(["profile", "model", "reading", "quantity", "cycle"])
    rows = []
    keys = ["profile", "scenario", "reading", "quantity", "cycle", "unit", "model"]
    for key, part in values.groupby(keys, sort=False):
        profile, scenario, reading, quantity, cycle, unit, model = key
        samples = {code: part.loc[part["code"] == code, "value"].to_numpy() for code in CODES}
        if not all(len(s) for s in samples.values()) or not any(s.any() for s in samples.values()):
            continue
        found = known.loc[(profile, model, reading, quantity, cycle)] if key_in(known, key) else None
        spread = (math.nan, 0) if found is None else (float(found["scatter_ratio"]), float(found["degrees"]))
        means = {code: float(s.mean()) for code, s in samples.items()}
        beds = tuple(len(samples[code]) for code in ("liggghts", "yade"))
        rows.append(
            {
                "profile": profile,
                "scenario": scenario,
                "reading": reading,
                "quantity": quantity,
                "cycle": cycle,
                "unit": unit,
                **{f"{code}_mean": means[code] for code in CODES},
                **{f"{code}_beds": len(samples[code]) for code in CODES},
                "scatter_ratio": spread[0],
                **judge(means["liggghts"], means["yade"], *spread, beds, agrees_within(quantity)),
            }
        )
    return pd.DataFrame(rows, columns=AGREEMENT)


def key_in(known: pd.DataFrame, key: tuple) -> bool:
    """Whether a pooled scatter is known for a row of `agreement_table`."""
    profile, _, reading, quantity, cycle, _, model = key
    return (profile, model, reading, quantity, cycle) in known.index


AGREEMENT = (
    "profile",
    "scenario",
    "reading",
    "quantity",
    "cycle",
    "unit",
    *(f"{code}_mean" for code in CODES),
    *(f"{code}_beds" for code in CODES),
    "scatter_ratio",
    "difference",
    "difference_ratio",
    "low_ratio",
    "high_ratio",
    "within_ratio",
    "state",
    "beds_needed",
)

SAME_BED = (
    "profile",
    "scenario",
    "reading",
    "bed",
    "differs",
    "one",
    "other",
    "cycle",
    "one_m",
    "other_m",
    "difference_m",
    "difference_ratio",
)


def same_bed_table(found: Iterable[Member]) -> pd.DataFrame:
    """Settlement of runs from one bed that differ in code, time step or rounding alone (columns SAME_BED); cycle 0 is
    preload.
    """
    rows = []
    for m, pair in _pairs(found):
        for row in same_bed.settlements(pair).to_dict("records"):
            rows.append(
                {
                    "profile": m.run.profile,
                    "scenario": m.scenario,
                    "reading": m.reading,
                    "bed": m.bed[:8],
                    "differs": pair.differs,
                    "one": pair.one.id,
                    "other": pair.other.id,
                    **row,
                }
            )
    return pd.DataFrame(rows, columns=SAME_BED)


def pairs_by_bed(found: Iterable[Member]) -> dict[tuple[str, str, str], list[same_bed.Pair]]:
    """Pairs of runs from one bed that differ in one thing alone, by scenario, reading and checksum of the bed."""
    by_bed: dict[tuple[str, str, str], list[same_bed.Pair]] = {}
    for m, pair in _pairs(found):
        by_bed.setdefault((m.scenario, m.reading, m.bed), []).append(pair)
    return by_bed


def _pairs(found: Iterable[Member]) -> Iterator[tuple[Member, same_bed.Pair]]:
    """Pairs of runs from one bed, each with the member that its first run is."""
    by_run = {id(m.run): m for m in found}
    for pair in same_bed.same_bed_pairs([m.run for m in by_run.values()]):
        yield by_run[id(pair.one)], pair


HALF_STEP = 0.02
"""Two time steps are one half of the other to within this share: a cycle is a whole number of steps."""


def replicates(timestep: pd.DataFrame) -> pd.DataFrame:
    """Pairs of LIGGGHTS runs of `make timestep` from one bed, under the true load, that differ in rounding (ranks) or
    by half a time step alone: scenario, bed, one, other, cycle, difference_ratio (over the mean of the two).
    """
    columns = ["scenario", "bed", "one", "other", "cycle", "difference_ratio"]
    if timestep.empty:
        return pd.DataFrame(columns=columns)
    shared = timestep[timestep["cycle"].isin(same_bed.SHARED_CYCLES)]
    pairs = shared.merge(shared, on=["scenario", "bed", "cycle"], suffixes=("_one", "_other"))
    ratio = pairs["time_step_s_one"] / pairs["time_step_s_other"]
    rounding = (ratio == 1) & (pairs["ranks_one"] < pairs["ranks_other"])
    half = (ratio.sub(2).abs() < 2 * HALF_STEP) & (pairs["ranks_one"] == pairs["ranks_other"])
    pairs = pairs[rounding | half]
    one, other = pairs["settlement_m_one"], pairs["settlement_m_other"]
    pairs = pairs.rename(columns={"case_one": "one", "case_other": "other"})
    return pairs.assign(difference_ratio=2 * (other - one) / (one + other))[columns]


def same_bed_verdicts(pairs: pd.DataFrame, timestep: pd.DataFrame | None = None) -> pd.DataFrame:
    """Is the criterion met, that the codes differ by no more than half a time step or rounding alone changes?

    A row per profile, scenario, reading and bed: largest difference between the codes and largest of the band, both
    over the judged cycles and as a share of the settlement, the state (for which a band of LEAST_PAIRS pairs is
    needed and no OTHER_DASHPOT), and both after the last cycle that the codes share. The band is that of all pairs of
    one code in that scenario and reading, from whatever bed, and of the `replicates` of the time step's study.
    """
    more = replicates(pd.DataFrame() if timestep is None else timestep)
    of_codes = pairs["differs"].isin([same_bed.CODE, same_bed.CODE_AND_DASHPOT])
    codes, alone = pairs[of_codes], pairs[~of_codes]
    alone = pd.concat([alone, more.assign(profile="full", reading=TRUE_LOAD)], ignore_index=True)
    codes, alone = (part.assign(size=part["difference_ratio"].abs()) for part in (codes, alone))
    bed = ["profile", "scenario", "reading", "bed"]
    rows = []
    for where, part in codes.groupby(bed, sort=False):
        band = alone[(alone[bed[:3]] == list(where[:3])).all(axis=1)]
        rows.append(dict(zip(bed, where, strict=True)) | _against_band(part, band))
        if (part["differs"] == same_bed.CODE_AND_DASHPOT).any():
            rows[-1]["state"] = OTHER_DASHPOT
    columns = [*bed, "cycles", "codes_ratio", "band_ratio", "band_pairs", "state"]
    columns += ["late_cycle", "codes_late_ratio", "band_late_ratio"]
    return pd.DataFrame(rows, columns=columns)


OTHER_DASHPOT = "another dashpot"
"""State of a pair whose codes differ in the law, too: not judged."""

LEAST_PAIRS = 3
"""Of runs that differ by half a time step or rounding; one or two do not say how far they scatter."""


def _against_band(codes: pd.DataFrame, band: pd.DataFrame) -> dict:
    """Differences between the codes against those by time step or rounding; `size` is that of a difference."""
    last = codes["cycle"].max()
    late = [float(part.loc[part["cycle"] == last, "size"].max()) for part in (codes, band)]
    codes, band = (part[part["cycle"] <= same_bed.JUDGED_CYCLES] for part in (codes, band))
    largest = float(codes["size"].max())
    limit = float(band["size"].max()) if len(band) else math.nan
    number = len(band[["bed", "one", "other"]].drop_duplicates())
    return {
        "cycles": int(codes["cycle"].max()),
        "codes_ratio": largest,
        "band_ratio": limit,
        "band_pairs": number,
        "state": OPEN if number < LEAST_PAIRS else AGREES if largest <= limit else DIFFERS,
        "late_cycle": int(last),
        "codes_late_ratio": late[0],
        "band_late_ratio": late[1],
    }
