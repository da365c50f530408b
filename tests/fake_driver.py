"""`ballast run` with the fake engine in place of the real ones."""

import sys
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import run
from analysis.driver.engine import write_common_inputs
from analysis.formats.run_record import STAGES

PROGRAM = Path(__file__).resolve().parent / "fake_engine.py"


class FakeEngine:
    """An engine that computes nothing worth the time, see fake_engine.py."""

    checkpoint_suffix = "yade.gz"
    stages = STAGES

    def __init__(self, name):
        self.name = name

    def version(self):
        return "fake 1"

    def refuses(self, folder, ranks):
        return None

    def parallel(self, ranks):
        return {"ranks": ranks, "threads": 1}

    def write_inputs(self, scenario, folder, seed):
        write_common_inputs(scenario, folder, seed)

    def command(self, stage, folder, checkpoint=None, ranks=1):
        return [sys.executable, str(PROGRAM), stage, *map(str, filter(None, (folder, checkpoint)))]


if __name__ == "__main__":
    parser = Parser()
    run.add_arguments(parser)
    sys.exit(run.execute(parser.parse_args(), {name: FakeEngine(name) for name in ("yade", "liggghts")}))
