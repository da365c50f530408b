"""Verification of the load control: a column of clumps of known stiffness between floor and sleeper.

It is preloaded and loaded by the stages of a full run.
"""

from __future__ import annotations

import csv
import math
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from analysis.driver.engine import write_bed
from analysis.driver.engines import ENGINES
from analysis.formats.quantities import CODES
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, load_scenario
from analysis.verification.case_sketch import Arrow, Disc, Sketch
from analysis.verification.cases.case import Account, StagedCase
from analysis.verification.cases.clump_cases import about_y
from analysis.verification.probes import call_engine
from analysis.verification.results import Results

CLEARANCE = 1e-8
"""Gap beside the column, m: the walls keep it from buckling and carry nothing."""
LAYERS = 3


class LoadedColumn(StagedCase):
    """Case 7, both load-control laws. Three clumps lie on each other, in a box of just their width and length.

    Expected: the chain of clump masses and contact springs under a harmonic force, solved as a linear system; the
    sleeper is a mass with a drag (force) or moves at a speed proportional to the error of force (pfc).
    """

    name, title = "load-control", "Sleeper on a column of known stiffness"
    account = Account(
        "Three clumps on each other carry the sleeper: preload, then two cycles at 20 Hz, through the "
        "scripts of a full run.",
        "Masses and springs under a harmonic force; the sleeper is a mass with a drag, or PFC's servo v = g "
        "(F_target − F).",
        "Linear algebra by numpy; stiffness of the column from eq. 1",
        "0.5 % of stress and displacement; 2 % of the tracking error: in cycle 2 something is left of the start.",
        ("force", "sleeper_displacement_m"),
    )

    def __init__(self, code: str):
        super().__init__(code)
        self.scenarios = {law: self._scenario(law) for law in ("force", "pfc")}

    def _scenario(self, law: str) -> Scenario:
        base = load_scenario("linear-mu0.8", variant="paper-step")  # a small sleeper stands no larger one
        clump, box = derived.clump(base), derived.apparatus(base)
        length, width = 2 * (clump.radius_m + clump.half_distance_m + CLEARANCE), 2 * (clump.radius_m + CLEARANCE)
        share = length * width / box.sleeper_area_m2  # mass and drag per area are those of the study
        return base.with_values(
            {
                "geometry.box_length": length,
                "geometry.box_width": width,
                "geometry.sleeper_length": length,
                "geometry.sleeper_width": width,
                "geometry.sleeper_base": 2 * LAYERS * clump.radius_m + 1e-7,
                "contact.particle_particle.friction": 0.0,
                "contact.particle_wall.friction": 0.0,
                "load_control.sleeper_law": law,
                "load_control.plate_law": "fixed",
                "load_control.pfc_contact_floor": 1,
                "load_control.pfc_time_step": 0.0,
                "load_control.sleeper_mass": base["load_control.sleeper_mass"] * share,
                "load_control.sleeper_drag": base["load_control.sleeper_drag"] * share,
                "loading.cycles": 2,
                "output.checkpoint_cycles": 2,
                "output.keep_beds": [2],
            },
            f"column-{law}",
        )

    @classmethod
    def sketch(cls) -> Sketch:
        """The column between floor and sleeper."""
        scenario = cls(CODES[0]).scenarios["force"]  # the same in every engine
        clump = derived.clump(scenario)
        discs = (
            Disc(side * clump.half_distance_m, height, clump.radius_m)
            for height in layers(scenario)
            for side in (-1, 1)
        )
        top = scenario["geometry.sleeper_base"]
        return Sketch(tuple(discs), (Arrow(0.0, top + 2.2 * clump.radius_m, 0.0, -1.0),), floor=True, lid_m=top)

    def run(self, folder: Path, workers: int) -> None:
        """Preload and load both columns."""
        with ThreadPoolExecutor(workers) as pool:
            list(pool.map(lambda item: self._run(item[1], (folder / item[0]).resolve()), self.scenarios.items()))

    def _run(self, scenario: Scenario, run_dir: Path) -> None:
        engine = ENGINES[self.code]
        engine.write_inputs(scenario, run_dir, seed=1)
        box = derived.apparatus(scenario)
        write_bed(
            run_dir / "raw" / "bed_packed.csv",
            [(box.length_m / 2, box.width_m / 2, height, *about_y(90)) for height in layers(scenario)],
        )
        call_engine(engine.command("preload", run_dir), run_dir)
        checkpoint = run_dir / "checkpoints" / f"cyclic_000000.{engine.checkpoint_suffix}"
        call_engine(engine.command("cyclic", run_dir, checkpoint), run_dir)

    def judge(self, folder: Path, results: Results) -> None:
        for law, scenario in self.scenarios.items():
            self._judge(law, scenario, folder / law / "raw", results)

    def _judge(self, law: str, scenario: Scenario, raw: Path, results: Results) -> None:
        self._judge_rest(law, scenario, raw, results)
        rows, grid = _columns(raw / "cyclic.csv"), derived.time_grid(scenario)
        second = rows["step"] > grid.steps_per_cycle
        self._judge_response(law, scenario, {name: column[second] for name, column in rows.items()}, results)
        sums = self._contact_sums(raw / "contacts_cycle_000002.csv")
        results.compare(
            self.name,
            f"sum of contact forces on the sleeper_N under load, {law}",
            rows["sleeper_stress_Pa"][-1] * derived.apparatus(scenario).sleeper_area_m2,
            sums[1],
            0.005,
            "wall reaction at the last row",
        )

    def _judge_rest(self, law: str, scenario: Scenario, raw: Path, results: Results) -> None:
        """Stress and wall forces at the end of preload."""
        area = derived.apparatus(scenario).sleeper_area_m2
        weight = LAYERS * derived.clump(scenario).mass_kg * scenario["packing.final_gravity"]
        preload = _columns(raw / "preload.csv")
        results.compare(
            self.name,
            f"static stress_Pa, {law}",
            scenario["preload.sleeper_stress"],
            preload["sleeper_stress_Pa"][-1],
            0.005,
            "at the end of preload",
        )
        floor, sleeper = self._contact_sums(raw / "contacts_preloaded.csv")
        results.compare(
            self.name,
            f"contact force on the floor_N, {law}",
            scenario["preload.sleeper_stress"] * area + weight,
            floor,
            0.005,
            "static: sleeper force and weight of the clumps",
        )
        results.compare(
            self.name,
            f"sum of contact forces on the sleeper_N at rest, {law}",
            preload["sleeper_stress_Pa"][-1] * area,
            sleeper,
            0.005,
            "wall reaction at the last row",
        )

    def _judge_response(self, law: str, scenario: Scenario, rows: dict[str, np.ndarray], results: Results) -> None:
        """Displacement and tracking error in the `rows` of the second cycle."""
        (sway, error), frequency = expected_response(scenario, law), scenario["loading.frequency"]
        time, moved = rows["time_s"], rows["sleeper_displacement_m"]
        results.compare(
            self.name,
            f"displacement amplitude_m at 20 Hz, {law}",
            abs(sway),
            abs(_harmonic(time, moved, frequency)),
            0.005,
            "chain of masses and springs, second cycle",
        )
        results.compare(
            self.name,
            f"tracking error_Pa rms, {law}",
            abs(error) / math.sqrt(2),
            math.sqrt(rows["sleeper_error_ms_Pa2"].mean()),
            0.02,
            "same chain; 2 %: what is left of the start of loading",
        )
        turns = np.exp(2j * math.pi * frequency * time)
        results.curve(
            self.name,
            law,
            time_s=time,
            sleeper_displacement_m=moved,
            sleeper_displacement_m_expected=moved.mean() + (sway * turns).real,
        )

    @staticmethod
    def _contact_sums(path: Path) -> tuple[float, float]:
        """Sums of vertical wall forces: on the floor (normal from clump to wall down) and on the sleeper."""
        contacts = _columns(path)
        wall, up = contacts["clump_2"] == 0, contacts["nz"]
        return tuple(contacts["normal_force_N"][wall & (up * side > 0.9)].sum() for side in (-1, 1))


def layers(scenario: Scenario) -> list[float]:
    """Heights of the clumps' centres, m."""
    return [(2 * k + 1) * derived.clump(scenario).radius_m for k in range(LAYERS)]


def expected_response(scenario: Scenario, law: str) -> tuple[complex, complex]:
    """Complex amplitudes at the loading frequency of sleeper displacement (m, down) and stress error (Pa)."""
    clump, box, control = derived.clump(scenario), derived.apparatus(scenario), derived.load_control(scenario)
    omega = 2 * math.pi * scenario["loading.frequency"]
    wall, pair = (2 * scenario[f"contact.{which}.normal_stiffness"] for which in ("particle_wall", "particle_particle"))
    springs = [wall, *[pair] * (LAYERS - 1), wall]  # floor first; each clump rests on two contacts
    system = np.zeros((LAYERS + 1, LAYERS + 1), complex)
    for k, spring in enumerate(springs):
        for i in (k - 1, k):
            for j in (k - 1, k):
                if i >= 0 and j >= 0:
                    system[i, j] += spring if i == j else -spring
    system[range(LAYERS), range(LAYERS)] -= omega**2 * clump.mass_kg
    if law == "force":
        system[LAYERS, LAYERS] += -(omega**2) * control["sleeper_mass"] + 1j * omega * control["sleeper_drag"]
    else:
        contacts = 2
        speed_per_force = scenario["load_control.pfc_gain"] / (
            scenario["contact.particle_wall.normal_stiffness"] * contacts * derived.pfc_time_step(scenario)
        )
        system[LAYERS, LAYERS] += 1j * omega / speed_per_force
    # the stress is mean - amplitude cos(omega t)
    force = -(scenario["loading.stress_max"] - scenario["loading.stress_min"]) / 2 * box.sleeper_area_m2
    moves = np.linalg.solve(system, np.array([0.0] * LAYERS + [force], complex))
    return moves[LAYERS], (wall * (moves[LAYERS] - moves[LAYERS - 1]) - force) / box.sleeper_area_m2


def _harmonic(time: np.ndarray, values: np.ndarray, frequency: float) -> complex:
    """Complex amplitude of `values` at `frequency`, by least squares with a mean."""
    turns = 2 * math.pi * frequency * time
    table = np.column_stack([np.ones_like(time), np.cos(turns), np.sin(turns)])
    _, cosine, sine = np.linalg.lstsq(table, values, rcond=None)[0]
    return complex(cosine, -sine)


def _columns(path: Path) -> dict[str, np.ndarray]:
    with open(path, newline="") as file:
        header, *rows = list(csv.reader(file))
    return dict(zip(header, np.array(rows, float).T, strict=True))


CASES = (LoadedColumn,)
