"""What the law that holds the plates decides: runs of one scenario under several laws, after the same cycle."""

from __future__ import annotations

import math
from collections.abc import Iterable

import pandas as pd

from analysis.comparison import codes, run_quantities
from analysis.comparison.findings.members import IDENTITY, TRUE_LOAD, Member
from analysis.formats.quantities import row_of
from analysis.normalised.readers import Run
from analysis.scenarios.study_list import key_scenarios

LAW = "load_control.plate_law"

PLATES = (
    "cycle",
    "settlement_m",
    "plate_moved_low_m",
    "plate_moved_high_m",
    "plate_mean_low_Pa",
    "plate_mean_high_Pa",
    "plate_low_Pa",
    "plate_high_Pa",
    "first_cycle",
    "last_cycle",
    "settlement_rate_m",
)


def plate_laws_table(found: Iterable[Member]) -> pd.DataFrame:
    """Key scenarios under the true load with the law of the plates as it stands and changed, first packed bed: IDENTITY
    and PLATES.

    All runs of a scenario and profile are told after the last cycle that each of them has reached; the rate is that of
    the last span of cycles up to it. Stresses are nan where the run does not have them.
    """
    rows = []
    for group in _groups(found):
        cycle = codes.last_common_cycle([m.run for m in group])
        rows += [m.identity | {"cycle": cycle} | _told(m.run, cycle) for m in group]
    return pd.DataFrame(rows, columns=[*IDENTITY, *PLATES])


def _groups(found: Iterable[Member]) -> list[list[Member]]:
    """Runs that differ in the law of the plates, by profile and scenario, of codes that have a changed one."""
    groups: dict[tuple[str, str], list[Member]] = {}
    for m in found:
        if m.run.scenario is not None and m.run.seed == 1 and m.reading == TRUE_LOAD and m.scenario in key_scenarios():
            groups.setdefault((m.run.profile, m.scenario), []).append(m)
    compared = []
    for group in groups.values():
        plain = {m.run.code: m.run.scenario[LAW] for m in group if not m.variants}
        laws = [
            m
            for m in group
            if len(m.variants) == 1 and m.run.scenario[LAW] != plain.get(m.run.code, m.run.scenario[LAW])
        ]
        varied = {m.run.code for m in laws}
        if together := [m for m in group if m.run.code in varied and (not m.variants or m in laws)]:
            compared.append(together)
    return compared


def _told(run: Run, cycle: int) -> dict[str, float]:
    """Settlement, way and stress of the plates, and the rate of settling, of one run up to a cycle."""
    last = run.cycles.set_index("cycle").loc[cycle]
    moved = last[list(row_of("lateral_{}_m"))]
    stresses = run.plate_stresses[run.plate_stresses["cycle"] <= cycle]
    means = stresses[list(row_of("plate_{}_stress_mean_Pa"))].mean()
    rates = run_quantities.settling_rates(run)
    rates = rates[rates["last_cycle"] <= cycle]
    span = rates.iloc[-1] if len(rates) else {}
    return {
        "settlement_m": last["settlement_m"],
        "plate_moved_low_m": moved.min(),
        "plate_moved_high_m": moved.max(),
        "plate_mean_low_Pa": means.min(),
        "plate_mean_high_Pa": means.max(),
        "plate_low_Pa": stresses["plate_stress_min_Pa"].min(),
        "plate_high_Pa": stresses["plate_stress_max_Pa"].max(),
        **{name: span.get(name, math.nan) for name in ("first_cycle", "last_cycle", "settlement_rate_m")},
    }
