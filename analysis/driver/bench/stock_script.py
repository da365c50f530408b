"""The stock YADE script (yade/stock.py), which times itself."""

from __future__ import annotations

import os
import re
import subprocess

from analysis.driver.bench.meter import Speed
from analysis.driver.engine import EngineError
from analysis.files import ROOT

SCRIPT = "yade/stock.py"
STEPS = 400
PRINTS = re.compile(r"(\d+) steps, ([\d.]+) s of processor time")


class StockScript:
    """YADE with its own contact laws and without a servo."""

    def prepare(self, case) -> None:
        """Nothing: the script reads the packed bed."""

    def argv(self, case) -> list[str]:
        """The command that is timed."""
        return ["yade", f"-j{case.ranks}", "-n", "-x", SCRIPT, str(case.folder), str(case.packed), str(STEPS)]

    def time(self, case) -> Speed:
        """What the script prints; the time by the clock is not known. Raises EngineError where it prints nothing."""
        modules = os.environ | {"PYTHONPATH": str(ROOT)}
        done = subprocess.run(self.argv(case), cwd=ROOT, env=modules, capture_output=True, text=True)
        found = PRINTS.search(done.stdout)
        if done.returncode or not found:
            raise EngineError(f"{SCRIPT}: {(done.stdout + done.stderr).strip().splitlines()[-1]}")
        return Speed(int(found[1]), float(found[2]), float("nan"))
