"""`python -m analysis impact FILE.toml`: any impact of two spheres, or of a sphere on the wall, in both codes.

The file is written like the scenario file, with a value and a unit for every key:

    base = "nonlinear-md1-en0.6"                            # scenario that gives what is not said here
    [impact]
    against = { value = "sphere", unit = "-" }              # sphere | wall (always the linear law of the walls)
    speed   = { value = 1.0,  unit = "m/s" }                # of body 1 relative to body 2
    angle   = { value = 30.0, unit = "degrees" }            # from the line of centres; 0 is head-on (default)
    [body_1]                                                # body_2 likewise; defaults: the clump's radius and mass
    radius  = { value = 0.01, unit = "m" }
    density = { value = 2600.0, unit = "kg/m3" }
    spin    = { value = [0.0, 20.0, 0.0], unit = "rad/s" }  # default none
    shear_modulus = { value = 30e6, unit = "Pa" }           # or young_modulus; of both bodies, with poisson_ratio
    poisson_ratio = { value = 0.25, unit = "-" }
    motion  = { value = "free", unit = "-" }                # body 2 only: free | held
    [contact]                                               # any contact key of the scenario file
    model   = { value = "hysteretic", unit = "-" }

The contact's normal is z, body 1 comes from above and moves towards +x. Writes <out>/<file>.csv, a row per code, and
<out>/<file>_series.csv with forces over time. Results along and across the line of centres at first touch:

    restitution              normal relative speed after over before; below 0 where body 1 glances past
    tangential_restitution   the same of the tangential relative velocity of the centres
    rebound_angle_degrees    of the contact patch: tangential over normal velocity after, negative where it slides back
    impulse_ratio            tangential over normal impulse
    expected_restitution     of a head-on impact by the paper's law, also beside YADE, which has another one at e_n < 1
"""

from __future__ import annotations

import argparse
import math
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis import laws
from analysis.arguments import Parser
from analysis.driver import engines
from analysis.driver.engine import EngineError
from analysis.files import write_csv
from analysis.formats import toml_file
from analysis.formats.errors import InputError
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, ScenarioError, load_scenario, scenario_names
from analysis.scenarios.schema import KEYS as SCENARIO_KEYS
from analysis.scenarios.schema import Key
from analysis.verification import oracle
from analysis.verification.cases.impacts import STEPS_BEFORE, pair_law, wall_law
from analysis.verification.probes import Ball, Probe, Trajectory, run_probes, with_values

HELD_MASS = 1e12
BODY_KEYS = {
    "radius": Key("m", float, 1e-4, 100),
    "density": Key("kg/m3", float, 1, 25000),
    "spin": Key("rad/s", list, -1e5, 1e5),
    "shear_modulus": Key("Pa", float, 1, 1e13),
    "young_modulus": Key("Pa", float, 1, 1e13),
    "poisson_ratio": Key("-", float, 0, 0.49),
}
KEYS = {
    "impact.against": Key("-", str, choices=("sphere", "wall")),
    "impact.speed": Key("m/s", float, 1e-6, 1000),
    "impact.angle": Key("degrees", float, 0, 89),
    "body_2.motion": Key("-", str, choices=("free", "held")),
    **{f"{body}.{name}": key for body in ("body_1", "body_2") for name, key in BODY_KEYS.items()},
    **{name: key for name, key in SCENARIO_KEYS.items() if name.startswith("contact.")},
}


@dataclass(frozen=True)
class Impact:
    """A case, ready to run: the scenario with its contact values, and the balls (the second is missing on a wall)."""

    name: str
    scenario: Scenario
    balls: tuple[Ball, ...]
    normal_speed: float

    @property
    def wall(self) -> bool:
        return len(self.balls) == 1

    def law(self, code: str):
        """Law of the contact in this code, for the oracle."""
        first = self.balls[0]
        if self.wall:
            return wall_law(self.scenario, first.mass)
        second = self.balls[1]
        return pair_law(
            code,
            self.scenario,
            laws.effective_mass(first.mass, second.mass),
            laws.effective_radius(first.radius, second.radius),
        )

    def probe(self) -> Probe:
        """The case as a probe: 3000 steps in contact, and a few before and after."""
        step = oracle.head_on(self.law("liggghts"), self.normal_speed).duration_s / 3000
        first, gap = self.balls[0], STEPS_BEFORE * step * self.normal_speed
        start = np.array([0.0, 0.0, first.radius + gap]) - STEPS_BEFORE * step * np.array(first.velocity) * [1, 1, 0]
        placed = Ball(first.radius, first.mass, tuple(map(float, start)), first.velocity, first.spin)
        return Probe(
            self.name, self.scenario, step, 3900, balls=(placed, *self.balls[1:]), wall="linear" if self.wall else ""
        )


def read_impact(path: Path) -> Impact:
    """The case in a file; ScenarioError with one line for anything unknown, of the wrong type or impossible."""
    try:
        content = toml_file.read(path, "impact file")
    except InputError as error:
        raise ScenarioError(str(error)) from None

    def refuse(key: str, value, allowed: str) -> ScenarioError:
        return ScenarioError(path.name, key, value, allowed)

    base = content.pop("base", "nonlinear-en1.0")
    if not isinstance(base, str) or base not in scenario_names():
        raise refuse("base", base, "one of " + ", ".join(scenario_names()))
    values = {}
    for key, entry in toml_file.leaves(content, KEYS):
        if key not in KEYS:
            raise refuse(key, entry, f"a known key{toml_file.nearest(key, KEYS)}; --help lists them")
        known = KEYS[key]
        value = toml_file.checked(refuse, key, entry, known, ("value", "unit"))
        if key.endswith(".spin") and len(value) != 3:
            raise refuse(f"{key}.value", value, known.allowed() + ", three of them")
        values[key] = float(value) if known.kind is float else value
    if "impact.speed" not in values:
        raise ScenarioError(f"{path.name}: impact.speed is missing; give value and unit")
    on_wall = values.get("impact.against", "sphere") == "wall"
    for key in values:
        if on_wall and key.startswith("body_2."):
            raise refuse(key, values[key], "no body_2 where impact.against is wall")

    changes = {key.replace(".", "__"): value for key, value in values.items() if key.startswith("contact.")}
    for body in ("body_1", "body_2"):
        if f"{body}.young_modulus" in values:
            young = values.pop(f"{body}.young_modulus")
            if f"{body}.shear_modulus" in values or f"{body}.poisson_ratio" not in values:
                raise refuse(f"{body}.young_modulus", young, "with poisson_ratio, and without shear_modulus")
            values[f"{body}.shear_modulus"] = young / (2 * (1 + values[f"{body}.poisson_ratio"]))
    given = [f"{body}.{name}" for body in ("body_1", "body_2") for name in ("shear_modulus", "poisson_ratio")]
    present = [key for key in given if key in values]
    if present and (len(present) < 4 or on_wall):
        raise refuse(
            present[0],
            values[present[0]],
            "shear_modulus and poisson_ratio of both bodies, or of none"
            + (" (walls have stiffnesses: contact.particle_wall)" if on_wall else ""),
        )
    if present:
        shear, poisson = laws.equivalent_material(*(values[key] for key in given))
        for name, value in (("shear_modulus", shear), ("poisson_ratio", poisson)):
            if f"contact.particle_particle.{name}" in values:
                raise refuse(
                    f"contact.particle_particle.{name}", value, f"{name} of the bodies or of the contact, not both"
                )
            changes[f"contact__particle_particle__{name}"] = value
    scenario = with_values(load_scenario(base), path.stem, **changes)
    pair = {key: scenario[f"contact.particle_particle.{key}"] for key in ("damping_mode", "restitution")}
    if scenario["contact.model"] == "hysteretic" and pair["damping_mode"] == 0 and pair["restitution"] == 0:
        raise refuse(
            "contact.particle_particle.restitution.value", 0.0, "> 0 with damping_mode 0, which is singular there"
        )
    return _place(path.stem, scenario, values, on_wall)


def of_scenario(name: str) -> Impact:
    """Two spheres of the clump's radius and mass, head-on at 1 m/s, with a scenario's law."""
    return _place(name, load_scenario(name), {"impact.speed": 1.0}, False)


def _place(name: str, scenario: Scenario, values: dict, on_wall: bool) -> Impact:
    clump = derived.clump(scenario)
    angle, speed = math.radians(values.get("impact.angle", 0.0)), values["impact.speed"]
    bodies = []
    for body in ("body_1",) if on_wall else ("body_1", "body_2"):
        radius = values.get(f"{body}.radius", clump.radius_m)
        volume = 4 / 3 * math.pi * radius**3
        mass = values[f"{body}.density"] * volume if f"{body}.density" in values else clump.mass_kg
        held = values.get(f"{body}.motion") == "held"
        moving = body == "body_1"
        bodies.append(
            Ball(
                radius,
                HELD_MASS if held else mass,
                (0.0, 0.0, radius if moving else -radius),
                (speed * math.sin(angle), 0.0, -speed * math.cos(angle)) if moving else (0.0, 0.0, 0.0),
                tuple(map(float, values.get(f"{body}.spin", (0.0, 0.0, 0.0)))),
                held,
            )
        )
    return Impact(name, scenario, tuple(bodies), speed * math.cos(angle))


# ------------------------------------------------------------------ result


def evaluate(impact: Impact, probe: Probe, code: str, found: Trajectory) -> tuple[dict, np.ndarray]:
    """Measures of one code as a row; time, overlap, normal and shear force (4, n) as the series."""
    first = probe.balls[0]
    if impact.wall:
        normal = np.tile([0.0, 0.0, 1.0], (len(found.time), 1))
        overlap = first.radius - found.position[:, 0, 2]
        relative = found.velocity[:, 0]
    else:
        apart = found.position[:, 0] - found.position[:, 1]
        distance = np.linalg.norm(apart, axis=1)
        normal, overlap = apart / distance[:, None], first.radius + probe.balls[1].radius - distance
        relative = found.velocity[:, 0] - found.velocity[:, 1]
    normal_force = np.einsum("ni,ni->n", found.force[:, 0], normal)
    shear = found.force[:, 0] - normal_force[:, None] * normal
    touching = np.flatnonzero(overlap > 0)
    separated = len(touching) > 0 and touching[-1] + 1 < len(overlap)
    law = impact.law("liggghts")  # the paper's
    expected = oracle.head_on(law, impact.normal_speed).restitution
    peak = oracle.head_on(impact.law(code), impact.normal_speed).peak_overlap_m
    row = {
        "code": code,
        "peak_overlap_m": overlap.max(),
        "peak_normal_force_N": normal_force.max(),
        "peak_shear_force_N": np.linalg.norm(shear, axis=1).max(),
        "duration_s": (touching[-1] - touching[0] + 1) * probe.step if separated else math.nan,
        **_rebound(probe, found, relative, normal, touching, separated),
    }
    for k in range(len(probe.balls)):
        for what, values in (("velocity", found.velocity), ("spin", found.spin)):
            unit = "m_s" if what == "velocity" else "rad_s"
            row |= {f"{what}_{k + 1}_{axis}_{unit}": values[-1, k, n] for n, axis in enumerate("xyz")}
    row |= {"expected_restitution": expected, "expected_peak_overlap_m": peak}
    row["remark"] = "" if separated else "no separation within the time that was run"
    if code == "yade" and isinstance(impact.law(code), oracle.ViscousHertz):
        row["remark"] = (
            "YADE has no hysteretic law: viscous Hertz law with the same restitution"
            + "; " * bool(row["remark"])
            + row["remark"]
        )
    return row, np.array([found.time, overlap, normal_force, np.linalg.norm(shear, axis=1)])


def _rebound(probe: Probe, found: Trajectory, relative, normal, touching, separated: bool) -> dict[str, float]:
    """What comes out along and across the line of centres at first touch; nan without separation."""
    names = ("restitution", "tangential_restitution", "rebound_angle_degrees", "impulse_ratio")
    if not separated:
        return dict.fromkeys(names, math.nan)
    first, along = probe.balls[0], normal[touching[0]]
    start = np.subtract(first.velocity, probe.balls[1].velocity if len(probe.balls) > 1 else 0.0)
    turns = [sum(ball.radius * np.array(ball.spin) for ball in probe.balls)]
    turns.append(sum(ball.radius * found.spin[-1, k] for k, ball in enumerate(probe.balls)))
    # velocity of body 1's contact point against that of body 2, before and after
    patch = [v - np.cross(turn, along) for v, turn in zip((start, relative[-1]), turns, strict=True)]

    def split(vector) -> tuple[float, np.ndarray]:
        across = vector - (vector @ along) * along
        return float(vector @ along), across

    (before, came), (after, went) = split(start), split(relative[-1])
    (_, slid), (_, slides) = split(patch[0]), split(patch[-1])
    size, sliding = float(np.linalg.norm(came)), float(np.linalg.norm(slid))
    pushed, dragged = split(first.mass * (found.velocity[-1, 0] - np.array(first.velocity)))
    sideways = float(slides @ slid) / sliding if sliding else 0.0
    values = (
        after / -before,
        float(went @ came) / size**2 if size else math.nan,
        math.degrees(math.atan2(sideways, after)),
        float(np.linalg.norm(dragged)) / pushed,
    )
    return dict(zip(names, values, strict=True))


def main(argv: list[str]) -> int:
    """Command line."""
    parser = Parser(prog="ballast impact", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", help="an impact file, or the name of a scenario: its law, head-on at 1 m/s")
    parser.add_argument("--code", choices=engines.CODES, action="append", help="only this code")
    parser.add_argument("--out", type=Path, default=Path("report/impact"), help="folder of the result")
    arguments = parser.parse_args(argv)
    codes = arguments.code or list(engines.CODES)
    folder = Path(tempfile.mkdtemp(prefix="impact-"))
    try:
        known = arguments.case in scenario_names()
        impact = of_scenario(arguments.case) if known else read_impact(Path(arguments.case))
        for code in codes:
            engines.ENGINES[code].version()
        probe, rows, series = impact.probe(), [], []
        for code in codes:
            found, failures = run_probes(code, [probe], folder / code)
            if failures:
                print(f"impact: {failures[probe.name]}", file=sys.stderr)
                return 1
            row, curves = evaluate(impact, probe, code, found[probe.name])
            rows.append(row)
            series += [(code, *(f"{value:.9g}" for value in point)) for point in curves.T]
    except (ScenarioError, EngineError) as error:
        print(f"impact: {error}", file=sys.stderr)
        return 2
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    write_csv(
        arguments.out / f"{impact.name}.csv",
        [list(rows[0]), *([f"{v:.9g}" if isinstance(v, float) else v for v in row.values()] for row in rows)],
    )
    write_csv(
        arguments.out / f"{impact.name}_series.csv",
        [["code", "time_s", "overlap_m", "normal_force_N", "shear_force_N"], *series],
    )
    for name in rows[0]:
        print(
            f"{name:26}"
            + "".join(f"{row[name]:>16.6g}" if isinstance(row[name], float) else f"{row[name]:>16}" for row in rows)
        )
    print(arguments.out / f"{impact.name}.csv")
    return 0
