"""The scenario file: base, scenario, profile and variants laid over each other, checked, and made into one flat table.

A scenario with variants is called by its id, scenario and variants joined by `+`: nonlinear-en1.0+same-bed+servo.
Needs only the standard library, because YADE's Python has no more.
"""

from __future__ import annotations

import functools
import hashlib
import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from analysis.files import ROOT
from analysis.formats import json_file, toml_file
from analysis.formats.errors import InputError
from analysis.scenarios import cost, derived, lattice
from analysis.scenarios.schema import FILE_KEYS, KEYS, PROFILE_KEYS, STAGES, STATUSES

SCENARIO_FILE = ROOT / "scenarios.toml"
FIELDS = ("value", "unit", "status", "source")
REMEDY = "restore the file, or move the run away and run it again"
MOST_NAMES_SHOWN = 40
GROUPS = ("paper", "chen2015", "own")
BED_SECTIONS = ("geometry.", "clump.", "packing.")
"""A variant that sets a key of these needs a packed bed of its own; where a bed comes from (packing.bed_*) aside."""


class ScenarioError(InputError):
    """A scenario file that cannot be used; the message is one line naming file, key, value and what is allowed."""


@dataclass(frozen=True)
class Parameter:
    """One value with its unit, status (reported, derived, assumed, calibrated) and source."""

    value: float | int | str | list
    unit: str
    status: str
    source: str


class Scenario:
    """All parameters of one scenario at one profile: `scenario["geometry.box_length"]` gives the value in SI units."""

    def __init__(
        self,
        name: str,
        profile: str,
        title: str,
        parameters: dict[str, Parameter],
        variants: Sequence[str] = (),
        label: str = "",
    ):
        """`label` is how figures and tables call it."""
        self.name, self.profile, self.title, self.parameters = name, profile, title, parameters
        self.variants, self.label = tuple(variants), label or join_id(name, variants)

    def __getitem__(self, key: str):
        return self.parameters[key].value

    @property
    def id(self) -> str:
        """Name and variants, as the run's folder is called."""
        return join_id(self.name, self.variants)

    def with_values(self, values: dict[str, float | int | str | list], name: str = "") -> Scenario:
        """A copy with some values changed, for calibration and verification; their status becomes `assumed`.

        `name` is given to a copy that is no scenario of the file any more: it has no variants and no other label.
        """
        changed = {}
        for key, value in values.items():
            old = self.parameters[key]
            changed[key] = Parameter(value, old.unit, "assumed", f"varied from {old.value}")
        named = (name, self.profile, self.title) if name else (self.name, self.profile, self.title)
        kept = () if name else (self.variants, self.label)
        return Scenario(*named, self.parameters | changed, *kept)

    @property
    def hash(self) -> str:
        """Twelve hex digits over all values that are physics: equal exactly when two runs simulate the same.

        Texts, what a run writes and how far it goes are left out.
        """
        values = {
            key: p.value
            for key, p in sorted(self.parameters.items())
            if key in KEYS and KEYS[key].matters("packing", "loading") and p.value != KEYS[key].neutral
        }
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:12]

    def to_json(self) -> str:
        """The resolved scenario as JSON, the form kept in a run's folder."""
        body = {
            "name": self.name,
            "variant": "+".join(self.variants),
            "profile": self.profile,
            "title": self.title,
            "label": self.label,
            "hash": self.hash,
            "parameters": {key: asdict(p) for key, p in self.parameters.items()},
        }
        return json.dumps(body, indent=1)

    @classmethod
    def from_json(cls, text: str) -> Scenario:
        """Read what `to_json` wrote. Keys that are newer than the text get their neutral value, if they have one."""
        return cls._from_body(json_file.parse("scenario.json", text.encode()))

    @classmethod
    def read(cls, path: Path) -> Scenario:
        """The scenario that a run keeps. ScenarioError where the file is missing, damaged or impossible."""
        path = Path(path)
        try:
            return cls._from_body(json_file.read(path, dict, REMEDY))
        except FileNotFoundError:
            raise ScenarioError(path.name, allowed=f"is missing; {REMEDY}") from None
        except ScenarioError:
            raise
        except InputError as error:
            raise ScenarioError(error.file, error.key, error.value, error.allowed) from None

    @classmethod
    def _from_body(cls, body: dict) -> Scenario:
        _check_kept(body)
        parameters = {key: Parameter(**p) for key, p in body["parameters"].items()}
        for key, known in KEYS.items():
            if key not in parameters and known.neutral is not None:
                parameters[key] = Parameter(known.neutral, known.unit, "derived", "the run is older than this key")
        variants = split_variants(body.get("variant", ""))
        return cls(body["name"], body["profile"], body["title"], parameters, variants, body.get("label", ""))

    def changed_keys(self, other: Scenario, from_stage: str = "packing", to_stage: str = "loading") -> list[str]:
        """Keys read by a stage from `from_stage` to `to_stage` (schema.STAGES) in which two scenarios differ.

        packing to loading is physics. A key that only one of them has counts as well.
        """
        keys = dict.fromkeys((*self.parameters, *other.parameters))
        known = (key for key in keys if key not in KEYS or KEYS[key].matters(from_stage, to_stage))
        return [key for key in known if self._shown(key) != other._shown(key)]

    def changes(self, other: Scenario, from_stage: str = "packing", to_stage: str = "loading") -> list[str]:
        """Lines `key: here -> there` for `changed_keys`; `none` stands for a key that one of them does not have."""
        keys = self.changed_keys(other, from_stage, to_stage)
        return [f"{key}: {self._shown(key)} -> {other._shown(key)}" for key in keys]

    def differences(self, other: Scenario) -> list[str]:
        """Lines `key: here -> there` for every value in which two scenarios differ, also what is not physics."""
        return self.changes(other, STAGES[0], STAGES[-1])

    def _shown(self, key: str):
        return self.parameters[key].value if key in self.parameters else "none"


def split_variants(text: str) -> tuple[str, ...]:
    """Variants of a text such as `servo,same-bed` or `same-bed+servo`: each once, in the order of the alphabet."""
    return tuple(sorted(set(filter(None, re.split(r"[,+\s]+", text)))))


def split_id(identity: str) -> tuple[str, tuple[str, ...]]:
    """Name and variants of `nonlinear-en1.0+same-bed+servo`."""
    name, _, variants = identity.partition("+")
    return name, split_variants(variants)


def join_id(name: str, variants: Sequence[str] = ()) -> str:
    """The id of a scenario with these variants."""
    return "+".join((name, *sorted(set(variants))))


def _refuse(path: Path, key: str, value, allowed: str) -> ScenarioError:
    return ScenarioError(path.name, key, value, allowed)


def _check_kept(body: dict) -> None:
    """Refuse a kept scenario whose texts or parameters are not what `to_json` writes."""

    def refuse(key: str, value, allowed: str) -> ScenarioError:
        return ScenarioError("scenario.json", key, value, f"{allowed}; {REMEDY}")

    for key in ("name", "profile", "title", "variant", "label"):
        if not isinstance(body.get(key, "" if key in ("variant", "label") else None), str):
            raise refuse(key, body.get(key), "a text")
    parameters = body.get("parameters")
    if not isinstance(parameters, dict) or not parameters:
        raise refuse("parameters", parameters, "a table of parameters")
    for key, entry in parameters.items():
        if not isinstance(entry, dict) or set(entry) != set(FIELDS):
            raise refuse(key, entry, "a table of exactly " + ", ".join(FIELDS))
        if key in KEYS and not KEYS[key].accepts(entry["value"]):
            raise refuse(f"{key}.value", entry["value"], KEYS[key].allowed())


def _parameter(path: Path, where: str, key: str, entry) -> Parameter:
    name = f"{where}.{key}"
    if key not in FILE_KEYS:
        if key in KEYS:
            raise _refuse(path, name, entry, f"nothing: it is made from {KEYS[key].made}")
        raise _refuse(path, name, entry, f"a known key{toml_file.nearest(key, FILE_KEYS)}")
    known = KEYS[key]
    value = toml_file.checked(functools.partial(_refuse, path), name, entry, known, FIELDS)
    if entry["status"] not in STATUSES:
        raise _refuse(path, f"{name}.status", entry["status"], "one of " + ", ".join(STATUSES))
    if not isinstance(entry["source"], str) or not entry["source"].strip():
        raise _refuse(path, f"{name}.source", entry["source"], "a text that is not empty")
    if known.kind is float:
        value = float(value)
    elif known.kind is list:
        value = [known.item(v) for v in value]
    return Parameter(value, entry["unit"], entry["status"], entry["source"])


def _read(path: Path) -> dict:
    try:
        return _parsed(path, toml_file.content(path, "scenario file"))
    except ScenarioError:
        raise
    except InputError as error:
        raise ScenarioError(error.file, error.key, error.value, error.allowed) from None


@functools.lru_cache(maxsize=8)  # a study loads a hundred scenarios of one file
def _parsed(path: Path, text: bytes) -> dict:
    content = toml_file.parse(path.name, text)
    content = {"variant": {}, "study": {}} | content
    sections = ("base", "scenario", "profile", "variant", "study")
    for section in content:
        if section not in sections:
            raise _refuse(path, section, "...", "the sections " + ", ".join(sections))
    for section in sections:
        if not isinstance(content.get(section), dict):
            raise _refuse(path, section, content.get(section), f"a table [{section}]")
    for section in ("scenario", "variant", "profile"):
        for name in content[section]:
            if not re.fullmatch(r"[A-Za-z0-9][\w.-]*", name, re.ASCII):  # it names folders and make targets
                raise _refuse(path, f"{section} name", name, "letters, digits and . _ -")
    return content


def _overlay(path: Path, where: str, table, extras: tuple[str, ...]) -> tuple[dict[str, str], dict[str, Parameter]]:
    """Split a [scenario.X] or [profile.X] table into its texts (title, base) and its parameters."""
    if not isinstance(table, dict):
        raise _refuse(path, where, table, "a table")
    texts = {name: table[name] for name in extras if name in table}
    for name, text in texts.items():
        if not isinstance(text, str):
            raise _refuse(path, f"{where}.{name}", text, "a text")
    rest = {name: entry for name, entry in table.items() if name not in extras}
    return texts, {key: _parameter(path, where, key, entry) for key, entry in toml_file.leaves(rest, KEYS)}


def read_file(path: Path = SCENARIO_FILE) -> dict:
    """The scenario file's sections base, scenario, variant, profile and study, as tables; ScenarioError if unusable."""
    return _read(Path(path))


def scenario_names(path: Path = SCENARIO_FILE, group: str | None = None) -> list[str]:
    """Names of all scenarios of the file, in its order; of one group (paper, chen2015, own) where it is given."""
    path = Path(path)
    scenarios = _read(path)["scenario"]
    return [name for name in scenarios if group in (None, _role(path, scenarios, name)["group"])]


def variant_names(path: Path = SCENARIO_FILE) -> list[str]:
    """Names of all variants of the file, in its order."""
    return list(_read(Path(path))["variant"])


def profile_names(path: Path = SCENARIO_FILE) -> list[str]:
    """Names of all profiles of the file, in its order."""
    return list(_read(Path(path))["profile"])


def label_of(identity: str, path: Path = SCENARIO_FILE) -> str:
    """How figures and tables call a scenario, with its variants; the id itself where the file does not know it."""
    name, variants = split_id(identity)
    labels = _labels(Path(path))
    return ", ".join((labels.get(name, name), *(labels.get(f"+{variant}", variant) for variant in variants)))


@functools.cache
def _labels(path: Path) -> dict[str, str]:
    """Labels by name; those of variants by `+name`."""
    try:
        content = _read(path)
        return {name: _role(path, content["scenario"], name)["label"] for name in content["scenario"]} | {
            f"+{name}": str(table.get("label", name)) for name, table in content["variant"].items()
        }
    except (ScenarioError, AttributeError):
        return {}


def _role(path: Path, scenarios: dict, name: str) -> dict[str, str]:
    """Label and group of a scenario."""
    table = scenarios[name] if isinstance(scenarios[name], dict) else {}
    role = {"label": table.get("label", name), "group": table.get("group", "own")}
    if role["group"] not in GROUPS:
        raise _refuse(path, f"scenario.{name}.group", role["group"], "one of " + ", ".join(GROUPS))
    return role


def base_parameters(path: Path = SCENARIO_FILE) -> dict[str, Parameter]:
    """Parameters of [base], before any scenario."""
    return _made(_base(Path(path), _read(Path(path))))


def load_scenario(
    name: str, profile: str = "full", path: Path = SCENARIO_FILE, cycles: int | None = None, variant: str = ""
) -> Scenario:
    """Resolve base <- scenario (and the scenarios it is based on) <- profile <- variants.

    `name` may be an id, with variants; `variant` adds further ones, in any order (`servo,same-bed`). `cycles` replaces
    loading.cycles, as CYCLES=n does on the command line.
    Raises ScenarioError with one line for anything that is unknown, of the wrong type or impossible.
    """
    path = Path(path)
    content = _read(path)
    name, variants = split_id(name)
    scenario = _resolve(path, content, name, (*variants, *split_variants(variant)), profile, cycles)
    _check_together(path, scenario)
    _check_bed(path, content, scenario)
    return scenario


def _base(path: Path, content: dict) -> dict[str, Parameter]:
    parameters = {key: _parameter(path, "base", key, entry) for key, entry in toml_file.leaves(content["base"], KEYS)}
    for key in FILE_KEYS:
        if key not in parameters:
            raise ScenarioError(f"{path.name}: base.{key} is missing; give value, unit, status and source")
    return parameters


def _made(parameters: dict[str, Parameter]) -> dict[str, Parameter]:
    """The same with the keys that follow from others: the time step that is chosen."""
    chosen, factor = f"time.{parameters['time.choice'].value}_step", parameters["time.factor"].value
    step = parameters[chosen]
    status = step.status if factor == 1 else parameters["time.factor"].status
    text = chosen + ("" if factor == 1 else f" x {factor:g}")
    made = {"time.step": Parameter(step.value * factor, step.unit, status, f"{text}: {step.source}")}
    ordered: dict[str, Parameter] = {}
    for key, parameter in parameters.items():
        ordered[key] = parameter
        if key == "time.factor":
            ordered |= made
    return ordered


def _unknown(path: Path, section: str, known: dict, name: str) -> ScenarioError:
    head, dot, rest = name.partition(".")
    if dot and isinstance(known.get(head), dict) and rest in known[head]:
        return ScenarioError(f'{path.name}: {section}.{name}: put the name in quotes, [{section}."{name}"]')
    hint = toml_file.nearest(name, known)
    shown = ", ".join(list(known)[:MOST_NAMES_SHOWN]) or "none"
    return ScenarioError(f"{path.name}: {section} {name[:80]!r} is unknown{hint}; known: {shown}")


def _chain(path: Path, section: str, known: dict, name: str, texts: tuple[str, ...]):
    """The layers of [section.name] and of the tables it is based on, the deepest first, and its own texts."""
    layers, current, chain, own = [], name, [], {}
    while current:
        if current in chain:
            raise _refuse(path, f"{section}.{chain[-1]}.base", current, "a chain of bases without a circle")
        if current not in known:
            raise _refuse(path, f"{section}.{chain[-1]}.base", current, "one of " + ", ".join(known))
        chain.append(current)
        found, values = _overlay(path, f"{section}.{current}", known[current], texts)
        layers.insert(0, values)
        own = found if current == name else own
        current = found.get("base")
    return layers, own


def _resolve(
    path: Path, content: dict, name: str, variants: Sequence[str], profile: str, cycles: int | None = None
) -> Scenario:
    """Lay the layers over each other, each value checked by itself."""
    _check_known(path, content, name, variants, profile)
    parameters = _base(path, content)
    layers, texts = _chain(path, "scenario", content["scenario"], name, ("title", "base", "label", "group"))
    titles, labels = [texts.get("title", name)], [_role(path, content["scenario"], name)["label"]]
    for layer in (*layers, _profile_layer(path, content, profile)):
        parameters.update(layer)

    own_bed = []
    for variant in (v for v in content["variant"] if v in variants):  # later ones of the file win, in whatever order
        layers, texts = _chain(path, "variant", content["variant"], variant, ("title", "base", "label"))
        titles.append(texts.get("title", variant))
        labels.append(texts.get("label", variant))
        for layer in layers:
            parameters.update(layer)
            if any(key.startswith(BED_SECTIONS) and not key.startswith("packing.bed_") for key in layer):
                own_bed.append(variant)
    if variants:
        parameters["packing.bed_from"] = _bed_of_variant(parameters["packing.bed_from"], name, variants, own_bed)
    if cycles is not None:
        given = {"value": cycles, "unit": "-", "status": "assumed", "source": "given on the command line"}
        parameters["loading.cycles"] = _parameter(path, "CYCLES", "loading.cycles", given)
    return Scenario(name, profile, "; ".join(titles), _made(parameters), sorted(set(variants)), ", ".join(labels))


def _check_known(path: Path, content: dict, name: str, variants: Sequence[str], profile: str) -> None:
    """Refuse a scenario, variant or profile that the file does not have."""
    if name not in content["scenario"]:
        raise _unknown(path, "scenario", content["scenario"], name)
    for variant in variants:
        if variant not in content["variant"]:
            raise _unknown(path, "variant", content["variant"], variant)
    if profile not in content["profile"]:
        raise ScenarioError(f"{path.name}: profile {profile!r} is unknown; known: {', '.join(content['profile'])}")


def _profile_layer(path: Path, content: dict, profile: str) -> dict[str, Parameter]:
    """The values of a profile, which are of size and length only."""
    _, values = _overlay(path, f"profile.{profile}", content["profile"][profile], ("title",))
    for key, parameter in values.items():
        if key not in PROFILE_KEYS:
            allowed = "size and length only: " + ", ".join(PROFILE_KEYS)
            raise _refuse(path, f"profile.{profile}.{key}", parameter.value, allowed)
    return values


def _bed_of_variant(source: Parameter, name: str, variants: Sequence[str], own_bed: Sequence[str]) -> Parameter:
    """Which bed a scenario with variants starts from: its scenario's, unless variants (`own_bed`) change what is
    packed.
    """
    bed = join_id(source.value or name, own_bed)
    if bed == join_id(name, variants):
        return Parameter("", "-", "derived", "own packing: the variant changes what is packed")
    if bed != source.value:
        return Parameter(bed, "-", "assumed", "a variant starts from the packed bed of its scenario")
    return Parameter(bed, "-", source.status, source.source)


Impossible = Iterator[tuple[str, str]]
"""Keys whose values are each allowed but impossible together with others, and what they could be."""


def _check_together(path: Path, scenario: Scenario) -> None:
    """Refuse values that are each allowed but impossible together; later checks rest on earlier ones."""
    for check in (_of_load, _of_box, _of_spheres, _of_packing, _of_output, _of_clumps, _of_time):
        for key, allowed in check(scenario):
            raise _refuse(path, f"scenario.{scenario.id}: {key}", scenario[key], allowed)


def _of_load(s: Scenario) -> Impossible:
    damping_mode, restitution = (s[f"contact.particle_particle.{key}"] for key in ("damping_mode", "restitution"))
    if s["contact.model"] == "hysteretic" and damping_mode == 0 and restitution == 0:
        singular = "> 0 with damping_mode = 0, whose D = (1 - e^2)/e is singular at 0"
        yield "contact.particle_particle.restitution", singular
    if s["loading.stress_max"] <= s["loading.stress_min"]:
        yield "loading.stress_max", f"> loading.stress_min = {s['loading.stress_min']:g} Pa"
    if s["preload.sleeper_stress"] != s["loading.stress_min"]:
        where = f"loading.stress_min = {s['loading.stress_min']:g} Pa, where loading starts"
        yield "preload.sleeper_stress", where


def _of_box(s: Scenario) -> Impossible:
    if s["geometry.sleeper_length"] > s["geometry.box_length"]:
        yield "geometry.sleeper_length", f"<= geometry.box_length = {s['geometry.box_length']:g} m"
    room = s["geometry.sleeper_length"] - 2 * s["clump.ball_radius"]
    if s["geometry.cut_x"] > room:
        yield "geometry.cut_x", f"<= {room:g} m, so that a clump fits between the cut and the plates"
    if s["geometry.sleeper_width"] >= s["geometry.box_width"]:
        yield "geometry.sleeper_width", f"< geometry.box_width = {s['geometry.box_width']:g} m"
    if s["geometry.sleeper_base"] + s["geometry.sleeper_height"] > s["geometry.box_height"] + 1e-9:
        yield "geometry.sleeper_height", "a sleeper whose top is not above the box"
    stack = s["geometry.plate_count"] * (s["geometry.plate_height"] + s["geometry.plate_gap"])
    if stack > s["geometry.box_height"]:
        inside = f"plates inside the box: {stack:g} m of plates and gaps in {s['geometry.box_height']:g} m"
        yield "geometry.plate_height", inside


def _of_spheres(s: Scenario) -> Impossible:
    if len(s["geometry.measurement_x"]) != 3:
        yield "geometry.measurement_x", "three values"
    radius, z = s["geometry.measurement_radius"], s["geometry.measurement_z"]
    if any(x - radius < -1e-9 or x + radius > s["geometry.box_length"] + 1e-9 for x in s["geometry.measurement_x"]):
        yield "geometry.measurement_x", "measurement spheres inside the box"
    if z - radius < -1e-9 or z + radius > s["geometry.sleeper_base"] + 1e-9:
        yield "geometry.measurement_z", "measurement spheres between floor and sleeper base"


def _of_packing(s: Scenario) -> Impossible:
    if s["packing.relax_stiffness"][-1] != 1.0:
        yield "packing.relax_stiffness", "fractions that end at 1"
    if abs(s["packing.lattice_radius"] * s["packing.growth"] - s["clump.ball_radius"]) > 1e-6:
        grown = f"clump.ball_radius / packing.lattice_radius: balls grow to {s['clump.ball_radius']:g} m"
        yield "packing.growth", grown


def _of_output(s: Scenario) -> Impossible:
    if s["output.rows_per_cycle"] % (2 * s["output.blocks_per_cycle"]):
        yield "output.rows_per_cycle", "a multiple of twice output.blocks_per_cycle"
    yield from cost.too_much(s)


def _of_clumps(s: Scenario) -> Impossible:
    diameter = 2 * derived.clump(s).radius_m
    if s["geometry.plate_gap"] >= diameter:
        yield "geometry.plate_gap", f"< {diameter:.4g} m, twice the radius of a clump's spheres"
    if derived.apparatus(s).width_m < 2 * s["clump.ball_radius"]:
        yield "geometry.width_scale", "a slice wide enough for one clump"
    void = lattice.void_fraction(s)
    if void <= 0:
        yield "packing.lattice_gap", "a gap that leaves room: the clumps would fill more than the whole box"
    if void > 0.6:
        reach = f"a gap whose bed can reach the sleeper: porosity of the filled box at most 0.6, here {void:.3g}"
        yield "packing.lattice_gap", reach


def _of_time(s: Scenario) -> Impossible:
    limit = derived.critical_time_step(s)
    if max(s["time.step"], derived.time_grid(s).step_s) > limit:
        yield "time.step", f"<= {limit:.3g} s, the critical step of one contact, also once rounded to whole output rows"


def _check_bed(path: Path, content: dict, scenario: Scenario) -> None:
    """Refuse a bed that another scenario cannot give: unknown, borrowed itself, or of other clumps in another box."""
    bed, code = scenario["packing.bed_from"], scenario["packing.bed_code"]
    if not bed:
        if code:
            raise _refuse(
                path, f"scenario.{scenario.id}: packing.bed_code", code, "empty where packing.bed_from is empty"
            )
        return

    def refuse(allowed: str) -> ScenarioError:
        return _refuse(path, f"scenario.{scenario.id}: packing.bed_from", bed, allowed)

    if bed == scenario.id:
        raise refuse("another scenario")
    name, variants = split_id(bed)
    if name not in content["scenario"] or not set(variants) <= set(content["variant"]):
        raise refuse("empty or one of " + ", ".join(content["scenario"]))
    other = _resolve(path, content, name, variants, scenario.profile)
    if other["packing.bed_from"]:
        raise refuse(f"a scenario that packs its own bed, as {other['packing.bed_from']} does")
    for line in scenario.differences(other):
        if line.startswith(("geometry.", "clump.")):
            raise refuse(f"a scenario with the same box and clumps, but {line}")
