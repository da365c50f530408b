"""Pictures of beds and force chains."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path

from analysis.comparison.run_quantities import last_cycle
from analysis.normalised.readers import Run
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import short_name
from analysis.report.pictures.panels import ASKEW, bed_panel, chain_panel
from analysis.report.pictures.scene import NoBed, Scene, ViewError, last_with_contacts, load_scene, packed_scene
from analysis.report.report_data import KEY_SCENARIOS, ReportData
from analysis.report.style import CODE_NAMES, Canvas
from analysis.scenarios.scenario import load_scenario

KEPT_BED = Path("beds") / "liggghts-seed1.csv.gz"
"""The full bed that is kept in the repository, below the folder of kept runs."""


def kept_scene(gallery: Gallery, kept: Path) -> Scene | None:
    """The full bed that is kept in the repository; None where it is not there."""
    if not KEY_SCENARIOS:
        return None
    try:
        return packed_scene(kept / KEPT_BED, load_scenario(KEY_SCENARIOS[0], "full"))
    except ViewError as error:
        if not isinstance(error, NoBed):
            gallery.complain(str(error))
        return None


def kept_bed_figure(gallery: Gallery, kept: Path, name: str, title: str, caption: str) -> Figure | None:
    """That bed as a picture."""
    scene = kept_scene(gallery, kept)
    return scene and gallery.finish(name, title, caption, [_bed_panel(scene, name, scene.title)], [], layout="picture")


def _bed_panel(scene: Scene, name: str, heading: str) -> Canvas:
    return bed_panel(scene, name, heading, **ASKEW, pixels=1200)


def bed_figure(
    gallery: Gallery, runs: Sequence[Run], name: str, label: str, title: str, caption: str, *, chains: bool = False
) -> Figure | None:
    """The bed of each run as a picture, and its force chains where contacts were kept."""
    drawn, used = [], []
    for run in runs:
        try:
            scene = load_scene(run.folder, (last_with_contacts(run.folder) if chains else None) or label)
        except ViewError as error:
            if not isinstance(error, NoBed):
                gallery.complain(f"{run.id}/{error}")
            continue
        key = f"{name}-{run.scenario_name}-{run.code}" + (f"-seed{run.seed}" if run.seed != 1 else "")
        heading = f"{short_name(run.scenario_name)}, {CODE_NAMES.get(run.code, run.code)}, {scene.title}"
        c = chain_panel(scene, key, heading) if chains else _bed_panel(scene, key, heading)
        if c is None:
            continue
        drawn.append(c)
        used.append(run)
    return gallery.finish(name, title, caption, drawn, used, layout="picture")


def full_bed_figure(data: ReportData, profile: str = "full") -> Figure | None:
    """The bed after loading of the longest run whose bed is on this machine; None without one."""
    runs = [run for run in data.of(profile) if (run.folder / "bed_after.csv").exists()]
    runs.sort(key=lambda run: (run.base_name == KEY_SCENARIOS[-1], run.code == "liggghts", last_cycle(run)))
    return bed_figure(
        data.gallery,
        runs[-1:],
        "bed-full",
        "after",
        "The bed after loading",
        "Clumps of two spheres, coloured by how far they moved since the end of preload; sleeper and plates as glass, "
        "where they stand at the end. The bed is cut open along the middle of the sleeper.",
    )


def moving_picture(path: Path) -> str:
    """The moving picture kept in the repository as a data URI; empty where it is not there."""
    return "data:image/webp;base64," + base64.b64encode(path.read_bytes()).decode() if path.exists() else ""
