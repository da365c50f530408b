"""Command line: `ballast COMMAND ...`, or `python -m analysis COMMAND ...`; the Makefile calls nothing else."""

from __future__ import annotations

import importlib
import os
import signal
import sys
from collections.abc import Callable

from analysis.arguments import Parser
from analysis.formats.errors import InputError

COMMANDS = {  # name: module, purpose
    "run": ("driver.run", "simulate one scenario in one code, or go on with it"),
    "prepare": ("driver.prepare", "write a run's folder and print the commands that its stages are started with"),
    "study": ("driver.study", "the list of the study's runs, or one of them"),
    "status": ("driver.status", "list all runs"),
    "keep": ("driver.keep", "put a run's normalised results into the repository"),
    "unload": ("driver.unload", "how much of a run's settlement springs back, measured on a copy"),
    "delete": ("driver.delete", "delete one run, after asking"),
    "report": ("report.build", "rebuild the report from the runs that exist"),
    "findings": ("report.export", "what the runs say, as CSV tables"),
    "readme": ("report.readme", "write the README's results and hours, from the kept runs"),
    "docs": ("docs.write", "what docs/ and PARAMETERS.md say of the code: sketch, tables, glossary"),
    "verify": ("verification.verify", "contact laws and clumps of both codes against closed forms"),
    "impact": ("verification.impact", "any impact of two bodies in both codes"),
    "mutations": ("verification.mutations", "wrong laws that the verification must notice"),
    "reference": ("reference.check", "the reference curves and their state"),
    "view": ("report.pictures.view", "pictures of a bed, and files for ParaView"),
    "calibrate": ("driver.calibrate", "clumps, porosity and settlement over lattice gaps and clump aspects"),
    "timestep": ("driver.timestep", "how large the time step may be: runs at several, and a table of them"),
    "bench": ("driver.bench.command", "steps per second of processor time: ours, stock, both codes"),
}


def main(argv: list[str] | None = None) -> int:
    """One parser with a sub-command for each module, of which only the chosen one is imported, to start quickly."""
    argv = sys.argv[1:] if argv is None else argv
    os.environ.pop("MPLBACKEND", None)  # a notebook's: figures are files, and an unknown one ends matplotlib's import
    parser = Parser(prog="ballast", description="Ballast under cyclic load, in YADE and LIGGGHTS.")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True, title="commands")
    chosen = next((word for word in argv if not word.startswith("-")), None)
    for name, (path, purpose) in COMMANDS.items():
        command = commands.add_parser(name, help=purpose, description=purpose[0].upper() + purpose[1:] + ".")
        if name == chosen:
            module = importlib.import_module(f"analysis.{path}")
            if not hasattr(module, "add_arguments"):
                return _ended(module.main, argv[argv.index(name) + 1 :])
            module.add_arguments(command)
    options = parser.parse_args(argv)
    return _ended(module.execute, options)


def _ended(work: Callable[[object], int | None], options: object) -> int:
    try:
        code = work(options) or 0
        sys.stdout.flush()
        return code
    except InputError as error:  # a damaged file that the command needs
        print(error, file=sys.stderr)
        return 1
    except BrokenPipeError:  # `| head` has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 128 + signal.SIGPIPE


if __name__ == "__main__":
    sys.exit(main())
