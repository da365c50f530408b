"""PARAMETERS.md: every parameter with value, unit, status and source, made from the scenario file.

`ballast docs` writes it; a test compares the committed file with `render()`.
"""

from __future__ import annotations

from itertools import groupby

from analysis.formats.markdown import table
from analysis.scenarios import conversions, derived
from analysis.scenarios.scenario import (
    SCENARIO_FILE,
    Parameter,
    Scenario,
    base_parameters,
    load_scenario,
    profile_names,
    scenario_names,
    variant_names,
)
from analysis.scenarios.schema import PROFILE_KEYS, STAGES, STATUSES

PARAMETER_FILE = SCENARIO_FILE.with_name("PARAMETERS.md")

MEANING = {
    "reported": "printed in Talebiahooie et al. (2021)",
    "derived": "follows from reported values",
    "assumed": "nobody's value is known: a knob for sensitivity studies",
    "calibrated": "tuned by this project; the source says to what",
}


def render() -> str:
    """The whole file as Markdown."""
    base = base_parameters()
    scenarios = [load_scenario(name) for name in scenario_names()]
    parts = [
        "# Parameters\n\nMade from [scenarios.toml](scenarios.toml) by `make docs`; do not edit. "
        "[docs/glossary.md](docs/glossary.md) explains the terms.\n"
        "SI units; x along the sleeper, y along the track, z up; settlement positive downward.\n\n" + _statuses(base),
        "## Base\n\n" + "\n".join(_section(name, dict(keys)) for name, keys in groupby(base.items(), _section_name)),
        "## Scenarios\n\nWhere a scenario differs from the base.\n\n" + _scenarios(base, scenarios),
        "## Variants\n\nA variant can be laid over any scenario. It starts from its scenario's packed bed, unless it "
        "changes box, clumps or packing.\n\n" + _variants(),
        "## Profiles\n\nA profile changes size and length only.\n\n" + _profiles(),
        "## What follows\n\nFor the full bed.\n\n" + _derived(scenarios),
        conversions.markdown(),
    ]
    return "\n".join(part.rstrip() + "\n" for part in parts)


def _value(value) -> str:
    if isinstance(value, list):
        return ", ".join(map(_value, value))
    if isinstance(value, float):
        # 1e8, not 100000000.0; 2.9e-6, not 2.9e-06
        text = f"{value:.10g}" if 1e-3 <= abs(value) < 1e6 or value == 0 else f"{value:.10e}"
        mantissa, _, exponent = text.partition("e")
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        return mantissa + (f"e{int(exponent)}" if exponent else "")
    return str(value) if value != "" else "(empty)"


def _with_unit(p: Parameter) -> str:
    return _value(p.value) + (f" {p.unit}" if p.unit != "-" else "")


def _statuses(base: dict[str, Parameter]) -> str:
    return table(
        ["status", "meaning", "values in the base"],
        [[s, MEANING[s], str(sum(p.status == s for p in base.values()))] for s in STATUSES],
    )


def _section_name(item) -> str:
    return item[0].rpartition(".")[0]


def _section(name: str, parameters: dict[str, Parameter]) -> str:
    rows = [
        [f"`{key.rpartition('.')[2]}`", _value(p.value), p.unit, p.status, p.source] for key, p in parameters.items()
    ]
    return f"### {name}\n\n" + table(["key", "value", "unit", "status", "source"], rows)


def _scenarios(base: dict[str, Parameter], scenarios: list[Scenario]) -> str:
    """A row for each value that a scenario sets otherwise, scenarios that share it in one row."""
    rows: dict[tuple, list[str]] = {}
    for s in scenarios:
        for key, p in s.parameters.items():
            if p.value != base[key].value:
                rows.setdefault((key, _with_unit(p), p.status, p.source), []).append(s.name)
    order = list(base)
    cells = [
        [f"`{key}`", _with_unit(base[key]), value, ", ".join(_shorten(names)), status, source]
        for (key, value, status, source), names in sorted(rows.items(), key=lambda item: order.index(item[0][0]))
    ]
    same = [s.name for s in scenarios if all(s.parameters[k].value == p.value for k, p in base.items())]
    header = ["key", "base", "value", "scenarios", "status", "source"]
    return table(header, cells) + f"\nAs the base: {', '.join(same)}.\n"


def _shorten(names: list[str]) -> list[str]:
    """All scenarios that begin alike as one: nonlinear-*."""
    everything = scenario_names()
    for prefix in reversed(dict.fromkeys(f"{name.partition('-')[0]}-" for name in everything)):
        alike = [n for n in everything if n.startswith(prefix)]
        if len(alike) > 1 and set(alike) <= set(names):
            names = [f"{prefix}*", *(n for n in names if n not in alike)]
    return names


def _variants() -> str:
    """A row for each value of each variant, over the first scenario whose value it changes."""
    rows = []
    for name in variant_names():
        found: dict[str, Parameter] = {}
        for scenario in scenario_names():
            plain, varied = load_scenario(scenario), load_scenario(scenario, variant=name)
            for key in plain.changed_keys(varied, STAGES[0], STAGES[-1]):
                if key not in ("packing.bed_from", "time.step"):
                    found.setdefault(key, varied.parameters[key])
            for key in ("time.choice", "time.factor"):
                if plain[key] != varied[key]:
                    found.setdefault(key, varied.parameters[key])
        rows += [[f"`{name}`", f"`{key}`", _with_unit(p), p.status, p.source] for key, p in found.items()]
    return table(["variant", "key", "value", "status", "source"], rows)


def _profiles() -> str:
    name = scenario_names()[0]
    rows = []
    for key in PROFILE_KEYS:
        values = [load_scenario(name, profile).parameters[key] for profile in profile_names()]
        rows.append([f"`{key}`", *(_with_unit(p) for p in values), values[-1].source])
    return table(["key", *profile_names(), "source"], rows)


def _derived(scenarios: list[Scenario]) -> str:
    """Clump, apparatus and time grid; scenarios with the same numbers share a column."""
    columns: dict[tuple, list[str]] = {}
    for s in scenarios:
        columns.setdefault(tuple(_numbers(s).items()), []).append(s.name)
    names = [name for name, _ in next(iter(columns))]
    rows = [[name, *(dict(column)[name] for column in columns)] for name in names]
    return table(["quantity", *(", ".join(_shorten(names)) for names in columns.values())], rows)


def _numbers(scenario: Scenario) -> dict[str, str]:
    c, box, grid = derived.clump(scenario), derived.apparatus(scenario), derived.time_grid(scenario)
    share = grid.step_s / derived.critical_time_step(scenario)
    return {
        "clump: radius of its spheres, m": f"{c.radius_m:.6g}",
        "clump: distance of the sphere centres, m": f"{2 * c.half_distance_m:.6g}",
        "clump: volume, m3": f"{c.volume_m3:.6g}",
        "clump: mass, kg": f"{c.mass_kg:.6g}",
        "clump: inertia about its axis, kg m2": f"{c.inertia_axial_kgm2:.6g}",
        "clump: inertia across, kg m2": f"{c.inertia_transverse_kgm2:.6g}",
        "sleeper: base area, m2": f"{box.sleeper_area_m2:.6g}",
        "plate: area, m2": f"{box.plate_area_m2:.6g}",
        "space for ballast, m3": f"{box.ballast_volume_m3:.6g}",
        "time step after rounding, s": f"{grid.step_s:.6g}",
        "steps per cycle": str(grid.steps_per_cycle),
        "time step over the critical one of a linear contact": f"{share:.3f}",
    }
