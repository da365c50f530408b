"""`make keep`: a run's normalised results into the repository, whole or not at all."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import record
from analysis.driver.delete import add_identity, folder_of
from analysis.driver.run import cycles_asked, cycles_done
from analysis.driver.status import state_of
from analysis.files import ROOT, sync

KEPT = ROOT / "reference_data" / "runs"
NEEDED = ("run.json", "scenario.json", "stages.json")
FILES = (*NEEDED, "cycles.csv", "microstructure.csv")


class KeepError(ValueError):
    """A run that cannot be kept; the message is one line with the remedy."""


def keep(folder: Path, target: Path, failed: bool = False) -> str:
    """Copy the normalised files of the run in `folder` to `target`, in place of what was kept there; say what they are.

    Raises KeepError for a run that is not there, is running, lacks files or (unless `failed`) has failed, and OSError
    where a file cannot be copied; `target` is then as it was.
    """
    body = record.read(folder)
    if body is None:
        raise KeepError(f"{folder}: no run.json that can be read; run the scenario first")
    state, reason = state_of(folder, body)
    if state == "running":
        raise KeepError(f"{folder}: is running; stop it, or wait for its end")
    if state == "failed" and not failed:
        raise KeepError(f"{folder}: has failed ({reason}); --failed keeps it all the same")
    for name in NEEDED:
        if not (folder / name).is_file():
            raise KeepError(f"{folder}/{name}: is missing; what is left is no complete result: run the scenario again")
    new, old = (target.with_name(f".{target.name}.{word}") for word in ("new", "old"))
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(new, ignore_errors=True)
    try:
        new.mkdir()
        for name in FILES:
            if (folder / name).exists():
                shutil.copyfile(folder / name, new / name)
                sync(new / name)
    except OSError:
        shutil.rmtree(new, ignore_errors=True)
        raise
    shutil.rmtree(old, ignore_errors=True)
    if target.exists():
        target.rename(old)
    new.rename(target)
    shutil.rmtree(old, ignore_errors=True)
    return f"{state}, {cycles_done(target)} of {cycles_asked(target)} cycles" + (f" ({reason})" if reason else "")


def main(argv: list[str]) -> int:
    """Command line of `make keep`."""
    parser = Parser(prog="python -m analysis keep", description="Put a run's normalised results into the repository.")
    add_identity(parser)
    parser.add_argument("--failed", action="store_true", help="keep a run that failed, too")
    parser.add_argument("--out", type=Path, default=KEPT, help="folder of all kept runs")
    options = parser.parse_args(argv)
    folder, target = (folder_of(options, base) for base in (options.results, options.out))
    try:
        what = keep(folder, target, options.failed)
    except KeepError as error:
        print(f"keep: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"keep: {error.filename}: {error.strerror}; nothing was kept, mend that and try again", file=sys.stderr)
        return 1
    print(f"kept in {record.relative(target)}: {what}; git add and commit it")
    return 0
