"""What a claim is judged on: the runs of one code in one reading of the load and the reference curves, asked for
quantities with uncertainty.

A claim is a list of checks. A check is a margin, by how much a quantity lies on the claim's side, and the half-width of
that margin's confidence interval: it holds where the whole interval is positive, does not hold where it is all
negative, and is not decidable otherwise. A claim holds where all its checks do, and does not where one does not; so
that many checks do not make one of them fail by chance, each fails at its share of the error only (Bonferroni).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

import pandas as pd

from analysis.comparison.claims.claimed_quantities import lateral_profile, profile_error
from analysis.comparison.claims.uncertainty import (
    OWN_SEEDS,
    Estimate,
    combined,
    coverage,
    estimates,
    propagate,
    scatters,
)
from analysis.comparison.findings.members import Member, member
from analysis.comparison.run_quantities import last_cycle
from analysis.formats import quantities
from analysis.formats.quantities import SHOWN_UNITS
from analysis.reference.curves import References
from analysis.scenarios.scenario import ScenarioError, load_scenario

HOLDS, FAILS, OPEN = "holds", "does not hold", "not decidable"

CODES = tuple(sorted(quantities.CODES))

PAPER, CHEN = "paper", "chen2015"

RUN = "a full-size run of "
AND = " and "
WITHIN = "more packed beds or cycles: what decides is within the uncertainty"
PENDING = "(pending)"
ANOTHER_SEED = "a second seed of any scenario with the same contact law, for the uncertainty"


@dataclass(frozen=True)
class Claim:
    """One claim; `criterion` and `quantity` with the thresholds filled in.

    name       what it claims in a few words, for lists
    about      whose: the paper's of its own models; chen2015, the paper's of Chen et al.'s, judged from our own run of
               that model; own, this project's
    compares   of a claim that compares a quantity of two scenarios, what a function of its own would say otherwise:
               the quantity, the scenario that has more of it and the one that has less, see checks.compares
    """

    number: int
    id: str
    name: str
    sentence: str
    where: str
    compared: str
    runs: tuple[str, ...]
    quantity: str
    criterion: str
    thresholds: dict[str, float]
    uncertainty: str
    reference: tuple[str, ...]
    about: str = PAPER
    compares: dict[str, str] | None = None


@dataclass(frozen=True)
class Rules:
    """Which runs count, how sure a verdict has to be, and the uncertainties that are stated (relative half-widths)."""

    profile: str
    confidence: float
    stated: dict[str, float]


@dataclass(frozen=True)
class Measured:
    """A quantity that a check needs: its estimate, or what is missing for it."""

    name: str
    estimate: Estimate | None = None
    missing: tuple[str, ...] = ()


@dataclass(frozen=True)
class Check:
    """One part of a claim.

    what            what is compared, in words
    numbers         the measured quantities in words, with their half-widths
    margin          how far the quantities lie on the claim's side, in `unit`; nan where something is missing
    standard_error  of the margin; nan where no uncertainty is known
    degrees         of freedom of the standard error
    missing         what is missing, one entry each
    without_curve   what can be said while the experiment's curve is pending; empty where none is needed or nothing can
    parts           number of checks of the claim
    """

    what: str
    numbers: str
    margin: float
    standard_error: float
    degrees: float
    unit: str
    confidence: float
    missing: tuple[str, ...] = ()
    without_curve: str = ""
    parts: int = 1

    @property
    def half_width(self) -> float:
        """Half the width of the margin's confidence interval; against the claim at the check's share of the error."""
        confidence = self.confidence if self.margin > 0 else 1 - (1 - self.confidence) / self.parts
        return coverage(self.degrees, confidence) * self.standard_error

    @property
    def verdict(self) -> str:
        """holds, does not hold, or not decidable."""
        if self.margin - self.half_width > 0:
            return HOLDS
        return FAILS if self.margin + self.half_width < 0 else OPEN


@dataclass(frozen=True)
class Verdict:
    """A claim, judged for one code in one reading of the load.

    because         what decides, or what stands in the way, in words
    without_curve   what can be said while the experiment's curve is pending
    missing         what is missing; empty where the claim is decided
    runs            that were used
    uncertainty     where it comes from
    notes           what a reader must know of the runs
    """

    claim: Claim
    code: str
    reading: str
    verdict: str
    checks: tuple[Check, ...]
    because: str
    without_curve: tuple[str, ...]
    missing: tuple[str, ...]
    runs: tuple[str, ...]
    uncertainty: str
    notes: tuple[str, ...] = field(default=())


class Evidence:
    """Runs of one code in one reading, and reference curves, asked for quantities by the functions of the claims."""

    def __init__(
        self,
        runs: Iterable,
        references: References,
        rules: Rules,
        claim: Claim,
        code: str,
        reading: str,
        lend: bool = True,
    ):
        """`lend`: whether the other code's seeds lend their scatter where this one has none."""
        self.references, self.rules, self.claim, self.code, self.reading = references, rules, claim, code, reading
        found = [m for m in map(member, runs) if m.run.profile == rules.profile and m.plain and m.reading == reading]
        self.members = _longest(m for m in found if m.run.code == code)
        self._others = _longest(m for m in found if m.run.code != code) if lend else []
        self._used: dict[str, Member] = {}
        self._scatter: set[str] = set()
        self._undecided: dict[str, None] = {}

    # -------------------------------------------------------------- runs

    def reached(self, cycles: int) -> list[Member]:
        """Runs that have finished at least `cycles` cycles."""
        return [m for m in self.members if finished(m) >= cycles]

    def common_cycle(self, least: int) -> int:
        """The last cycle that all runs of the claim have reached; those that stopped before `least` do not count."""
        return min((finished(m) for m in self.reached(least) if m.scenario in self.claim.runs), default=least)

    def measure(
        self,
        name: str,
        function: Callable,
        cycles: int,
        relative: bool = True,
        stated: str | None = None,
        members: list[Member] | None = None,
        least_seeds: int = 1,
    ) -> dict[str, Measured]:
        """`function(run)` for every scenario of the claim, averaged over seeds.

        name          of the quantity, in words
        cycles        that a run must have reached (0: the end of preload)
        relative      scatter that is lent is a share of the mean
        stated        name of the stated uncertainty that replaces the scatter over seeds
        members       to choose from, instead of all that have reached `cycles`
        least_seeds   that must have a value
        """
        groups, undecided = self._values(function, self.reached(cycles) if members is None else members)
        of_claim = {s: v for s, v in groups.items() if s in self.claim.runs and len(v) >= least_seeds}
        if stated:
            found = self._with_stated_error(of_claim, self.rules.stated[stated])
        else:
            found = estimates(of_claim, self._lenders(of_claim, groups, function, cycles), relative)
            self._scatter |= {e.lent or f"{s} ({e.seeds} seeds)" for s, e in found.items() if e.seeds > 1 or e.lent}
        measured = {}
        for s, seeds in undecided.items():
            self._undecided |= dict.fromkeys(f"{s}: seed {n} leaves it undecided ({name})" for n in seeds)
        for s in self.claim.runs:
            if s in found:
                measured[s] = Measured(f"{name}, {s}{_seeds(undecided.get(s, ()))}", found[s])
            else:
                why = self._why_missing(s, cycles, len(groups.get(s, ())), undecided.get(s, ()))
                measured[s] = Measured(f"{name}, {s}", missing=(why,))
        return measured

    def _with_stated_error(self, groups: dict[str, list[float]], half_width: float) -> dict[str, Estimate]:
        """Means over seeds by scenario, each with the stated relative half-width instead of the scatter over seeds."""
        self._scatter.add(f"stated: {half_width:.0%} of a run's value")
        means = {s: sum(values) / len(values) for s, values in groups.items()}
        return {
            s: Estimate(mean, half_width / coverage(math.inf) * abs(mean), seeds=len(groups[s]))
            for s, mean in means.items()
        }

    def seen(self, function: Callable, cycles: int) -> dict[str, float]:
        """Mean over seeds of `function(run)` by scenario, to be told where nothing is judged by it."""
        groups, _ = self._values(function, self.reached(cycles))
        return {scenario: sum(values) / len(values) for scenario, values in groups.items()}

    def _values(self, function: Callable, members: list[Member]) -> tuple[dict[str, list[float]], dict[str, list[int]]]:
        """Values by scenario, and the seeds that have none."""
        groups: dict[str, list[float]] = {}
        undecided: dict[str, list[int]] = {}
        for m in members:
            value = function(m.run)
            if math.isfinite(value):
                groups.setdefault(m.scenario, []).append(value)
                if m.scenario in self.claim.runs and m in self.members:
                    self._used[m.run.id] = m
            else:
                undecided.setdefault(m.scenario, []).append(m.run.seed)
        return groups, {s: sorted(seeds) for s, seeds in undecided.items()}

    def _lenders(
        self, wanted: dict, groups: dict, function: Callable, cycles: int
    ) -> dict[str, dict[str, list[float]]]:
        """For each scenario with fewer than OWN_SEEDS: the scenarios with its contact law whose seeds lend it their
        scatter, those of the other code where this one has none.
        """
        lenders = {}
        laws = {m.scenario: _contact_law(m) for m in (*self._others, *self.members)}
        for scenario, values in wanted.items():
            if len(values) >= OWN_SEEDS:
                continue
            alike = {f"{s} ({len(v)} seeds)": v for s, v in groups.items() if laws[s] == laws[scenario]}
            if not any(map(scatters, alike.values())):
                members = [m for m in self._others if finished(m) >= cycles and laws[m.scenario] == laws[scenario]]
                alike = {
                    f"{s} ({len(v)} seeds of the other code)": v for s, v in self._values(function, members)[0].items()
                }
            lenders[scenario] = {name: values for name, values in alike.items() if scatters(values)}
        return lenders

    def longest(self, scenario: str) -> Member | None:
        """The run of the scenario with most cycles that count; None without any run."""
        return max((m for m in self.members if m.scenario == scenario), key=finished, default=None)

    def _why_missing(self, scenario: str, cycles: int, values: int, undecided: Iterable[int]) -> str:
        found = [m for m in self.members if m.scenario == scenario]
        if not found:
            return f"{RUN}{scenario}"
        longest = self.longest(scenario)
        if finished(longest) < cycles:
            ended = f"; failed after cycle {last_cycle(longest.run)}" if failed(longest) else ""
            return f"{scenario}: {max(finished(longest), 0)} of {cycles} cycles{ended}"
        if undecided:
            return f"{scenario}: a second seed that decides{_seeds(undecided)}"
        if values:
            return f"{scenario}: a second seed, {values} of {len(found)} has a value"
        return f"{scenario}: a value (its runs are damaged)"

    # -------------------------------------------------------------- reference

    def experiment(self, quantity: str, cycle: int | None = None) -> pd.DataFrame:
        """Points of the claim's reference curve; empty while they are pending."""
        rows = self.references.curve(quantity, cycle=cycle)
        return rows[rows["sidecar"].isin(self.claim.reference)]

    def profile_errors(self, cycle: int, *scenarios: str) -> list[Measured]:
        """`profile_error` of the scenarios after `cycle`, with the error of the experiment's curve."""
        curve = self.experiment("lateral_displacement", cycle)
        name = f"profile error after cycle {cycle}"
        if curve.empty:
            runs = self.measure(name, lambda r: lateral_profile(r, cycle).mean(), cycle)
            pending = self.pending(f"lateral displacement after cycle {cycle}")
            return [Measured(name, missing=runs[s].missing + pending.missing) for s in scenarios]
        measured = self.measure(name, lambda r: profile_error(r, curve, cycle), cycle, relative=False)
        error = float(curve["error"].mean() / coverage(math.inf) / curve["value"].abs().mean())
        return [widened(measured[s], error) for s in scenarios]

    def pending(self, *quantities: str) -> Measured:
        """What stands for a reference curve that is not there."""
        return Measured("experiment", missing=tuple(f"the experiment's {q} {PENDING}" for q in quantities))

    # -------------------------------------------------------------- judging

    def check(
        self, what: str, unit: str, margin: Callable[..., float], *inputs: Measured, without_curve: str = ""
    ) -> Check:
        """Evaluate `margin` at the inputs' means, with its uncertainty."""
        numbers = "; ".join(f"{m.name}: {_show(m.estimate, unit, self.rules.confidence)}" for m in inputs if m.estimate)
        missing = tuple(dict.fromkeys(w for m in inputs for w in m.missing))
        if missing:
            values = math.nan, math.nan, math.inf
        else:
            values = propagate(margin, [m.estimate for m in inputs])
            if math.isnan(values[1]):
                missing = (ANOTHER_SEED,)
        pending = any(PENDING in what for what in missing)
        return Check(what, numbers, *values, unit, self.rules.confidence, missing, without_curve if pending else "")

    def judge(self, checks: tuple[Check, ...]) -> Verdict:
        """All parts together: one that fails decides, otherwise all have to hold."""
        checks = tuple(replace(c, parts=len(checks)) for c in checks)
        found = [c.verdict for c in checks]
        verdict = FAILS if FAILS in found else HOLDS if found and all(v == HOLDS for v in found) else OPEN
        missing = _together(w for c in checks for w in c.missing)
        if verdict == OPEN and not missing:
            missing = (WITHIN,)
        if not any(math.isfinite(c.half_width) for c in checks):
            basis = "none yet"
        elif self.claim.uncertainty == "stated":
            basis = "; ".join(sorted(self._scatter))
        else:
            basis = "scatter over seeds of " + ", ".join(sorted(self._scatter))
        runs = sorted(self._used)
        return Verdict(
            self.claim,
            self.code,
            self.reading,
            verdict,
            checks,
            _because(verdict, checks, missing),
            tuple(dict.fromkeys(c.without_curve for c in checks if c.without_curve)),
            missing if verdict == OPEN else (),
            tuple(runs),
            basis,
            (*self._undecided, *_notes(self._used[r] for r in runs)),
        )


def _because(verdict: str, checks: tuple[Check, ...], missing: tuple[str, ...]) -> str:
    """What decides a claim or stands in the way: the part that fails, the one that holds least, what is missing."""
    decided = [c for c in checks if c.verdict == verdict and math.isfinite(c.margin)]
    if verdict == OPEN:
        within = [c for c in checks if c.verdict == OPEN and math.isfinite(c.half_width)]
        parts = [f"{c.what}: {_margin(c)}" for c in within]
        return "; ".join([*(m for m in missing if m != WITHIN), *(f"within the uncertainty: {p}" for p in parts)])
    weakest = min(decided, key=lambda c: abs(c.margin) / max(c.half_width, 1e-300), default=None)
    strongest = max(decided, key=lambda c: abs(c.margin) / max(c.half_width, 1e-300), default=None)
    chosen = weakest if verdict == HOLDS else strongest
    word = "" if verdict == HOLDS else "not so: "
    others = f" (the least certain of {len(checks)} parts)" if verdict == HOLDS and len(checks) > 1 else ""
    return f"{word}{chosen.what}: {_margin(chosen)}{others}"


def _margin(check: Check) -> str:
    shown, factor = SHOWN_UNITS[check.unit]
    spread = f" +- {factor * check.half_width:.2g}"
    return f"margin {factor * check.margin:.3g}{spread} {shown}".strip()


def _together(missing: Iterable[str]) -> tuple[str, ...]:
    """What is missing, each once, runs in one entry."""
    entries = list(dict.fromkeys(missing))
    scenarios = [e.removeprefix(RUN) for e in entries if e.startswith(RUN)]
    others = [e for e in entries if not e.startswith(RUN)]
    return ((f"{RUN}{AND.join(scenarios)}",) if scenarios else ()) + tuple(others)


def _longest(members: Iterable[Member]) -> list[Member]:
    """One run for each scenario and seed, the one with most cycles that count."""
    best: dict[tuple, Member] = {}
    for m in sorted(members, key=finished):
        best[m.scenario, m.run.seed] = m
    return list(best.values())


def finished(member: Member) -> int:
    """Cycles of a run that count; those of a failed run up to the one before it failed, and -1 without any."""
    return last_cycle(member.run) - failed(member)


def failed(member: Member) -> bool:
    """True for a run that ended because its bed failed."""
    return member.run.info.get("state") == "failed"


def _contact_law(member: Member) -> str:
    return member.run.scenario["contact.model"] if member.run.scenario is not None else ""


def _seeds(undecided: Iterable[int]) -> str:
    """Seeds that leave a value undecided, in brackets."""
    found = list(undecided)
    return f" (undecided: seed{'s' if len(found) > 1 else ''} {', '.join(map(str, found))})" if found else ""


@functools.lru_cache(64)
def _today(scenario: str, profile: str):
    """A scenario as it is now; None where it is no more."""
    try:
        return load_scenario(scenario, profile)
    except ScenarioError:
        return None


def _notes(members: Iterable[Member]) -> tuple[str, ...]:
    """What a reader must know of the runs: deviations from the paper's laws, parameters that are not today's, an end
    before its time.
    """
    notes: dict[str, list[str]] = {}
    for m in members:
        for deviation in m.run.info.get("deviations", []):
            notes.setdefault(str(deviation), []).append(m.scenario)
        if failed(m):
            reason = m.run.info.get("reason") or "no reason given"
            note = f"seed {m.run.seed} failed after cycle {last_cycle(m.run)} ({reason}); the cycles before count"
            notes.setdefault(note, []).append(m.scenario)
        today = _today(m.run.scenario_name, m.run.profile)
        changed = today.changes(m.run.scenario) if today and m.run.scenario is not None else []
        if changed:
            more = f" and {len(changed) - 3} more" if len(changed) > 3 else ""
            note = f"made with other parameters than today's (today -> then): {'; '.join(changed[:3])}{more}"
            notes.setdefault(note, []).append(m.scenario)
    return tuple(f"{', '.join(dict.fromkeys(names))}: {note}" for note, names in notes.items())


def _show(e: Estimate, unit: str, confidence: float) -> str:
    shown, factor = SHOWN_UNITS[unit]
    half_width = e.half_width(confidence)
    spread = f" +- {factor * half_width:.2g}" if math.isfinite(half_width) else ""
    return f"{factor * e.mean:.3g}{spread} {shown}".strip()


def widened(measured: Measured, standard_error: float) -> Measured:
    """The same with a further, independent standard error."""
    if measured.estimate is None:
        return measured
    e = measured.estimate
    error = math.hypot(e.standard_error, standard_error)
    degrees = combined((e.standard_error**2, standard_error**2), (e.degrees, math.inf))
    return Measured(measured.name, replace(e, standard_error=error, degrees=degrees))
