"""What each claim is judged by: one function for each, named as its id, yields the checks that it is made of.

See `evidence` for what a check is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from analysis.comparison.claims.claimed_quantities import (
    exponential_share,
    lateral_profile,
    porosities,
    porosity_range,
    profile_error,
    run_slope,
    seconds_per_cycle,
    settlement,
    settlement_difference,
    slope,
)
from analysis.comparison.claims.evidence import Check, Claim, Evidence, Measured, failed, finished, widened
from analysis.comparison.claims.uncertainty import Estimate, coverage, one_run
from analysis.comparison.run_quantities import has_processor_time, last_cycle, value_after
from analysis.formats.quantities import QUANTITIES, SHOWN_UNITS
from analysis.scenarios.scenario import load_scenario, scenario_names
from analysis.scenarios.study_list import key_scenarios

LINEAR, NONLINEAR = key_scenarios()
(BONDED,) = scenario_names(group="chen2015")
MODELS = {LINEAR: "linear", NONLINEAR: "nonlinear", BONDED: "bonded"}
Judge = Callable[[Evidence, dict], Iterator[Check]]
CHECKS: dict[str, Judge] = {}
"""Claims by their id."""


def judges(function: Judge) -> Judge:
    """The function judges the claim whose id is its name."""
    CHECKS[function.__name__] = function
    return function


def compares(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """A claim with `compares`: the quantity of the scenario `more` is above `ratio` times that of the scenario `less`,
    after the last cycle that both have reached, at least `cycles`.
    """
    asked, last = evidence.claim.compares, evidence.common_cycle(thresholds["cycles"])
    quantity = QUANTITIES[asked["quantity"]]
    found = evidence.measure(
        f"{quantity.label} after cycle {last}", lambda run: value_after(run, asked["quantity"], last), last
    )
    yield evidence.check(
        f"{quantity.label} above {thresholds['ratio']:g} times that of {asked['less']}",
        quantity.unit,
        lambda more, less: more - thresholds["ratio"] * less,
        found[asked["more"]],
        found[asked["less"]],
    )


def judge_of(claim: Claim) -> Judge | None:
    """What judges a claim: `compares` where the claim says so, else the function of its id; None without one."""
    return compares if claim.compares else CHECKS.get(claim.id)


@judges
def exponential_start(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 1."""
    last = evidence.common_cycle(thresholds["cycles"])
    # the fits take their time: only the runs that are judged; nobody has to lend, since two seeds are asked for
    share = evidence.measure(
        f"exponential share after cycle {last}",
        lambda r: exponential_share(r, last, thresholds["share"]),
        last,
        relative=False,
        members=[m for m in evidence.reached(last) if m.scenario in evidence.claim.runs],
        least_seeds=2,
    )
    yield evidence.check(
        f"{NONLINEAR} has the exponential start", "-", lambda s: s - thresholds["share"], share[NONLINEAR]
    )
    yield evidence.check(f"{LINEAR} does not have it", "-", lambda s: thresholds["share"] - s, share[LINEAR])


@judges
def late_slope(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 2."""
    ours = evidence.measure(
        "late slope", lambda r: run_slope(r, thresholds["first"], thresholds["cycles"]), thresholds["cycles"]
    )
    curve = evidence.experiment("settlement")
    theirs = evidence.pending("settlement")
    if len(curve):
        late = curve.loc[(curve["cycle"] >= thresholds["first"]) & (curve["cycle"] <= thresholds["cycles"]), "cycle"]
        value = slope(curve["cycle"], curve["value"], thresholds["first"], thresholds["cycles"])
        if math.isfinite(value):
            error = curve["error"].mean() / coverage(math.inf) / math.sqrt(((late - late.mean()) ** 2).sum())
            theirs = Measured("late slope, experiment", Estimate(value, error))
        else:
            theirs = Measured(
                "experiment", missing=(f"three points of the experiment from cycle {thresholds['first']} on",)
            )
    yield evidence.check(
        "the nonlinear slope is nearer to the experiment's",
        "m per cycle",
        lambda lin, non, exp: abs(lin - exp) - abs(non - exp),
        ours[LINEAR],
        ours[NONLINEAR],
        theirs,
        without_curve=""
        if len(curve)
        else _no_late_slope(evidence, thresholds) or _nearer("late slope", *SHOWN_UNITS["m per cycle"], ours),
    )


@judges
def vertical_shift(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 3."""
    what, curve = "the difference scatters little about its mean", evidence.experiment("settlement")
    last = thresholds["cycles"]
    if curve.empty:
        runs = evidence.measure("settlement", lambda r: settlement(r, last), last)
        missing = Measured("settlement", missing=runs[NONLINEAR].missing + evidence.pending("settlement").missing)
        yield evidence.check(what, "m", abs, missing, without_curve=_growth(evidence, last))
        return

    def margin(run) -> float:
        shift, scatter = (settlement_difference(run, curve, last, field) for field in ("shift_m", "rms_shifted_m"))
        return thresholds["scatter"] * abs(shift) - scatter

    measured = evidence.measure(
        f"{thresholds['scatter']:g} of the mean difference less its standard deviation", margin, last, relative=False
    )
    error = curve["error"].mean() / coverage(math.inf) * math.hypot(1, thresholds["scatter"])
    yield evidence.check(what, "m", lambda m: m, widened(measured[NONLINEAR], error))


@judges
def linear_lateral(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 4."""
    for cycle, sign in ((1, -1), (100, 1), (thresholds["cycles"], 1)):
        (error,) = evidence.profile_errors(cycle, LINEAR)
        yield evidence.check(
            f"{'good' if sign > 0 else 'poor'} after cycle {cycle}",
            "-",
            lambda value, sign=sign: sign * (thresholds["good"] - value),
            error,
            without_curve=_within(evidence, cycle, thresholds["good"], sign),
        )


@judges
def nonlinear_lateral(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 5."""
    for cycle in (1, 100):
        yield evidence.check(
            f"nonlinear better after cycle {cycle}",
            "-",
            lambda lin, non: lin - non,
            *evidence.profile_errors(cycle, LINEAR, NONLINEAR),
            without_curve=_nearer_profile(evidence, cycle, NONLINEAR, LINEAR),
        )
    yield evidence.check(
        f"comparable after cycle {thresholds['cycles']}",
        "-",
        lambda lin, non: thresholds["alike"] - abs(lin - non),
        *evidence.profile_errors(thresholds["cycles"], LINEAR, NONLINEAR),
        without_curve=_alike_profiles(evidence, thresholds["cycles"], thresholds["alike"]),
    )


def by_restitution(claim: Claim, mode: int, low: float = 0.0, high: float = 1.0) -> dict[float, str]:
    """The claim's scenarios of a damping mode by their e_n, rising from `low` to `high`; with e_n = 1 all modes are
    one.
    """
    found = {}
    for name in claim.runs:
        scenario = load_scenario(name)
        of_mode, restitution = (scenario[f"contact.particle_particle.{k}"] for k in ("damping_mode", "restitution"))
        if (of_mode == mode or restitution == 1) and low <= restitution <= high:
            found[restitution] = name
    return dict(sorted(found.items()))


@judges
def damping_modes(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 6."""
    for cycle, words in ((1, "twice"), (thresholds["cycles"], "alike")):
        low, high = thresholds[f"{words}_low"], thresholds[f"{words}_high"]
        lateral = evidence.measure(
            f"lateral displacement in m after cycle {cycle}", lambda r, n=cycle: lateral_profile(r, n).mean(), cycle
        )

        gonthier = by_restitution(evidence.claim, 0)
        each = len(gonthier)

        def margin(*values, low=low, high=high, count=each):
            ratio = np.mean(values[:count]) / np.mean(values[count:])
            return min(ratio - low, high - ratio)

        for mode in (1, 2):
            names = [*gonthier.values(), *by_restitution(evidence.claim, mode).values()]
            yield evidence.check(
                f"M_d = 0 over M_d = {mode} after cycle {cycle} between {low:g} and {high:g}",
                "-",
                margin,
                *(lateral[n] for n in names),
            )


@judges
def restitution_trend(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 7."""
    last = evidence.common_cycle(thresholds["cycles"])
    branches = (
        ("M_d = 0", by_restitution(evidence.claim, 0), -1),
        ("M_d = 2", by_restitution(evidence.claim, 2), -1),
        ("M_d = 1 from 0.6", by_restitution(evidence.claim, 1, low=0.6), -1),
        ("M_d = 1 to 0.6", by_restitution(evidence.claim, 1, high=0.6), 1),
    )
    for name, function in (
        ("settlement", lambda r: settlement(r, last)),
        ("lateral displacement", lambda r: lateral_profile(r, last).mean()),
    ):
        measured = evidence.measure(f"{name} after cycle {last}", function, last)
        for branch, scenarios, sign in branches:

            def margin(*values, restitutions=tuple(scenarios), sign=sign):
                return sign * (np.polyfit(restitutions, values, 1)[0] - thresholds["flat"])

            yield evidence.check(
                f"{name} {'rises' if sign > 0 else 'falls'} with e_n, {branch}",
                "m",
                margin,
                *(measured[s] for s in scenarios.values()),
            )


@judges
def undamped_best(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 8."""
    curve = evidence.experiment("settlement")
    curve = curve[curve["cycle"] <= thresholds["cycles"]]
    profiles = {n: evidence.experiment("lateral_displacement", n) for n in (1, 100, thresholds["cycles"])}
    pending = [] if len(curve) else ["settlement"]
    pending += [f"lateral displacement after cycle {n}" for n, profile in profiles.items() if profile.empty]

    def misfit(run) -> float:
        if pending:
            return settlement(run, thresholds["cycles"])
        errors = [
            settlement_difference(run, curve, thresholds["cycles"], "rms_m") / abs(float(curve["value"].iloc[-1]))
        ]
        return float(np.mean(errors + [profile_error(run, profile, n) for n, profile in profiles.items()]))

    measured = evidence.measure("misfit", misfit, thresholds["cycles"], relative=False)
    best_between = _best_between(evidence) if pending else ""
    for scenario in evidence.claim.runs:
        what = f"{NONLINEAR} agrees better than {scenario}"
        if scenario == NONLINEAR:
            continue
        if pending:
            missing = measured[NONLINEAR].missing + measured[scenario].missing + evidence.pending(*pending).missing
            yield evidence.check(what, "-", max, Measured("misfit", missing=missing), without_curve=best_between)
            continue
        relative = [c["error"].mean() / c["value"].abs().max() for c in (curve, *profiles.values())]
        error = float(np.mean(relative)) / coverage(math.inf)
        yield evidence.check(
            what,
            "-",
            lambda best, other: other - best,
            widened(measured[NONLINEAR], error),
            widened(measured[scenario], error),
        )


@judges
def porosity_order(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 9."""
    last = evidence.common_cycle(thresholds["cycles"])
    longest = evidence.longest(NONLINEAR)

    for higher, lower in ((3, 1), (3, 2), (2, 1)):

        def difference(run, cycle=last, higher=higher, lower=lower):
            values = porosities(run, cycle)
            return values[higher - 1] - values[lower - 1]

        what = f"sphere {higher} above sphere {lower} after cycle "
        measured = evidence.measure(f"{what}{last}", difference, last, relative=False)[NONLINEAR]
        after = {last: measured}
        if longest and (end := finished(longest)) > last and measured.estimate:
            of_one = one_run(measured.estimate, difference(longest.run, end))
            after[end] = Measured(f"{what}{end}, {NONLINEAR}, seed {longest.run.seed}", of_one)
        for cycle, value in after.items():
            yield evidence.check(f"{what}{cycle}", "-", lambda x: x, value)
    spread = evidence.measure(f"range to cycle {last}", lambda r: porosity_range(r, last), last, relative=False)
    yield evidence.check(
        "range wider than in the linear model", "-", lambda non, lin: non - lin, spread[NONLINEAR], spread[LINEAR]
    )


@judges
def preload_drop(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 10."""
    start = evidence.measure("porosity after preload", lambda r: porosities(r, 0).mean(), 0, relative=False)
    yield evidence.check(
        "lower than in the linear model",
        "-",
        lambda lin, non: lin - non - thresholds["drop"],
        start[LINEAR],
        start[NONLINEAR],
    )


@judges
def computing_time(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 11."""
    what = "shorter than the linear model's"
    timed = [m for m in evidence.reached(1) if math.isfinite(seconds_per_cycle(m.run))]
    machines = {name: {_machine(m.run) for m in timed if m.scenario == name} for name in (LINEAR, NONLINEAR)}
    shared = sorted(machines[LINEAR] & machines[NONLINEAR])
    best = max(shared, key=lambda machine: sum(_machine(m.run) == machine for m in timed), default=None)
    members = [m for m in timed if best in (None, _machine(m.run))]
    by_processor = [m for m in members if has_processor_time(m.run)]
    stated = "computing_time"
    if {m.scenario for m in by_processor} >= {LINEAR, NONLINEAR}:
        members, stated = by_processor, "processor_time"
    # other work on the machine can only slow a run: the fastest one is nearest to what a cycle costs
    fastest = {m.scenario: m for m in sorted(members, key=lambda m: -seconds_per_cycle(m.run))}
    members = list(fastest.values())
    time = evidence.measure("computing time per cycle", seconds_per_cycle, 1, stated=stated, members=members)
    if all(machines.values()) and not shared:
        time[LINEAR] = Measured(time[LINEAR].name, missing=("both models on one machine, same ranks and threads",))
    yield evidence.check(what, "s", lambda lin, non: thresholds["ratio"] * lin - non, time[LINEAR], time[NONLINEAR])


@judges
def settles_as_chen(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 12."""
    for cycle in (thresholds["early"], evidence.common_cycle(thresholds["cycles"])):
        settled = evidence.measure(f"settlement after cycle {cycle}", lambda r, n=cycle: settlement(r, n), cycle)
        yield evidence.check(
            f"alike after cycle {cycle}",
            "m",
            lambda lin, bonded: thresholds["alike"] * min(lin, bonded) - max(lin, bonded),
            settled[LINEAR],
            settled[BONDED],
        )


@judges
def chen_lateral(evidence: Evidence, thresholds: dict) -> Iterator[Check]:
    """Claim 13."""
    for cycle, nearer, other in ((1, BONDED, LINEAR), (thresholds["cycles"], LINEAR, BONDED)):
        yield evidence.check(
            f"{MODELS[nearer]} nearer after cycle {cycle}",
            "-",
            lambda near, far: far - near,
            *evidence.profile_errors(cycle, nearer, other),
            without_curve=_nearer_profile(evidence, cycle, nearer, other),
        )


def _machine(run) -> tuple:
    return tuple(str(run.info.get(key)) for key in ("host", "ranks", "threads"))


# ------------------------------------------------------------------ what can be said while a curve is pending


def _nearer(quantity: str, unit: str, factor: float, ours: dict[str, Measured]) -> str:
    """On which side of the middle between the two models the experiment has to be."""
    linear, nonlinear = (ours[name].estimate for name in (LINEAR, NONLINEAR))
    if linear is None or nonlinear is None:
        return ""
    side = "below" if nonlinear.mean < linear.mean else "above"
    return (
        f"it holds if the experiment's {quantity} is {side} {factor * (linear.mean + nonlinear.mean) / 2:.3g} {unit}, "
        f"the middle between {factor * nonlinear.mean:.3g} (nonlinear) and {factor * linear.mean:.3g} (linear)"
    )


def _no_late_slope(evidence: Evidence, thresholds: dict) -> str:
    """That the nonlinear bed fails before the late slope ends, where its longest run does."""
    longest = evidence.longest(NONLINEAR)
    if longest is None or not failed(longest):
        return ""
    first, last = thresholds["first"], thresholds["cycles"]
    return f"the nonlinear model has no slope from cycle {first} to {last}: it fails after {last_cycle(longest.run)}"


def _growth(evidence: Evidence, last: int) -> str:
    """By how much the experiment's settlement has to grow, for the difference to be a constant shift."""
    longest = evidence.longest(NONLINEAR)
    last = min(last, finished(longest)) if longest else 0
    if last < 2:
        return ""
    grown = evidence.seen(lambda r: settlement(r, last) - settlement(r, 1), last)
    return (
        f"a constant shift asks that the experiment's settlement grows by {1e3 * grown[NONLINEAR]:.3g} mm from cycle 1 "
        f"to {last}, as the model's does"
    )


def _lateral(evidence: Evidence, cycle: int) -> dict[str, float]:
    """Mean lateral displacement of the plates by scenario, m."""
    return evidence.seen(lambda r: lateral_profile(r, cycle).mean(), cycle)


def _within(evidence: Evidence, cycle: int, good: float, sign: int) -> str:
    """Between which means of the experiment's profile the linear model's can be good; outside them it is poor."""
    mean = _lateral(evidence, cycle).get(LINEAR)
    if mean is None:
        return ""
    if mean <= 0:
        no = "cannot be good" if sign > 0 else "is poor for sure"
        return f"after cycle {cycle} it {no} unless the experiment's plates move inward, as the model's do"
    low, high = 1e3 * mean / (1 + good), 1e3 * mean / (1 - good)
    does = "can be good" if sign > 0 else "is poor for sure"
    where = "only if" if sign > 0 else "unless"
    return (
        f"after cycle {cycle} it {does} {where} the experiment's mean lateral displacement is between {low:.3g} and "
        f"{high:.3g} mm (the model's is {1e3 * mean:.3g})"
    )


def _nearer_profile(evidence: Evidence, cycle: int, one: str, other: str) -> str:
    """On which side of the middle between two models the experiment's mean has to be for `one` to be nearer."""
    means = _lateral(evidence, cycle)
    if one not in means or other not in means:
        return ""
    side = "below" if means[one] < means[other] else "above"
    return (
        f"after cycle {cycle} the {MODELS[one]} model's is nearer to the experiment's mean lateral displacement if "
        f"that is {side} {1e3 * (means[one] + means[other]) / 2:.3g} mm ({MODELS[one]} {1e3 * means[one]:.3g}, "
        f"{MODELS[other]} {1e3 * means[other]:.3g})"
    )


def _alike_profiles(evidence: Evidence, cycle: int, alike: float) -> str:
    """Above which mean of the experiment's profile two errors cannot differ by more than `alike`."""
    plates = [evidence.seen(lambda r, k=k: lateral_profile(r, cycle)[k], cycle) for k in range(5)]
    if any(LINEAR not in plate or NONLINEAR not in plate for plate in plates):
        return ""
    apart = math.sqrt(sum((plate[LINEAR] - plate[NONLINEAR]) ** 2 for plate in plates) / len(plates))
    return (
        f"after cycle {cycle} the two are comparable whatever the experiment's shape if its mean lateral displacement "
        f"is above {1e3 * apart / alike:.3g} mm, since their profiles differ by {1e3 * apart:.3g} mm (rms)"
    )


def _best_between(evidence: Evidence) -> str:
    """Between which settlements of the experiment e_n = 1 is nearest to it."""
    judged = [m for m in evidence.members if m.scenario in evidence.claim.runs and finished(m) >= 1]
    if {m.scenario for m in judged} < set(evidence.claim.runs) or not judged:
        return ""
    last = min(max(finished(m) for m in judged if m.scenario == name) for name in evidence.claim.runs)
    values = evidence.seen(lambda r: settlement(r, last), last)
    best, others = (
        values[NONLINEAR],
        [v for name, v in values.items() if name in evidence.claim.runs and name != NONLINEAR],
    )
    below, above = (
        max((v for v in others if v < best), default=None),
        min((v for v in others if v > best), default=None),
    )
    limits = [f"above {1e3 * (below + best) / 2:.3g}"] if below is not None else []
    limits += [f"below {1e3 * (above + best) / 2:.3g}"] if above is not None else []
    place = 1 + sum(v > best for v in others)
    return (
        f"after cycle {last} e_n = 1 settles {1e3 * best:.3g} mm, no. {place} of {len(others) + 1} from the largest: "
        f"by settlement alone it is nearest to the experiment if that is {' and '.join(limits)} mm"
    )
