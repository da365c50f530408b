"""The answer in numbers: what the first page and the README say in words, from the findings alone."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass

import pandas as pd

from analysis.comparison.claims.evidence import HOLDS, PAPER
from analysis.comparison.findings.agreement import (
    AGREES,
    AGREES_WITHIN,
    DIFFERS,
    OPEN,
    OTHER_DASHPOT,
    POROSITY_AGREES_WITHIN,
    RESTATED,
)
from analysis.comparison.findings.find import Findings
from analysis.comparison.findings.influence import LEAST_INFLUENCE, size_of_change
from analysis.comparison.findings.members import READINGS, SERVO, TRUE_LOAD
from analysis.comparison.run_quantities import value_after
from analysis.formats import file_columns
from analysis.formats.quantities import CODES, QUANTITIES
from analysis.formats.run_record import DIVERGED
from analysis.reference.ballast_stiffness import ballast_stiffness


@dataclass(frozen=True)
class Outcome:
    """How one scenario settles in one reading and code; SI units, nan where it is not known."""

    scenario: str
    reading: str
    code: str
    cycle: int
    """After which it is told, see `told_cycle`."""
    beds: int
    settlement_m: float
    low_m: float
    high_m: float
    first_m: float
    """After the first cycle."""
    longest: int
    """Cycles of the longest run."""
    failure: str
    """What ended the longest run in the cycle after; empty where it did not fail."""
    trend: str
    """slowing, steady, growing or empty, of the longest run."""
    last_m: float
    """Settlement after the last cycle of the longest run."""
    rate_m: float
    """Settlement per cycle in its last span of cycles."""
    heave_m: float
    """Largest heave of the cribs in it."""
    outward_m: float
    """Largest lateral displacement of a plate at its end."""
    run_in_m: float
    """By how much the plate that is farthest in has then run inward; 0 where none has."""
    stroke_m: float
    """Resilient stroke in the cycle that is told, and its peak acceleration."""
    peak_acceleration_m_s2: float
    stress_min_Pa: float
    stress_max_Pa: float
    elastic_m: float
    """What of the settlement springs back at the least prescribed stress, where that was measured; mean over beds."""
    law: str
    """Which law describes the settlement of the longest run best: exponential, logarithm, power, line or empty."""
    exponential_start: str
    """Whether that run has the exponential start: yes, no, undecided or empty."""

    @property
    def first_share(self) -> float:
        """Settlement of the first cycle over that of all."""
        return self.first_m / self.settlement_m if self.settlement_m else math.nan


def outcomes(found: Findings, scenarios: Iterable[str], profile: str) -> dict[tuple[str, str, str], Outcome]:
    """The outcomes of `scenarios` by scenario, reading and code; those without a run are not there."""
    result = {}
    for scenario in scenarios:
        for reading in READINGS:
            for code in CODES:
                outcome = _outcome(found, profile, scenario, reading, code, told_cycle(found, profile, scenario, code))
                if outcome is not None:
                    result[scenario, reading, code] = outcome
    return result


JUDGED = "full"
"""Profile of the runs that the paper's claims are judged on."""

PLATE_RUNS_IN_M = 0.05
"""Only where the sleeper has sunk to its height does a plate run inward by more than this, two stones: sleeper and
plates do not touch each other."""

LEAST_TOLD = 100
"""Outcomes are told after at least this many cycles where a reading has reached them; a shorter one then is not."""


def told_cycle(found: Findings, profile: str, scenario: str, code: str) -> int:
    """The cycle after which a scenario is told, the same in each reading that is long enough: of those that they all
    have reached, the one with most packed beds, of equals the last.
    """
    rows = only(found.values, profile=profile, scenario=scenario, code=code, quantity="settlement_m")
    last = rows.groupby("reading")["cycle"].transform("max")
    if (last >= LEAST_TOLD).any():
        rows = rows[last >= LEAST_TOLD]
    beds = rows.pivot_table(index="cycle", columns="reading", values="beds").dropna().min(axis=1)
    if beds.empty:
        return 0
    beds = beds[beds.index >= min(LEAST_TOLD, beds.index.max())]
    return int(beds[beds == beds.max()].index.max())


def _outcome(found: Findings, profile: str, scenario: str, reading: str, code: str, cycle: int) -> Outcome | None:
    where = {"profile": profile, "scenario": scenario, "reading": reading, "code": code}
    values = only(found.values, **where, quantity="settlement_m").sort_values("cycle")
    if cycle not in set(values["cycle"]):
        return None
    shared = values.set_index("cycle").loc[cycle]
    first = values.loc[values["cycle"] == 1, "mean"]
    runs = [m for m in found.members if m.plain and m.key == (profile, scenario, reading, code)]
    longest = max(runs, key=lambda m: (m.run.cycles["cycle"].iloc[-1], -m.run.seed)).run
    spans = only(found.rates, run=longest.id)
    inner = longest.microstructure["crib_heave_m"].dropna()
    last = longest.cycles.iloc[-1]
    lateral = [last[f"lateral_{k}_m"] for k in file_columns.PLATES]
    elastic = only(found.elastic, cycle=cycle)
    elastic = elastic[elastic["run"].isin([m.run.id for m in runs])]["elastic_m"]
    laws = only(found.settlement_laws, run=longest.id)
    return Outcome(
        scenario,
        reading,
        code,
        cycle,
        int(shared["beds"]),
        shared["mean"],
        shared["low"],
        shared["high"],
        float(first.iloc[0]) if len(first) else math.nan,
        int(last["cycle"]),
        failure(longest.info),
        spans["trend"].iloc[-1] if len(spans) else "",
        last["settlement_m"],
        spans["settlement_rate_m"].iloc[-1] if len(spans) else math.nan,
        float(inner.max()) if len(inner) else math.nan,
        max(lateral),
        max(0.0, -min(lateral)),
        value_after(longest, "resilient_stroke_m", cycle),
        value_after(longest, "peak_acceleration_m_s2", cycle),
        last["sleeper_stress_min_Pa"],
        last["sleeper_stress_max_Pa"],
        float(elastic.mean()) if len(elastic) else math.nan,
        laws["best"].iloc[0] if len(laws) else "",
        laws["exponential_start"].iloc[0] if len(laws) else "",
    )


def failure(info: dict) -> str:
    """What ended a failed run, of `run.json`, without the step and what follows from it; empty for other runs."""
    if info.get("state") != "failed":
        return ""
    reason = (info.get("reason") or "no reason given").removeprefix(DIVERGED)
    return re.split(r" (?:at|before) step ", reason)[0]


def only(frame: pd.DataFrame, **where) -> pd.DataFrame:
    """The rows in which the named columns have these values."""
    for name, value in where.items():
        frame = frame[frame[name] == value]
    return frame


def compared(agreement: pd.DataFrame) -> pd.DataFrame:
    """Each compared quantity at its last compared cycle, rows of the finding; what restates another is left out."""
    rows = agreement[~agreement["quantity"].isin(RESTATED)]
    return rows.sort_values("cycle").groupby(["scenario", "reading", "quantity"], sort=False).tail(1)


def states(agreement: pd.DataFrame) -> dict[str, int]:
    """How many of the compared quantities agree, differ, or cannot be told."""
    if agreement.empty:
        return {}
    counts = compared(agreement)["state"].value_counts()
    return {state: int(counts.get(state, 0)) for state in (AGREES, DIFFERS, OPEN)}


def differing(agreement: pd.DataFrame) -> list[dict]:
    """Which of the compared quantities differ: scenario, reading, names."""
    if agreement.empty:
        return []
    rows = only(compared(agreement), state=DIFFERS)
    return [
        {"scenario": scenario, "reading": reading, "names": ", ".join(QUANTITIES[q].label for q in part["quantity"])}
        for (scenario, reading), part in rows.groupby(["scenario", "reading"], sort=False)
    ]


def claim_counts(verdicts: pd.DataFrame) -> pd.DataFrame:
    """Number of claims about the paper's models with each verdict, by code and reading: code, reading, verdict, claims,
    names.
    """
    verdicts = of_the_paper(verdicts)
    if verdicts.empty:
        return pd.DataFrame(columns=["code", "reading", "verdict", "claims", "names"])
    table = verdicts if "reading" in verdicts else verdicts.assign(reading=READINGS[0])
    each = table.drop_duplicates(["number", "code", "reading"]).sort_values("number", kind="stable")
    grouped = each.groupby(["code", "reading", "verdict"], sort=True)["name"]
    counted = grouped.agg(claims="count", names="; ".join)
    rank = {reading: n for n, reading in enumerate(READINGS)}
    counted = counted.reset_index().sort_values("verdict", key=lambda verdicts: verdicts != HOLDS, kind="stable")
    return counted.sort_values("reading", key=lambda column: column.map(rank), kind="stable")


def of_the_paper(verdicts: pd.DataFrame) -> pd.DataFrame:
    """The verdicts on claims about the paper's own models."""
    return verdicts[verdicts["about"] == PAPER] if "about" in verdicts else verdicts


def _worst_of_key(verdicts: pd.DataFrame, scenarios: tuple[str, ...]) -> dict[str, dict]:
    """The bed of a key scenario in which the codes differ most within the judged cycles, and that after the late one,
    where there is one later than these: `within` and `late`; and the worst bed of those whose dashpot is another one
    in each code: `damped`.
    """
    rows = verdicts[verdicts["scenario"].isin(scenarios)]
    late = rows[rows["late_cycle"] > rows["cycles"]]
    found = {
        "within": rows.sort_values("codes_ratio"),
        "late": late.sort_values("codes_late_ratio"),
        "damped": only(verdicts, state=OTHER_DASHPOT).sort_values("codes_ratio"),
    }
    return {name: part.iloc[-1].to_dict() for name, part in found.items() if len(part)}


def influences(found: Findings, scenarios: tuple[str, ...], profile: str) -> pd.DataFrame:
    """Change of the settlement of `scenarios` by one thing changed at a time: rows of the finding, smallest first."""
    rows = only(found.influence, profile=profile, quantity="settlement_m").dropna(subset=["change_ratio"])
    return rows[rows["scenario"].isin(scenarios)].sort_values("change_ratio", key=size_of_change)


def extremes(findings: Findings, scenarios: tuple[str, ...], profile: str) -> list[dict]:
    """Of each of `scenarios` under the true load the changes to the least and the largest settlement, as the rows of
    the finding: `least` and `most`. Only scenarios with a change of influence in both directions.
    """
    rows = only(influences(findings, scenarios, profile), reading=TRUE_LOAD)
    rows = rows[rows["scatters"] >= LEAST_INFLUENCE].sort_values("change_ratio")
    found = [only(rows, scenario=name).to_dict("records") for name in scenarios]
    ends = [{"least": changes[0], "most": changes[-1]} for changes in found if changes]
    return [one for one in ends if one["least"]["change_ratio"] < 0 < one["most"]["change_ratio"]]


def servo_filter(servo: pd.DataFrame, scenario: str, profile: str) -> dict:
    """What the servo with its default gain passes of the load, measured and predicted; {} where it is not known."""
    rows = only(servo, profile=profile, scenario=scenario, variant=SERVO).dropna(subset="predicted_amplitude_ratio")
    return rows.sort_values(["cycle", "seed"], ascending=[False, True]).iloc[0].to_dict() if len(rows) else {}


def damped(found: Findings, profile: str) -> dict:
    """How the nonlinear scenarios with damping between particles settle under the true load in LIGGGHTS: number, cycle,
    least and largest settlement, and how many have the exponential start; {} without runs of them.
    """
    names = {
        m.scenario
        for m in found.members
        if (s := m.run.scenario) is not None
        and s["contact.model"] == "hysteretic"
        and s["contact.particle_particle.restitution"] < 1
    }
    where = {"profile": profile, "reading": TRUE_LOAD, "code": "liggghts"}
    rows = only(found.values, **where, quantity="settlement_m", cycle=LEAST_TOLD)
    rows = rows[rows["scenario"].isin(names)]
    if rows.empty:
        return {}
    laws = only(found.settlement_laws, **where, seed=1)
    laws = laws[laws["scenario"].isin(rows["scenario"]) & (laws["variant"] == "")]
    return {
        "scenarios": len(rows),
        "cycle": LEAST_TOLD,
        "low_m": rows["mean"].min(),
        "high_m": rows["mean"].max(),
        "exponential": int((laws["exponential_start"] == "yes").sum()),
    }


def _bonded(found: Findings, profile: str) -> dict:
    """How the bonded model settles under the true load, what became of its bonds, and how it settles without them; {}
    without a run of it.
    """
    rows = only(found.bonds, profile=profile, variant="")
    if rows.empty:
        return {}
    first = rows.sort_values(["code", "seed"]).iloc[0]  # LIGGGHTS before YADE
    last = only(rows, code=first["code"], seed=first["seed"]).sort_values("cycle").iloc[-1]
    outcome = outcomes(found, [last["scenario"]], profile).get((last["scenario"], TRUE_LOAD, last["code"]))
    made = int(last["bonds_made"])
    without = influences(found, (last["scenario"],), profile)
    without = only(without, variant="no-bonds", reading=TRUE_LOAD, code=last["code"]).to_dict("records")
    bonds = {"made": made, "broken": made - int(last["bonds"]), "without": without[0] if without else {}}
    return {"outcome": outcome} | bonds if outcome else {}


def answer(found: Findings, key_scenarios: tuple[str, ...], profile: str) -> dict:
    """Everything that the sentences of templates/answer.txt need; claims, which are
    judged on full-size runs, only for these.
    """
    judged = found.verdicts if profile == JUDGED and _has_run(found, profile) else found.verdicts.iloc[:0]
    linear, nonlinear = (*key_scenarios, "", "")[:2]
    agreement = only(found.agreement, profile=profile)
    return {
        "profile": profile,
        "linear": linear,
        "nonlinear": nonlinear,
        "outcomes": outcomes(found, [linear, nonlinear], profile),
        "filter": servo_filter(found.servo, nonlinear, profile),
        "bonded": _bonded(found, profile),
        "same_bed": _worst_of_key(only(found.same_bed_verdicts, profile=profile), (linear, nonlinear)),
        "states": states(agreement),
        "differing": differing(agreement),
        "damped": damped(found, profile),
        "plate_runs_in_m": PLATE_RUNS_IN_M,
        "extremes": extremes(found, (linear, nonlinear), profile),
        "claims": claim_counts(judged).to_dict("records"),
        "claim_count": of_the_paper(judged)["number"].nunique(),
        "agrees_within": AGREES_WITHIN,
        "porosity_agrees_within": POROSITY_AGREES_WITHIN,
    }


def _has_run(found: Findings, profile: str) -> bool:
    return any(m.run.profile == profile for m in found.members)


def engineer(found: Findings, key_scenarios: tuple[str, ...], profile: str) -> dict:
    """What templates/engineer.txt needs of the key scenarios in LIGGGHTS: stiffness beside published ones, overlaps,
    clumps, losses and time steps.
    """
    values = only(found.values, profile=profile, code="liggghts")
    values = values[values["scenario"].isin(key_scenarios)]

    def ranges(quantity: str) -> pd.DataFrame:
        rows = values[values["quantity"] == quantity].dropna(subset=["low", "high"])
        return rows.groupby(["scenario", "reading"], sort=False).agg(low=("low", "min"), high=("high", "max"))

    overlaps = ranges("overlap_max_ratio").groupby("scenario", sort=False).agg(low=("low", "min"), high=("high", "max"))
    beds = only(found.coverage, profile=profile)
    beds = beds[beds["scenario"].isin(key_scenarios) & beds["variant"].isin(["", SERVO])]
    clumps = beds["clumps"]
    return {
        "code": "liggghts",
        "outcomes": list(outcomes(found, key_scenarios, profile).values()),
        "stiffness": dict(ranges("secant_stiffness_N_m").iterrows()),
        "overlaps": list(overlaps.iterrows()),
        "filter": servo_filter(found.servo, key_scenarios[-1] if key_scenarios else "", profile),
        "published": ballast_stiffness(),
        "steps": step_shares(found.timestep, key_scenarios),
        "clumps": [int(clumps.min()), int(clumps.max())] if len(clumps) else [],
        "energy": ranges("loop_energy_J").reset_index().to_dict("records"),
        "hours": fastest_hours(found.computing_time, key_scenarios, profile),
    }


def fastest_hours(computing_time: pd.DataFrame, scenarios: tuple[str, ...], profile: str) -> list[tuple[str, float]]:
    """Hours of one core for 1000 cycles under the true load in LIGGGHTS, of each scenario's fastest run."""
    rows = only(computing_time, profile=profile, variant="", code="liggghts")
    rows = rows[rows["scenario"].isin(scenarios)]
    return list(rows.groupby("scenario", sort=False)["hours_per_1000_cycles"].min().items())


def step_shares(timestep: pd.DataFrame, scenarios: tuple[str, ...]) -> list[dict]:
    """Of each scenario the steps of the paper and of the study over the critical step of its preloaded bed."""
    if timestep.empty:
        return []
    shares = timestep.drop_duplicates(["scenario", "case"]).pivot(index="scenario", columns="case", values="step_share")
    shares = shares.reindex(columns=["paper", "verified"]).dropna()
    known = [name for name in scenarios if name in shares.index]
    return [
        {"scenario": name, "paper": shares.at[name, "paper"], "study": shares.at[name, "verified"]} for name in known
    ]
