"""Command line: `python -m analysis COMMAND ...`; the Makefile calls nothing else."""

from __future__ import annotations

import importlib
import os
import signal
import sys

COMMANDS = {  # name: module, purpose
    "run": ("driver.run", "simulate one scenario in one code, or go on with it"),
    "study": ("driver.study", "the list of the study's runs, or one of them"),
    "status": ("driver.status", "list all runs"),
    "keep": ("driver.keep", "put a run's normalised results into the repository"),
    "delete": ("driver.delete", "delete one run, after asking"),
    "report": ("report.build", "rebuild the report from the runs that exist"),
    "findings": ("report.export", "what the runs say, as CSV tables"),
    "verify": ("verification.verify", "contact laws and clumps of both codes against closed forms"),
    "impact": ("verification.impact", "any impact of two bodies in both codes"),
    "mutations": ("verification.mutations", "wrong laws that the verification must notice"),
    "reference": ("reference.check", "the reference curves and their state"),
    "view": ("report.pictures.view", "pictures of a bed, and files for ParaView"),
    "calibrate": ("driver.calibrate", "clumps, porosity and settlement over lattice gaps and clump aspects"),
    "bench": ("driver.bench", "steps per second of both codes"),
}


def main(argv: list[str]) -> int:
    """Hand the arguments to the module of the command, imported only now so that each stays quick to start."""
    if not argv or argv[0] not in COMMANDS:
        unknown = argv and argv[0] not in ("-h", "--help")
        print(
            "usage: python -m analysis COMMAND ... (each has --help)\n\n"
            + "\n".join(f"  {name:10} {purpose}" for name, (_, purpose) in COMMANDS.items()),
            file=sys.stderr if unknown else sys.stdout,
        )
        return 2 if unknown else 0
    module, _ = COMMANDS[argv[0]]
    try:
        return importlib.import_module(f"analysis.{module}").main(argv[1:]) or 0
    except BrokenPipeError:  # `| head` has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 128 + signal.SIGPIPE


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
