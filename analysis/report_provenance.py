"""Where the numbers come from: the pages on runs and on parameters."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import pandas as pd

from . import derived, figures, tables
from .figures import KPA, MM
from .readers import Run
from .report_book import (
    KEY_SCENARIOS,
    Book,
    changed_keys,
    known_scenarios,
    last_cycle,
    name_of,
    speed,
    state_of,
    timing,
    tracking_percent,
)
from .report_words import Chip, Column, Table, number, plural, shown
from .scenario import Scenario, load_scenario
from .schema import STATUSES

STATUS_KIND = {"reported": "good", "derived": "calm", "assumed": "open", "calibrated": "bad"}
STATUS_TEXT = {
    "reported": "Printed in the paper.",
    "derived": "Follows from reported values; the source says how.",
    "assumed": "Nobody's value is known: a knob for sensitivity studies.",
    "calibrated": "Tuned by this project; the source says to what. What it was tuned to is no evidence any more.",
}
STATE_KIND = {"finished": "good", "running": "calm", "interrupted": "open", "failed": "bad"}


def runs_table(runs: Sequence[Run]) -> Table:
    """One line per run: what, how far, how well."""
    table = Table(
        "All runs. Settlement at minimum load and tracking error (worst cycle, rms) are of the cycles reached.",
        [
            Column("run"),
            Column("size"),
            Column("state"),
            Column("cycles", True),
            Column("clumps", True),
            Column("settlement, mm", True),
            Column("plates, mm", True),
            Column("tracking, %", True),
            Column("steps/s", True),
            Column("bed"),
        ],
    )
    for run in runs:
        state, _ = state_of(run)
        goal = run.scenario["loading.cycles"] if run.scenario else None
        last = run.cycles.iloc[-1] if len(run.cycles) else None
        lateral = last[[f"lateral_{k}_m" for k in tables.PLATES]] if last is not None else None
        table.rows.append(
            [
                name_of(run),
                run.profile,
                Chip(state, STATE_KIND.get(state, "open")),
                f"{last_cycle(run)}{f' of {goal}' if goal else ''}",
                number(last["clumps"] if last is not None else run.info.get("clumps"), 6),
                number(last["settlement_m"], 3, MM) if last is not None else "–",
                f"{number(lateral.min(), 2, MM)} to {number(lateral.max(), 2, MM)}" if last is not None else "–",
                number(tracking_percent(run), 2),
                number(speed(run), 3),
                bed_of(run),
            ]
        )
    return table


def runs_page(book: Book) -> dict:
    """Every run with where it comes from."""
    summary = Table(
        "Provenance",
        [
            Column("run"),
            Column("parameters"),
            Column("engine"),
            Column("analysis"),
            Column("commit"),
            Column("seed", True),
            Column("bed"),
            Column("state"),
        ],
    )
    entries = []
    for run in book.runs:
        versions = run.info.get("versions", {})
        state, reason = state_of(run)
        commit = str(run.info.get("git_commit") or "")[:10] or "–"
        summary.rows.append(
            [
                run.id,
                figures.run_id(run).rpartition("@")[2],
                versions.get("engine", "–"),
                versions.get("analysis", "–"),
                commit + ("+" if run.info.get("git_dirty") else ""),
                str(run.seed),
                bed_of(run),
                Chip(state, STATE_KIND.get(state, "open")),
            ]
        )
        entries.append(run_entry(run, state, reason))
    summary.note = (
        "A commit with + had changes that were not committed. Runs below runs/ are the ones kept in the "
        "repository; they have no beds."
    )
    left_out = Table(
        "Runs that are not drawn",
        [Column("run"), Column("why", wide=True)],
        [[run.id, why] for run, why in book.left_out],
    )
    tracking = [
        figures.tracking(
            book.gallery,
            book.of(profile),
            f"tracking-all-{profile}",
            f"Load tracking, all runs of profile {profile}",
            "rms error over each cycle, and the extremes of each cycle minus their targets (paler: minimum).",
        )
        for profile in book.profiles
    ]
    return {
        "summary": summary,
        "runs": entries,
        "tables": [left_out],
        "figures": tracking,
        "results": book.results,
        "problems": book.problems,
    }


def bed_of(run: Run) -> str:
    """Where the packed bed came from."""
    bed = str(run.info.get("bed", "–"))
    return f"of {bed.split('/')[2]}" if bed.startswith("../../") else bed


def run_entry(run: Run, state: str, reason: str) -> dict:
    """One run in a few sentences."""
    times, info = timing(run), run.info
    text = [
        f"{info.get('title') or (run.scenario.title if run.scenario else run.scenario_name)}; profile {run.profile}, "
        f"seed {run.seed}."
    ]
    if reason:
        text.append(f"Reason: {reason}.")
    if run.last_error():
        text.append(f"Last error in its logs: {run.last_error()}.")
    text.append(
        f"{last_cycle(run)} cycles"
        + (f" of {run.scenario['loading.cycles']}" if run.scenario else "")
        + f", stage {info.get('stage', 'unknown')}, "
        f"{plural(int(info.get('ranks') or 1), 'rank')}, {plural(int(info.get('threads') or 1), 'thread')}"
        + (f", {plural(len(info['resumes']), 'resume')}" if info.get("resumes") else "")
        + "."
    )
    speeds = times.get("steps_per_second")
    if isinstance(speeds, dict) and speeds:
        text.append(
            "Steps per second: " + ", ".join(f"{stage} {number(value, 3)}" for stage, value in speeds.items()) + "."
        )
    if times.get("start"):
        text.append(
            f"From {times['start']} to "
            f"{times.get('end') or 'now'}{' on ' + str(times['host']) if times.get('host') else ''}."
        )
    if len(run.cycles):
        text.append(
            f"Tracking error {number(tracking_percent(run), 2)} % rms in the worst cycle; sleeper stress "
            f"{number(run.cycles['sleeper_stress_min_Pa'].min(), 3, KPA)} to "
            f"{number(run.cycles['sleeper_stress_max_Pa'].max(), 3, KPA)} kPa."
        )
        text.extend(plate_sentence(run))
    versions = info.get("versions", {})
    if versions:
        text.append("Versions: " + ", ".join(f"{key} {value}" for key, value in versions.items()) + ".")
    return {
        "anchor": re.sub(r"[^a-z0-9]+", "-", run.id.lower()),
        "name": run.id,
        "state": state,
        "kind": STATE_KIND.get(state, "open"),
        "text": " ".join(text),
        "deviations": [str(d) for d in info.get("deviations", [])],
        "problems": run.problems,
        "command": info.get("command", "command unknown"),
    }


def plate_sentence(run: Run) -> list[str]:
    """Mean stress on each plate over the run, where the history is there."""
    columns = [f"plate_{k}_stress_Pa" for k in tables.PLATES]
    means = run.history[columns].mean() if len(run.history) else pd.Series(dtype=float)
    if not len(means) or not np.isfinite(means).any():
        return []
    return ["Mean stress on plates 1 to 5: " + ", ".join(number(v, 3, KPA) for v in means) + " kPa."]


def assumptions(book: Book) -> dict:
    """Every parameter with status and source, and what runs say about the assumed ones."""
    names = known_scenarios()
    scenarios = {name: load_scenario(name, "full") for name in names}
    base = scenarios.get(KEY_SCENARIOS[0]) or next(iter(scenarios.values()), None)
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
    table, missing = sensitivity(book)
    return {
        "statuses": [{"name": s, "kind": STATUS_KIND[s], "count": counts[s], "text": STATUS_TEXT[s]} for s in STATUSES],
        "groups": [{"name": name, "parameters": entries} for name, entries in groups.items()],
        "derived": derived_table(base) if base else None,
        "differences": difference_table(scenarios),
        "base": base.name if base else "",
        "sensitivity": table,
        "sensitivity_missing": missing,
    }


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
            "force on the sleeper at 50 and 460 kPa",
            f"{number(50e3 * box.sleeper_area_m2, 4, 1e-3)}, {number(460e3 * box.sleeper_area_m2, 4, 1e-3)}",
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


def sensitivity(book: Book) -> tuple[Table, str]:
    """Pairs of runs of one code, profile and seed that differ in a single assumed or calibrated parameter."""
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
    runs = [run for run in book.runs if len(run.cycles) and run.scenario is not None]
    for n, run in enumerate(runs):
        for other in runs[n + 1 :]:
            if (run.profile, run.code, run.seed) != (other.profile, other.code, other.seed):
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
        "No two runs of one code and seed differ in just one assumed or calibrated parameter yet. Add a scenario to "
        "scenarios.toml that is based on another and changes "
        "one such value, run it, and it is listed here."
    )
