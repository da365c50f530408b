"""Pictures of a bed: `python -m analysis view SCENARIO --code CODE` writes PNGs, and VTP files for ParaView.

The report takes the same pictures. Nothing here needs a display or a graphics library.
"""

from __future__ import annotations

import argparse
import base64
import struct
import sys
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import pandas as pd
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap

from . import beds, derived, render, style, tables
from .engines import CODES
from .run import run_folder
from .scenario import Scenario

MOVED = LinearSegmentedColormap.from_list("moved", ["#d9d5cb", "#e9c46a", "#e07b2e", "#a3273f", "#5e1a63"])
"""From resting stone to what moved most; lightness falls all the way, so it also works without colour."""
FORCE = LinearSegmentedColormap.from_list("force", ["#b9a98f", "#e08a2e", "#d7301f"])
STONE = np.array([[0.80, 0.78, 0.74], [0.72, 0.71, 0.69], [0.66, 0.65, 0.64], [0.76, 0.73, 0.68], [0.70, 0.68, 0.63]])
STEEL = (0.36, 0.42, 0.48)
PICTURE_WIDTH = 1600
CUT_FROM_WIDTH_M = 0.25
"""Beds at least this wide are cut open along the sleeper; a narrow slice is drawn whole."""


class ViewError(ValueError):
    """A run that cannot be drawn; the message is one line with the remedy."""


class NoBed(ViewError):
    """A run without the bed that was asked for: not packed yet, or kept without beds."""


@dataclass(frozen=True)
class Scene:
    """A bed with sleeper and plates where they stand; `moved_m` (n, 3) is each clump's displacement, nan where
    unknown.
    """

    scenario: Scenario
    title: str
    bed: pd.DataFrame
    moved_m: np.ndarray | None
    sleeper: derived.Block
    plates: tuple[derived.Block, ...]
    contacts: pd.DataFrame | None

    @property
    def box(self) -> derived.Apparatus:
        return derived.apparatus(self.scenario)


def load_scene(folder: Path, label: str | int = "after") -> Scene:
    """The bed of a run folder: `packed`, `before` (end of preload), `after` (the last one there is) or that of a cycle.

    Raises NoBed where there is none, ViewError where it is damaged.
    """
    folder = Path(folder)
    cycle, path = _bed_file(folder, label)
    if not path.exists():
        raise NoBed(
            f"{path.name}: is not there; run it at least that far, or again where the run was kept without beds"
        )
    try:
        scenario = Scenario.from_json((folder / "scenario.json").read_text())
        bed = beds.read_bed(path)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ViewError(f"{' '.join(str(error).split())}; the bed is not drawn") from None
    down, out = _places(folder, cycle)
    box = derived.apparatus(scenario)
    title = {None: "after packing", 0: "after preload", 1: "after 1 cycle"}.get(cycle, f"after {cycle} cycles")
    contacts = {None: "packed", 0: "preloaded"}.get(cycle, f"cycle_{cycle or 0:06d}")
    return Scene(
        scenario,
        title,
        bed,
        _displacement(folder / "bed_before.csv", bed) if cycle else None,
        _shifted(box.sleeper, (0, 0, -down)),
        tuple(_shifted(plate, (shift, 0, 0)) for plate, shift in zip(box.plates, out, strict=True)),
        _contacts(folder / "raw" / f"contacts_{contacts}.csv"),
    )


def _bed_file(folder: Path, label: str | int) -> tuple[int | None, Path]:
    """Cycle (None: packed, 0: end of preload) and file of a bed."""
    if label == "packed":
        return None, folder / "raw" / "bed_packed.csv"
    if label == "before":
        return 0, folder / "bed_before.csv"
    if label == "after":
        done = _cycles(folder)
        last = int(done.index[-1]) if len(done) else 0
        kept = [cycle for cycle in _kept(folder, "bed") if cycle <= last]
        if not kept or not last:
            return last, folder / "bed_after.csv"
        label = kept[-1]
    return int(label), folder / "raw" / f"bed_cycle_{int(label):06d}.csv"


def last_with_contacts(folder: Path) -> int | None:
    """The last cycle whose bed and contacts are both there."""
    both = set(_kept(folder, "bed")) & set(_kept(folder, "contacts")) & set(_cycles(folder).index)
    return max(both, default=None)


def _kept(folder: Path, what: str) -> list[int]:
    found = (path.stem.rpartition("_")[2] for path in (folder / "raw").glob(f"{what}_cycle_*.csv"))
    return sorted(int(number) for number in found if number.isdigit())


def _shifted(block: derived.Block, by) -> derived.Block:
    return derived.Block(
        tuple(a + b for a, b in zip(block.low, by, strict=True)),
        tuple(a + b for a, b in zip(block.high, by, strict=True)),
    )


def _cycles(folder: Path) -> pd.DataFrame:
    """Displacements of sleeper and plates (m) by cycle; no rows where there are none."""
    columns = ["cycle", "settlement_m", *(f"lateral_{k}_m" for k in tables.PLATES)]
    try:
        return pd.read_csv(folder / "cycles.csv", usecols=columns)[columns].astype({"cycle": int}).set_index("cycle")
    except (OSError, ValueError):
        return pd.DataFrame(columns=columns).set_index("cycle")


def _places(folder: Path, cycle: int | None) -> tuple[float, list[float]]:
    """How far the sleeper is down and each plate out since packing, m; what is not known counts as 0."""
    if cycle is None:
        return 0.0, [0.0] * len(tables.PLATES)
    columns = ["sleeper_displacement_m", *(f"plate_{k}_displacement_m" for k in tables.PLATES)]
    moved = np.zeros(len(columns))
    try:
        moved = moved + pd.read_csv(folder / "raw" / "cyclic.csv", usecols=columns, nrows=1)[columns].to_numpy(float)[0]
    except (OSError, ValueError, IndexError):
        pass  # committed runs have no raw files: their preload displacement is not drawn
    done = _cycles(folder)
    if cycle in done.index:
        moved = moved + np.nan_to_num(done.loc[cycle].to_numpy(float))
    return float(moved[0]), [float(v) for v in moved[1:]]


def _displacement(before: Path, bed: pd.DataFrame) -> np.ndarray | None:
    try:
        start = beds.read_bed(before).set_index("id")[["x_m", "y_m", "z_m"]]
    except ValueError:
        return None
    return beds.positions(bed) - start.reindex(bed["id"]).to_numpy(float)


def _contacts(path: Path) -> pd.DataFrame | None:
    try:
        table = pd.read_csv(path)
        return table[["clump_1", "clump_2", "x_m", "y_m", "z_m", "normal_force_N"]].astype(float)
    except (OSError, ValueError, KeyError):
        return None


# ----------------------------------------------------------------- pictures


def is_cut(scene: Scene) -> bool:
    """True where pictures show the bed cut open along the sleeper."""
    return scene.box.width_m >= CUT_FROM_WIDTH_M


def picture(
    scene: Scene,
    *,
    azimuth_deg: float = 0.0,
    elevation_deg: float = 0.0,
    width: int = PICTURE_WIDTH,
    pale: bool = False,
) -> tuple[np.ndarray, render.Camera, float]:
    """The bed, cut open along the sleeper: (RGBA picture, camera, displacement at full colour in m or nan).

    Clumps whose centre lies before the cut are left out. `pale` draws uncoloured stone, as a backdrop.
    """
    box, clump = scene.box, derived.clump(scene.scenario)
    front = box.width_m / 2 if is_cut(scene) else 0.0
    behind = beds.positions(scene.bed)[:, 1] >= front
    bed = scene.bed[behind]
    colours, top = STONE[bed["id"].to_numpy() % len(STONE)], float("nan")
    if scene.moved_m is not None and not pale:
        length = np.linalg.norm(scene.moved_m, axis=1)
        top = float(np.nanquantile(length, 0.99)) if np.isfinite(length).any() else float("nan")
        if top > 0:
            colours = np.where(
                np.isfinite(length[behind])[:, None], MOVED(np.nan_to_num(length[behind] / top))[:, :3], colours
            )
    blocks = [scene.sleeper, *scene.plates]
    corners = np.array(
        [
            [x, y, z]
            for x in (0, max(p.high[0] for p in scene.plates))
            for y in (front, box.width_m)
            for z in (0, scene.sleeper.high[2])
        ]
    )
    view = render.camera(corners, azimuth_deg, elevation_deg, margin_m=0.6 * clump.radius_m)
    faces = [
        face
        for block in blocks
        for face in render.box_faces(
            (block.low[0], max(front, block.low[1]), block.low[2]), block.high, view, STEEL, opacity=0.30
        )
    ]
    image = render.render(
        beds.sphere_centres(bed, clump.half_distance_m),
        clump.radius_m,
        np.repeat(colours, 2, axis=0),
        np.repeat(np.arange(len(bed)), 2),
        view,
        width,
        [] if pale else faces,
    )
    return image, view, top


def _picture_canvas(name: str, alt: str, view: render.Camera, foot: float, title: str) -> style.Canvas:
    """An empty panel with the camera's window at true scale, `foot` inches below it and a line for the title above
    it.
    """
    width = 6.0
    height = width * (view.high[1] - view.low[1]) / (view.high[0] - view.low[0])
    head = 0.27 if title else 0.0
    c = style.canvas(name, alt, width=width, height=height + foot + head, left=0, right=0, bottom=foot, top=head)
    c.figure.text(
        0.005, 1 - 0.03 / (height + foot + head), title, fontsize=10, fontweight="bold", va="top", color=style.INK
    )
    c.axes.set(xlim=(view.low[0], view.high[0]), ylim=(view.low[1], view.high[1]))
    c.axes.set_axis_off()
    return c


def _scale_bar(c: style.Canvas, view: render.Camera, foot: float) -> None:
    """A bar of 100 mm at the lower left, and what the plan of the picture is."""
    width, height = c.figure.get_size_inches()
    share = 0.1 / (view.high[0] - view.low[0])
    y = (style.STAMP_HEIGHT + 0.45 * foot) / height
    c.figure.add_artist(_line([0.02, 0.02 + share], [y, y]))
    c.figure.text(0.02, y - 0.07 / height, "100 mm", fontsize=8.5, va="top", color=style.INK)


def _line(xs, ys):
    from matplotlib.lines import Line2D

    return Line2D(xs, ys, color=style.INK, linewidth=2, solid_capstyle="butt")


def bed_panel(
    scene: Scene,
    name: str,
    title: str = "",
    *,
    azimuth_deg: float = 0.0,
    elevation_deg: float = 0.0,
    pixels: int = PICTURE_WIDTH,
) -> style.Canvas:
    """The bed as a panel: shaded spheres, sleeper and plates as glass, colour bar of displacement where it is known."""
    image, view, top = picture(scene, azimuth_deg=azimuth_deg, elevation_deg=elevation_deg, width=pixels)
    foot = 0.5
    alt = f"Bed {scene.title}{', cut open along the sleeper' if is_cut(scene) else ''}, with sleeper and plates"
    c = _picture_canvas(name, alt, view, foot, title)
    c.axes.imshow(
        image, extent=(view.low[0], view.high[0], view.low[1], view.high[1]), interpolation="antialiased", aspect="auto"
    )
    _scale_bar(c, view, foot)
    if top > 0:
        width, height = c.figure.get_size_inches()
        bar = c.figure.add_axes([0.44, (style.STAMP_HEIGHT + 0.30) / height, 0.42, 0.11 / height])
        bar.imshow(np.linspace(0, 1, 256)[None], aspect="auto", cmap=MOVED, extent=(0, 1e3 * top, 0, 1))
        bar.set_yticks([])
        bar.tick_params(length=2, pad=1.5, labelsize=8)
        bar.grid(False)
        for spine in bar.spines.values():
            spine.set_visible(False)
        c.figure.text(
            0.43,
            (style.STAMP_HEIGHT + 0.355) / height,
            "clump displacement, mm",
            fontsize=8.5,
            va="center",
            ha="right",
            color=style.INK,
        )
    c.table = (
        scene.bed.assign(displacement_m=np.linalg.norm(scene.moved_m, axis=1))
        if scene.moved_m is not None
        else scene.bed
    )
    return c


def chain_lines(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Force chains: lines (n, 2, 3) between clump centres, or from a centre to the wall, and their normal forces, N."""
    if scene.contacts is None or scene.contacts.empty:
        return np.zeros((0, 2, 3)), np.zeros(0)
    places = pd.DataFrame(beds.positions(scene.bed), index=scene.bed["id"])
    contacts = scene.contacts
    start = places.reindex(contacts["clump_1"]).to_numpy()
    end = places.reindex(contacts["clump_2"]).to_numpy(copy=True)
    wall = contacts["clump_2"].to_numpy() == 0
    end[wall] = contacts[["x_m", "y_m", "z_m"]].to_numpy()[wall]
    lines, force = np.stack([start, end], axis=1), contacts["normal_force_N"].to_numpy()
    known = np.isfinite(lines).all((1, 2)) & np.isfinite(force)
    return lines[known], force[known]


def chain_panel(scene: Scene, name: str, title: str = "") -> style.Canvas | None:
    """Force chains in a slab along the middle of the sleeper, over the pale bed; None where contacts were not kept."""
    lines, force = chain_lines(scene)
    half = 3 * scene.scenario["clump.ball_radius"]
    near = np.abs(lines[:, :, 1].mean(axis=1) - scene.box.width_m / 2) <= half
    lines, force = lines[near], force[near]
    if not len(force):
        return None
    image, view, _ = picture(scene, pale=True, width=PICTURE_WIDTH // 2)
    image[..., 3] = (image[..., 3] * 0.30).astype(np.uint8)
    foot = 0.5
    c = _picture_canvas(name, f"Force chains {scene.title} in a slab along the sleeper", view, foot, title)
    c.axes.imshow(
        image, extent=(view.low[0], view.high[0], view.low[1], view.high[1]), interpolation="antialiased", aspect="auto"
    )
    order = np.argsort(force, kind="stable")
    top = float(np.quantile(force, 0.995))
    share = np.clip(force[order] / top, 0, 1)
    drawn = share > 0.02
    colours = FORCE(share[drawn])
    colours[:, 3] = 0.25 + 0.75 * np.sqrt(share[drawn])
    c.axes.add_collection(
        LineCollection(
            lines[order][drawn][:, :, [0, 2]],
            linewidths=0.25 + 6 * share[drawn],
            colors=colours,
            capstyle="round",
            rasterized=True,
        )
    )
    for block in (scene.sleeper, *scene.plates):
        c.axes.plot(*_outline(block), color=style.SOFT, linewidth=1)
    _scale_bar(c, view, foot)
    width, height = c.figure.get_size_inches()
    y = (style.STAMP_HEIGHT + 0.45 * foot) / height
    for n, portion in enumerate((0.1, 0.3, 1.0)):
        x = 0.42 + 0.19 * n
        line = _line([x, x + 0.05], [y, y])
        line.set(color=FORCE(portion), linewidth=0.25 + 6 * portion)
        c.figure.add_artist(line)
        c.figure.text(x + 0.06, y, f"{_round(portion * top)} N", fontsize=8.5, va="center", color=style.INK)
    c.table = pd.DataFrame(
        {f"{axis}{end + 1}_m": lines[:, end, k] for end in (0, 1) for k, axis in enumerate("xyz")}
        | {"normal_force_N": force}
    )
    return c


def _round(value: float) -> str:
    """Two significant digits without an exponent."""
    return f"{float(f'{value:.2g}'):,.10g}"


def _outline(block: derived.Block):
    return (
        [block.low[0], block.high[0], block.high[0], block.low[0], block.low[0]],
        [block.low[2], block.low[2], block.high[2], block.high[2], block.low[2]],
    )


# ----------------------------------------------------------------- ParaView


def write_vtp(path: Path, points: np.ndarray, *, lines=None, quads=None, point_data=None, cell_data=None) -> None:
    """Points (n, 3) in m with `lines` (m, 2) or `quads` (m, 4) of point numbers, or as vertices, as VTK PolyData
    XML.
    """

    def array(name: str, values: np.ndarray) -> str:
        values = np.ascontiguousarray(values)
        kind = "Int64" if values.dtype.kind in "iu" else "Float64"
        values = values.astype("<i8" if kind == "Int64" else "<f8")
        content = base64.b64encode(struct.pack("<Q", values.nbytes) + values.tobytes()).decode()
        parts = values.shape[1] if values.ndim == 2 else 1
        return (
            f'<DataArray type="{kind}" Name={quoteattr(name)} NumberOfComponents="{parts}" format="binary">'
            f"{content}</DataArray>\n"
        )

    if lines is None and quads is None:
        kind, cells = "Verts", np.arange(len(points))[:, None]
    else:
        kind, cells = ("Lines", np.asarray(lines)) if lines is not None else ("Polys", np.asarray(quads))
    counts = {name: len(cells) if name == kind else 0 for name in ("Verts", "Lines", "Polys")}
    data = [("PointData", point_data or {}), ("CellData", cell_data or {})]
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" '
        'header_type="UInt64">\n<PolyData>\n'
        f'<Piece NumberOfPoints="{len(points)}" NumberOfStrips="0" '
        + " ".join(f'NumberOf{name}="{count}"' for name, count in counts.items())
        + ">\n"
        "<Points>\n"
        + array("Points", np.asarray(points, float))
        + f"</Points>\n<{kind}>\n"
        + array("connectivity", cells.ravel().astype(np.int64))
        + array("offsets", (np.arange(1, len(cells) + 1) * cells.shape[1]).astype(np.int64))
        + f"</{kind}>\n"
        + "".join(
            f"<{where}>\n" + "".join(array(name, values) for name, values in fields.items()) + f"</{where}>\n"
            for where, fields in data
        )
        + "</Piece>\n</PolyData>\n</VTKFile>\n"
    )
    tables.write_aside(path, text)


def write_paraview(scene: Scene, folder: Path, label: str) -> list[Path]:
    """Spheres (glyph them by `radius_m`), walls and force chains of a scene as VTP files."""
    clump = derived.clump(scene.scenario)
    ids = np.repeat(scene.bed["id"].to_numpy(), 2)
    data = {"clump": ids, "radius_m": np.full(len(ids), clump.radius_m)}
    if scene.moved_m is not None:
        data["displacement_m"] = np.repeat(scene.moved_m, 2, axis=0)
    spheres = folder / f"spheres_{label}.vtp"
    write_vtp(spheres, beds.sphere_centres(scene.bed, clump.half_distance_m), point_data=data)
    points, quads, names = [], [], []
    for number, block in enumerate((scene.sleeper, *scene.plates)):
        corners = [[(block.low, block.high)[b][a] for a, b in enumerate(bits)] for bits in np.ndindex(2, 2, 2)]
        quads += [
            [8 * number + n for n in side]
            for side in ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
        ]
        names += [number] * 6
        points += corners
    walls = folder / f"walls_{label}.vtp"
    write_vtp(walls, np.array(points), quads=np.array(quads), cell_data={"wall": np.array(names)})
    lines, force = chain_lines(scene)
    if not len(force):
        return [spheres, walls]
    chains = folder / f"force_chains_{label}.vtp"
    write_vtp(
        chains,
        lines.reshape(-1, 3),
        lines=np.arange(2 * len(lines)).reshape(-1, 2),
        cell_data={"normal_force_N": force},
    )
    return [spheres, walls, chains]


# ----------------------------------------------------------------- command line


def main(argv: list[str]) -> int:
    """Write the pictures and ParaView files of one run into its folder `view/`."""
    parser = argparse.ArgumentParser(
        prog="python -m analysis view", description="Pictures of a bed, and files for ParaView."
    )
    parser.add_argument("scenario")
    parser.add_argument("--code", choices=CODES, required=True)
    parser.add_argument("--profile", default="demo")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--results", type=Path, default=Path("results"))
    options = parser.parse_args(argv)
    run = run_folder(options.results, options.profile, options.scenario, options.code, options.seed)
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
