"""`ballast prepare`: a run's folder, ready for its decks or scripts to be started by hand."""

from __future__ import annotations

import argparse
import shlex
import sys

from analysis.arguments import Parser
from analysis.driver import bed_source, options, refusal
from analysis.driver.engine import Engine
from analysis.driver.engines import ENGINES
from analysis.driver.folder import STAGES
from analysis.driver.locks import Busy, hold
from analysis.driver.run import engine_command, unusable
from analysis.driver.settings import RunSettings
from analysis.driver.supervise import RunError
from analysis.formats.errors import InputError
from analysis.scenarios.scenario import ScenarioError


def prepare(settings: RunSettings, engine: Engine) -> str:
    """Write a run's folder without starting anything; return the commands of its three stages, one a line.

    Raises RunError where the folder has results of other parameters or a loaded bed, which stages started by hand would
    write over, is in use, or cannot be used by the engine.
    """
    refusal.refuse_changes(settings)
    if refusal.is_loaded(settings):
        raise RunError(f"{settings.folder} has cycles or a preloaded bed already; {refusal.START_OVER}")
    refusal.refuse_place(settings, engine)
    first, source = settings.folder / "checkpoints" / f"cyclic_000000.{engine.checkpoint_suffix}", settings.bed
    if not source and settings.scenario["packing.bed_from"]:
        source = settings.of_the_bed().folder / "raw" / "bed_packed.csv"
    try:
        with hold(settings.folder / "run.lock"):
            engine.write_inputs(settings.scenario, settings.folder, settings.seed)
            if source and not (settings.folder / "raw" / "bed_packed.csv").exists():
                bed_source.take(source, settings)
    except Busy:
        raise RunError(f"{settings.title} | in progress; `make status` shows it") from None
    stages = STAGES[1:] if source else STAGES
    commands = [engine_command(engine, stage, settings, first if stage == "cyclic" else None) for stage in stages]
    return "".join(f"{shlex.join(words)}\n" for words in commands)


def add_arguments(parser: Parser) -> None:
    """Arguments of `ballast prepare`."""
    options.add_run(parser)


def execute(chosen: argparse.Namespace) -> int:
    """Write the folder, print the commands."""
    try:
        settings = options.settings(chosen)
        commands = prepare(settings, ENGINES[settings.code])
    except (RunError, InputError, ScenarioError) as error:
        print(error, file=sys.stderr)
        return 1
    except OSError as error:
        print(unusable(error), file=sys.stderr)
        return 1
    print(f"# {settings.folder} is ready; in the top folder of the repository, start one after the other:")
    print(commands, end="")
    return 0
