"""Every parameter with its status and source, and what runs say about the assumed ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.comparison import codes, quantities
from analysis.comparison.quantities import last_cycle
from analysis.comparison.same_bed import changed_keys, ranks
from analysis.driver import calibrate
from analysis.formats import file_columns
from analysis.formats.numbers import plural
from analysis.normalised.readers import Run
from analysis.report.figures.calibration import calibration_figure
from analysis.report.figures.lateral import lateral_figure
from analysis.report.figures.settlement import settlement_figure
from analysis.report.labels import KPA, MM, short_name
from analysis.report.paper import paper
from analysis.report.report_data import KEY_SCENARIOS, ReportData, known_scenarios, name_of
from analysis.report.style import CODE_NAMES
from analysis.report.tables import Column, Table, number, shown
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, join_id, load_scenario
from analysis.scenarios.schema import STATUSES

PLATE_VARIANTS = ("plates-fixed", "plates-pfc")
"""Variants of the law that holds the plates."""
STATUS_KIND = {"reported": "good", "derived": "calm", "assumed": "open", "calibrated": "bad"}

STATUS_TEXT = {
    "reported": "Printed in the paper.",
    "derived": "Follows from reported values; the source says how.",
    "assumed": "Nobody's value is known: a knob for sensitivity studies.",
    "calibrated": "Tuned by this project; the source says to what. What it was tuned to is no evidence any more.",
}


def assumptions(data: ReportData) -> dict:
    """Every parameter with status and source, and what runs say about the assumed ones."""
    names = known_scenarios()
    scenarios = {name: load_scenario(name, "full") for name in names}
    base = scenarios.get(next(iter(KEY_SCENARIOS), "")) or next(iter(scenarios.values()), None)
    groups: dict[str, list] = {}
    for key, p in (base.parameters if base else {}).items():
        section = key.rpartition(".")[0]
        groups.setdefault(section, []).append(
            {
                "key": key,
                "value": shown(p.value),
                "unit": p.unit if p.unit != "-" else "",
                "status": p.status,
                "kind": STATUS_KIND[p.status],
                "source": p.source,
            }
        )
    counts = {s: sum(p["status"] == s for group in groups.values() for p in group) for s in STATUSES}
    table, missing = sensitivity(data)
    return {
        "statuses": [{"name": s, "kind": STATUS_KIND[s], "count": counts[s], "text": STATUS_TEXT[s]} for s in STATUSES],
        "groups": [{"name": name, "parameters": entries} for name, entries in groups.items()],
        "derived": derived_table(base) if base else None,
        "differences": difference_table(scenarios),
        "base": base.name if base else "",
        "sensitivity": table,
        "calibration": calibration(data, base),
        "plates": plate_laws(data),
        "sensitivity_missing": missing,
    }


def calibration(data: ReportData, base: Scenario | None) -> dict:
    """Table and figure of the beds that `make calibrate` tried, the chosen one marked; {} where there are none."""
    try:
        beds = calibrate.read_table(data.kept / calibrate.TABLE.name)
    except FileNotFoundError:
        return {}
    except ValueError as error:
        data.gallery.complain(str(error))
        return {}
    chosen = (base["clump.aspect"], base["packing.lattice_gap"]) if base else (np.nan, np.nan)
    return {
        "table": calibration_table(beds, chosen),
        "figure": calibration_figure(data.gallery, beds, chosen),
    }


def calibration_table(beds: pd.DataFrame, chosen: tuple[float, float]) -> Table:
    """One row per bed, with how far it settles under each contact model; `chosen` are the aspect and the gap (m) of the
    scenario file.
    """
    cycles, models = int(beds["cycles"].max()), list(dict.fromkeys(beds["scenario"]))
    names, seeds = (sorted(set(beds[name])) for name in ("code", "seed"))
    table = Table(
        f"Beds tried in {' and '.join(CODE_NAMES.get(code, code) for code in names)}; the paper's has "
        f"{paper().reported.clumps} clumps at porosity {paper().reported.porosity}",
        [
            Column("aspect and gap"),
            Column("clumps", True),
            Column("of the paper's, %", True),
            Column("mean porosity", True),
            Column("contacts per clump", True),
            *(
                Column(f"{what}, {short_name(model)}, mm", True)
                for model in models
                for what in ("preload", plural(cycles, "cycle"))
            ),
        ],
    )
    for (aspect, gap), bed in beds.groupby(["aspect", "lattice_gap_m"]):
        first = bed.iloc[0]
        row = [
            f"{shown(aspect)}, {shown(gap * MM)} mm" + (" (chosen)" if (aspect, gap) == chosen else ""),
            number(first["clumps"], 4),
            number(100 * first["clumps_over_reported"], 4),
            number(first["porosity_mean"], 3),
            number(first["coordination_number"], 3),
        ]
        for model in models:
            loaded = bed[bed["scenario"] == model]
            if loaded.empty:
                row += ["–", "–"]
                continue
            last = loaded.iloc[0]
            settled = number(last["settlement_m"], 3, MM)
            if last["cycles"] < cycles:
                settled = f"{last['state']} after {plural(last['cycles'], 'cycle')}"
            row += [number(last["preload_settlement_m"], 3, MM), settled]
        table.rows.append(row)
    table.note = f"From `make calibrate`, seed {', '.join(map(str, seeds))}. Settlement in preload, and after it."
    return table


def plate_laws(data: ReportData) -> list[dict]:
    """A table and figures per profile and contact model: what the law that holds the plates decides."""
    parts = []
    runs = [
        run for run in (*data.runs, *data.variants) if len(run.cycles) and run.scenario is not None and run.seed == 1
    ]
    for profile in data.profiles:
        for base in KEY_SCENARIOS:
            laws = [base, *(join_id(base, [variant]) for variant in PLATE_VARIANTS)]
            members = [run for run in runs if run.profile == profile and run.scenario_name in laws]
            varied = {run.code for run in members if run.scenario_name != base}
            members = [run for run in members if run.code in varied]
            if not members:
                continue
            shared = codes.last_common_cycle(members)
            name = f"plates-{base}-{profile}"
            settlement = settlement_figure(
                data.gallery,
                members,
                name,
                f"{short_name(base)}: settlement under three laws of the plates",
                "Plates driven by the difference of force (the default), by PFC's servo, or not moving at all; from "
                "the same packed bed.",
                references=False,
            )
            lateral = lateral_figure(
                data.gallery,
                members,
                f"{name}-lateral",
                f"{short_name(base)}: plates under three laws",
                "Lateral displacement over depth since the end of preload.",
                cycles=sorted({1, shared}),
                references=False,
            )
            parts += [{"table": plate_table(members, shared)}, {"figure": settlement}, {"figure": lateral}]
    return parts


def plate_table(runs: Sequence[Run], cycle: int) -> Table:
    """Runs under different laws of the plates after the same cycle, and the stress that the plates had up to it."""
    table = Table(
        f"Laws of the plates, after {plural(cycle, 'cycle')}; the paper prescribes "
        f"{number(paper().plate_stress_Pa, 3, KPA)} kPa",
        [
            Column("run"),
            Column("settlement, mm", True),
            Column("plates moved, mm", True),
            Column("mean stress of each plate, kPa", True),
            Column("lowest and highest stress, kPa", True),
            Column("settling in the last span, µm per cycle", True),
        ],
    )
    for run in runs:
        row = run.cycles.set_index("cycle").loc[cycle]
        moved = row[[f"lateral_{k}_m" for k in file_columns.PLATES]]
        history = run.history[(run.history["cycle"] > 0) & (run.history["cycle"] <= cycle)]
        stress = history[[f"plate_{k}_stress_Pa" for k in file_columns.PLATES]].to_numpy(dtype=float)
        known = np.isfinite(stress).any()
        rates = quantities.settling_rates(run)
        rates = rates[rates["last_cycle"] <= cycle]
        last = rates.iloc[-1] if len(rates) else None
        table.rows.append(
            [
                name_of(run),
                number(row["settlement_m"], 3, MM),
                f"{number(moved.min(), 2, MM)} to {number(moved.max(), 2, MM)}",
                f"{number(stress.mean(axis=0).min(), 3, KPA)} to {number(stress.mean(axis=0).max(), 3, KPA)}"
                if known
                else "–",
                f"{number(stress.min(), 2, KPA)}, {number(stress.max(), 2, KPA)}" if known else "–",
                "–"
                if last is None
                else f"{number(last['settlement_rate_m'], 3, 1e6)} (cycles {last['first_cycle']:.0f} to "
                f"{last['last_cycle']:.0f})",
            ]
        )
    table.note = "Stress from the 64 rows per cycle of history.csv, which copies kept in the repository lack."
    return table


def difference_table(scenarios: dict[str, Scenario]) -> Table:
    """Every scenario with the parameters in which any two of them differ."""
    sets = list(scenarios.values())
    keys = [key for key in (sets[0].parameters if sets else ()) if any(s[key] != sets[0][key] for s in sets)]
    columns = [Column("scenario"), *(Column(key.replace(".", ". ").replace("_", " "), True) for key in keys)]
    rows = [[name, *(shown(s[key]) for key in keys)] for name, s in scenarios.items()]
    return Table("Parameters in which any two scenarios differ, SI units", columns, rows)


def derived_table(s: Scenario) -> Table:
    """Quantities that follow from the parameters."""
    clump, box, grid = derived.clump(s), derived.apparatus(s), derived.time_grid(s)
    low, high = s["loading.stress_min"], s["loading.stress_max"]
    rows = [
        ("radius of the two spheres", number(clump.radius_m, 5, MM), "mm"),
        ("distance of their centres", number(2 * clump.half_distance_m, 5, MM), "mm"),
        ("clump volume", number(clump.volume_m3, 5, 1e6), "cm³"),
        ("clump mass", number(clump.mass_kg, 5, 1e3), "g"),
        ("inertia about the axis", number(clump.inertia_axial_kgm2, 5), "kg m²"),
        ("inertia across it", number(clump.inertia_transverse_kgm2, 5), "kg m²"),
        ("sleeper area", number(box.sleeper_area_m2, 5), "m²"),
        ("area of a plate", number(box.plate_area_m2, 5), "m²"),
        (
            f"force on the sleeper at {number(low, 3, KPA)} and {number(high, 3, KPA)} kPa",
            f"{number(low * box.sleeper_area_m2, 4, 1e-3)}, {number(high * box.sleeper_area_m2, 4, 1e-3)}",
            "kN",
        ),
        ("space for ballast", number(box.ballast_volume_m3, 4), "m³"),
        ("time step", number(grid.step_s, 4), "s"),
        ("steps per cycle", str(grid.steps_per_cycle), ""),
    ]
    return Table(
        f"Of {s.name} at full size",
        [Column("quantity"), Column("value", True), Column("unit")],
        [list(r) for r in rows],
    )


def sensitivity(data: ReportData) -> tuple[Table, str]:
    """Pairs of runs of one code, profile, seed and rank count that differ in one assumed or calibrated parameter."""
    table = Table(
        "Runs that differ in one assumed or calibrated parameter only, after the last cycle they share",
        [
            Column("parameter"),
            Column("value", True),
            Column("against", True),
            Column("run"),
            Column("against run"),
            Column("cycle", True),
            Column("settlement, mm", True),
            Column("against", True),
            Column("change, %", True),
        ],
    )
    runs = [run for run in (*data.runs, *data.variants) if len(run.cycles) and run.scenario is not None]
    for n, run in enumerate(runs):
        for other in runs[n + 1 :]:
            if (run.profile, run.code, run.seed, ranks(run)) != (other.profile, other.code, other.seed, ranks(other)):
                continue
            keys = changed_keys(run, other)
            if len(keys) != 1 or not {
                run.scenario.parameters[keys[0]].status,
                other.scenario.parameters[keys[0]].status,
            } & {"assumed", "calibrated"}:
                continue
            cycle = min(last_cycle(run), last_cycle(other))
            a, b = (float(r.cycles.set_index("cycle")["settlement_m"].loc[cycle]) for r in (run, other))
            table.rows.append(
                [
                    keys[0],
                    shown(other.scenario[keys[0]]),
                    shown(run.scenario[keys[0]]),
                    other.id,
                    run.id,
                    str(cycle),
                    number(b, 3, MM),
                    number(a, 3, MM),
                    number(100 * (b / a - 1), 2) if a else "–",
                ]
            )
    return table, (
        "No two runs of one code and seed differ in just one assumed or calibrated parameter yet. Run a variant of "
        "scenarios.toml that changes one such value (VARIANT=...), and it is listed here."
    )
