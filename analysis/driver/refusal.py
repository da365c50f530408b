"""What stops a run before it starts: results of other parameters, or that would be lost; a place no engine can use.

Where results exist, nothing but an explicit command deletes them.
"""

from __future__ import annotations

from analysis.driver import checkpoints
from analysis.driver.engine import Engine
from analysis.driver.folder import NORMALISED, cycles_done
from analysis.driver.record import stored_record
from analysis.driver.settings import RunSettings
from analysis.driver.supervise import RunError
from analysis.files import ROOT
from analysis.scenarios.scenario import Scenario, ScenarioError

START_OVER = "give another SEED or RESULTS, move the folder away, or delete it with `make distclean-run`"
REDO = "restore what is missing, or give REDO=yes to compute them again"


def stored_scenario(settings: RunSettings) -> Scenario | None:
    """The scenario that the folder's results were made with; None without one. RunError where it cannot be read."""
    path = settings.folder / "scenario.json"
    if not path.exists():
        return None
    try:
        return Scenario.read(path)
    except ScenarioError as error:
        raise RunError(f"{settings.folder}/{error}; else {START_OVER}") from None


def refuse_place(settings: RunSettings, engine: Engine) -> None:
    """RunError where the engine cannot work in the run's folder, before anything is started."""
    if reason := engine.refuses(path_for_engine(settings.folder), settings.ranks):
        raise RunError(f"{settings.title} | {reason}")


def refuse_step(settings: RunSettings) -> None:
    """RunError where the step is too near to the critical one of the preloaded bed, which stages.json tells."""
    from analysis.normalised.critical_step import LARGEST_SHARE  # here: their libraries take a second to load
    from analysis.normalised.stages import read_stages

    preload = read_stages(settings.folder).get("preload", {})
    if (share := preload.get("step_share", 0.0)) > LARGEST_SHARE:
        raise RunError(
            f"the step is {share:.2f} of the critical one of this bed, {preload['critical_step_s']:.3g} s; at most "
            f"{LARGEST_SHARE:g} is allowed: choose a smaller time.verified_step or time.factor"
        )


def path_for_engine(path):
    """A path as the engine gets it: relative to the repository, where it starts, if it is inside."""
    return path.relative_to(ROOT) if path.is_relative_to(ROOT) else path


def has_results(settings: RunSettings) -> bool:
    """True once something was loaded, or packed: what a run of other parameters must leave alone."""
    folder = settings.folder
    return (folder / "raw" / "bed_packed.csv").exists() or is_loaded(settings)


def is_loaded(settings: RunSettings) -> bool:
    """True once there is a checkpoint or a cycle."""
    folder = settings.folder
    return (folder / "cycles.csv").exists() or bool(checkpoints.listed(folder / "checkpoints"))


def refuse_changes(settings: RunSettings) -> None:
    """RunError where the folder has results of other parameters, with the difference.

    As long as a bed is packed only, what packing does not read may change.
    """
    if not has_results(settings):
        return
    record, stored = stored_record(settings.folder), stored_scenario(settings)
    if stored is None:
        if record and record.scenario_hash == settings.scenario.hash:
            return
        raise RunError(f"{settings.folder}/scenario.json: is missing; restore it; else {START_OVER}")
    changes = stored.changes(settings.scenario, "packing", "output" if is_loaded(settings) else "packing")
    bed = record.bed if record else settings.bed_name
    if bed != settings.bed_name:
        changes.append(f"bed: {bed} -> {settings.bed_name}")
    if changes:
        raise RunError(f"{settings.title} | has results of other parameters: {'; '.join(changes)}; {START_OVER}")


def refuse_fewer_cycles(settings: RunSettings) -> None:
    """RunError where more cycles are done than the run is asked for."""
    done, asked = cycles_done(settings.folder), settings.scenario["loading.cycles"]
    if done > asked:
        raise RunError(
            f"{settings.title} | {done} cycles are done already, more than the {asked} asked for; "
            f"give CYCLES={done} or more"
        )


def refuse_loss(settings: RunSettings, start: checkpoints.Checkpoint | None) -> None:
    """RunError where going on from `start` (None: from the packed bed) would drop cycles that were finished.

    What a kill can cost is not among them: the cycles since the last checkpoint, or since the one before it where the
    last is damaged.
    """
    done, record = cycles_done(settings.folder), stored_record(settings.folder)
    if not done or settings.redo:
        return
    finished = record is not None and record.state == "finished"
    usual = 0 if finished else checkpoints.KEEP * settings.scenario["output.checkpoint_cycles"] - 1
    kept = start.cycle if start else 0
    if start is None or done - kept > usual:
        raise RunError(
            f"{settings.title} | the checkpoint after cycle {done} is missing or damaged in "
            f"{settings.folder}/checkpoints (the last good one: {start or 'none'}): going on would drop "
            f"{done - kept} of {done} cycles; {REDO}"
        )


def refuse_new_bed(settings: RunSettings) -> None:
    """RunError where a bed would be packed anew although results of the lost one exist."""
    there = [name for name in NORMALISED if (settings.folder / name).exists()]
    if there and not settings.redo:
        raise RunError(
            f"{settings.title} | {settings.folder}/raw/bed_packed.csv and the checkpoints are missing, but there are "
            f"results ({', '.join(there)}); {REDO}"
        )
