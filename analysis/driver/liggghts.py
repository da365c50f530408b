"""LIGGGHTS as an engine: the host that liggghts/Makefile builds, driven by the decks in liggghts/."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

from analysis.driver.engine import EngineError, package_version, write_common_inputs
from analysis.files import ROOT, write_aside
from analysis.formats.run_record import STAGES
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario

HOST = ROOT / "liggghts" / "build" / "ballast"
LONGEST_COMMENT = 1000
"""Characters; LIGGGHTS reads lines of at most 2048."""
LONGEST_PATH = 140
"""Characters of a run's folder; LIGGGHTS' lines and file names have fixed lengths, and decks add to the folder."""


class Liggghts:
    """The engine LIGGGHTS; `host` is its executable."""

    name = "liggghts"
    checkpoint_suffix = "restart"
    stages = (*STAGES, "unload")

    def __init__(self, host: Path = HOST):
        self.host = host

    def version(self) -> str:
        if not self.host.exists():
            raise EngineError("liggghts: liggghts/build/ballast is not built; run `make setup`")
        return f"liggghts {package_version('liggghts') or 'of unknown version'}"

    def refuses(self, folder: Path, ranks: int) -> str | None:
        bad = sorted({character for character in str(folder) if re.match(r"[^\w.,:@+=/~-]", character)})
        if bad:
            shown = ", ".join("a space" if character == " " else repr(character) for character in bad)
            return f"{folder}: LIGGGHTS cannot read a path with {shown}; give RESULTS=folder of another name"
        if len(str(folder)) > LONGEST_PATH:
            return (
                f"{folder}: LIGGGHTS cannot read a path of more than {LONGEST_PATH} characters; "
                "give RESULTS=folder with a shorter path"
            )
        return None

    def parallel(self, ranks: int) -> dict[str, int]:
        return {"ranks": ranks, "threads": 1}

    def write_inputs(self, scenario: Scenario, folder: Path, seed: int) -> None:
        write_common_inputs(scenario, folder, seed)
        write_aside(folder / "parameters.in", parameter_deck(scenario, seed))

    def command(self, stage: str, folder: Path, checkpoint: Path | None = None, ranks: int = 1) -> list[str]:
        launcher = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-np", str(ranks)] if ranks > 1 else []
        host = self.host.relative_to(ROOT) if self.host.is_relative_to(ROOT) else self.host
        words = [str(host), "-in", f"liggghts/{stage}.in", "-log", "none"]
        variables = {"run": folder, "ranks": ranks} | ({"checkpoint": checkpoint} if checkpoint else {})
        return [*launcher, *words, *(w for name, value in variables.items() for w in ("-var", name, str(value)))]


def parameter_deck(scenario: Scenario, seed: int) -> str:
    """The scenario as LIGGGHTS variables: every key with dots as underscores, and what follows from them.

    Sections are those of the scenario file; a comment tells unit, status and source of each value.
    """
    lines = [f"# {scenario.id}, profile {scenario.profile}, scenario {scenario.hash}: written from scenarios.toml"]
    section, following = "", _derived(scenario, seed)
    for key, parameter in scenario.parameters.items():
        if (here := key.rpartition(".")[0]) != section:
            section = here
            lines += ["", f"# [{section}]"]
        if parameter.value != "":
            name, comment = key.replace(".", "_"), f"{parameter.unit}, {parameter.status}: {parameter.source}"
            lines += _variable(name, following.pop(name, parameter.value), comment)
    lines += ["", "# what follows from them, and the seed"]
    for name, value in following.items():
        lines += _variable(name, value)
    return "\n".join(lines) + "\n"


def _derived(scenario: Scenario, seed: int) -> dict:
    clump, box, grid = derived.clump(scenario), derived.apparatus(scenario), derived.time_grid(scenario)
    values = {
        "clump_radius": clump.radius_m,
        "clump_half_distance": clump.half_distance_m,
        "clump_volume": clump.volume_m3,
        "clump_mass": clump.mass_kg,
        "clump_inertia_axial": clump.inertia_axial_kgm2,
        "clump_inertia_transverse": clump.inertia_transverse_kgm2,
        "box_width_scaled": box.width_m,
        "end_friction_share": box.end_friction_share,
        "sleeper_area": box.sleeper_area_m2,
        "plate_area": box.plate_area_m2,
        "time_step": grid.step_s,
        "steps_per_cycle": grid.steps_per_cycle,
        "steps_per_row": grid.steps_per_row,
        "steps_per_block": grid.steps_per_block,
        **{f"preload_{kind}_law": law for kind, law in derived.wall_laws(scenario, "preload").items()},
        "cycles": scenario["loading.cycles"],
        "seed": seed,
    }
    scaled = {f"{key}_scaled": value for key, value in derived.load_control(scenario).items()}
    return values | _pairs(scenario) | _bonds(scenario) | scaled | _blocks(scenario)


PAIR_LAWS = {
    ("linear", "paper"): "model ballast/linear tangential ballast/slip",
    ("hysteretic", "paper"): "model ballast/hysteretic tangential ballast/slip",
    ("linear", "engine"): "model hooke/stiffness tangential history tangential_damping off",
    ("hysteretic", "engine"): "model hertz tangential history tangential_damping off",
}
"""Words of LIGGGHTS' `pair_style gran` by contact.model and contact.origin."""


def _pairs(scenario: Scenario) -> dict:
    """The law between particles, and whether it is LIGGGHTS' own."""
    model, origin = scenario["contact.model"], scenario["contact.origin"]
    return {"pair_law": PAIR_LAWS[model, origin], "stock_pairs": int(origin == "engine")}


def _bonds(scenario: Scenario) -> dict[str, float]:
    """Whether there are bonds, and the distance of two centres (m) at which none holds any more."""
    bond, radius = derived.bond(scenario), derived.clump(scenario).radius_m
    if bond is None:
        return {"bonded": 0}
    return {"bonded": 1, "bond_reach": 2.1 * radius + bond.tensile_strength / bond.normal_stiffness}


def _blocks(scenario: Scenario) -> dict[str, list[float]]:
    """Walls, box and simulated space, XLO XHI YLO YHI ZLO ZHI; lids close the box beside the sleeper during packing."""
    box = derived.apparatus(scenario)
    (_, left, _), (_, right, _) = box.sleeper.low, box.sleeper.high
    top, lid_top = box.height_m, box.height_m + scenario["geometry.plate_thickness"]
    blocks = {
        "sleeper": box.sleeper,
        "fixed_wall": box.fixed_wall,
        "lid_left": derived.Block((box.end_m, 0.0, top), (box.length_m, left, lid_top)),
        "lid_right": derived.Block((box.end_m, right, top), (box.length_m, box.width_m, lid_top)),
    }
    blocks["box"] = derived.Block((box.end_m, 0.0, 0.0), (box.length_m, box.width_m, box.height_m))
    blocks["space"] = derived.simulated_space(scenario)
    blocks |= {f"plate_{k}": plate for k, plate in enumerate(box.plates, start=1)}
    return {
        f"{name}_block": [*itertools.chain(*zip(block.low, block.high, strict=True))] for name, block in blocks.items()
    }


def _variable(name: str, value, comment: str = "") -> list[str]:
    """Lines that define a LIGGGHTS variable; a list also gets its count and its items."""
    lines = []
    if isinstance(value, list):
        lines.append(f"variable {name}_count index {len(value)}")
        lines += [f"variable {name}_{n} index {_number(item)}" for n, item in enumerate(value, start=1)]
        value = " ".join(map(_number, value))
    line = f'variable {name} index "{_number(value)}"'
    # a line that ends in & would go on in the next
    return [*lines, f"{line:70} # {' '.join(comment.split()).rstrip(' &')[:LONGEST_COMMENT]}" if comment else line]


def _number(value) -> str:
    return repr(value) if isinstance(value, float) else str(value)
