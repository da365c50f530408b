"""The case of the stock LIGGGHTS deck (liggghts/stock.in): parameters, the bed as a restart file, boxes as STL.

Stock LIGGGHTS moves walls as triangles only. The boxes stand where the preload of our run left sleeper and plates.
"""

from __future__ import annotations

import itertools
import subprocess
from pathlib import Path

from analysis.driver.bench.bench_beds import Preloaded
from analysis.driver.bench.meter import Speed
from analysis.driver.engine import EngineError
from analysis.driver.liggghts import HOST
from analysis.files import ROOT, write_aside
from analysis.formats.quantities import PLATES
from analysis.scenarios import derived

EXECUTABLE = "liggghts"
DECK, BED_DECK = "liggghts/stock.in", "liggghts/stock_bed.in"
LAWS = {"linear": "hooke/stiffness", "hysteretic": "hertz"}
ROWS = Path("raw") / "stock.csv"


class StockDeck:
    """LIGGGHTS as Debian packs it, with its own contact models and walls of triangles: the first cycle."""

    def prepare(self, case) -> None:
        """Add to the case's folder what stock.in reads: the preloaded bed, at rest, and the boxes.

        The case's scenario has the sleeper where preload left it. Raises EngineError where the bed cannot be placed.
        """
        (case.folder / "stl").mkdir(parents=True, exist_ok=True)
        for name, block in moved_blocks(case.scenario, case.bed).items():
            write_aside(case.folder / "stl" / f"{name}.stl", box_stl(name, block))
        values = ["-var", "run", str(case.folder), "-var", "bed_file", str(case.bed.bed)]
        host = [str(HOST), "-in", BED_DECK, "-log", "none", *values]
        done = subprocess.run(host, cwd=ROOT, capture_output=True, text=True)
        if done.returncode:
            raise EngineError(f"{BED_DECK}: {(done.stdout + done.stderr).strip().splitlines()[-1]}")

    def argv(self, case) -> list[str]:
        """Command line of the stock deck, to be started in the repository's root."""
        law = LAWS[case.scenario["contact.model"]]
        return [EXECUTABLE, "-in", DECK, "-log", "none", "-var", "run", str(case.folder), "-var", "particle_law", law]

    def time(self, case) -> Speed:
        """Time it once."""
        return case.timed(self.argv(case), ROWS)


def moved_blocks(scenario, preloaded: Preloaded) -> dict[str, derived.Block]:
    """Sleeper, plates and fixed wall as boxes, the plates where preload left them; lengths in m."""
    box, ways = derived.apparatus(scenario), preloaded.ways_m()
    plates = {f"plate_{k}": shifted(plate, 0, ways[f"plate_{k}"]) for k, plate in zip(PLATES, box.plates, strict=True)}
    return {"sleeper": box.sleeper, "fixed_wall": box.fixed_wall, **plates}


def shifted(block: derived.Block, axis: int, way_m: float) -> derived.Block:
    """The block, moved along an axis."""

    def corner(at):
        return tuple(value + way_m * (n == axis) for n, value in enumerate(at))

    return derived.Block(corner(block.low), corner(block.high))


def box_stl(name: str, block: derived.Block) -> str:
    """The six faces of a box as twelve triangles in ASCII STL."""
    corner = dict(
        zip(
            itertools.product((0, 1), repeat=3),
            itertools.product(*zip(block.low, block.high, strict=True)),
            strict=True,
        )
    )
    lines = [f"solid {name}"]
    for axis, side in itertools.product(range(3), (0, 1)):
        first, second = (a for a in range(3) if a != axis)
        square = []
        for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
            key = [side] * 3
            key[first], key[second] = u, v
            square.append(corner[tuple(key)])
        for triangle in ((0, 1, 2), (0, 2, 3)):
            lines += [" facet normal 0 0 0", "  outer loop"]
            lines += ["   vertex {!r} {!r} {!r}".format(*square[n]) for n in triangle]
            lines += ["  endloop", " endfacet"]
    return "\n".join([*lines, f"endsolid {name}", ""])
