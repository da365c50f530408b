"""Impact files: two spheres, or a sphere and a plane, with materials, speeds and spins; several of them by a sweep.

    base   = "nonlinear-md1-en0.6"                          # scenario that gives what is not said here
    title  = "A light sphere on a heavy one"                # of the figure
    figure = ["rebound_angle_degrees", "spin_1_y_rad_s"]    # columns of the result that are drawn
    [impact]
    against = { value = "sphere", unit = "-" }              # sphere | plane (the particles' law) | wall (linear)
    speed   = { value = 1.0,  unit = "m/s" }                # of body 1 relative to body 2
    angle   = { value = 30.0, unit = "degrees" }            # from the line of centres; 0 is head-on (default)
    normal_speed, tangential_speed                          # m/s, instead of speed and angle
    restitution = { value = 0.5, unit = "-" }               # that comes out head-on, instead of e_n or damping ratio
    [body_1]                                                # body_2 likewise; defaults: the clump's radius and mass
    radius  = { value = 0.01, unit = "m" }
    density = { value = 2600.0, unit = "kg/m3" }            # or mass, kg
    spin    = { value = [0.0, 20.0, 0.0], unit = "rad/s" }  # default none
    young_modulus = { value = 75e6, unit = "Pa" }           # or shear_modulus; of both bodies, with poisson_ratio
    poisson_ratio = { value = 0.25, unit = "-" }            # a plane whose material is not given is rigid
    motion  = { value = "free", unit = "-" }                # body 2 only: free | held
    [contact]                                               # any contact key of the scenario file
    model   = { value = "hysteretic", unit = "-" }
    [curve.steel]                                           # any of these keys once more, for one curve of the figure
    body_1.young_modulus = { value = 208e9, unit = "Pa" }
    [sweep]                                                 # lists: an impact for each entry; several keys go together
    impact.angle = { value = [5.0, 45.0, 85.0], unit = "degrees" }

The contact's normal is z, body 1 comes from above and moves towards +x.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis import contact_laws
from analysis.formats import toml_file
from analysis.formats.errors import InputError
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, ScenarioError, load_scenario, scenario_names
from analysis.scenarios.schema import KEYS as SCENARIO_KEYS
from analysis.scenarios.schema import Key
from analysis.verification import oracle
from analysis.verification.cases.impact_cases import STEPS_BEFORE
from analysis.verification.engine_laws import PAPER, EngineLaws, wall_law
from analysis.verification.probes import Ball, Probe

HELD_MASS = 1e12
MOST_IMPACTS = 300
BODY_KEYS = {
    "radius": Key("m", float, 1e-6, 100),
    "density": Key("kg/m3", float, 1, 25000),
    "mass": Key("kg", float, 1e-15, 1e9),
    "spin": Key("rad/s", list, -1e7, 1e7),
    "shear_modulus": Key("Pa", float, 1, 1e15),
    "young_modulus": Key("Pa", float, 1, 1e15),
    "poisson_ratio": Key("-", float, 0, 0.49),
}
KEYS = {
    "impact.against": Key("-", str, choices=("sphere", "plane", "wall")),
    "impact.speed": Key("m/s", float, 1e-6, 1000),
    "impact.angle": Key("degrees", float, 0, 89),
    "impact.normal_speed": Key("m/s", float, 1e-6, 1000),
    "impact.tangential_speed": Key("m/s", float, 0, 1000),
    "impact.restitution": Key("-", float, 0.01, 1),
    "body_2.motion": Key("-", str, choices=("free", "held")),
    **{f"{body}.{name}": key for body in ("body_1", "body_2") for name, key in BODY_KEYS.items()},
    **{name: key for name, key in SCENARIO_KEYS.items() if name.startswith("contact.")},
}
MATERIAL = ("shear_modulus", "young_modulus", "poisson_ratio")


class Refuse:
    """Makes the one line that names the file, a key, its value and what is allowed."""

    def __init__(self, file: str):
        self.file = file

    def __call__(self, key: str, value, allowed: str) -> ScenarioError:
        return ScenarioError(self.file, key, value, allowed)


@dataclass(frozen=True)
class Several:
    """A list of values of one key."""

    key: Key

    @property
    def unit(self) -> str:
        return self.key.unit

    def accepts(self, value) -> bool:
        return isinstance(value, list) and 0 < len(value) <= MOST_IMPACTS and all(map(self.key.accepts, value))

    def allowed(self) -> str:
        return f"a list of at most {MOST_IMPACTS} entries, each {self.key.allowed()}"


@dataclass(frozen=True)
class Impact:
    """A case, ready to run.

    name          unique in its file
    scenario      with the contact's values
    balls         one where the other body is a plane or a wall
    normal_speed  along the line of centres, m/s
    against       sphere | plane | wall
    curve         of which it is a point
    swept         the values that a sweep gave it, by key
    """

    name: str
    scenario: Scenario
    balls: tuple[Ball, ...]
    normal_speed: float
    against: str = "sphere"
    curve: str = ""
    swept: tuple[tuple[str, float | tuple[float, ...]], ...] = ()

    def law(self, engine: EngineLaws = PAPER):
        """Law of the contact in this engine, for the oracle; by default the paper's."""
        first = self.balls[0]
        if self.against == "wall":
            return wall_law(self.scenario, first.mass)
        return engine.pair(
            self.scenario, self.effective_mass, contact_laws.effective_radius(*(b.radius for b in self.balls))
        )

    @property
    def effective_mass(self) -> float:
        """Of the two bodies, kg; that of the first against a plane or a wall."""
        masses = [ball.mass for ball in self.balls]
        return contact_laws.effective_mass(*masses) if len(masses) == 2 else masses[0]

    def probe(self) -> Probe:
        """The case as a probe: 3000 steps in contact, and a few before and after."""
        step = oracle.head_on(self.law(), self.normal_speed).duration_s / 3000
        first, gap = self.balls[0], STEPS_BEFORE * step * self.normal_speed
        start = np.array([0.0, 0.0, first.radius + gap]) - STEPS_BEFORE * step * np.array(first.velocity) * [1, 1, 0]
        placed = Ball(first.radius, first.mass, tuple(map(float, start)), first.velocity, first.spin)
        wall = {"sphere": "", "plane": "hysteretic", "wall": "linear"}[self.against]
        return Probe(self.name, self.scenario, step, 3900, balls=(placed, *self.balls[1:]), wall=wall)


@dataclass(frozen=True)
class ImpactFile:
    """What a file asks for: its impacts, and what is drawn of them against the first swept key."""

    name: str
    title: str
    figure: tuple[str, ...]
    impacts: tuple[Impact, ...]

    @property
    def swept(self) -> tuple[str, ...]:
        """The swept keys."""
        return tuple(key for key, _ in self.impacts[0].swept)


def of_scenario(name: str) -> ImpactFile:
    """Two spheres of the clump's radius and mass, head-on at 1 m/s, with a scenario's law."""
    impact = _impact(Refuse(name), name, load_scenario(name), {"impact.speed": 1.0})
    return ImpactFile(name, f"Head-on at 1 m/s, {name}", (), (impact,))


def read_impacts(path: Path) -> ImpactFile:
    """The impacts of a file; ScenarioError with one line for anything unknown, of the wrong type or impossible."""
    try:
        content = toml_file.read(path, "impact file")
    except InputError as error:
        raise ScenarioError(str(error)) from None
    refuse = Refuse(path.name)
    base = content.pop("base", "nonlinear-en1.0")
    if not isinstance(base, str) or base not in scenario_names():
        raise refuse("base", base, "one of " + ", ".join(scenario_names()))
    title, figure = content.pop("title", path.stem), content.pop("figure", [])
    if not isinstance(title, str) or not title.isprintable() or len(title) > 200:
        raise refuse("title", title, "a text of at most 200 characters")
    if not isinstance(figure, list) or not all(isinstance(name, str) for name in figure):
        raise refuse("figure", figure, "a list of columns of the result")
    curves, sweep = content.pop("curve", {}), content.pop("sweep", {})
    for name, table in (("curve", curves), ("sweep", sweep)):
        if not isinstance(table, dict):
            raise refuse(name, table, "a table")
    values = _values(refuse, content)
    named = {name: _values(refuse, table, f"curve.{name}.") for name, table in curves.items()} or {"": {}}
    points = list(_points(refuse, sweep))
    if len(named) * len(points) > MOST_IMPACTS:
        raise refuse("sweep", len(named) * len(points), f"at most {MOST_IMPACTS} impacts in a file")
    scenario, impacts = load_scenario(base), []
    for curve, own in named.items():
        for swept in points:
            name = f"{path.stem}-{len(impacts) + 1}" if curve or swept else path.stem
            given = values | own | {key: list(v) if isinstance(v, tuple) else v for key, v in swept}
            impacts.append(_impact(refuse, name, scenario, given, curve, swept))
    return ImpactFile(path.stem, title, tuple(figure), tuple(impacts))


def _values(refuse: Refuse, content, prefix: str = "") -> dict:
    """The checked values of a table of keys."""
    if not isinstance(content, dict):
        raise refuse(prefix.rstrip("."), content, "a table")
    values = {}
    for key, entry in toml_file.leaves(content, KEYS):
        values[key] = _checked(refuse, prefix, key, entry, lambda key: key)
    return values


def _points(refuse: Refuse, sweep: dict) -> Iterator[tuple[tuple[str, object], ...]]:
    """What each impact of a curve gets by the sweep; one impact without anything where there is none."""
    lists = {key: _checked(refuse, "sweep.", key, entry, Several) for key, entry in toml_file.leaves(sweep, KEYS)}
    for key, entries in lists.items():
        first = next(iter(lists))
        if len(entries) != len(lists[first]):
            raise refuse(f"sweep.{key}.value", entries, f"as many entries as {first}: {len(lists[first])}")
    for entries in zip(*lists.values(), strict=True) if lists else ((),):
        yield tuple(
            (key, tuple(value) if isinstance(value, list) else value) for key, value in zip(lists, entries, strict=True)
        )


def _checked(refuse: Refuse, prefix: str, key: str, entry, as_key: Callable):
    if key not in KEYS:
        raise refuse(prefix + key, entry, f"a known key{toml_file.nearest(key, KEYS)}; --help lists them")
    known = KEYS[key]
    value = toml_file.checked(refuse, prefix + key, entry, as_key(known), ("value", "unit"))
    values = value if as_key is Several else [value]
    if key.endswith(".spin") and any(len(spin) != 3 for spin in values):
        raise refuse(f"{prefix}{key}.value", value, known.allowed() + ", three of them")
    if known.kind is float:
        values = [float(each) for each in values]
    return values if as_key is Several else values[0]


# ------------------------------------------------------------------ one impact


def _impact(refuse: Refuse, name: str, base: Scenario, given: dict, curve: str = "", swept: tuple = ()) -> Impact:
    """The case that these values describe; ScenarioError where they contradict each other."""
    against = given.get("impact.against", "sphere")
    if against != "sphere":
        no_more = f"no body_2{' but its material' if against == 'plane' else ''} where impact.against is {against}"
        for key in (key for key in given if key.startswith("body_2.")):
            if against == "wall" or key.removeprefix("body_2.") not in MATERIAL:
                raise refuse(key, given[key], no_more)
    changes = {key: value for key, value in given.items() if key.startswith("contact.")}
    scenario = base.with_values(changes | _moduli(refuse, given, against, changes), name)
    if against == "plane":
        if scenario["contact.model"] != "hysteretic":
            raise refuse("impact.against", against, 'wall with the linear law; plane with contact.model "hysteretic"')
        same = scenario["contact.particle_particle.friction"]  # the plane has the particles' law, friction included
        scenario = scenario.with_values({"contact.particle_wall.friction": same}, name)
    scenario = scenario.with_values(_damping(refuse, given, against, scenario), name)
    pair = {key: scenario[f"contact.particle_particle.{key}"] for key in ("damping_mode", "restitution")}
    if scenario["contact.model"] == "hysteretic" and pair["damping_mode"] == 0 and pair["restitution"] == 0:
        raise refuse(
            "contact.particle_particle.restitution.value", 0.0, "> 0 with damping_mode 0, which is singular there"
        )
    normal, tangential = _speeds(refuse, given)
    bodies = ("body_1", "body_2") if against == "sphere" else ("body_1",)
    balls = tuple(_ball(refuse, scenario, given, body, (tangential, 0.0, -normal)) for body in bodies)
    return Impact(name, scenario, balls, normal, against, curve, swept)


def _moduli(refuse: Refuse, given: dict, against: str, changes: dict) -> dict[str, float]:
    """Shear modulus and Poisson's ratio of the contact, from the materials of the bodies."""
    of = {body: {name: given[f"{body}.{name}"] for name in MATERIAL if f"{body}.{name}" in given}
          for body in ("body_1", "body_2")}  # fmt: skip
    present = [f"{body}.{name}" for body, material in of.items() for name in material]
    if not present:
        return {}
    first = present[0]
    if against == "wall":
        raise refuse(first, given[first], "no material: walls have stiffnesses, contact.particle_wall")
    for body, material in of.items():
        if "young_modulus" in material:
            young = material.pop("young_modulus")
            if "shear_modulus" in material or "poisson_ratio" not in material:
                raise refuse(f"{body}.young_modulus", young, "with poisson_ratio, and without shear_modulus")
            material["shear_modulus"] = young / (2 * (1 + material["poisson_ratio"]))
    if against == "plane" and not of["body_2"]:
        of["body_2"] = {"shear_modulus": math.inf, "poisson_ratio": of["body_1"].get("poisson_ratio", 0.0)}
    if any(len(material) < 2 for material in of.values()):
        raise refuse(first, given[first], "shear_modulus or young_modulus, and poisson_ratio, of both bodies")
    shear, poisson = contact_laws.equivalent_material(
        *(of[body][name] for body in of for name in ("shear_modulus", "poisson_ratio"))
    )
    for name in ("shear_modulus", "poisson_ratio"):
        if f"contact.particle_particle.{name}" in changes:
            key = f"contact.particle_particle.{name}"
            raise refuse(key, given[key], f"{name} of the bodies or of the contact, not both")
    return {"contact.particle_particle.shear_modulus": shear, "contact.particle_particle.poisson_ratio": poisson}


def _damping(refuse: Refuse, given: dict, against: str, scenario: Scenario) -> dict[str, float]:
    """The damping that makes impact.restitution come out of a head-on impact."""
    if (restitution := given.get("impact.restitution")) is None:
        return {}
    linear = against == "wall" or scenario["contact.model"] == "linear"
    pair = "particle_wall" if against == "wall" else "particle_particle"
    key = f"contact.{pair}.{'damping_ratio' if linear else 'restitution'}"
    if key in given:
        raise refuse(key, given[key], "impact.restitution, which comes out, or this, not both")
    if linear:
        return {key: contact_laws.damping_ratio_of(restitution) if restitution < 1 else 0.0}
    try:
        nominal = contact_laws.nominal_restitution(scenario["contact.particle_particle.damping_mode"], restitution)
    except ValueError as error:
        raise refuse("impact.restitution", restitution, str(error)) from None
    return {key: nominal}


def _speeds(refuse: Refuse, given: dict) -> tuple[float, float]:
    """Normal and tangential speed, m/s."""
    parts = [f"impact.{name}" for name in ("normal_speed", "tangential_speed") if f"impact.{name}" in given]
    whole = [f"impact.{name}" for name in ("speed", "angle") if f"impact.{name}" in given]
    if parts and whole:
        raise refuse(parts[0], given[parts[0]], "speed and angle, or normal_speed and tangential_speed, not both")
    for keys, needed in ((parts, "impact.normal_speed"), (whole, "impact.speed")):
        if needed not in given and (keys or (needed == "impact.speed" and not parts)):
            raise ScenarioError(f"{refuse.file}: {needed} is missing; give value and unit")
    if parts:
        return given["impact.normal_speed"], given.get("impact.tangential_speed", 0.0)
    angle = math.radians(given.get("impact.angle", 0.0))
    return given["impact.speed"] * math.cos(angle), given["impact.speed"] * math.sin(angle)


def _ball(refuse: Refuse, scenario: Scenario, given: dict, body: str, velocity: tuple[float, float, float]) -> Ball:
    clump, moving = derived.clump(scenario), body == "body_1"
    radius = given.get(f"{body}.radius", clump.radius_m)
    mass, density = given.get(f"{body}.mass"), given.get(f"{body}.density")
    if mass is not None and density is not None:
        raise refuse(f"{body}.mass", mass, "mass or density, not both")
    if mass is None:
        mass = clump.mass_kg if density is None else density * 4 / 3 * math.pi * radius**3
    held = given.get(f"{body}.motion") == "held"
    return Ball(
        radius,
        HELD_MASS if held else mass,
        (0.0, 0.0, radius if moving else -radius),
        velocity if moving else (0.0, 0.0, 0.0),
        tuple(map(float, given.get(f"{body}.spin", (0.0, 0.0, 0.0)))),
        held,
    )
