"""One run in a few sentences: what ran, how far, how well the load was met."""

from __future__ import annotations

import numpy as np

from analysis.comparison.run_quantities import last_cycle
from analysis.driver.status import load_not_reached
from analysis.formats.quantities import row_of
from analysis.normalised.readers import Run
from analysis.report.report_data import state_of, timing, tracking_percent
from analysis.report.sentences import lines, slug
from analysis.report.tables.run_tables import STATE_KIND


def run_entry(run: Run) -> dict:
    """One run in a few sentences."""
    state, reason = state_of(run)
    return {
        "anchor": slug(run.id),
        "name": run.id,
        "state": state,
        "kind": STATE_KIND.get(state, "open"),
        "text": " ".join(lines("run.txt", **said_of(run, reason))),
        "deviations": [str(d) for d in run.info.get("deviations", [])],
        "problems": run.problems,
        "command": run.info.get("command", "command unknown"),
    }


def said_of(run: Run, reason: str) -> dict:
    """What templates/run.txt needs."""
    times, choice = timing(run), run.scenario.parameters.get("time.choice") if run.scenario is not None else None
    speeds = times.get("steps_per_second")
    plates = run.plate_stresses[list(row_of("plate_{}_stress_mean_Pa"))].mean()
    return {
        "run": run,
        "info": run.info,
        "reason": reason,
        "times": times,
        "choice": choice.value if choice else "",
        "missed": load_not_reached(run.folder, run.scenario) if run.scenario is not None else "",
        "cycles": last_cycle(run),
        "speeds": speeds if isinstance(speeds, dict) else {},
        "tracking_percent": tracking_percent(run) if len(run.cycles) else None,
        "plates": list(plates) if np.isfinite(plates).any() else [],
        "versions": run.info.get("versions", {}),
    }
