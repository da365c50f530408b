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
    seconds_per_cycle,
    settlement,
    settlement_difference,
    slope,
)
from analysis.comparison.claims.evidence import Check, Evidence, Measured, widened
from analysis.comparison.claims.uncertainty import Estimate, coverage
from analysis.scenarios.study import key_scenarios

LINEAR, NONLINEAR = key_scenarios()


def exponential_start(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 1."""
    last = e.common_cycle(t["cycles"])
    # the fits take their time: only the runs that are judged, others do not lend their scatter
    runs = [r for r in e.reached(last) if r.scenario_name in e.claim.runs]
    share = e.measure(
        f"exponential share after cycle {last}", lambda r: exponential_share(r, last), last, relative=False, runs=runs
    )
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
    yield e.check(
        "the nonlinear slope is nearer to the experiment's",
        "m/cycle",
        lambda lin, non, exp: abs(lin - exp) - abs(non - exp),
        ours[LINEAR],
        ours[NONLINEAR],
        theirs,
    )


def vertical_shift(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 3."""
    what, curve = "the difference scatters little about its mean", e.experiment("settlement")
    if curve.empty:
        runs = e.measure("settlement", lambda r: settlement(r, t["cycles"]), t["cycles"])
        yield e.check(what, "m", lambda s, exp: math.nan, runs[NONLINEAR], e.pending("settlement"))
        return
    last = t["cycles"]
    shift, scatter = (
        e.measure(name, lambda r, field=field: settlement_difference(r, curve, last, field), last, relative=False)
        for name, field in (("mean difference", "shift_m"), ("its standard deviation", "rms_shifted_m"))
    )
    error = curve["error"].mean() / coverage(math.inf)
    yield e.check(
        what,
        "m",
        lambda m, s: t["scatter"] * abs(m) - s,
        widened(shift[NONLINEAR], error),
        widened(scatter[NONLINEAR], error),
    )


def linear_lateral(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 4."""
    for cycle, sign in ((1, -1), (100, 1), (t["cycles"], 1)):
        (error,) = e.profile_errors(cycle, LINEAR)
        yield e.check(
            f"{'good' if sign > 0 else 'poor'} after cycle {cycle}",
            "-",
            lambda value, sign=sign: sign * (t["good"] - value),
            error,
        )


def nonlinear_lateral(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 5."""
    for cycle in (1, 100):
        yield e.check(
            f"nonlinear better after cycle {cycle}",
            "-",
            lambda lin, non: lin - non,
            *e.profile_errors(cycle, LINEAR, NONLINEAR),
        )
    yield e.check(
        f"comparable after cycle {t['cycles']}",
        "-",
        lambda lin, non: t["alike"] - abs(lin - non),
        *e.profile_errors(t["cycles"], LINEAR, NONLINEAR),
    )


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
        yield e.check(
            what,
            "-",
            lambda best, other: other - best,
            widened(measured[NONLINEAR], error),
            widened(measured[scenario], error),
        )


def porosity_order(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 9."""
    last = e.common_cycle(t["cycles"])

    def above(run):
        one, two, three = porosities(run, last)
        return three - max(one, two)

    def below(run):
        one, two, three = porosities(run, last)
        return min(two, three) - one

    for what, name, function in (
        ("sphere 3 highest", "sphere 3 above the next", above),
        ("sphere 1 lowest", "sphere 1 below the next", below),
    ):
        measured = e.measure(name, function, last, relative=False)
        yield e.check(f"{what} after cycle {last}", "-", lambda x: x, measured[NONLINEAR])
    spread = e.measure(f"range to cycle {last}", lambda r: porosity_range(r, last), last, relative=False)
    yield e.check(
        "range wider than in the linear model", "-", lambda non, lin: non - lin, spread[NONLINEAR], spread[LINEAR]
    )


def preload_drop(e: Evidence, t: dict) -> Iterator[Check]:
    """Claim 10."""
    start = e.measure("porosity after preload", lambda r: porosities(r, 0).mean(), 0, relative=False)
    yield e.check(
        "lower than in the linear model", "-", lambda lin, non: lin - non - t["drop"], start[LINEAR], start[NONLINEAR]
    )


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


CHECKS: dict[str, Callable[[Evidence, dict], Iterator[Check]]] = {
    f.__name__: f
    for f in (
        exponential_start,
        late_slope,
        vertical_shift,
        linear_lateral,
        nonlinear_lateral,
        damping_modes,
        restitution_trend,
        undamped_best,
        porosity_order,
        preload_drop,
        computing_time,
    )
}
