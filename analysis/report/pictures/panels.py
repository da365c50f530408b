"""Pictures of a scene: the bed as shaded spheres, and force chains. No display or graphics library is needed."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap

from analysis.normalised import beds
from analysis.report import style
from analysis.report.pictures import render
from analysis.report.pictures.scene import Scene, chain_lines
from analysis.scenarios import derived

MOVED = LinearSegmentedColormap.from_list("moved", ["#d9d5cb", "#e9c46a", "#e07b2e", "#a3273f", "#5e1a63"])
"""From resting stone to what moved most; lightness falls all the way, so it also works without colour."""

FORCE = LinearSegmentedColormap.from_list("force", ["#b9a98f", "#e08a2e", "#d7301f"])

STONE = np.array([[0.80, 0.78, 0.74], [0.72, 0.71, 0.69], [0.66, 0.65, 0.64], [0.76, 0.73, 0.68], [0.70, 0.68, 0.63]])

STEEL = (0.36, 0.42, 0.48)

PICTURE_WIDTH = 1600

FOOT = 0.62
"""Inches below a picture, for its scale and what its colours mean."""

CUT_FROM_WIDTH_M = 0.25
"""Beds at least this wide are cut open along the sleeper; a narrow slice is drawn whole."""

ASKEW = {"azimuth_deg": -28, "elevation_deg": 20}
"""A view that shows the cut, the top and the plates."""

MOST_HEIGHT = 1.5
"""What flies higher than this many heights of the sleeper's top is cut off the picture."""


def is_cut(scene: Scene) -> bool:
    """True where pictures show the bed cut open along the sleeper."""
    return scene.box.width_m >= CUT_FROM_WIDTH_M


def _front(scene: Scene) -> float:
    """y of the cut, m."""
    return scene.box.width_m / 2 if is_cut(scene) else 0.0


def _shown(scene: Scene) -> np.ndarray:
    """Which clumps are drawn: those whose centre lies behind the cut."""
    return beds.positions(scene.bed)[:, 1] >= _front(scene)


def full_colour(scene: Scene) -> float:
    """Displacement at full colour, m; nan where none is known."""
    if scene.moved_m is None:
        return float("nan")
    length = np.linalg.norm(scene.moved_m, axis=1)
    return float(np.nanquantile(length, 0.99)) if np.isfinite(length).any() else float("nan")


def colours_of(scene: Scene, top: float) -> np.ndarray:
    """RGB 0-1 of each clump: by its displacement, full at `top` m, or of stone where that is not known."""
    colours = STONE[scene.bed["id"].to_numpy() % len(STONE)]
    if scene.moved_m is None or not top > 0:
        return colours
    length = np.linalg.norm(scene.moved_m, axis=1)
    return np.where(np.isfinite(length)[:, None], MOVED(np.nan_to_num(length / top))[:, :3], colours)


def camera_of(scene: Scene, azimuth_deg: float = 0.0, elevation_deg: float = 0.0) -> render.Camera:
    """A camera that shows box, sleeper and clumps."""
    clump = derived.clump(scene.scenario)
    corners = np.array(
        [
            [x, y, z]
            for x in (scene.box.end_m, max(p.high[0] for p in scene.plates))
            for y in (_front(scene), scene.box.width_m)
            for z in (0, scene.sleeper.high[2])
        ]
    )
    crowns = beds.positions(scene.bed)[_shown(scene)] + [
        0,
        0,
        clump.radius_m + clump.half_distance_m,
    ]  # also of clumps thrown out of the cribs
    crowns[:, 2] = np.minimum(crowns[:, 2], MOST_HEIGHT * scene.sleeper.high[2])
    return render.camera(np.vstack([corners, crowns]), azimuth_deg, elevation_deg, margin_m=0.6 * clump.radius_m)


def picture(
    scene: Scene, view: render.Camera, top: float = float("nan"), width: int = PICTURE_WIDTH, pale: bool = False
) -> np.ndarray:
    """The bed, cut open along the sleeper, as an RGBA picture.

    Clumps whose centre lies before the cut are left out. `top` is the displacement (m) at full colour; `pale` draws
    uncoloured stone without sleeper and plates, as a backdrop.
    """
    clump, shown = derived.clump(scene.scenario), _shown(scene)
    bed, colours = scene.bed[shown], colours_of(scene, float("nan") if pale else top)[shown]
    faces = [
        face
        for block in (scene.sleeper, *scene.plates)
        for face in render.box_faces(
            (block.low[0], max(_front(scene), block.low[1]), block.low[2]), block.high, view, STEEL, opacity=0.30
        )
    ]
    return render.render(
        beds.sphere_centres(bed, clump.half_distance_m),
        clump.radius_m,
        np.repeat(colours, 2, axis=0),
        np.repeat(np.arange(len(bed)), 2),
        view,
        width,
        [] if pale else faces,
    )


def _picture_canvas(name: str, alt: str, view: render.Camera, title: str) -> style.Canvas:
    """An empty panel with the camera's window at true scale, FOOT below it and a line for the title above it."""
    width = 6.0
    height = width * (view.high[1] - view.low[1]) / (view.high[0] - view.low[0])
    head = 0.27 if title else 0.0
    c = style.canvas(name, alt, width=width, height=height + FOOT + head, left=0, right=0, bottom=FOOT, top=head)
    c.figure.text(
        0.005, 1 - 0.03 / (height + FOOT + head), title, fontsize=12.5, fontweight="bold", va="top", color=style.INK
    )
    c.axes.set(xlim=(view.low[0], view.high[0]), ylim=(view.low[1], view.high[1]))
    c.axes.set_axis_off()
    return c


def _scale_bar(canvas: style.Canvas, view: render.Camera) -> None:
    """A bar of 100 mm at the lower left, and what the plan of the picture is."""
    width, height = canvas.figure.get_size_inches()
    share = 0.1 / (view.high[0] - view.low[0])
    y = (style.STAMP_HEIGHT + 0.45 * FOOT) / height
    canvas.figure.add_artist(_line([0.02, 0.02 + share], [y, y]))
    canvas.figure.text(0.02, y - 0.07 / height, "100 mm", fontsize=12, va="top", color=style.INK)


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
    view, top = camera_of(scene, azimuth_deg, elevation_deg), full_colour(scene)
    alt = f"Bed {scene.title}{', cut open along the sleeper' if is_cut(scene) else ''}, with sleeper and plates"
    c = _picture_canvas(name, alt, view, title)
    _show_picture(c, view, picture(scene, view, top, pixels))
    _scale_bar(c, view)
    if top > 0:
        _colour_bar(c, top)
    known = scene.moved_m is not None
    c.table = scene.bed.assign(displacement_m=np.linalg.norm(scene.moved_m, axis=1)) if known else scene.bed
    return c


def _show_picture(canvas: style.Canvas, view: render.Camera, image: np.ndarray) -> None:
    extent = (view.low[0], view.high[0], view.low[1], view.high[1])
    canvas.axes.imshow(image, extent=extent, interpolation="antialiased", aspect="auto")


def _colour_bar(canvas: style.Canvas, top: float) -> None:
    """A bar at the lower right: colours of displacements up to `top` m."""
    height = canvas.figure.get_size_inches()[1]
    bar = canvas.figure.add_axes([0.44, (style.STAMP_HEIGHT + 0.30) / height, 0.42, 0.11 / height])
    bar.imshow(np.linspace(0, 1, 256)[None], aspect="auto", cmap=MOVED, extent=(0, 1e3 * top, 0, 1))
    bar.set_yticks([])
    bar.tick_params(length=2, pad=1.5, labelsize=12)
    bar.grid(False)
    for spine in bar.spines.values():
        spine.set_visible(False)
    place = 0.44, (style.STAMP_HEIGHT + 0.44) / height
    canvas.figure.text(*place, "clump displacement, mm", fontsize=12, va="bottom", ha="left", color=style.INK)


def chain_panel(scene: Scene, name: str, title: str = "") -> style.Canvas | None:
    """Force chains in a slab along the middle of the sleeper, over the pale bed; None where contacts were not kept."""
    lines, force = chain_lines(scene)
    half = 3 * scene.scenario["clump.ball_radius"]
    near = np.abs(lines[:, :, 1].mean(axis=1) - scene.box.width_m / 2) <= half
    lines, force = lines[near], force[near]
    if not len(force):
        return None
    view = camera_of(scene)
    image = picture(scene, view, width=PICTURE_WIDTH // 2, pale=True)
    image[..., 3] = (image[..., 3] * 0.30).astype(np.uint8)
    c = _picture_canvas(name, f"Force chains {scene.title} in a slab along the sleeper", view, title)
    _show_picture(c, view, image)
    top = float(np.quantile(force, 0.995))
    _draw_chains(c, lines, force, top)
    for block in (scene.sleeper, *scene.plates):
        c.axes.plot(*_outline(block), color=style.SOFT, linewidth=1)
    _scale_bar(c, view)
    _force_key(c, top)
    c.table = pd.DataFrame(
        {f"{axis}{end + 1}_m": lines[:, end, k] for end in (0, 1) for k, axis in enumerate("xyz")}
        | {"normal_force_N": force}
    )
    return c


def _chain_width(share):
    """Points, of a force over the one at full width."""
    return 0.25 + 6 * share


def _draw_chains(canvas: style.Canvas, lines: np.ndarray, force: np.ndarray, top: float) -> None:
    """Contacts as lines (n, 2, 3) in m, the more force the broader and redder, full at `top` N; the strongest last."""
    order = np.argsort(force, kind="stable")
    share = np.clip(force[order] / top, 0, 1)
    drawn = share > 0.02
    colours = FORCE(share[drawn])
    colours[:, 3] = 0.25 + 0.75 * np.sqrt(share[drawn])
    canvas.axes.add_collection(
        LineCollection(
            lines[order][drawn][:, :, [0, 2]],
            linewidths=_chain_width(share[drawn]),
            colors=colours,
            capstyle="round",
            rasterized=True,
        )
    )


def _force_key(canvas: style.Canvas, top: float) -> None:
    """Lines below the picture that say which force has which breadth and colour."""
    height = canvas.figure.get_size_inches()[1]
    y = (style.STAMP_HEIGHT + 0.45 * FOOT) / height
    for n, portion in enumerate((0.1, 0.3, 1.0)):
        x = 0.42 + 0.19 * n
        line = _line([x, x + 0.05], [y, y])
        line.set(color=FORCE(portion), linewidth=_chain_width(portion))
        canvas.figure.add_artist(line)
        canvas.figure.text(x + 0.06, y, f"{_round(portion * top)} N", fontsize=12, va="center", color=style.INK)


def _round(value: float) -> str:
    """Two significant digits without an exponent."""
    return f"{float(f'{value:.2g}'):,.10g}"


def _outline(block: derived.Block):
    return (
        [block.low[0], block.high[0], block.high[0], block.low[0], block.low[0]],
        [block.low[2], block.low[2], block.high[2], block.high[2], block.low[2]],
    )
