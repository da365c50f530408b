"""Where the time of an engine goes: its functions, sampled by Linux `perf` while the bed is loaded, summed up by part.

A part is told by the name of the function, the first pattern that fits. What an engine's compiler inlined counts for
the function that it was inlined into.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections import defaultdict
from pathlib import Path

from analysis.driver.bench.cases import TimedCase
from analysis.driver.bench.meter import last_step
from analysis.driver.engine import EngineError
from analysis.driver.process import EngineProcess, descendants

SAMPLES_PER_S = 1999
SAMPLED_S = 2.0
"""A cycle of LIGGGHTS takes four seconds, and no more than one is simulated."""
POLL_S = 0.2
OTHER = "other"
UNNAMED = "functions without a name, in libraries stripped of symbols"

PARTS = {
    "liggghts": (
        ("contacts between particles", r"PairBallast|advance_|find_touching|PairGran|ContactModel"),
        ("walls, sleeper and plates", r"FixWall|FixLoad|LoadControl"),
        ("motion of clumps", r"[Mm]ultisphere|kick|apply|rotate|FixGravity"),
        ("neighbour lists", r"Neighbor|NeighList|bin_|CommBrick|Comm::|Atom|exchange"),
        ("output", r"FixHistory|FixState|FixStage|write_|vfprintf|Dump"),
        ("MPI", r"MPI|ompi|opal|mca_"),
    ),
    "yade": (
        ("contacts between particles and with walls", r"Law2|Ig2|Ip2|IGeom|IPhys|InteractionLoop|Gem?om|ScGeom"),
        ("collider", r"Collider|Bo1|insertion|Bound|Aabb"),
        ("motion of clumps", r"Newton|Clump|ForceResetter|ForceContainer|leapfrog"),
        ("Python", r"^_?Py|_PyEval|python|boost::python"),
        ("OpenMP", r"GOMP|gomp|omp"),
    ),
}
KERNEL = re.compile(r"^\[k\]")
LINE = re.compile(r"^\s*([\d.]+)%\s+(\[.\]\s+\S.*?)\s*$")


def is_there() -> bool:
    """Whether this machine has `perf`."""
    return shutil.which("perf") is not None


def sample(case: TimedCase) -> list[tuple]:
    """Rows of benchmark_profile.csv of one engine and law: parts and their shares, which add up to 1.

    Raises EngineError where the engine ends or perf may not sample.
    """
    rows, data = case.folder / "raw" / "cyclic.csv", case.folder / "perf.data"
    rows.unlink(missing_ok=True)
    (case.folder / "raw" / "state.csv").unlink(missing_ok=True)
    engine = EngineProcess(case.argv(), case.folder / "log" / "profile.log", 1)
    try:
        while not last_step(rows):
            if engine.wait(POLL_S) is not None:
                raise EngineError(f"{case.folder.name}: ended before it was sampled; read {case.folder}/log")
        record(data, (engine.pid, *descendants(engine.pid)))
    finally:
        engine.kill()
    shares = shares_of(report(data), case.code)
    return [(case.code, case.law, part, round(share, 4)) for part, share in shares.items()]


def record(data: Path, pids: tuple[int, ...]) -> None:
    """Sample processes for SAMPLED_S seconds."""
    done = subprocess.run(
        ["perf", "record", "-q", "-F", str(SAMPLES_PER_S), "-o", str(data), "-p", ",".join(map(str, pids)), "--"]
        + ["sleep", str(SAMPLED_S)],
        capture_output=True,
        text=True,
    )
    if done.returncode or not data.exists():
        said = (done.stderr.strip() or "no samples").splitlines()[-1]
        raise EngineError(f"perf: {said}; as root, or with kernel.perf_event_paranoid at most 2")


def report(data: Path) -> str:
    """Functions and their shares, as perf prints them."""
    argv = [
        "perf",
        "report",
        "-i",
        str(data),
        "--stdio",
        "-q",
        "-g",
        "none",
        "-F",
        "overhead,sym",
        "--percent-limit",
        "0",
    ]
    return subprocess.run(argv, capture_output=True, text=True, check=True).stdout


def shares_of(printed: str, code: str) -> dict[str, float]:
    """Share of each part, largest first; what the kernel does counts as other."""
    found = defaultdict(float)
    for line in filter(None, map(LINE.match, printed.splitlines())):
        found[part_of(line[2], code)] += float(line[1])
    whole = sum(found.values())
    if not whole:
        raise EngineError("perf: no function was sampled")
    return {part: share / whole for part, share in sorted(found.items(), key=lambda item: -item[1])}


def part_of(symbol: str, code: str) -> str:
    """The part that a function belongs to."""
    if KERNEL.match(symbol):
        return OTHER
    name = symbol.partition("]")[2].strip()
    if name.startswith("0x"):
        return UNNAMED
    return next((part for part, pattern in PARTS[code] if re.search(pattern, name)), OTHER)
