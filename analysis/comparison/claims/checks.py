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
from analysis.comparison.claims.evidence import Check, Evidence, Measured, finished, widened
from analysis.comparison.claims.uncertainty import Estimate, coverage
from analysis.comparison.quantities import has_processor_time
from analysis.scenarios.scenario import scenario_names
from analysis.scenarios.study import key_scenarios

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


@judges
def exponential_start(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 1."""
    last = e.common_cycle(t["cycles"])
    # the fits take their time: only the runs that are judged; nobody has to lend, since two seeds are asked for
    share = e.measure(
        f"exponential share after cycle {last}",
        lambda r: exponential_share(r, last, t["share"]),
        last,
        relative=False,
        members=[m for m in e.reached(last) if m.scenario in e.claim.runs],
        least_seeds=2,
    )
    yield e.check(f"{NONLINEAR} has the exponential start", "-", lambda s: s - t["share"], share[NONLINEAR])
    yield e.check(f"{LINEAR} does not have it", "-", lambda s: t["share"] - s, share[LINEAR])


@judges
def late_slope(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 2."""
    ours = e.measure("late slope", lambda r: run_slope(r, t["first"], t["cycles"]), t["cycles"])
    curve = e.experiment("settlement")
    theirs = e.pending("settlement")
    if len(curve):
        late = curve.loc[(curve["cycle"] >= t["first"]) & (curve["cycle"] <= t["cycles"]), "cycle"]
        value = slope(curve["cycle"], curve["value"], t["first"], t["cycles"])
        if math.isfinite(value):
            error = curve["error"].mean() / coverage(math.inf) / math.sqrt(((late - late.mean()) ** 2).sum())
            theirs = Measured("late slope, experiment", Estimate(value, error))
        else:
            theirs = Measured("experiment", missing=(f"three points of the experiment from cycle {t['first']} on",))
    yield e.check(
        "the nonlinear slope is nearer to the experiment's",
        "m/cycle",
        lambda lin, non, exp: abs(lin - exp) - abs(non - exp),
        ours[LINEAR],
        ours[NONLINEAR],
        theirs,
        without_curve="" if len(curve) else _nearer("late slope", "mm per 1000 cycles", 1e6, ours),
    )


@judges
def vertical_shift(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 3."""
    what, curve = "the difference scatters little about its mean", e.experiment("settlement")
    last = t["cycles"]
    if curve.empty:
        runs = e.measure("settlement", lambda r: settlement(r, last), last)
        missing = Measured("settlement", missing=runs[NONLINEAR].missing + e.pending("settlement").missing)
        yield e.check(what, "m", abs, missing, without_curve=_growth(e, last))
        return

    def margin(run) -> float:
        shift, scatter = (settlement_difference(run, curve, last, field) for field in ("shift_m", "rms_shifted_m"))
        return t["scatter"] * abs(shift) - scatter

    measured = e.measure(
        f"{t['scatter']:g} of the mean difference less its standard deviation", margin, last, relative=False
    )
    error = curve["error"].mean() / coverage(math.inf) * math.hypot(1, t["scatter"])
    yield e.check(what, "m", lambda m: m, widened(measured[NONLINEAR], error))


@judges
def linear_lateral(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 4."""
    for cycle, sign in ((1, -1), (100, 1), (t["cycles"], 1)):
        (error,) = e.profile_errors(cycle, LINEAR)
        yield e.check(
            f"{'good' if sign > 0 else 'poor'} after cycle {cycle}",
            "-",
            lambda value, sign=sign: sign * (t["good"] - value),
            error,
            without_curve=_within(e, cycle, t["good"], sign),
        )


@judges
def nonlinear_lateral(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 5."""
    for cycle in (1, 100):
        yield e.check(
            f"nonlinear better after cycle {cycle}",
            "-",
            lambda lin, non: lin - non,
            *e.profile_errors(cycle, LINEAR, NONLINEAR),
            without_curve=_nearer_profile(e, cycle, NONLINEAR, LINEAR),
        )
    yield e.check(
        f"comparable after cycle {t['cycles']}",
        "-",
        lambda lin, non: t["alike"] - abs(lin - non),
        *e.profile_errors(t["cycles"], LINEAR, NONLINEAR),
        without_curve=_alike_profiles(e, t["cycles"], t["alike"]),
    )


@judges
def damping_modes(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 6."""
    for cycle, words in ((1, "twice"), (t["cycles"], "alike")):
        low, high = t[f"{words}_low"], t[f"{words}_high"]
        lateral = e.measure(
            f"lateral displacement after cycle {cycle}", lambda r, n=cycle: lateral_profile(r, n).mean(), cycle
        )

        def margin(*values, low=low, high=high):
            ratio = np.mean(values[:3]) / np.mean(values[3:])
            return min(ratio - low, high - ratio)

        for mode in (1, 2):
            names = [f"nonlinear-md{m}-en{en}" for m in (0, mode) for en in (0.3, 0.6, 0.9)]
            yield e.check(
                f"M_d = 0 over M_d = {mode} after cycle {cycle} between {low:g} and {high:g}",
                "-",
                margin,
                *(lateral[n] for n in names),
            )


@judges
def restitution_trend(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 7."""
    last = e.common_cycle(t["cycles"])
    branches = (
        ("M_d = 0", 0, (0.3, 0.6, 0.9, 1.0), -1),
        ("M_d = 2", 2, (0.3, 0.6, 0.9, 1.0), -1),
        ("M_d = 1 from 0.6", 1, (0.6, 0.9, 1.0), -1),
        ("M_d = 1 to 0.6", 1, (0.0, 0.3, 0.6), 1),
    )
    for name, function in (
        ("settlement", lambda r: settlement(r, last)),
        ("lateral displacement", lambda r: lateral_profile(r, last).mean()),
    ):
        measured = e.measure(f"{name} after cycle {last}", function, last)
        for branch, mode, restitutions, sign in branches:
            scenarios = [NONLINEAR if en == 1 else f"nonlinear-md{mode}-en{en}" for en in restitutions]

            def margin(*values, x=restitutions, sign=sign):
                return sign * (np.polyfit(x, values, 1)[0] - t["flat"])

            yield e.check(
                f"{name} {'rises' if sign > 0 else 'falls'} with e_n, {branch}",
                "m",
                margin,
                *(measured[s] for s in scenarios),
            )


@judges
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
    best_between = _best_between(e) if pending else ""
    for scenario in e.claim.runs:
        what = f"{NONLINEAR} agrees better than {scenario}"
        if scenario == NONLINEAR:
            continue
        if pending:
            missing = measured[NONLINEAR].missing + measured[scenario].missing + e.pending(*pending).missing
            yield e.check(what, "-", max, Measured("misfit", missing=missing), without_curve=best_between)
            continue
        relative = [c["error"].mean() / c["value"].abs().max() for c in (curve, *profiles.values())]
        error = float(np.mean(relative)) / coverage(math.inf)
        yield e.check(
            what,
            "-",
            lambda best, other: other - best,
            widened(measured[NONLINEAR], error),
            widened(measured[scenario], error),
        )


@judges
def porosity_order(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 9."""
    last = e.common_cycle(t["cycles"])

    for higher, lower in ((3, 1), (3, 2), (2, 1)):

        def difference(run, higher=higher, lower=lower):
            values = porosities(run, last)
            return values[higher - 1] - values[lower - 1]

        what = f"sphere {higher} above sphere {lower} after cycle {last}"
        measured = e.measure(what, difference, last, relative=False)
        yield e.check(what, "-", lambda x: x, measured[NONLINEAR])
    spread = e.measure(f"range to cycle {last}", lambda r: porosity_range(r, last), last, relative=False)
    yield e.check(
        "range wider than in the linear model", "-", lambda non, lin: non - lin, spread[NONLINEAR], spread[LINEAR]
    )


@judges
def preload_drop(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 10."""
    start = e.measure("porosity after preload", lambda r: porosities(r, 0).mean(), 0, relative=False)
    yield e.check(
        "lower than in the linear model", "-", lambda lin, non: lin - non - t["drop"], start[LINEAR], start[NONLINEAR]
    )


@judges
def computing_time(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 11."""
    what = "shorter than the linear model's"
    timed = [m for m in e.reached(1) if math.isfinite(seconds_per_cycle(m.run))]
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
    time = e.measure("computing time per cycle", seconds_per_cycle, 1, stated=stated, members=members)
    if all(machines.values()) and not shared:
        time[LINEAR] = Measured(time[LINEAR].name, missing=("both models on one machine, same ranks and threads",))
    yield e.check(what, "s", lambda lin, non: t["ratio"] * lin - non, time[LINEAR], time[NONLINEAR])


@judges
def settles_as_chen(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 12."""
    for cycle in (t["early"], e.common_cycle(t["cycles"])):
        settled = e.measure(f"settlement after cycle {cycle}", lambda r, n=cycle: settlement(r, n), cycle)
        yield e.check(
            f"alike after cycle {cycle}",
            "m",
            lambda lin, bonded: t["alike"] * min(lin, bonded) - max(lin, bonded),
            settled[LINEAR],
            settled[BONDED],
        )


@judges
def chen_lateral(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 13."""
    for cycle, nearer, other in ((1, BONDED, LINEAR), (t["cycles"], LINEAR, BONDED)):
        yield e.check(
            f"{MODELS[nearer]} nearer after cycle {cycle}",
            "-",
            lambda near, far: far - near,
            *e.profile_errors(cycle, nearer, other),
            without_curve=_nearer_profile(e, cycle, nearer, other),
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


def _growth(e: Evidence, last: int) -> str:
    """By how much the experiment's settlement has to grow, for the difference to be a constant shift."""
    last = min(last, max((finished(m) for m in e.members if m.scenario == NONLINEAR), default=0))
    if last < 2:
        return ""
    grown = e.seen(lambda r: settlement(r, last) - settlement(r, 1), last)
    return (
        f"a constant shift asks that the experiment's settlement grows by {1e3 * grown[NONLINEAR]:.3g} mm from cycle 1 "
        f"to {last}, as the model's does"
    )


def _lateral(e: Evidence, cycle: int) -> dict[str, float]:
    """Mean lateral displacement of the plates by scenario, m."""
    return e.seen(lambda r: lateral_profile(r, cycle).mean(), cycle)


def _within(e: Evidence, cycle: int, good: float, sign: int) -> str:
    """Between which means of the experiment's profile the linear model's can be good; outside them it is poor."""
    mean = _lateral(e, cycle).get(LINEAR)
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


def _nearer_profile(e: Evidence, cycle: int, one: str, other: str) -> str:
    """On which side of the middle between two models the experiment's mean has to be for `one` to be nearer."""
    means = _lateral(e, cycle)
    if one not in means or other not in means:
        return ""
    side = "below" if means[one] < means[other] else "above"
    return (
        f"after cycle {cycle} the {MODELS[one]} model's is nearer to the experiment's mean lateral displacement if "
        f"that is {side} {1e3 * (means[one] + means[other]) / 2:.3g} mm ({MODELS[one]} {1e3 * means[one]:.3g}, "
        f"{MODELS[other]} {1e3 * means[other]:.3g})"
    )


def _alike_profiles(e: Evidence, cycle: int, alike: float) -> str:
    """Above which mean of the experiment's profile two errors cannot differ by more than `alike`."""
    plates = [e.seen(lambda r, k=k: lateral_profile(r, cycle)[k], cycle) for k in range(5)]
    if any(LINEAR not in plate or NONLINEAR not in plate for plate in plates):
        return ""
    apart = math.sqrt(sum((plate[LINEAR] - plate[NONLINEAR]) ** 2 for plate in plates) / len(plates))
    return (
        f"after cycle {cycle} the two are comparable whatever the experiment's shape if its mean lateral displacement "
        f"is above {1e3 * apart / alike:.3g} mm, since their profiles differ by {1e3 * apart:.3g} mm (rms)"
    )


def _best_between(e: Evidence) -> str:
    """Between which settlements of the experiment e_n = 1 is nearest to it."""
    judged = [m for m in e.members if m.scenario in e.claim.runs and finished(m) >= 1]
    if {m.scenario for m in judged} < set(e.claim.runs) or not judged:
        return ""
    last = min(max(finished(m) for m in judged if m.scenario == name) for name in e.claim.runs)
    values = e.seen(lambda r: settlement(r, last), last)
    best, others = values[NONLINEAR], [v for name, v in values.items() if name in e.claim.runs and name != NONLINEAR]
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
