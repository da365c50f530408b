"""`ballast view SCENARIO --code CODE`: pictures of a bed as PNG, and VTP files for ParaView."""

from __future__ import annotations

import sys
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver.engines import CODES
from analysis.driver.folder import run_folder
from analysis.report import style
from analysis.report.pictures.panels import bed_panel, chain_panel
from analysis.report.pictures.paraview import write_paraview
from analysis.report.pictures.scene import ViewError, last_with_contacts, load_scene
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
    print("\n".join(str(path) for path in written))
    return 0


def _write_view(run: Path, label: str, name: str) -> list[Path]:
    """Pictures and ParaView files of one bed of a run."""
    scene, folder = load_scene(run, label), run / "view"
    chained = last_with_contacts(run) if label == "after" and scene.contacts is None else None
    folder.mkdir(exist_ok=True)
    with style.settings():
        drawings = [
            bed_panel(scene, f"bed_{label}", azimuth_deg=-28, elevation_deg=20),
            bed_panel(scene, f"section_{label}"),
            chain_panel(load_scene(run, chained) if chained else scene, f"force_chains_{label}"),
        ]
        for drawing in filter(None, drawings):
            style.save(drawing, folder, f"{name}, {scene.title}, scenario {scene.scenario.hash}")
    pictures = [folder / f"{drawing.name}.png" for drawing in drawings if drawing]
    return [*pictures, *write_paraview(scene, folder, label)]
