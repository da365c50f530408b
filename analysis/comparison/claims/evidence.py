"""What a claim is judged on: the runs of one code and the reference curves, asked for quantities with uncertainty.

A claim is a list of checks. A check is a margin, by how much a quantity lies on the claim's side, and the half-width of
that margin's confidence interval: it holds where the whole interval is positive, does not hold where it is all
negative, and is not decidable otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import pandas as pd

from analysis.comparison.claims.claimed_quantities import lateral_profile, profile_error
from analysis.comparison.claims.uncertainty import Estimate, coverage, pooled, propagate
from analysis.comparison.quantities import last_cycle
from analysis.reference.curves import References
from analysis.scenarios.scenario import ScenarioError, load_scenario

HOLDS, FAILS, OPEN = "holds", "does not hold", "not decidable yet"

CODES = ("liggghts", "yade")

RUN = "a full-size run of "


@dataclass(frozen=True)
class Claim:
    """One claim; `criterion` and `quantity` with the thresholds filled in."""

    number: int
    id: str
    sentence: str
    where: str
    compared: str
    runs: tuple[str, ...]
    quantity: str
    criterion: str
    thresholds: dict[str, float]
    uncertainty: str
    reference: tuple[str, ...]


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

    what        what is compared, in words
    numbers     the measured quantities in words, with their half-widths
    margin      how far the quantities lie on the claim's side, in `unit`; nan where something is missing
    half_width  of the margin's confidence interval; nan where no uncertainty is known
    missing     what is missing, one entry each
    """

    what: str
    numbers: str
    margin: float
    half_width: float
    unit: str
    missing: tuple[str, ...] = ()

    @property
    def verdict(self) -> str:
        """holds, does not hold, or not decidable yet."""
        if self.margin - self.half_width > 0:
            return HOLDS
        return FAILS if self.margin + self.half_width < 0 else OPEN


@dataclass(frozen=True)
class Verdict:
    """A claim, judged for one code."""

    claim: Claim
    code: str
    verdict: str
    checks: tuple[Check, ...]
    missing: tuple[str, ...]
    runs: tuple[str, ...]
    uncertainty: str
    notes: tuple[str, ...] = field(default=())


class Evidence:
    """The runs of one code and the reference curves, asked for quantities by the functions of the claims."""

    def __init__(self, runs: list, references: References, rules: Rules, claim: Claim):
        self.references, self.rules, self.claim = references, rules, claim
        self.runs = _longest([r for r in runs if r.profile == rules.profile and r.info.get("state") != "failed"])
        self._used: dict[str, object] = {}
        self._scatter: set[str] = set()

    # -------------------------------------------------------------- runs

    def reached(self, cycles: int) -> list:
        """Runs that have finished at least `cycles` cycles."""
        return [r for r in self.runs if last_cycle(r) >= cycles]

    def common_cycle(self, least: int) -> int:
        """The last cycle that all runs of the claim have reached; those that stopped before `least` do not count."""
        return min((last_cycle(r) for r in self.reached(least) if r.scenario_name in self.claim.runs), default=least)

    def measure(
        self,
        name: str,
        function: Callable,
        cycles: int,
        relative: bool = True,
        stated: str | None = None,
        runs: list | None = None,
    ) -> dict[str, Measured]:
        """`function(run)` for every scenario of the claim, averaged over seeds.

        name      of the quantity, in words
        cycles    that a run must have reached (0: the end of preload)
        relative  scatter as a share of the mean, see `uncertainty.pooled`
        stated    name of the stated uncertainty that replaces the scatter over seeds
        runs      to choose from, instead of all that have reached `cycles`
        """
        chosen = self.reached(cycles) if runs is None else runs
        groups: dict[str, list[float]] = {}
        for run in chosen:
            value = function(run)
            if math.isfinite(value):
                groups.setdefault(run.scenario_name, []).append(value)
                if run.scenario_name in self.claim.runs:
                    self._used[run.id] = run
        estimates = pooled(groups, relative)
        if stated:
            half_width = self.rules.stated[stated]
            estimates = {
                s: Estimate(e.mean, half_width / coverage(math.inf) * abs(e.mean), math.inf, e.seeds)
                for s, e in estimates.items()
            }
            self._scatter.add(f"stated: {half_width:.0%} of a run's value")
        else:
            self._scatter |= {f"{s} ({e.seeds} seeds)" for s, e in estimates.items() if e.seeds > 1}
        return {
            s: Measured(f"{name}, {s}", estimates[s])
            if s in estimates
            else Measured(f"{name}, {s}", missing=(self._why_missing(s, cycles),))
            for s in self.claim.runs
        }

    def _why_missing(self, scenario: str, cycles: int) -> str:
        lengths = [last_cycle(r) for r in self.runs if r.scenario_name == scenario]
        if not lengths:
            return f"{RUN}{scenario}"
        if max(lengths) < cycles:
            return f"{scenario}: {max(lengths)} of {cycles} cycles"
        return f"{scenario}: a value (its runs are damaged or leave it undecided)"

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
        return Measured("experiment", missing=tuple(f"the experiment's {q} (pending)" for q in quantities))

    # -------------------------------------------------------------- judging

    def check(self, what: str, unit: str, margin: Callable[..., float], *inputs: Measured) -> Check:
        """Evaluate `margin` at the inputs' means, with its confidence interval."""
        numbers = "; ".join(f"{m.name}: {_show(m.estimate, unit, self.rules.confidence)}" for m in inputs if m.estimate)
        missing = tuple(dict.fromkeys(w for m in inputs for w in m.missing))
        if missing:
            return Check(what, numbers, math.nan, math.nan, unit, missing)
        value, half_width = propagate(margin, [m.estimate for m in inputs], self.rules.confidence)
        if math.isnan(half_width):
            missing = ("a second seed of any scenario, for the uncertainty",)
        return Check(what, numbers, value, half_width, unit, missing)

    def judge(self, code: str, checks: tuple[Check, ...]) -> Verdict:
        """All parts together: one that fails decides, otherwise all have to hold."""
        found = [c.verdict for c in checks]
        verdict = FAILS if FAILS in found else HOLDS if found and all(v == HOLDS for v in found) else OPEN
        missing = _together(w for c in checks for w in c.missing)
        if verdict == OPEN and not missing:
            missing = ("more seeds or cycles: within the uncertainty",)
        if not any(math.isfinite(c.half_width) for c in checks):
            basis = "none yet"
        elif self.claim.uncertainty == "stated":
            basis = "; ".join(sorted(self._scatter))
        else:
            basis = "scatter over seeds of " + ", ".join(sorted(self._scatter))
        runs = sorted(self._used)
        return Verdict(
            self.claim,
            code,
            verdict,
            checks,
            missing if verdict == OPEN else (),
            tuple(runs),
            basis,
            _notes(self._used[r] for r in runs),
        )


def _together(missing: Iterable[str]) -> tuple[str, ...]:
    """What is missing, each once, runs in one entry."""
    entries = list(dict.fromkeys(missing))
    scenarios = [e.removeprefix(RUN) for e in entries if e.startswith(RUN)]
    others = [e for e in entries if not e.startswith(RUN)]
    return ((f"{RUN}{', '.join(scenarios)}",) if scenarios else ()) + tuple(others)


def _longest(runs: list) -> list:
    """One run for each scenario and seed, the one with most cycles."""
    best: dict[tuple, object] = {}
    for run in sorted(runs, key=last_cycle):
        best[run.scenario_name, run.seed] = run
    return list(best.values())


def _notes(runs: Iterable) -> tuple[str, ...]:
    """What a reader must know of the runs: deviations from the paper's laws, parameters that are not today's."""
    notes = {}
    for run in runs:
        for deviation in run.info.get("deviations", []):
            notes.setdefault(str(deviation), []).append(run.scenario_name)
        try:
            today = load_scenario(run.scenario_name, run.profile)
        except ScenarioError:
            continue
        changed = today.changes(run.scenario) if run.scenario else []
        if changed:
            more = f" and {len(changed) - 3} more" if len(changed) > 3 else ""
            note = f"made with other parameters than today's (today -> then): {'; '.join(changed[:3])}{more}"
            notes.setdefault(note, []).append(run.scenario_name)
    return tuple(f"{', '.join(dict.fromkeys(names))}: {note}" for note, names in notes.items())


_SHOWN = {"m": ("mm", 1e3), "m/cycle": ("mm per 1000 cycles", 1e6), "s": ("s", 1.0), "-": ("", 1.0)}


def _show(e: Estimate, unit: str, confidence: float) -> str:
    shown, factor = _SHOWN[unit]
    half_width = e.half_width(confidence)
    spread = f" +- {factor * half_width:.2g}" if math.isfinite(half_width) else ""
    return f"{factor * e.mean:.3g}{spread} {shown}".strip()


def widened(measured: Measured, standard_error: float) -> Measured:
    """The same with a further, independent standard error."""
    if measured.estimate is None:
        return measured
    e = measured.estimate
    return Measured(measured.name, Estimate(e.mean, math.hypot(e.standard_error, standard_error), e.degrees, e.seeds))
