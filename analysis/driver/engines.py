"""What the driver must know of the two engines: their inputs, command lines and versions.

Everything an engine reads is made here from the resolved scenario; the engines hold no parameter of their own.
"""

from __future__ import annotations

import functools
import itertools
import shutil
import subprocess
from pathlib import Path

from analysis.files import ROOT, write_aside
from analysis.formats import bed_file, file_columns
from analysis.scenarios import derived
from analysis.scenarios.lattice import lattice_bed
from analysis.scenarios.scenario import Scenario

CODES = file_columns.CODES
STAGES = ("packing", "preload", "cyclic")
CHECKPOINT_SUFFIX = {"yade": "yade.gz", "liggghts": "restart"}
HOST = ROOT / "liggghts" / "build" / "ballast"


class EngineError(RuntimeError):
    """An engine that cannot be used; the message is one line with the remedy."""


def write_inputs(scenario: Scenario, run_dir: Path, seed: int) -> None:
    """Write all that an engine reads into `run_dir`: scenario.json, parameters.in, raw/bed_start.csv."""
    for folder in ("raw", "checkpoints", "log"):
        (run_dir / folder).mkdir(parents=True, exist_ok=True)
    write_aside(run_dir / "parameters.in", liggghts_parameters(scenario, seed))
    write_bed(run_dir / "raw" / "bed_start.csv", lattice_bed(scenario, seed))
    write_aside(run_dir / "scenario.json", scenario.to_json())


def write_bed(path: Path, poses) -> None:
    """Write poses (x, y, z, qw, qx, qy, qz) as a common bed file with ids from 1."""
    bed_file.write(path, ((number, *pose) for number, pose in enumerate(poses, start=1)))


def command(code: str, stage: str, run_dir: Path, checkpoint: Path | None = None, ranks: int = 1) -> list[str]:
    """Command line of one stage, to be started in the repository's root."""
    if code == "yade":
        extra = [str(checkpoint)] if checkpoint else []
        return ["yade", f"-j{ranks}", "-n", "-x", f"yade/{stage}.py", str(run_dir), *extra]
    launcher = []
    if ranks > 1:
        launcher = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-np", str(ranks)]
    extra = ["-var", "checkpoint", str(checkpoint)] if checkpoint else []
    return [*launcher, str(HOST), "-in", f"liggghts/{stage}.in", "-log", "none", "-var", "run", str(run_dir), *extra]


@functools.cache
def versions(code: str) -> str:
    """Version of the installed engine, e.g. `yade 2023.02a`. Raises EngineError where it is missing."""
    if code == "liggghts":
        if not HOST.exists():
            raise EngineError("liggghts: liggghts/build/ballast is not built; run `make setup`")
        return f"liggghts {_package_version('liggghts')}"
    if not shutil.which("yade"):
        raise EngineError("yade: not installed; run `make setup`")
    return f"yade {_package_version('yade')}"


def _package_version(package: str) -> str:
    found = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package], capture_output=True, text=True)
    return found.stdout.strip() or "of unknown version"


def liggghts_parameters(scenario: Scenario, seed: int) -> str:
    """The scenario as LIGGGHTS variables: every key with dots as underscores, and the derived quantities."""
    clump, box, grid = derived.clump(scenario), derived.apparatus(scenario), derived.time_grid(scenario)
    values = {key.replace(".", "_"): p.value for key, p in scenario.parameters.items() if p.value != ""}
    values |= {
        "clump_radius": clump.radius_m,
        "clump_half_distance": clump.half_distance_m,
        "clump_volume": clump.volume_m3,
        "clump_mass": clump.mass_kg,
        "clump_inertia_axial": clump.inertia_axial_kgm2,
        "clump_inertia_transverse": clump.inertia_transverse_kgm2,
        "box_width_scaled": box.width_m,
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
    values |= {f"{key}_scaled": value for key, value in derived.load_control(scenario).items()}
    values |= _walls(scenario)
    lines = [f"# {scenario.id}, profile {scenario.profile}, scenario {scenario.hash}: written from scenarios.toml"]
    for name, value in values.items():
        if isinstance(value, list):
            lines.append(f"variable {name}_count index {len(value)}")
            lines += [f"variable {name}_{n} index {_number(item)}" for n, item in enumerate(value, start=1)]
            value = " ".join(map(_number, value))
        lines.append(f'variable {name} index "{_number(value)}"')
    return "\n".join(lines) + "\n"


def _number(value) -> str:
    return repr(value) if isinstance(value, float) else str(value)


def _walls(scenario: Scenario) -> dict[str, list[float]]:
    """Blocks of the apparatus, XLO XHI YLO YHI ZLO ZHI; lids close the box beside the sleeper during packing."""
    box = derived.apparatus(scenario)
    (_, left, _), (_, right, _) = box.sleeper.low, box.sleeper.high
    top, lid_top = box.height_m, box.height_m + scenario["geometry.plate_thickness"]
    blocks = {
        "sleeper": box.sleeper,
        "fixed_wall": box.fixed_wall,
        "lid_left": derived.Block((0.0, 0.0, top), (box.length_m, left, lid_top)),
        "lid_right": derived.Block((0.0, right, top), (box.length_m, box.width_m, lid_top)),
    }
    blocks |= {f"plate_{k}": plate for k, plate in enumerate(box.plates, start=1)}
    return {
        f"{name}_block": [*itertools.chain(*zip(block.low, block.high, strict=True))] for name, block in blocks.items()
    }
