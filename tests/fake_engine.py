"""Stands in for an engine where the driver alone is tested: the same rules, a chaotic map instead of a bed.

usage: fake_engine.py STAGE RUN_FOLDER [CHECKPOINT]
A file `behave` in the run's folder makes it misbehave; it holds one of the words that are looked for below.
"""

import json
import os
import signal
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from analysis.formats import file_columns  # noqa: E402
from analysis.scenarios import derived  # noqa: E402
from analysis.scenarios.scenario import Scenario  # noqa: E402

stage, run = sys.argv[1], Path(sys.argv[2])
checkpoint = Path(sys.argv[3]) if len(sys.argv) > 3 else None
raw, kept = run / "raw", run / "checkpoints"
scenario = Scenario.from_json((run / "scenario.json").read_text())
grid, blocks = derived.time_grid(scenario), scenario["output.blocks_per_cycle"]
END_M = derived.apparatus(scenario).end_m
behave = (run / "behave").read_text().strip() if (run / "behave").exists() else ""
stop = []
BLOCK_S = 0.5 if behave == "deaf" else 0.02
for number in (signal.SIGTERM, signal.SIGINT):
    signal.signal(number, signal.SIG_IGN if behave == "deaf" else lambda *_: stop.append(1))


def write_aside(path: Path, text: str) -> None:
    aside = path.with_name(path.name + ".partial")
    aside.write_text(text)
    aside.replace(path)


def append(name: str, columns, *values) -> None:
    path = raw / name
    new = not path.exists()
    with open(path, "a") as file:
        if new:
            file.write(",".join(columns) + "\n")
        file.write(",".join(map(str, values)) + "\n")


def state_row(step: int, x: float) -> None:
    late = stage == "cyclic" and step > 2 * grid.steps_per_cycle
    clumps = 1 if behave == "loss" and late else 2
    overlap = 0.3 if behave == "overlap" and late else 0.01 * x
    energy = "nan" if behave == "nan" and late else 1e-8 * x
    append(
        "state.csv",
        file_columns.RAW_STATE,
        stage,
        step,
        step * grid.step_s,
        energy,
        1e-4,
        overlap,
        1e-6,
        4,
        clumps,
        "nan",
        0,
    )


def load_row(step: int, x: float) -> None:
    moved = 0.001 + 1e-5 * x
    target = 255e3
    values = [step, step * grid.step_s, target, target + x, 460e3 * x, x, moved]
    for _ in range(5):
        values += [1e4, 1e4, 0.1 * moved]
    append(f"{stage}.csv", file_columns.RAW_LOADING, *values)


def bed(label: str, x: float) -> None:
    poses = "".join(f"{k},{END_M + 0.06 + 0.03 * k + 0.01 * x},0.02,0.1,1.0,0.0,0.0,0.0\n" for k in (1, 2))
    write_aside(raw / f"bed_{label}.csv", "id,x_m,y_m,z_m,qw,qx,qy,qz\n" + poses)


def contacts(label: str, x: float) -> None:
    """The one contact, midway between the two clumps: further off it would make the critical step too small."""
    write_aside(
        raw / f"contacts_{label}.csv",
        "clump_1,clump_2,x_m,y_m,z_m,nx,ny,nz,overlap_m,normal_force_N,shear_force_N,sliding\n"
        f"1,2,{END_M + 0.105 + 0.01 * x},0.02,0.1,1,0,0,1e-6,10,1,0\n",
    )


def save(name: str, cycle: int, block: int, x: float) -> None:
    write_aside(kept / f"{name}.yade.gz", json.dumps([cycle, block, x]))


def advance(x: float) -> float:
    """One block; the logistic map forgets nothing and forgives nothing."""
    time.sleep(BLOCK_S)
    for _ in range(10):
        x = 3.99 * x * (1 - x)
    return x


if behave == "error":
    sys.exit("ERROR: packing: not at rest after 1 s")
if behave == "nothing":
    sys.exit(0)
if behave == "crash":
    os.kill(os.getpid(), signal.SIGSEGV)

if stage != "cyclic":
    x = 0.3
    for block in range(1, 9):
        x = advance(x)
        if stage == "preload":
            for step in range((block - 1) * grid.steps_per_block, block * grid.steps_per_block, grid.steps_per_row):
                load_row(step + grid.steps_per_row, x)
        state_row(block * grid.steps_per_block, x)
        if stop:
            sys.exit(75)
    label = {"packing": "packed", "preload": "preloaded"}[stage]
    contacts(label, x)
    bed(label, x)
    if stage == "preload":
        save("cyclic_000000", 0, 0, x)
    sys.exit(0)

cycle, block, x = json.loads(checkpoint.read_text())
if (cycle, block) == (0, 0):
    load_row(0, x)
while cycle < scenario["loading.cycles"]:
    start = cycle * grid.steps_per_cycle
    while block < blocks:
        for row in range(1, grid.steps_per_block // grid.steps_per_row + 1):
            if not (behave == "gap" and cycle == 1 and block == 3):
                load_row(start + block * grid.steps_per_block + row * grid.steps_per_row, x)
        x = advance(x)
        block += 1
        state_row(start + block * grid.steps_per_block, x)
        if stop and block < blocks:
            save(f"cyclic_{cycle:06d}_block{block}", cycle, block, x)
            sys.exit(75)
    cycle, block = cycle + 1, 0
    bed(f"cycle_{cycle:06d}", x)
    if cycle in scenario["output.keep_beds"] or cycle == scenario["loading.cycles"]:
        contacts(f"cycle_{cycle:06d}", x)
    if cycle % scenario["output.checkpoint_cycles"] == 0 or cycle == scenario["loading.cycles"]:
        save(f"cyclic_{cycle:06d}", cycle, 0, x)
    if stop:
        save(f"cyclic_{cycle:06d}_block0", cycle, 0, x)
        sys.exit(75)
