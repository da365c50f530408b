"""The driver with the fake engine in place of the real ones; arguments as for `python -m analysis run`."""

import sys
from pathlib import Path

from analysis.driver import run

FAKE = Path(__file__).resolve().parent / "fake_engine.py"


def command(code, stage, folder, checkpoint=None, ranks=1):
    """Command line of the fake engine."""
    return [sys.executable, str(FAKE), stage, str(folder), *([str(checkpoint)] if checkpoint else [])]


run.command, run.versions = command, lambda code: "fake 1"
sys.exit(run.main(sys.argv[1:]))
