"""YADE as an engine: Debian's package, driven by the scripts in yade/."""

from __future__ import annotations

import functools
import shutil
import subprocess
from pathlib import Path

from analysis.driver.engine import EngineError, package_version, write_common_inputs
from analysis.files import ROOT
from analysis.formats.run_record import STAGES
from analysis.scenarios.scenario import Scenario

LAUNCHER = ROOT / "yade" / "launch.sh"  # `yade` on faster memory


class Yade:
    """The engine YADE."""

    name = "yade"
    checkpoint_suffix = "yade.gz"
    stages = STAGES

    def version(self) -> str:
        return f"yade {_version()}"

    def refuses(self, folder: Path, ranks: int) -> str | None:
        return None

    def parallel(self, ranks: int) -> dict[str, int]:
        return {"ranks": 1, "threads": ranks}

    def write_inputs(self, scenario: Scenario, folder: Path, seed: int) -> None:
        write_common_inputs(scenario, folder, seed)

    def command(self, stage: str, folder: Path, checkpoint: Path | None = None, ranks: int = 1) -> list[str]:
        script = f"yade/{stage}.py"
        return [str(LAUNCHER), f"-j{ranks}", "-n", "-x", script, *map(str, filter(None, (folder, checkpoint)))]


@functools.cache
def _version() -> str:
    if not shutil.which("yade"):
        raise EngineError("yade: not installed; run `make setup`")
    if version := package_version("yade"):
        return version
    done = subprocess.run(["yade", "--version"], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    words = done.stdout.split()  # "Yade version: 2023.02a, ..."
    return words[2].rstrip(",") if len(words) > 2 else "of unknown version"
