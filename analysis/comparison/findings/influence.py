"""What one thing changed at a time does to settlement and lateral displacement, with the seeds' scatter as
yardstick.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator

import numpy as np
import pandas as pd

from analysis.comparison.findings.members import Member
from analysis.comparison.run_quantities import last_cycle, value_after
from analysis.formats.quantities import QUANTITIES
from analysis.scenarios.scenario import ScenarioError, load_scenario

CYCLE = 20
"""After which influences are compared; after fewer where a pair has fewer."""

CHANGED = ("settlement_m", "lateral_mean_m")
"""What is compared."""

INFLUENCE = (
    "profile",
    "scenario",
    "reading",
    "code",
    "variant",
    "quantity",
    "cycle",
    "unit",
    "base",
    "changed",
    "change_ratio",
    "scatter_ratio",
    "scatters",
    "run",
    "base_run",
)

LEAST_INFLUENCE = 2
"""Standard deviations between packed beds from which on a change is called an influence."""


def influence_table(found: Iterable[Member], scatter: pd.DataFrame) -> pd.DataFrame:
    """Each varied run against the plain run of its scenario, reading, code and seed (columns INFLUENCE).

    change_ratio    changed over base, minus 1; nan where they have no common sign
    scatter_ratio   standard deviation between beds as a share of the mean, see `agreement.scatter_table`
    scatters        size of the change in such deviations
    """
    found = list(found)
    plain = {(*m.key, m.run.seed): m for m in found if m.plain}
    rows = []
    for m in found:
        base = plain.get((*m.key, m.run.seed))
        if base is None or not m.others or not m.own_bed or not one_thing_changed(base, m) or of_the_step(base, m):
            continue
        cycle = min(CYCLE, last_cycle(m.run), last_cycle(base.run))
        for change in changes(base, m, cycle, scatter):
            spread = change["scatter_ratio"]
            scatters = abs(change["change_ratio"]) / spread if spread else math.nan
            of = {"variant": "+".join(m.others), "run": m.run.id, "base_run": base.run.id}
            rows.append(change | of | {"unit": QUANTITIES[change["quantity"]].unit, "scatters": scatters})
    table = pd.DataFrame(rows, columns=INFLUENCE)
    return table.sort_values("change_ratio", key=size_of_change, ascending=False, kind="stable")


def size_of_change(change_ratio: pd.Series) -> pd.Series:
    """By how large a factor something changed, as its logarithm: a third is as large a change as three times."""
    return np.log1p(change_ratio).abs()


def one_thing_changed(base: Member, varied: Member) -> bool:
    """True where two runs differ in nothing but what the variant of the scenario file says: not in an older time
    step.
    """
    if base.run.scenario is None or varied.run.scenario is None:
        return False
    try:
        wanted = _changed(base.run.scenario_name, varied.run.scenario_name, base.run.profile)
    except ScenarioError:
        return False
    return set(base.run.scenario.changed_keys(varied.run.scenario)) <= wanted


def of_the_step(base: Member, varied: Member) -> bool:
    """True for a variant of the time step alone, whichever run its bed is named after: it is set beside rounding, not
    beside what the paper leaves out.
    """
    changed = _changed(base.run.scenario_name, varied.run.scenario_name, base.run.profile) - {"packing.bed_from"}
    return all(key.startswith("time.") for key in changed)


def changes(base: Member, varied: Member, cycle: int, scatter: pd.DataFrame) -> Iterator[dict]:
    """Settlement and lateral displacement of two runs after `cycle`: where they belong, base, changed, m, change_ratio
    (nan where the two have no common sign) and scatter_ratio, see `influence_table`.
    """
    for quantity in CHANGED:
        before, after = (value_after(m.run, quantity, cycle) for m in (base, varied))
        yield {
            "profile": varied.run.profile,
            "scenario": varied.scenario,
            "reading": varied.reading,
            "code": varied.run.code,
            "seed": varied.run.seed,
            "cycle": cycle,
            "quantity": quantity,
            "base": before,
            "changed": after,
            "change_ratio": after / before - 1 if before * after > 0 else math.nan,
            "scatter_ratio": spread_between_beds(scatter, varied, quantity, cycle),
        }


@functools.cache
def _changed(base: str, varied: str, profile: str) -> frozenset[str]:
    one, other = (load_scenario(name, profile) for name in (base, varied))
    return frozenset(one.changed_keys(other))


def spread_between_beds(scatter: pd.DataFrame, member: Member, quantity: str, cycle: int) -> float:
    """Scatter between beds at the nearest compared cycle not after `cycle`."""
    rows = scatter[
        (scatter["profile"] == member.run.profile)
        & (scatter["model"] == member.run.scenario["contact.model"])
        & (scatter["reading"] == member.reading)
        & (scatter["quantity"] == quantity)
        & (scatter["cycle"] <= cycle)
    ].sort_values("cycle")
    return float(rows["scatter_ratio"].iloc[-1]) if len(rows) else math.nan
