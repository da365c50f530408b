"""The paper's eleven claims, each judged per code by a criterion fixed beforehand in reference_data/claims.toml.

A claim is a list of checks. A check is a margin, by how much a quantity lies on the claim's side, and the half-width of
that margin's confidence interval: it holds where the whole interval is positive, does not hold where it is all
negative, and is not decidable otherwise. One function for each claim, named as its id, yields the checks.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from . import compare, derived, laws, quantities, settlement as settlement_fit
from .reference import REFERENCE_FOLDER, References, load_references
from .scenario import ScenarioError, load_scenario
from .tables import PLATES, SPHERES
from .uncertainty import Estimate, coverage, pooled, propagate

HOLDS, FAILS, OPEN = "holds", "does not hold", "not decidable yet"
CODES = ("liggghts", "yade")
RUN = "a full-size run of "


class ClaimError(ValueError):
    """A claims file that cannot be used; the message is one line naming file, key and remedy."""


# ------------------------------------------------------------------ claims as data

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


def load_claims(path: Path = REFERENCE_FOLDER / "claims.toml") -> tuple[list[Claim], Rules]:
    """Read claims.toml and check that every claim is complete, judged by a function, and words all its thresholds."""
    try:
        content = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        rules = Rules(content["rules"]["profile"], content["rules"]["confidence"],
                      {name: entry["value"] for name, entry in content["stated"].items()})
        entries = content["claim"]
    except (OSError, tomllib.TOMLDecodeError, KeyError, TypeError) as error:
        reason = f"cannot be used ({error}); it has [rules], [stated] and [[claim]]"
        raise ClaimError(f"{Path(path).name}: {reason}") from None
    return [_claim(Path(path).name, entry) for entry in entries], rules


def _claim(file: str, entry: dict) -> Claim:
    where = f"{file}: claim {entry.get('id', '?')}"
    try:
        claim = Claim(**(entry | {"runs": tuple(entry["runs"]), "reference": tuple(entry["reference"])}))
    except (TypeError, KeyError) as error:
        raise ClaimError(f"{where}: {error}; each claim has {', '.join(Claim.__dataclass_fields__)}") from None
    if claim.id not in CHECKS:
        raise ClaimError(f"{where}: no function of that name in analysis/claims.py; write one or correct the id")
    for name in claim.thresholds:
        if f"{{{name}" not in claim.criterion + claim.quantity:
            raise ClaimError(f"{where}: threshold {name} is not worded in criterion or quantity; "
                             f"write {{{name}:g}} into one")
    try:
        worded = {key: entry[key].format(**claim.thresholds) for key in ("criterion", "quantity")}
    except (KeyError, ValueError) as error:
        raise ClaimError(f"{where}: criterion or quantity names {error}; give it in thresholds") from None
    return Claim(**(claim.__dict__ | worded))


# ------------------------------------------------------------------ measuring

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


def evaluate_claims(runs: Iterable, references: References | None = None,
                    path: Path = REFERENCE_FOLDER / "claims.toml") -> list[Verdict]:
    """Judge all claims for both codes from `runs` (of load_runs) and `references` (default: the committed ones)."""
    claims, rules = load_claims(path)
    references = load_references() if references is None else references
    runs = list(runs)
    return [judge(claim, code, runs, references, rules) for claim in claims for code in CODES]


def judge(claim: Claim, code: str, runs: Iterable, references: References, rules: Rules) -> Verdict:
    """Judge one claim for one code."""
    evidence = Evidence([r for r in runs if r.code == code], references, rules, claim)
    return evidence.judge(code, tuple(CHECKS[claim.id](evidence, claim.thresholds)))


def to_frame(verdicts: Iterable[Verdict]) -> pd.DataFrame:
    """A row per check, with the claim's verdict and the check's own; margins in SI units."""
    return pd.DataFrame([
        {"number": v.claim.number, "claim": v.claim.sentence, "code": v.code, "verdict": v.verdict, "check": c.what,
         "check_verdict": c.verdict, "numbers": c.numbers, "margin": c.margin, "half_width": c.half_width,
         "unit": c.unit, "missing": "; ".join(c.missing)} for v in verdicts for c in v.checks])


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
        return [r for r in self.runs if _last_cycle(r) >= cycles]

    def common_cycle(self, least: int) -> int:
        """The last cycle that all runs of the claim have reached; those that stopped before `least` do not count."""
        return min((_last_cycle(r) for r in self.reached(least) if r.scenario_name in self.claim.runs), default=least)

    def measure(self, name: str, function: Callable, cycles: int, relative: bool = True,
                stated: str | None = None, runs: list | None = None) -> dict[str, Measured]:
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
            estimates = {s: Estimate(e.mean, half_width / coverage(math.inf) * abs(e.mean), math.inf, e.seeds)
                         for s, e in estimates.items()}
            self._scatter.add(f"stated: {half_width:.0%} of a run's value")
        else:
            self._scatter |= {f"{s} ({e.seeds} seeds)" for s, e in estimates.items() if e.seeds > 1}
        return {s: Measured(f"{name}, {s}", estimates[s]) if s in estimates else
                Measured(f"{name}, {s}", missing=(self._why_missing(s, cycles),)) for s in self.claim.runs}

    def _why_missing(self, scenario: str, cycles: int) -> str:
        lengths = [_last_cycle(r) for r in self.runs if r.scenario_name == scenario]
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
        return [_widened(measured[s], error) for s in scenarios]

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
        return Verdict(self.claim, code, verdict, checks, missing if verdict == OPEN else (), tuple(runs), basis,
                       _notes(self._used[r] for r in runs))


def _together(missing: Iterable[str]) -> tuple[str, ...]:
    """What is missing, each once, runs in one entry."""
    entries = list(dict.fromkeys(missing))
    scenarios = [e.removeprefix(RUN) for e in entries if e.startswith(RUN)]
    others = [e for e in entries if not e.startswith(RUN)]
    return ((f"{RUN}{', '.join(scenarios)}",) if scenarios else ()) + tuple(others)


def _longest(runs: list) -> list:
    """One run for each scenario and seed, the one with most cycles."""
    best: dict[tuple, object] = {}
    for run in sorted(runs, key=_last_cycle):
        best[run.scenario_name, run.seed] = run
    return list(best.values())


def _last_cycle(run) -> int:
    return int(run.cycles["cycle"].iloc[-1]) if len(run.cycles) else 0


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
        changed = [line for line in (today.differences(run.scenario) if run.scenario else [])
                   if not line.startswith(("loading.cycles", "output.", "limits."))]
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


# ------------------------------------------------------------------ quantities of one run

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


def exponential_share(run, last: int) -> float:
    """Exponential part over the whole settlement after cycle `last`, both of the fitted law.

    0 where another law describes the curve better, nan where the curve leaves it undecided (`settlement.choose`).
    """
    table = run.cycles[run.cycles["cycle"] <= last]
    choice = settlement_fit.choose(table["cycle"], table["settlement_m"])
    if choice.exponential_start != "yes":
        return 0.0 if choice.exponential_start == "no" else math.nan
    fit = choice.fits["exponential"]
    return float(-fit.values["b"] * math.expm1(-last / fit.values["c"]) / fit.settlement([last])[0])


def slope(cycles, values, first: int, last: int) -> float:
    """Least-squares slope over first <= cycle <= last, per cycle; nan with fewer than three values."""
    cycles, values = np.asarray(cycles, dtype=float), np.asarray(values, dtype=float)
    inside = (cycles >= first) & (cycles <= last) & np.isfinite(values)
    return float(np.polyfit(cycles[inside], values[inside], 1)[0]) if inside.sum() >= 3 else math.nan


def seconds_per_cycle(run) -> float:
    """Computing time of one cycle of loading, s."""
    speed = run.info.get("steps_per_second", {}).get("cyclic")
    if run.scenario is None or not isinstance(speed, (int, float)) or not speed > 0:
        return math.nan
    return derived.time_grid(run.scenario).steps_per_cycle / speed


def settlement_difference(run, curve: pd.DataFrame, last: int, what: str) -> float:
    """A field of `compare.against_reference` (rms_m, shift_m, rms_shifted_m), over the curve's points up to `last`."""
    points = curve[curve["cycle"] <= last]
    ours = run.cycles["cycle"], run.cycles["settlement_m"]
    result = compare.against_reference(*ours, points["cycle"], points["value"])
    return getattr(result, what) if result else math.nan


def profile_error(run, curve: pd.DataFrame, cycle: int) -> float:
    """rms difference of the plates' lateral displacement from the reference's profile, over the mean of that profile.

    The profile is interpolated at the plates' mid-heights; plates that it does not reach do not count, three have to.
    """
    if run.scenario is None:
        return math.nan
    depth, half = quantities.plate_depths(run.scenario), run.scenario["geometry.plate_height"] / 2
    points = curve.sort_values("depth_m")
    covered = (depth >= points["depth_m"].min() - half) & (depth <= points["depth_m"].max() + half)
    if covered.sum() < 3:
        return math.nan
    theirs = np.interp(depth[covered], points["depth_m"], points["value"])
    return float(np.sqrt(np.mean((lateral_profile(run, cycle)[covered] - theirs) ** 2)) / np.abs(theirs).mean())


def _widened(measured: Measured, standard_error: float) -> Measured:
    """The same with a further, independent standard error."""
    if measured.estimate is None:
        return measured
    e = measured.estimate
    return Measured(measured.name, Estimate(e.mean, math.hypot(e.standard_error, standard_error), e.degrees, e.seeds))


# ------------------------------------------------------------------ the claims

LINEAR, NONLINEAR = "linear-mu0.8", "nonlinear-en1.0"


def exponential_start(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 1."""
    last = e.common_cycle(t["cycles"])
    # the fits take their time: only the runs that are judged, others do not lend their scatter
    runs = [r for r in e.reached(last) if r.scenario_name in e.claim.runs]
    share = e.measure(f"exponential share after cycle {last}", lambda r: exponential_share(r, last), last,
                      relative=False, runs=runs)
    yield e.check(f"{NONLINEAR} has the exponential start", "-", lambda s: s - t["share"], share[NONLINEAR])
    yield e.check(f"{LINEAR} does not have it", "-", lambda s: t["share"] - s, share[LINEAR])


def late_slope(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 2."""
    def of(run):
        return slope(run.cycles["cycle"], run.cycles["settlement_m"], t["first"], t["cycles"])

    ours, curve = e.measure("late slope", of, t["cycles"]), e.experiment("settlement")
    theirs = e.pending("settlement")
    if len(curve):
        late = curve.loc[(curve["cycle"] >= t["first"]) & (curve["cycle"] <= t["cycles"]), "cycle"]
        value = slope(curve["cycle"], curve["value"], t["first"], t["cycles"])
        if math.isfinite(value):
            error = curve["error"].mean() / coverage(math.inf) / math.sqrt(((late - late.mean()) ** 2).sum())
            theirs = Measured("late slope, experiment", Estimate(value, error))
        else:
            theirs = Measured("experiment", missing=(f"three points of the experiment from cycle {t['first']} on",))
    yield e.check("the nonlinear slope is nearer to the experiment's", "m/cycle",
                  lambda lin, non, exp: abs(lin - exp) - abs(non - exp), ours[LINEAR], ours[NONLINEAR], theirs)


def vertical_shift(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 3."""
    what, curve = "the difference scatters little about its mean", e.experiment("settlement")
    if curve.empty:
        runs = e.measure("settlement", lambda r: settlement(r, t["cycles"]), t["cycles"])
        yield e.check(what, "m", lambda s, exp: math.nan, runs[NONLINEAR], e.pending("settlement"))
        return
    last = t["cycles"]
    shift, scatter = (e.measure(name, lambda r, field=field: settlement_difference(r, curve, last, field), last,
                                relative=False)
                      for name, field in (("mean difference", "shift_m"), ("its standard deviation", "rms_shifted_m")))
    error = curve["error"].mean() / coverage(math.inf)
    yield e.check(what, "m", lambda m, s: t["scatter"] * abs(m) - s,
                  _widened(shift[NONLINEAR], error), _widened(scatter[NONLINEAR], error))


def linear_lateral(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 4."""
    for cycle, sign in ((1, -1), (100, 1), (t["cycles"], 1)):
        error, = e.profile_errors(cycle, LINEAR)
        yield e.check(f"{'good' if sign > 0 else 'poor'} after cycle {cycle}", "-",
                      lambda value, sign=sign: sign * (t["good"] - value), error)


def nonlinear_lateral(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 5."""
    for cycle in (1, 100):
        yield e.check(f"nonlinear better after cycle {cycle}", "-", lambda lin, non: lin - non,
                      *e.profile_errors(cycle, LINEAR, NONLINEAR))
    yield e.check(f"comparable after cycle {t['cycles']}", "-", lambda lin, non: t["alike"] - abs(lin - non),
                  *e.profile_errors(t["cycles"], LINEAR, NONLINEAR))


def damping_modes(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 6."""
    for cycle, words in ((1, "twice"), (t["cycles"], "alike")):
        low, high = t[f"{words}_low"], t[f"{words}_high"]
        lateral = e.measure(f"lateral displacement after cycle {cycle}",
                            lambda r, n=cycle: lateral_profile(r, n).mean(), cycle)

        def margin(*values, low=low, high=high):
            ratio = np.mean(values[:3]) / np.mean(values[3:])
            return min(ratio - low, high - ratio)

        for mode in (1, 2):
            names = [f"nonlinear-md{m}-en{en}" for m in (0, mode) for en in (0.3, 0.6, 0.9)]
            yield e.check(f"M_d = 0 over M_d = {mode} after cycle {cycle} between {low:g} and {high:g}", "-", margin,
                          *(lateral[n] for n in names))


def restitution_trend(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 7."""
    last = e.common_cycle(t["cycles"])
    branches = (("M_d = 0", 0, (0.3, 0.6, 0.9, 1.0), -1), ("M_d = 2", 2, (0.3, 0.6, 0.9, 1.0), -1),
                ("M_d = 1 from 0.6", 1, (0.6, 0.9, 1.0), -1), ("M_d = 1 to 0.6", 1, (0.0, 0.3, 0.6), 1))
    for name, function in (("settlement", lambda r: settlement(r, last)),
                           ("lateral displacement", lambda r: lateral_profile(r, last).mean())):
        measured = e.measure(f"{name} after cycle {last}", function, last)
        for branch, mode, restitutions, sign in branches:
            scenarios = [NONLINEAR if en == 1 else f"nonlinear-md{mode}-en{en}" for en in restitutions]

            def margin(*values, x=restitutions, sign=sign):
                return sign * (np.polyfit(x, values, 1)[0] - t["flat"])

            yield e.check(f"{name} {'rises' if sign > 0 else 'falls'} with e_n, {branch}", "m", margin,
                          *(measured[s] for s in scenarios))


def undamped_best(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 8."""
    curve = e.experiment("settlement")
    curve = curve[curve["cycle"] <= t["cycles"]]
    profiles = {n: e.experiment("lateral_displacement", n) for n in (1, 100, t["cycles"])}
    pending = [] if len(curve) else ["settlement"]
    pending += [f"lateral displacement after cycle {n}" for n, profile in profiles.items() if profile.empty]

    def misfit(run) -> float:
        if pending:
            return settlement(run, t["cycles"])
        errors = [settlement_difference(run, curve, t["cycles"], "rms_m") / abs(float(curve["value"].iloc[-1]))]
        return float(np.mean(errors + [profile_error(run, profile, n) for n, profile in profiles.items()]))

    measured = e.measure("misfit", misfit, t["cycles"], relative=False)
    for scenario in e.claim.runs:
        what = f"{NONLINEAR} agrees better than {scenario}"
        if scenario == NONLINEAR:
            continue
        if pending:
            missing = measured[NONLINEAR].missing + measured[scenario].missing + e.pending(*pending).missing
            yield e.check(what, "-", max, Measured("misfit", missing=missing))
            continue
        relative = [c["error"].mean() / c["value"].abs().max() for c in (curve, *profiles.values())]
        error = float(np.mean(relative)) / coverage(math.inf)
        yield e.check(what, "-", lambda best, other: other - best,
                      _widened(measured[NONLINEAR], error), _widened(measured[scenario], error))


def porosity_order(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 9."""
    last = e.common_cycle(t["cycles"])

    def above(run):
        one, two, three = porosities(run, last)
        return three - max(one, two)

    def below(run):
        one, two, three = porosities(run, last)
        return min(two, three) - one

    for what, name, function in (("sphere 3 highest", "sphere 3 above the next", above),
                                 ("sphere 1 lowest", "sphere 1 below the next", below)):
        measured = e.measure(name, function, last, relative=False)
        yield e.check(f"{what} after cycle {last}", "-", lambda x: x, measured[NONLINEAR])
    spread = e.measure(f"range to cycle {last}", lambda r: porosity_range(r, last), last, relative=False)
    yield e.check("range wider than in the linear model", "-", lambda non, lin: non - lin,
                  spread[NONLINEAR], spread[LINEAR])


def preload_drop(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 10."""
    start = e.measure("porosity after preload", lambda r: porosities(r, 0).mean(), 0, relative=False)
    yield e.check("lower than in the linear model", "-", lambda lin, non: lin - non - t["drop"],
                  start[LINEAR], start[NONLINEAR])


def computing_time(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 11."""
    what = "shorter than the linear model's"
    timed = [r for r in e.reached(1) if math.isfinite(seconds_per_cycle(r))]
    machines = {name: {_machine(r) for r in timed if r.scenario_name == name} for name in (LINEAR, NONLINEAR)}
    shared = sorted(machines[LINEAR] & machines[NONLINEAR])
    best = max(shared, key=lambda m: sum(_machine(r) == m for r in timed), default=None)
    runs = [r for r in timed if best in (None, _machine(r))]
    time = e.measure("computing time per cycle", seconds_per_cycle, 1, stated="computing_time", runs=runs)
    if all(machines.values()) and not shared:
        time[LINEAR] = Measured(time[LINEAR].name, missing=("both models on one machine, same ranks and threads",))
    yield e.check(what, "s", lambda lin, non: t["ratio"] * lin - non, time[LINEAR], time[NONLINEAR])


def _machine(run) -> tuple:
    return tuple(str(run.info.get(key)) for key in ("host", "ranks", "threads"))


CHECKS: dict[str, Callable[[Evidence, dict], Iterator[Check]]] = {f.__name__: f for f in (
    exponential_start, late_slope, vertical_shift, linear_lateral, nonlinear_lateral, damping_modes, restitution_trend,
    undamped_best, porosity_order, preload_drop, computing_time)}


# ------------------------------------------------------------------ what follows from eq. 16 alone

def restitution_table(restitutions=(0.0, 0.3, 0.6, 0.9, 1.0)) -> pd.DataFrame:
    """Nominal against effective restitution: damping_mode, nominal_restitution, damping_factor, effective_restitution.

    Effective is what comes out of a free impact, whatever mass, stiffness and speed. M_d = 0 has no value at e_n = 0.
    """
    rows = []
    for mode in (0, 1, 2):
        for nominal in restitutions:
            factor = laws.damping_factor(mode, nominal) if (mode, nominal) != (0, 0.0) else math.nan
            rows.append((mode, nominal, factor, math.nan if math.isnan(factor) else laws.effective_restitution(factor)))
    return pd.DataFrame(rows, columns=["damping_mode", "nominal_restitution", "damping_factor",
                                       "effective_restitution"])


def equation_16_consequences() -> list[str]:
    """Sentences that follow from eq. 16 without any simulation."""
    table = restitution_table()
    undamped = table.loc[table["nominal_restitution"] == 1, "damping_factor"]
    least = table[table["nominal_restitution"] == 0].set_index("damping_mode")["effective_restitution"]
    if not (undamped == 0).all():
        raise AssertionError("eq. 16: D is not 0 at e_n = 1")
    return [
        "At e_n = 1 all three damping modes are the same undamped Hertz law (D = 0): the paper's best case says "
        "nothing about the damping mode.",
        f"The nominal e_n is not the restitution of an impact: at e_n = 0 it is {least[1]:.3f} for M_d = 1 and "
        f"{least[2]:.3f} for M_d = 2; M_d = 0 is singular there.",
    ]
