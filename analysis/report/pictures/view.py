"""`ballast view SCENARIO --code CODE`: pictures of a bed as PNG, its cycles as a moving picture, one that
can be turned where k3d is installed, and VTP files for ParaView.
"""

from __future__ import annotations

import sys
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver.engines import CODES
from analysis.driver.folder import run_folder
from analysis.report import style
from analysis.report.labels import short_name
from analysis.report.pictures import animation, turnable
from analysis.report.pictures.panels import ASKEW, bed_panel, chain_panel
from analysis.report.pictures.paraview import write_paraview
from analysis.report.pictures.scene import ViewError, kept_cycles, last_with_contacts, load_scene
from analysis.report.style import CODE_NAMES
from analysis.scenarios.scenario import join_id, split_id


def main(argv: list[str]) -> int:
    """Write the pictures and ParaView files of one run into its folder `view/`."""
    parser = Parser(prog="ballast view", description="Pictures of a bed, and files for ParaView.")
    parser.add_argument("scenario")
    parser.add_argument("--code", choices=CODES, required=True)
    parser.add_argument("--profile", default="demo")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--results", type=Path, default=Path("results"))
    options = parser.parse_args(argv)
    identity = join_id(*split_id(options.scenario))
    run = run_folder(options.results, options.profile, identity, options.code, options.seed)
    written, reason = [], ""
    for label in ("packed", "before", "after"):
        try:
            written += _write_view(run, label, f"{options.scenario} {options.profile} {run.name}")
        except ViewError as error:
            reason = str(error)
    if not written:
        print(f"view: {run}/{reason}", file=sys.stderr)
        return 1
    written += _write_cycles(run, f"{short_name(identity)}, {CODE_NAMES[options.code]}")
    print("\n".join(str(path) for path in written))
    if not turnable.available():
        print("view: a bed that can be turned needs k3d: .venv/bin/pip install -e '.[view]'", file=sys.stderr)
    return 0


def _write_cycles(run: Path, title: str) -> list[Path]:
    """The bed through its kept cycles: bed.webp, and bed-3d.html where k3d is installed; nothing without a cycle."""
    if not kept_cycles(run):
        return []
    scenes = animation.load_scenes(run)
    paths = [animation.write(run / "view" / "bed.webp", animation.frames(scenes, title))]
    return paths + ([turnable.write_html(run / "view" / "bed-3d.html", scenes, title)] if turnable.available() else [])


def _write_view(run: Path, label: str, name: str) -> list[Path]:
    """Pictures and ParaView files of one bed of a run."""
    scene, folder = load_scene(run, label), run / "view"
    chained = last_with_contacts(run) if label == "after" and scene.contacts is None else None
    folder.mkdir(exist_ok=True)
    with style.settings():
        drawings = [
            bed_panel(scene, f"bed_{label}", **ASKEW),
            bed_panel(scene, f"section_{label}"),
            chain_panel(load_scene(run, chained) if chained else scene, f"force_chains_{label}"),
        ]
        for drawing in filter(None, drawings):
            style.save(drawing, folder, f"{name}, {scene.title}, scenario {scene.scenario.hash}")
    pictures = [folder / f"{drawing.name}.png" for drawing in drawings if drawing]
    return [*pictures, *write_paraview(scene, folder, label)]
