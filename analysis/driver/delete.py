"""`make distclean-run`: delete one run, after asking."""

from __future__ import annotations

import argparse
import contextlib
import shutil
import sys

from analysis.arguments import Parser
from analysis.driver import options
from analysis.driver.locks import Busy, hold


def add_arguments(parser: Parser) -> None:
    """Arguments of `ballast delete`."""
    options.add_identity(parser)


def execute(chosen: argparse.Namespace) -> int:
    """`ballast delete`."""
    folder = options.folder(chosen)
    if not folder.is_dir():
        print(f"delete: {folder}: there is no such run", file=sys.stderr)
        return 1
    print(f"Delete {folder} and all that is in it? Type yes: ", end="", flush=True)
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
