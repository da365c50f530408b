"""Command line: `ballast COMMAND ...`, or `python -m analysis COMMAND ...`; the Makefile calls nothing else."""

from __future__ import annotations

import importlib
import os
import signal
import sys
from collections.abc import Callable

from analysis.arguments import Parser
from analysis.formats.errors import InputError, reason

COMMANDS = {  # name: module, purpose
    "run": ("driver.run", "simulate one scenario in one code, or resume it"),
    "prepare": ("driver.prepare", "write a run's folder and print the commands of its stages"),
    "study": ("driver.study", "list the runs of the study, or make one of them"),
    "status": ("driver.status", "list all runs: stage, cycle, speed, time left, tracking error, state"),
    "keep": ("driver.keep", "copy the normalised results of a run into the repository"),
    "unload": ("driver.unload", "measure on a copy how much of a run's settlement springs back"),
    "delete": ("driver.delete", "delete one run, after a question"),
    "report": ("report.build", "build the report from the runs that exist"),
    "findings": ("report.export", "write the findings as CSV tables"),
    "readme": ("report.readme", "write the README's results and hours, from the kept runs"),
    "docs": ("docs.write", "write docs/ and PARAMETERS.md from the scenario file and the code"),
    "verify": ("verification.verify_command", "compare contact laws and clumps of both codes with closed forms"),
    "impact": ("verification.impact", "simulate an impact of two bodies in both codes"),
    "mutations": (
        "verification.mutations",
        "put wrong laws into the codes and list which verification cases notice them",
    ),
    "reference": ("reference.check", "check the reference curves and list what is pending"),
    "view": ("report.pictures.view", "draw pictures of a bed and write files for ParaView"),
    "calibrate": ("driver.calibrate", "measure clumps, porosity and settlement over lattice gaps and clump aspects"),
    "timestep": ("driver.timestep", "make runs at several time steps and a table of them"),
    "bench": ("driver.bench.command", "measure steps per second of processor time: ours and stock, both codes"),
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
    except OSError as error:  # no right, no room, a disk that is gone
        place = error.filename or "a file"
        print(f"{place}: {reason(error)}; see to it, then give the same command again", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        return 128 + signal.SIGINT


if __name__ == "__main__":
    sys.exit(main())
