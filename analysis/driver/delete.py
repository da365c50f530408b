"""`make distclean-run`: delete one run, after asking."""

from __future__ import annotations

import argparse
import contextlib
import shutil
import sys
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver.engines import CODES
from analysis.driver.locks import Busy, hold
from analysis.driver.run import cycles_done, run_folder
from analysis.files import ROOT
from analysis.scenarios.scenario import join_id, split_id, split_variants


def add_identity(parser: Parser) -> None:
    """Arguments that say which run is meant."""
    parser.add_argument("scenario", help="a scenario that was run")
    parser.add_argument("--variant", default="", help="its variants, e.g. servo or servo,same-bed")
    parser.add_argument("--code", choices=CODES, required=True)
    parser.add_argument("--profile", default="demo", help="demo (default) or full")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--results", type=Path, default=ROOT / "results", help="folder of all results")


def folder_of(options: argparse.Namespace, base: Path) -> Path:
    """Folder below `base` of the run that the arguments mean."""
    name, variants = split_id(options.scenario)
    identity = join_id(name, (*variants, *split_variants(options.variant)))
    return run_folder(base, options.profile, identity, options.code, options.seed)


def main(argv: list[str]) -> int:
    """Command line of `make distclean-run`."""
    parser = Parser(prog="python -m analysis delete", description="Delete one run, after asking.")
    add_identity(parser)
    options = parser.parse_args(argv)
    folder = folder_of(options, options.results)
    if not folder.is_dir():
        print(f"delete: {folder}: there is no such run", file=sys.stderr)
        return 1
    print(f"Delete {folder} with its {cycles_done(folder)} cycles? Type yes: ", end="", flush=True)
    if sys.stdin.readline().strip() != "yes":
        print("nothing was deleted")
        return 1
    try:
        with hold(folder / "run.lock"), hold(folder / "packing.lock"):
            shutil.rmtree(folder)
    except Busy:
        print(f"delete: {folder}: is running; stop it first", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"delete: {error.filename}: {error.strerror}; some of the run may be left", file=sys.stderr)
        return 1
    with contextlib.suppress(OSError):
        folder.parent.rmdir()
    return 0
