"""Sections of docs/method.md: the stages with the scenario's numbers, where each equation stands, time steps, and what
each code does otherwise.
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import jinja2

from analysis import contact_laws
from analysis.formats import numbers
from analysis.formats.markdown import table
from analysis.scenarios import derived, deviations
from analysis.scenarios.scenario import load_scenario, scenario_names
from analysis.scenarios.study_list import key_scenarios

EQUATIONS = range(1, 17)
"""Of the paper's section 2."""
CODES = {"yade": "YADE", "liggghts": "LIGGGHTS"}
STAGES = Path(__file__).with_name("stages.txt")


def _stages() -> str:
    s = load_scenario(key_scenarios()[0], "full")
    low, high = s["loading.stress_min"] / 1e3, s["loading.stress_max"] / 1e3
    return jinja2.Template(STAGES.read_text(encoding="utf-8"), undefined=jinja2.StrictUndefined).render(
        s=s,
        n=lambda key, factor=1: numbers.readable(s[key], 5, factor),
        shares=", ".join(f"{share:g}" for share in s["packing.relax_stiffness"]),
        mean=f"{(low + high) / 2:g}",
        amplitude=f"{(high - low) / 2:g}",
    )


def equations_of(function) -> list[int]:
    """Numbers of the paper's equations that a docstring begins with: `Eq. 4 and 12, N`, `h_n of eq. 8`."""
    named = re.match(r"(?:\w+ of )?[Ee]q\. ((?:\d+|-|, | and | \(and )+)", inspect.getdoc(function) or "")
    found = []
    for start, end in re.findall(r"(\d+)(?:-(\d+))?", named.group(1) if named else ""):
        found += range(int(start), int(end or start) + 1)
    return found


def equation_functions() -> dict[int, list[str]]:
    """Equation -> the functions of analysis/contact_laws.py that are it."""
    found: dict[int, list[str]] = {number: [] for number in EQUATIONS}
    for name, function in inspect.getmembers(contact_laws, inspect.isfunction):
        if function.__module__ == contact_laws.__name__:
            for number in equations_of(function):
                found[number].append(name)
    return found


def _equations() -> str:
    rows = [[str(number), ", ".join(f"`{name}`" for name in names)] for number, names in equation_functions().items()]
    return table(["equation", "function in [analysis/contact_laws.py](../analysis/contact_laws.py)"], rows)


def _deviations() -> str:
    rows = []
    for d in deviations.DEVIATIONS:
        said = d.said.replace(" {restitution}", "").replace(" e_n = {nominal}", " e_n")
        rows.append([CODES[d.code], d.law, said, d.when])
    return table(["code", "law", "what the code does otherwise", "in which scenarios"], rows)


def _time_steps() -> str:
    """A row for each pair of steps that scenarios have."""
    groups: dict[tuple, list[str]] = {}
    for s in (load_scenario(name, "full") for name in scenario_names()):
        groups.setdefault((s["time.paper_step"], s["time.verified_step"]), []).append(s.name)
    rows = []
    for names in groups.values():
        cells = []
        for choice in ("paper-step", ""):
            s = load_scenario(names[0], "full", variant=choice)
            grid = derived.time_grid(s)
            cells += [f"{grid.step_s * 1e6:.3g} µs", str(grid.steps_per_cycle)]
        who = f"`{names[0]}`" + (f" and {len(names) - 1} more" if len(names) > 1 else "")
        rows.append([who, *cells, s.parameters["time.verified_step"].source])
    header = [
        "scenarios",
        "`paper`",
        "steps per cycle",
        "`verified` (default)",
        "steps per cycle",
        "source of `verified`",
    ]
    return table(header, rows)


SECTIONS = {"stages": _stages, "equations": _equations, "time-steps": _time_steps, "deviations": _deviations}
