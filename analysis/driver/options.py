"""Arguments that say which run is meant, the same for every command."""

from __future__ import annotations

import argparse
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver.engines import CODES
from analysis.driver.folder import run_folder
from analysis.driver.settings import RESULTS, RunSettings
from analysis.scenarios.scenario import SCENARIO_FILE, join_id, load_scenario, split_id, split_variants


def whole(text: str) -> int:
    """A whole number above 0, of any sensible size."""
    if not text.isdecimal() or len(text) > 9 or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text[:20]!r} is not a whole number above 0")
    return int(text)


def path(text: str) -> Path:
    """An absolute path. A path with a line break or a zero byte is a mistake."""
    if not text or min(text) < " ":
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is no path")
    return Path(text).resolve()


def add_identity(parser: Parser) -> None:
    """Scenario, variants, code, profile, seed and results: what names a run's folder."""
    parser.add_argument("scenario", help="name of a scenario in the scenario file; NAME+VARIANT adds a variant")
    parser.add_argument("--variant", default="", help="variants laid over the scenario, e.g. servo or servo,same-bed")
    parser.add_argument("--code", choices=CODES, required=True, help="engine")
    parser.add_argument("--profile", default="demo", help="size of the bed: demo (default) or full")
    parser.add_argument("--seed", type=whole, default=1, help="seed of the clumps' orientations (default 1)")
    parser.add_argument("--results", type=path, default=RESULTS, help="folder of all results")


def add_run(parser: Parser) -> None:
    """The same, and what else makes a run what it is."""
    add_identity(parser)
    parser.add_argument(
        "--cycles", type=whole, help="number of cycles, instead of loading.cycles; a larger one extends a finished run"
    )
    parser.add_argument("--bed", type=path, help="bed file of a packed bed to start from, instead of packing")
    parser.add_argument("--ranks", type=whole, default=1, help="MPI ranks of LIGGGHTS or threads of YADE (default 1)")
    parser.add_argument(
        "--scenarios", type=path, default=SCENARIO_FILE, help="scenario file, instead of scenarios.toml"
    )


def settings(chosen: argparse.Namespace, **more) -> RunSettings:
    """The run that the arguments of `add_run` mean. Raises ScenarioError."""
    return RunSettings(
        scenario=load_scenario(chosen.scenario, chosen.profile, chosen.scenarios, chosen.cycles, chosen.variant),
        **{name: getattr(chosen, name) for name in ("code", "seed", "ranks", "bed", "results", "scenarios", "cycles")},
        **more,
    )


def folder(chosen: argparse.Namespace, results: Path | None = None) -> Path:
    """Folder, below `results` or those of the arguments, of the run that the arguments of `add_identity` mean."""
    name, variants = split_id(chosen.scenario)
    identity = join_id(name, (*variants, *split_variants(chosen.variant)))
    return run_folder(results or chosen.results, chosen.profile, identity, chosen.code, chosen.seed)
