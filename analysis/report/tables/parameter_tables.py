"""Parameters: what follows from them, where scenarios differ, and what runs that differ in one of them say."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Iterator
from itertools import combinations

import pandas as pd

from analysis.comparison.run_quantities import last_cycle
from analysis.comparison.same_bed import changed_keys, ranks
from analysis.formats.quantities import SHOWN_UNITS
from analysis.normalised.readers import Run
from analysis.report.labels import KPA
from analysis.report.tables.table_html import Shown, Table, frame_table, number, shown
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario
from analysis.scenarios.schema import STATUSES

STATUS_KIND = {"reported": "good", "derived": "calm", "assumed": "open", "calibrated": "bad"}
"""Colours of the statuses."""

UNCERTAIN = {"assumed", "calibrated"}
"""Statuses of parameters whose value nobody reported."""


def status_counts(parameters: dict) -> list[dict]:
    """How many parameters have each status."""
    found = [p.status for p in parameters.values()]
    return [{"name": status, "kind": STATUS_KIND[status], "count": found.count(status)} for status in STATUSES]


def parameter_groups(parameters: dict) -> list[dict]:
    """The parameters by their section of the scenario file."""
    groups: dict[str, list[dict]] = {}
    for key, p in parameters.items():
        told = {"key": key, "value": shown(p.value), "unit": p.unit if p.unit != "-" else "", "status": p.status}
        groups.setdefault(key.rpartition(".")[0], []).append(told | {"kind": STATUS_KIND[p.status], "source": p.source})
    return [{"name": name, "parameters": entries} for name, entries in groups.items()]


def difference_table(scenarios: dict[str, Scenario]) -> Table | None:
    """Every scenario with the parameters in which any two of them differ; keys are those of the scenario file."""
    sets = list(scenarios.values())
    keys = [key for key in (sets[0].parameters if sets else ()) if any(s[key] != sets[0][key] for s in sets)]
    rows = [
        {"name": name} | {f"value_{n}": shown(s[key]) for n, key in enumerate(keys)} for name, s in scenarios.items()
    ]
    return frame_table(
        pd.DataFrame(rows),
        "Parameters in which any two scenarios differ, SI units",
        [
            Shown("name", "scenario", number=False),
            *(
                Shown(f"value_{n}", key.replace(".", ". ").replace("_", " "), text=operator.attrgetter(f"value_{n}"))
                for n, key in enumerate(keys)
            ),
        ],
    )


def derived_table(scenario: Scenario) -> Table | None:
    """Quantities that follow from the parameters."""
    clump, box, grid = derived.clump(scenario), derived.apparatus(scenario), derived.time_grid(scenario)
    ends = {name: scenario[f"loading.stress_{name}"] for name in ("min", "max")}
    rows = [
        ("radius of the two spheres", clump.radius_m, "m"),
        ("distance of their centres", 2 * clump.half_distance_m, "m"),
        ("clump volume", clump.volume_m3, "m3"),
        ("clump mass", clump.mass_kg, "kg"),
        ("inertia about the axis", clump.inertia_axial_kgm2, "kg m²"),
        ("inertia across it", clump.inertia_transverse_kgm2, "kg m²"),
        ("sleeper area", box.sleeper_area_m2, "m²"),
        ("area of a plate", box.plate_area_m2, "m²"),
        *(
            (f"force on the sleeper at {number(stress, 3, KPA)} kPa", stress * box.sleeper_area_m2, "N")
            for stress in ends.values()
        ),
        ("space for ballast", box.ballast_volume_m3, "m³"),
        ("time step", grid.step_s, "s"),
        ("steps per cycle", grid.steps_per_cycle, "-"),
    ]
    return frame_table(
        pd.DataFrame(rows, columns=["what", "value", "unit"]),
        f"Of {scenario.name} at full size",
        [
            Shown("what", "quantity", number=False),
            Shown("value", text=lambda row: number(row.value, 5, SHOWN_UNITS.get(row.unit, (row.unit, 1.0))[1])),
            Shown("unit", text=lambda row: SHOWN_UNITS.get(row.unit, (row.unit, 1.0))[0], number=False),
        ],
    )


def sensitivity_table(runs: Iterable[Run]) -> Table | None:
    """Pairs of runs of one code, profile, seed and rank count that differ in one assumed or calibrated parameter."""
    rows = []
    for run, other, key in one_apart([run for run in runs if len(run.cycles) and run.scenario is not None]):
        cycle = min(last_cycle(run), last_cycle(other))
        ours, theirs = (float(r.cycles.set_index("cycle")["settlement_m"].loc[cycle]) for r in (run, other))
        row = {"parameter": key, "value": shown(other.scenario[key]), "base_value": shown(run.scenario[key])}
        row |= {"run": other.id, "base_run": run.id, "cycle": cycle, "settlement_m": theirs, "base_settlement_m": ours}
        rows.append(row | {"change_ratio": theirs / ours - 1 if ours else math.nan})
    return frame_table(
        pd.DataFrame(rows),
        "Runs that differ in one assumed or calibrated parameter only, after the last cycle they share",
        [
            Shown("parameter", number=False),
            Shown("value", text=operator.attrgetter("value")),
            Shown("base_value", "against", text=operator.attrgetter("base_value")),
            "run",
            Shown("base_run", "against run", number=False),
            "cycle",
            "settlement_m",
            Shown("base_settlement_m", "against", like="settlement_m"),
            Shown("change_ratio", digits=2),
        ],
    )


def one_apart(runs: list[Run]) -> Iterator[tuple[Run, Run, str]]:
    """Pairs of runs that differ in one parameter alone, an assumed or calibrated one, and its key."""
    for run, other in combinations(runs, 2):
        if (run.profile, run.code, run.seed, ranks(run)) != (other.profile, other.code, other.seed, ranks(other)):
            continue
        keys = changed_keys(run, other)
        if len(keys) == 1 and {r.scenario.parameters[keys[0]].status for r in (run, other)} & UNCERTAIN:
            yield run, other, keys[0]
