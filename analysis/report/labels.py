"""How scenarios, spheres, damping modes and sources are called in figures, tables and sentences."""

from __future__ import annotations

import re

MM, KPA = 1e3, 1e-3

SENSITIVITY = re.compile(r"(.+)-(same-bed|half-step|plates-\w+)")
"""Scenarios of scenarios.toml that only change one assumption of another one."""

SPHERE_NAMES = ("rail seat", "middle", "shoulder")

MODE_NAMES = {0: "Gonthier", 1: "Lankarani–Nikravesh", 2: "Zhiying–Qishao"}

SOURCE_NAMES = {
    "indraratna2013": "experiment of Indraratna 2013",
    "chen2015": "simulation of Chen 2015",
    "talebiahooie2021": "the paper's own simulation",
}


def basis_of(scenario: str) -> str:
    """The scenario of which one assumption is changed, or the scenario itself."""
    varied = SENSITIVITY.fullmatch(scenario)
    return varied[1] if varied else scenario


def short_name(scenario: str) -> str:
    """`linear-mu0.8` as a reader of the paper writes it: linear μ 0.8."""
    if varied := SENSITIVITY.fullmatch(scenario):
        return f"{short_name(varied[1])}, {varied[2].replace('-', ' ')}"
    for pattern, text in (
        (r"linear-mu([\d.]+)", r"linear μ \1"),
        (r"nonlinear-en1(?:\.0)?", "nonlinear eₙ 1"),
        (r"nonlinear-md(\d)-en([\d.]+)", r"M_d \1, eₙ \2"),
    ):
        if re.fullmatch(pattern, scenario):
            return re.sub(pattern, text, scenario).replace("M_d ", "Md ")
    return scenario


def reference_name(kind: str, source: str, curve: str) -> str:
    """How a reference curve is named in figures."""
    if kind == "experiment":
        return "experiment"
    return {"chen2015": "Chen 2015", "talebiahooie2021": f"paper {short_name(curve)}"}.get(source, f"{source} {curve}")
