"""`make keep`: a run's normalised results into the repository, whole or not at all."""

from __future__ import annotations

import argparse
import gzip
import shutil
import sys
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import options
from analysis.driver.folder import cycles_asked, cycles_done
from analysis.driver.settings import relative
from analysis.driver.status import state_of
from analysis.files import KEPT_RUNS, sync, write_aside, write_csv
from analysis.formats.numbers import short
from analysis.formats.run_record import RunRecord
from analysis.normalised.readers import Run
from analysis.scenarios import study_list

NEEDED = ("run.json", "scenario.json", "stages.json")
FILES = (*NEEDED, "cycles.csv", "microstructure.csv", "unload.csv", "bonds.csv", "bonds_broken.csv")


class KeepError(ValueError):
    """A run that cannot be kept; the message is one line with the remedy."""


def keep(folder: Path, target: Path, failed: bool = False) -> str:
    """Copy the normalised files of the run in `folder` to `target`, in place of what was kept there; say what they are.

    Raises KeepError for a run that is not there, is running, lacks files or (unless `failed`) has failed, InputError
    where run.json or cycles.csv is damaged, and OSError where a file cannot be copied; `target` is then as it was.
    """
    try:
        body = RunRecord.read(folder)
    except FileNotFoundError:
        raise KeepError(f"{folder}: there is no run.json; run the scenario first") from None
    state, reason = state_of(folder, body.state, body.reason)
    if state == "running":
        raise KeepError(f"{folder}: is running; stop it, or wait for its end")
    if state == "failed" and not failed:
        raise KeepError(f"{folder}: has failed ({reason}); --failed keeps it all the same")
    for name in NEEDED:
        if not (folder / name).is_file():
            raise KeepError(f"{folder}/{name}: is missing; what is left is no complete result: run the scenario again")
    what = f"{state}, {cycles_done(folder)} of {cycles_asked(folder)} cycles" + (f" ({reason})" if reason else "")
    new, old = (target.with_name(f".{target.name}.{word}") for word in ("new", "old"))
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(new, ignore_errors=True)
    try:
        new.mkdir()
        for name in FILES:
            if (folder / name).exists():
                shutil.copyfile(folder / name, new / name)
                sync(new / name)
        keep_of_history(folder, new)
    except OSError:
        shutil.rmtree(new, ignore_errors=True)
        raise
    shutil.rmtree(old, ignore_errors=True)
    if target.exists():
        target.rename(old)
    new.rename(target)
    shutil.rmtree(old, ignore_errors=True)
    return what


def keep_of_history(folder: Path, target: Path) -> None:
    """Write the first harmonics, the stress on the plates and two cycles of history.csv, which is too large to be kept
    itself; nothing without it.
    """
    if (folder / "history.csv").exists():
        run = Run(folder, quiet=True)
        derived = {"harmonics.csv": run.harmonics, "loops.csv": run.loops, "plates.csv": run.plate_stresses}
        for name, table in derived.items():
            write_csv(target / name, [list(table.columns), *(map(short, row) for row in table.to_numpy())])


def keep_bed(folder: Path, beds: Path) -> Path | None:
    """Compress the bed that the run in `folder` packed itself into `beds`, for others to start from; None where it took
    another's, or where the run is not the one whose bed all scenarios of its code and seed share.
    """
    body = RunRecord.read(folder)
    packed = folder / "raw" / "bed_packed.csv"
    shared = body.bed == "own" and not body.variant and body.scenario == study_list.key_scenarios()[0]
    if not shared or body.profile != study_list.profile() or not packed.is_file():
        return None
    target = beds / f"{body.code}-seed{body.seed}.csv.gz"
    if not target.exists() or gzip.decompress(target.read_bytes()) != packed.read_bytes():
        beds.mkdir(parents=True, exist_ok=True)
        write_aside(target, gzip.compress(packed.read_bytes(), 9, mtime=0))
    return target


def add_arguments(parser: Parser) -> None:
    """Arguments of `ballast keep`."""
    options.add_identity(parser)
    parser.add_argument("--failed", action="store_true", help="keep a run that failed, too")
    parser.add_argument("--out", type=options.path, default=KEPT_RUNS, help="folder of all kept runs")


def execute(chosen: argparse.Namespace) -> int:
    """`ballast keep`."""
    target = options.folder(chosen, chosen.out)
    try:
        what = keep(options.folder(chosen), target, chosen.failed)
        bed = keep_bed(options.folder(chosen), chosen.out / "beds")
    except ValueError as error:  # KeepError and InputError
        print(f"keep: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"keep: {error.filename}: {error.strerror}; nothing was kept, mend that and try again", file=sys.stderr)
        return 1
    beside = f", its packed bed in {relative(bed)}" if bed else ""
    print(f"kept in {relative(target)}{beside}: {what}; git add and commit it")
    return 0
