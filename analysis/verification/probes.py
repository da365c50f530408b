"""Small cases that are run in the engines: a few spheres or clumps, perhaps a wall, for some thousand steps.

A `Probe` says what happens; `run_probes` runs it through the same contact models, properties and scripts as a full run
(liggghts/verify_*.in with liggghts/contact.in; yade/verify.py with yade/contact.py) and returns a `Trajectory`.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from analysis.driver.engine import write_bed
from analysis.driver.engines import LIGGGHTS
from analysis.driver.liggghts import parameter_deck
from analysis.files import ROOT
from analysis.scenarios.scenario import Scenario

TIME_LIMIT_S, PATIENCE_S = 250, 7200
"""Most processor time of an engine, and most real time, which a busy machine stretches."""
WALLS = ("", "linear", "hysteretic", "block")
BLOCK_M = (0.03, 0.04, 0.05)
"""Half the edges of the block of verification."""
ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "ASAN_OPTIONS": "detect_leaks=0",
}  # LIGGGHTS does not free all at its end; of use with --host only


@dataclass(frozen=True)
class Ball:
    """A sphere: radius (m), mass (kg), place (m), velocity (m/s), spin (rad/s). A held one does not move."""

    radius: float
    mass: float
    position: tuple[float, float, float]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    held: bool = False


@dataclass(frozen=True)
class ClumpAt:
    """The scenario's clump: place (m), unit quaternion as in bed files, velocity (m/s), spin (rad/s, in space)."""

    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Probe:
    """One small case. Balls and clumps do not mix.

    wall -- "" for none, "linear" for the study's wall at z = 0, "hysteretic" for a plane with the particles' law, which
            the study does not have, "block" for a block about the origin
    path -- [(velocity, steps), ...]: the first ball moves so instead of freely
    spins -- spin of that ball in each part of the path; else it keeps its own
    gravity -- along -z, m/s2
    every -- steps between the rows of the trajectory
    """

    name: str
    scenario: Scenario = field(repr=False)
    step: float
    steps: int
    balls: tuple[Ball, ...] = ()
    clumps: tuple[ClumpAt, ...] = ()
    wall: str = ""
    path: tuple[tuple[tuple[float, float, float], int], ...] = ()
    spins: tuple[tuple[float, float, float], ...] = ()
    gravity: float = 0.0
    every: int = 1


@dataclass(frozen=True)
class Trajectory:
    """Spheres over time, shapes (rows, spheres, 3): centres, velocities, spins, contact forces and torques; SI units.

    A clump gives two spheres; velocity and spin are those of the sphere as part of it. YADE's velocities are those of
    half a step earlier.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    force: np.ndarray
    torque: np.ndarray
    contacts: np.ndarray
    """Number of contacts, bonds aside, (rows,)."""
    at_limit: np.ndarray
    """Number of contacts whose hysteretic dashpot is at its limit, (rows,); nan in YADE, which has no such law."""
    bonds: np.ndarray
    """Number of bonds that hold, (rows,)."""


class EngineFailure(RuntimeError):
    """An engine that did not finish; the message is one line with its own error."""


def run_probes(
    code: str, probes: list[Probe], folder: Path, workers: int = 1
) -> tuple[dict[str, Trajectory], dict[str, str]]:
    """Run all probes in one engine, below `folder`, at most `workers` at a time.

    Returns trajectories by name, and for probes that did not finish one line each.
    """
    folder.mkdir(parents=True, exist_ok=True)
    runner, together = RUNNERS[code]
    if together:
        shares = [probes[k::workers] for k in range(workers)]
        jobs = [(share, folder / f"part_{k}") for k, share in enumerate(shares) if share]
    else:
        jobs = [([probe], folder / probe.name) for probe in probes]
    found, failures = {}, {}
    with ThreadPoolExecutor(workers) as pool:
        for done, failed in pool.map(lambda job: runner(*job), jobs):
            found.update(done)
            failures.update(failed)
    return found, failures


def _run_yade(probes: list[Probe], folder: Path):
    folder.mkdir(parents=True, exist_ok=True)
    entries = []
    for probe in probes:
        entry = asdict(replace(probe, scenario=None)) | {"block": BLOCK_M}
        entry["scenario"] = {key: asdict(parameter) for key, parameter in probe.scenario.parameters.items()}
        entries.append(entry)
    listing = folder / "probes.json"
    listing.write_text(json.dumps(entries))
    message = "yade: no result"
    try:
        call_engine(
            ["yade/launch.sh", "-j1", "-n", "-x", "yade/verify.py", str(listing.resolve()), str(folder.resolve())],
            folder,
        )
    except EngineFailure as error:
        message = str(error)
    found = {
        probe.name: _from_yade(probe, np.load(path))
        for probe in probes
        if (path := folder / f"{probe.name}.npy").exists()
    }
    return found, {probe.name: message for probe in probes if probe.name not in found}


def _from_yade(probe: Probe, rows: np.ndarray) -> Trajectory:
    values = rows[:, 2:].reshape(len(rows), -1, 5, 3)
    time = np.arange(len(rows)) * probe.every * probe.step
    contacts, bonds = rows[:, 0], rows[:, 1]
    return Trajectory(time, *(values[:, :, k] for k in range(5)), contacts, np.full(len(rows), np.nan), bonds)


def _run_liggghts(probes: list[Probe], folder: Path):
    (probe,) = probes
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "parameters.in").write_text(parameter_deck(probe.scenario, seed=1))
    (folder / "case.in").write_text(_liggghts_case(probe))
    if probe.clumps:
        write_bed(folder / "bed.csv", [clump.position + clump.quaternion for clump in probe.clumps])
        (folder / "motions.in").write_text(
            "".join(
                f"fix_modify probe motion {n} {_list(clump.velocity + clump.spin)}\n"
                for n, clump in enumerate(probe.clumps, start=1)
            )
        )
    deck = "liggghts/verify_clumps.in" if probe.clumps else "liggghts/verify_balls.in"
    try:
        call_engine([str(LIGGGHTS.host), "-in", deck, "-log", "none", "-var", "run", str(folder.resolve())], folder)
    except EngineFailure as error:
        return {}, {probe.name: str(error)}
    spheres = len(probe.balls) + 2 * len(probe.clumps)
    rows = np.fromfile(folder / "rows.bin")
    if len(rows) % (3 + 15 * spheres):
        return {}, {probe.name: f"{folder}/rows.bin: is not whole; free disk space and try again"}
    rows = rows.reshape(-1, 3 + 15 * spheres)
    values = rows[:, 3:].reshape(len(rows), spheres, 5, 3)
    time = np.arange(len(rows)) * probe.every * probe.step
    return {probe.name: Trajectory(time, *(values[:, :, k] for k in range(5)), *rows[:, :3].T)}, {}


RUNNERS = {"yade": (_run_yade, True), "liggghts": (_run_liggghts, False)}
"""How probes are run in each engine, and whether many of them in one process."""


def _list(values) -> str:
    return " ".join(repr(float(v)) for v in values)


def _liggghts_case(probe: Probe) -> str:
    """The case as LIGGGHTS variables; those of balls and path segments are lists that the deck walks through."""
    values = {
        "step": repr(float(probe.step)),
        "steps": probe.steps,
        "every": probe.every,
        "wall": WALLS.index(probe.wall),
        "block": f'"{_list(end for half in BLOCK_M for end in (-half, half))}"',
        "gravity": repr(float(probe.gravity)),
    }
    if probe.balls:
        balls = probe.balls
        free = [not ball.held and not (probe.path and ball is balls[0]) for ball in balls]
        moves = [[component * steps * probe.step for component in velocity] for velocity, steps in probe.path]
        places = [ball.position for ball in balls] + list(balls[0].position + np.cumsum(moves or [[0.0] * 3], axis=0))
        reach = max(abs(c) for place in places for c in place) + 2 * max(ball.radius for ball in balls)
        if probe.gravity == 0:  # how far balls can fly: a struck light one at twice the speed, or by its spin
            fastest = max(2 * np.linalg.norm(b.velocity) + b.radius * np.linalg.norm(b.spin) for b in balls)
            reach += float(fastest) * probe.step * probe.steps
        values["reach"] = repr(float(1.01 * reach))
        values["any_free"], values["driven"] = int(any(free)), int(bool(probe.path))
        values["ball"] = " ".join(str(n) for n in range(1, len(balls) + 1))
        values["ball_place"] = " ".join(f'"{_list(ball.position)}"' for ball in balls)
        values["ball_diameter"], values["ball_mass"] = _list(2 * b.radius for b in balls), _list(b.mass for b in balls)
        for k, axis in enumerate("xyz"):
            values[f"ball_v{axis}"] = _list(ball.velocity[k] for ball in balls)
            values[f"ball_w{axis}"] = _list(ball.spin[k] for ball in balls)
            if probe.path:
                values[f"path_v{axis}"] = _list(velocity[k] for velocity, _ in probe.path)
                spins = probe.spins or (balls[0].spin,) * len(probe.path)
                values[f"path_w{axis}"] = _list(spin[k] for spin in spins)
        values["ball_free"] = " ".join(str(int(f)) for f in free)
        if probe.path:
            values["path_steps"] = " ".join(str(steps) for _, steps in probe.path)
    return "".join(f"variable {name} index {value}\n" for name, value in values.items())


def _limit_processor_time() -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (TIME_LIMIT_S, TIME_LIMIT_S + 10))


def call_engine(command: list[str], folder: Path) -> None:
    """Run an engine in the repository's root, its words going to `folder`/engine.log; EngineFailure if it fails."""
    log, name = folder / "engine.log", Path(command[0]).name
    with open(log, "a") as out:
        try:
            status = subprocess.run(
                command,
                cwd=ROOT,
                stdout=out,
                stderr=subprocess.STDOUT,
                env=ENVIRONMENT | os.environ,
                stdin=subprocess.DEVNULL,
                timeout=PATIENCE_S,
                preexec_fn=_limit_processor_time,
            ).returncode
        except subprocess.TimeoutExpired:
            raise EngineFailure(f"{name}: no end after {PATIENCE_S} s") from None
    if status == -signal.SIGXCPU:
        raise EngineFailure(f"{name}: no end after {TIME_LIMIT_S} s of processor time")
    if status:
        errors = [line for line in log.read_text(errors="replace").splitlines() if "ERROR" in line]
        raise EngineFailure(f"{name}: exit code {status}: {errors[0] if errors else 'no line with ERROR; see --keep'}")
