"""Parameters: what follows from them, where scenarios differ, and what runs that differ in one of them say."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import combinations

from analysis.comparison.quantities import last_cycle
from analysis.comparison.same_bed import changed_keys, ranks
from analysis.normalised.readers import Run
from analysis.report.labels import KPA, MM
from analysis.report.tables.base import Column, Table, number, shown
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario

UNCERTAIN = {"assumed", "calibrated"}
"""Statuses of parameters whose value nobody reported."""


def difference_table(scenarios: dict[str, Scenario]) -> Table:
    """Every scenario with the parameters in which any two of them differ."""
    sets = list(scenarios.values())
    keys = [key for key in (sets[0].parameters if sets else ()) if any(s[key] != sets[0][key] for s in sets)]
    columns = [Column("scenario"), *(Column(key.replace(".", ". ").replace("_", " "), True) for key in keys)]
    rows = [[name, *(shown(s[key]) for key in keys)] for name, s in scenarios.items()]
    return Table("Parameters in which any two scenarios differ, SI units", columns, rows)


def derived_table(scenario: Scenario) -> Table:
    """Quantities that follow from the parameters."""
    clump, box, grid = derived.clump(scenario), derived.apparatus(scenario), derived.time_grid(scenario)
    ends = [scenario["loading.stress_min"], scenario["loading.stress_max"]]
    asked = " and ".join(number(stress, 3, KPA) for stress in ends)
    rows = [
        ["radius of the two spheres", number(clump.radius_m, 5, MM), "mm"],
        ["distance of their centres", number(2 * clump.half_distance_m, 5, MM), "mm"],
        ["clump volume", number(clump.volume_m3, 5, 1e6), "cm³"],
        ["clump mass", number(clump.mass_kg, 5, 1e3), "g"],
        ["inertia about the axis", number(clump.inertia_axial_kgm2, 5), "kg m²"],
        ["inertia across it", number(clump.inertia_transverse_kgm2, 5), "kg m²"],
        ["sleeper area", number(box.sleeper_area_m2, 5), "m²"],
        ["area of a plate", number(box.plate_area_m2, 5), "m²"],
        [
            f"force on the sleeper at {asked} kPa",
            ", ".join(number(stress * box.sleeper_area_m2, 4, 1e-3) for stress in ends),
            "kN",
        ],
        ["space for ballast", number(box.ballast_volume_m3, 4), "m³"],
        ["time step", number(grid.step_s, 4), "s"],
        ["steps per cycle", str(grid.steps_per_cycle), ""],
    ]
    return Table(f"Of {scenario.name} at full size", [Column("quantity"), Column("value", True), Column("unit")], rows)


def sensitivity_table(runs: Iterable[Run]) -> Table:
    """Pairs of runs of one code, profile, seed and rank count that differ in one assumed or calibrated parameter."""
    words = Column("run"), Column("against run")
    numbers = [Column(name, True) for name in ("cycle", "settlement, mm", "against", "change, %")]
    table = Table(
        "Runs that differ in one assumed or calibrated parameter only, after the last cycle they share",
        [Column("parameter"), Column("value", True), Column("against", True), *words, *numbers],
    )
    for run, other, key in one_apart([run for run in runs if len(run.cycles) and run.scenario is not None]):
        cycle = min(last_cycle(run), last_cycle(other))
        ours, theirs = (float(r.cycles.set_index("cycle")["settlement_m"].loc[cycle]) for r in (run, other))
        change = number(100 * (theirs / ours - 1), 2) if ours else "–"
        values = [shown(other.scenario[key]), shown(run.scenario[key])]
        settled = [number(theirs, 3, MM), number(ours, 3, MM), change]
        table.rows.append([key, *values, other.id, run.id, str(cycle), *settled])
    return table


def one_apart(runs: list[Run]) -> Iterator[tuple[Run, Run, str]]:
    """Pairs of runs that differ in one parameter alone, an assumed or calibrated one, and its key."""
    for run, other in combinations(runs, 2):
        if (run.profile, run.code, run.seed, ranks(run)) != (other.profile, other.code, other.seed, ranks(other)):
            continue
        keys = changed_keys(run, other)
        if len(keys) == 1 and {r.scenario.parameters[keys[0]].status for r in (run, other)} & UNCERTAIN:
            yield run, other, keys[0]
