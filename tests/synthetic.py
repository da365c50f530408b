"""Run folders with known answers, made without any engine: settlement law, bulge, hysteresis loop and beds are given.

`write_run` writes a complete normalised run folder in a fraction of a second per hundred cycles.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pandas as pd

from analysis.formats import file_columns
from analysis.scenarios import derived
from analysis.scenarios.lattice import lattice_bed
from analysis.scenarios.scenario import load_scenario

LAWS = {
    "exponential": lambda n, a, b, c, d: a + b * (1 - np.exp(-n / c)) + d * n,
    "logarithm": lambda n, a, b: a + b * np.log(n),
    "power": lambda n, a, b: a * n**b,
    "line": lambda n, a, b: a + b * n,
}
DEFAULT_LAW = ("exponential", {"a": 1e-3, "b": 6e-3, "c": 15.0, "d": 2e-6})
LATERAL_PROFILE = (0.5, 0.8, 1.0, 0.9, 0.6)  # lateral displacement of plates 1-5 over that of the largest
# resilient stroke and phase lag: loop = pi sigma_a A (stroke / 2) tan(lag)
STROKE_M, LOSS_ANGLE_RAD = 4e-3, 0.1


def settlement(law, cycles) -> np.ndarray:
    """Settlement (m) after `cycles` by law = (name, parameters)."""
    name, parameters = law
    return LAWS[name](np.asarray(cycles, dtype=float), **parameters)


def write_run(
    results_dir,
    profile="demo",
    scenario="linear-mu0.8",
    code="liggghts",
    cycles=20,
    seed=1,
    *,
    law=DEFAULT_LAW,
    noise=0.0,
    lateral_m=5e-3,
    porosity=(0.345, 0.350, 0.360),
    porosity_change=(-0.01, -0.005, 0.01),
    state="finished",
    rng=0,
    contacts=True,
    scenario_file=None,
    info=None,
) -> Path:
    """Write a complete normalised run folder and return its path.

    law         ("exponential" | "logarithm" | "power" | "line", {parameters in m and cycles})
    noise       standard deviation of the settlement at minimum load, as a share of its value
    lateral_m   lateral displacement of the middle plate at the end; plates follow LATERAL_PROFILE and the law's shape
    porosity, porosity_change   of the three spheres before loading and in the course of all cycles
    contacts    write raw/contacts_*.csv of the kept cycles, too
    info        entries that replace those of run.json
    """
    options = {} if scenario_file is None else {"path": scenario_file}
    s = load_scenario(scenario, profile, cycles=cycles, **options)
    generator = np.random.default_rng([rng, seed, cycles])
    folder = Path(results_dir) / profile / scenario / (code if seed == 1 else f"{code}-seed{seed}")
    for sub in ("raw", "log", "checkpoints"):
        (folder / sub).mkdir(parents=True, exist_ok=True)
    (folder / "scenario.json").write_text(s.to_json())

    n = np.arange(1, cycles + 1)
    minimum = settlement(law, n) * (1 + noise * generator.standard_normal(cycles))
    share = settlement(law, n) / settlement(law, [cycles])
    lateral = lateral_m * share[:, None] * np.array(LATERAL_PROFILE)
    porosities = np.array(porosity) + share[:, None] * np.array(porosity_change)
    bed = _bed(s, seed)

    _write_cycles(folder, s, n, minimum, lateral, porosities, len(bed), generator)
    _write_history(folder, s, minimum, lateral)
    _write_microstructure(folder, s, share, np.array(porosity), porosities, lateral)
    after = bed.copy()
    after["x_m"] += lateral[-1].max() * bed["x_m"] / s["geometry.box_length"]
    after["z_m"] -= minimum[-1] * bed["z_m"] / s["geometry.box_height"]
    bed.to_csv(folder / "bed_before.csv", index=False)
    after.to_csv(folder / "bed_after.csv", index=False)
    if contacts:
        for cycle in sorted({k for k in s["output.keep_beds"] if k <= cycles} | {cycles}):
            _write_contacts(folder / "raw" / f"contacts_cycle_{cycle:06d}.csv", bed, generator)
        _write_contacts(folder / "raw" / "contacts_preloaded.csv", bed, generator)
    _write_stages(folder, bed, porosity)
    (folder / "run.json").write_text(json.dumps(run_record(s, code, cycles, seed, state, len(bed), info), indent=1))
    return folder


def _bed(s, seed) -> pd.DataFrame:
    poses = np.array(lattice_bed(s, seed))
    return pd.DataFrame(np.column_stack([np.arange(1, len(poses) + 1), poses]), columns=file_columns.BED).astype(
        {"id": int}
    )


def _write_cycles(folder, s, n, minimum, lateral, porosities, clumps, generator) -> None:
    stress_min, stress_max = s["loading.stress_min"], s["loading.stress_max"]
    table = pd.DataFrame(
        {
            "cycle": n,
            "time_s": n / s["loading.frequency"],
            "settlement_m": minimum,
            "settlement_peak_m": minimum + STROKE_M,
        }
    )
    for k in file_columns.PLATES:
        table[f"lateral_{k}_m"] = lateral[:, k - 1]
    for k in file_columns.SPHERES:
        table[f"porosity_{k}"] = porosities[:, k - 1]
    table["sleeper_stress_min_Pa"] = stress_min * (1 + 0.01 * generator.random(len(n)))
    table["sleeper_stress_max_Pa"] = stress_max * (1 - 0.01 * generator.random(len(n)))
    table["tracking_rms_Pa"] = 0.005 * stress_max * (1 + 0.1 * generator.random(len(n)))
    table["clumps"] = clumps
    table[list(file_columns.CYCLES)].to_csv(folder / "cycles.csv", index=False)


def _write_history(folder, s, minimum, lateral) -> None:
    rows, cycles = s["output.rows_per_cycle"], len(minimum)
    cycle = np.arange(cycles * rows + 1) / rows
    middle, amplitude = (
        (s["loading.stress_max"] + s["loading.stress_min"]) / 2,
        (s["loading.stress_max"] - s["loading.stress_min"]) / 2,
    )
    target = middle - amplitude * np.cos(2 * np.pi * cycle)
    grid = np.arange(cycles + 1)
    # Loading leads displacement by the loss angle; stroke / 2 / cos(lag) makes peak minus minimum equal to the stroke.
    swing = STROKE_M / 2 * (1 - np.cos(2 * np.pi * cycle - LOSS_ANGLE_RAD) / np.cos(LOSS_ANGLE_RAD))
    table = pd.DataFrame(
        {
            "time_s": cycle / s["loading.frequency"],
            "cycle": cycle,
            "sleeper_target_Pa": target,
            "sleeper_stress_Pa": target,
            "settlement_m": np.interp(cycle, grid, np.r_[0, minimum]) + swing,
            "plate_target_Pa": s["preload.plate_stress"],
        }
    )
    for k in file_columns.PLATES:
        table[f"plate_{k}_stress_Pa"] = s["preload.plate_stress"]
    for k in file_columns.PLATES:
        table[f"lateral_{k}_m"] = np.interp(cycle, grid, np.r_[0, lateral[:, k - 1]])
    table[list(file_columns.HISTORY)].to_csv(folder / "history.csv", index=False, float_format="%.9g")


def _write_microstructure(folder, s, share, porosity, porosities, lateral) -> None:
    share = np.r_[0, share]
    area = derived.apparatus(s).plate_area_m2
    table = pd.DataFrame({"cycle": np.arange(len(share))})
    for k in file_columns.SPHERES:
        table[f"porosity_{k}"] = np.r_[porosity[k - 1], porosities[:, k - 1]]
    table["porosity_error"] = 0.0009
    table["bulge_volume_m3"] = np.r_[0, lateral.sum(axis=1)] * area
    start_and_change = {
        "coordination_number": (7.0, -0.5),
        "neighbours_mean": (6.0, -0.4),
        "overlap_mean_m": (2e-5, 1e-6),
        "overlap_max_ratio": (0.02, 0.002),
        "rotation_mean_rad": (0.0, 0.2),
        "rotation_max_rad": (0.0, 1.5),
        "shoulder_displacement_m": (0.0, 4e-3),
        "downward_mean_m": (0.0, 3e-3),
        "downward_under_sleeper_m": (0.0, 6e-3),
        "crib_heave_m": (0.0, 1e-3),
        "sleeper_contacts": (200.0, -20.0),
        "sliding_share": (0.05, 0.05),
        "kinetic_energy_J": (1e-6, 1e-5),
        "unbalanced_ratio": (1e-3, 5e-3),
        "normal_force_mean_N": (30.0, 5.0),
        "contact_anisotropy": (0.2, 0.3),
        "force_anisotropy": (0.5, 0.4),
        "fabric_xx": (0.31, -0.01),
        "fabric_yy": (0.32, -0.01),
        "fabric_zz": (0.37, 0.02),
        "force_chain_share": (0.36, 0.01),
        "force_chain_load_share": (0.7, 0.02),
    }
    for column, (start, change) in start_and_change.items():
        table[column] = start + change * share
    table["at_limit_share"] = 0.0 if s["contact.model"] == "linear" else 0.1
    table[list(file_columns.MICROSTRUCTURE)].to_csv(folder / "microstructure.csv", index=False)


def _write_stages(folder, bed, porosity) -> None:
    packed = {"clumps": len(bed), "porosity_mean": float(np.mean(porosity)), "coordination_number": 6.0}
    packed |= {
        "overlap_mean_m": 1e-7,
        "overlap_max_ratio": 1e-4,
        "bed_sha256": hashlib.sha256(bed.to_csv().encode()).hexdigest(),
    }
    moved = {"settlement_m": 4e-4} | {f"lateral_{k}_m": -1e-4 for k in file_columns.PLATES}
    porosities = {f"porosity_{k}": value for k, value in zip(file_columns.SPHERES, porosity, strict=True)}
    (folder / "stages.json").write_text(
        json.dumps({"packing": packed, "preload": packed | porosities | moved}, indent=1)
    )


def _write_contacts(path, bed, generator, count=2000) -> None:
    normals = generator.standard_normal((count, 3)) * (1, 1, 1.3)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    first, second = generator.integers(0, len(bed), (2, count))
    force = generator.exponential(30.0, count)
    table = pd.DataFrame(bed[["x_m", "y_m", "z_m"]].to_numpy()[first], columns=["x_m", "y_m", "z_m"])
    table["clump_1"], table["clump_2"] = bed["id"].to_numpy()[first], bed["id"].to_numpy()[second]
    table[["nx", "ny", "nz"]] = normals
    table["overlap_m"], table["normal_force_N"] = force / 1e8, force
    table["sliding"] = (generator.random(count) < 0.1).astype(int)
    table["shear_force_N"] = force * np.where(table["sliding"] == 1, 0.8, 0.3)
    table[list(file_columns.CONTACTS)].to_csv(path, index=False)


def run_record(s, code, cycles, seed=1, state="finished", clumps=380, changes=None) -> dict:
    """The content of run.json; `changes` replaces entries, those of its timing too."""
    steps, changes = cycles * derived.time_grid(s).steps_per_cycle, dict(changes or {})
    timing = {
        "start": "2026-01-01T00:00:00+00:00",
        "end": "2026-01-01T01:00:00+00:00",
        "steps_per_second": {"cyclic": 350.0},
        "wall_s": {"cyclic": 3600.0},
        "pid": 1,
        "host": "nowhere",
        "heartbeat": "2026-01-01T01:00:00+00:00",
    }
    timing |= {key: changes.pop(key) for key in timing if key in changes}
    return {
        "scenario": s.name,
        "variant": "+".join(s.variants),
        "profile": s.profile,
        "code": code,
        "scenario_hash": s.hash,
        "title": s.title,
        "versions": {"engine": "synthetic", "analysis": "0.1.0", "python": "3.11", "os": "none"},
        "command": f"make run SCENARIO={s.name} CODE={code} PROFILE={s.profile} CYCLES={cycles} SEED={seed}",
        "seed": seed,
        "bed": "own",
        "git_commit": "0" * 40,
        "git_dirty": False,
        "ranks": 1,
        "threads": 1,
        "state": state,
        "reason": "",
        "stage": "cyclic",
        "steps": {"cyclic": steps},
        "clumps": clumps,
        "deviations": [],
        "resumes": [],
        **changes,
        "timing": timing,
    }


def write_raw(
    results_dir,
    profile="demo",
    scenario="linear-mu0.8",
    code="liggghts",
    cycles=3,
    seed=1,
    *,
    law=DEFAULT_LAW,
    lateral_m=5e-3,
    preload_down_m=2e-3,
    scenario_file=None,
) -> Path:
    """Write the raw output that an engine leaves after `cycles` cycles (nothing normalised) and return the run folder.

    The bed sinks by z / box height of the settlement and bulges by x / box length of the lateral displacement; sleeper
    and plates are displaced by `preload_down_m` (outward: a tenth of it) before cyclic loading.
    """
    options = {} if scenario_file is None else {"path": scenario_file}
    s = load_scenario(scenario, profile, cycles=cycles, **options)
    folder = Path(results_dir) / profile / scenario / (code if seed == 1 else f"{code}-seed{seed}")
    raw = folder / "raw"
    raw.mkdir(parents=True, exist_ok=True)
    (folder / "scenario.json").write_text(s.to_json())
    grid, bed = derived.time_grid(s), _bed(s, seed)
    minimum = settlement(law, np.arange(1, cycles + 1))
    lateral = lateral_m * (minimum / minimum[-1])[:, None] * np.array(LATERAL_PROFILE)

    rows = s["output.rows_per_cycle"]
    step = np.arange(cycles * rows + 1) * grid.steps_per_row
    cycle = np.arange(cycles * rows + 1) / rows
    middle, amplitude = (
        (s["loading.stress_max"] + s["loading.stress_min"]) / 2,
        (s["loading.stress_max"] - s["loading.stress_min"]) / 2,
    )
    target = middle - amplitude * np.cos(2 * np.pi * cycle)
    knots = np.arange(cycles + 1)
    table = pd.DataFrame(
        {
            "step": step,
            "time_s": step * grid.step_s,
            "sleeper_target_Pa": target,
            "sleeper_stress_Pa": 1.01 * target,
            "sleeper_stress_mean_Pa": target,
            "sleeper_error_ms_Pa2": 4e6,
            "sleeper_displacement_m": preload_down_m
            + np.interp(cycle, knots, np.r_[0, minimum])
            + STROKE_M / 2 * (1 - np.cos(2 * np.pi * cycle)),
        }
    )
    for k in file_columns.PLATES:
        table[f"plate_{k}_stress_Pa"] = table[f"plate_{k}_stress_mean_Pa"] = s["preload.plate_stress"] * (1 + 0.001 * k)
        table[f"plate_{k}_displacement_m"] = preload_down_m / 10 + np.interp(cycle, knots, np.r_[0, lateral[:, k - 1]])
    table[list(file_columns.RAW_LOADING)].to_csv(raw / "cyclic.csv", index=False)
    preload = table.iloc[:9].copy()
    for column in preload.filter(like="displacement"):
        preload[column] = np.linspace(0, table[column].iloc[0], len(preload))
    preload[list(file_columns.RAW_LOADING)].to_csv(raw / "preload.csv", index=False)

    blocks = np.arange(1, cycles * s["output.blocks_per_cycle"] + 1) * grid.steps_per_block
    state = pd.DataFrame(
        {
            "stage": "cyclic",
            "step": blocks,
            "time_s": blocks * grid.step_s,
            "kinetic_energy_J": 1e-5,
            "unbalanced_ratio": 0.01,
            "overlap_max_ratio": 0.02,
            "overlap_mean_m": 1e-5,
            "contacts": 7 * len(bed) // 2,
            "clumps": len(bed),
            "at_limit_share": 0.0,
            "sliding_share": 0.1,
        }
    )
    packing = state.iloc[:2].assign(stage="packing")
    pd.concat([packing, state])[list(file_columns.RAW_STATE)].to_csv(raw / "state.csv", index=False)

    generator = np.random.default_rng(seed)
    bed.to_csv(raw / "bed_preloaded.csv", index=False)
    _write_contacts(raw / "contacts_preloaded.csv", bed, generator)
    for n in range(1, cycles + 1):
        moved = bed.copy()
        moved["x_m"] += lateral[n - 1].max() * bed["x_m"] / s["geometry.box_length"]
        moved["z_m"] -= minimum[n - 1] * bed["z_m"] / s["geometry.box_height"]
        moved.to_csv(raw / f"bed_cycle_{n:06d}.csv", index=False)
        if n in s["output.keep_beds"] or n == cycles:
            _write_contacts(raw / f"contacts_cycle_{n:06d}.csv", moved, generator)
    return folder
