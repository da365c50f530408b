"""How scenarios, spheres, damping modes and sources are called in figures, tables and sentences."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from analysis.comparison.findings.members import SAME_BED_VARIANT, SERVO, SERVO_VARIANT, TRUE_LOAD
from analysis.formats.numbers import readable as number
from analysis.normalised.readers import Run
from analysis.report.style import CODE_NAMES
from analysis.scenarios import derived
from analysis.scenarios.scenario import join_id, label_of, split_id

MM, KPA = 1e3, 1e-3


MODE_NAMES = {0: "Gonthier", 1: "Lankarani–Nikravesh", 2: "Zhiying–Qishao"}

READING_NAMES = {TRUE_LOAD: "true load", SERVO: "PFC's servo"}
READING_SLUGS = {TRUE_LOAD: "force", SERVO: "servo"}
"""How names of figures tell the readings apart."""

PUBLICATION_NAMES = {
    "indraratna2013": "experiment of Indraratna 2013",
    "chen2015": "simulation of Chen 2015",
    "talebiahooie2021": "the paper's own simulation",
}


def basis_of(scenario: str) -> str:
    """The scenario of an id without its variants."""
    return split_id(scenario)[0]


def is_varied(scenario: str) -> bool:
    """True where the id of a scenario names a variant."""
    return bool(split_id(scenario)[1])


def is_reading(scenario: str) -> bool:
    """True where the id of a scenario names PFC's servo and no other variant: a reading of the paper's load."""
    return split_id(scenario)[1] == (SERVO_VARIANT,)


def of_any_bed(scenario: str) -> str:
    """The id of a scenario whatever bed it began from: without the variant that takes another code's."""
    name, variants = split_id(scenario)
    return join_id(name, [variant for variant in variants if variant != SAME_BED_VARIANT])


def short_name(scenario: str) -> str:
    """The label of scenarios.toml: `linear-mu0.8+servo` is linear μ 0.8, PFC servo."""
    return label_of(scenario)


def with_labels(text: str, names: Sequence[str]) -> str:
    """A text of data files with the labels of scenarios in place of their `names`."""
    if not names:
        return text
    longest_first = "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))
    return re.sub(rf"(?<![\w-])(?:{longest_first})(?![\w-])", lambda found: short_name(found.group()), text)


def variant_name(variants: str) -> str:
    """Labels of variants, as they stand after a scenario's: `plates-fixed` is plates fixed."""
    return label_of(f"+{variants}").removeprefix(", ")


def reference_name(kind: str, source: str, curve: str) -> str:
    """How a reference curve is named in figures."""
    if kind == "experiment":
        return "experiment"
    return {"chen2015": "Chen 2015", "talebiahooie2021": f"paper {short_name(curve)}"}.get(source, f"{source} {curve}")


def time_steps(runs: Iterable[Run]) -> str:
    """Sentences on the time steps of runs that are shown together, by scenario; empty where each has one step."""
    scenarios: dict[str, dict[str, list[str]]] = {}
    for run in runs:
        if run.scenario is not None:
            step = number(derived.time_grid(run.scenario).step_s, 3, 1e6)
            name = f"{CODE_NAMES.get(run.code, run.code)} seed {run.seed}"
            name += " by the servo" if is_reading(run.scenario_name) else ""
            scenarios.setdefault(run.base_name, {}).setdefault(step, []).append(name)
    sentences = []
    for scenario, steps in scenarios.items():
        if len(steps) > 1:
            parts = [f"{step} µs in {', '.join(dict.fromkeys(names))}" for step, names in sorted(steps.items())]
            sentences.append(f"{short_name(scenario)}: {'; '.join(parts)}.")
    return " ".join(["Time steps differ.", *sentences]) if sentences else ""
