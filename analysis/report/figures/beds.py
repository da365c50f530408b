"""Pictures of beds and force chains."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.normalised.readers import Run
from analysis.report.figure import Figure, Gallery
from analysis.report.labels import short_name
from analysis.report.pictures.panels import bed_panel, chain_panel
from analysis.report.pictures.scene import NoBed, ViewError, last_with_contacts, load_scene
from analysis.report.style import CODE_NAMES


def bed_figure(
    g: Gallery, runs: Sequence[Run], name: str, label: str, title: str, caption: str, *, chains: bool = False
) -> Figure | None:
    """The bed of each run as a picture, and its force chains where contacts were kept."""
    drawn, used = [], []
    for run in runs:
        try:
            scene = load_scene(run.folder, (last_with_contacts(run.folder) if chains else None) or label)
        except ViewError as error:
            if not isinstance(error, NoBed):
                g.complain(f"{run.id}/{error}")
            continue
        key = f"{name}-{run.scenario_name}-{run.code}" + (f"-seed{run.seed}" if run.seed != 1 else "")
        heading = f"{short_name(run.scenario_name)}, {CODE_NAMES.get(run.code, run.code)}, {scene.title}"
        c = (
            chain_panel(scene, key, heading)
            if chains
            else bed_panel(scene, key, heading, azimuth_deg=-28, elevation_deg=20, pixels=1200)
        )
        if c is None:
            continue
        drawn.append(c)
        used.append(run)
    return g.finish(name, title, caption, drawn, used, layout="picture")
