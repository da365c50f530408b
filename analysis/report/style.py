"""How figures look and how they are kept: one palette, one encoding of scenario and code, and SVG, PNG and CSV of each.

Hue tells the family of scenarios, lightness the parameter varied within it, line style and marker the code. Every
colour has a twin for dark pages: inline SVG refers to them as CSS variables, so that one drawing serves both.
"""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path

import matplotlib
import matplotlib.style
import numpy as np
import pandas as pd
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from PIL import Image

INK, SOFT, PAPER = "#1b1f24", "#6c757d", "#fefefe"
PALETTE = {  # light page, dark page
    "ink": (INK, "#e8eaed"),
    "soft": (SOFT, "#9aa4ae"),
    "paper": (PAPER, "#14181d"),
    "linear": ("#006dbd", "#59b2f9"),
    "nonlinear": ("#ab2500", "#f88c54"),
    "md0": ("#8a2f87", "#b871c2"),
    "md1": ("#009876", "#4de2af"),
    "md2": ("#a47e00", "#eacd4d"),
    "servo": ("#c2187a", "#ff86c2"),
    "bonded": ("#7b2d6b", "#d48ac8"),
    "other": ("#5b5f66", "#b3b9c1"),
    "reference": ("#111418", "#f5f6f7"),
}
"""Hues that stay apart for red-green and blue-yellow blindness in their order of use; see tests/test_report.py."""
CODE_STYLES = {"liggghts": {"linestyle": "-", "marker": "o"}, "yade": {"linestyle": (0, (5, 2)), "marker": "s"}}
CODE_NAMES = {"liggghts": "LIGGGHTS", "yade": "YADE"}
CODE_SIGNS = {"liggghts": "●", "yade": "□"}
HOLLOW_CODES = ("yade",)
OTHER_STYLE = {"linestyle": (0, (1, 1.2)), "marker": "D"}

PANEL_WIDTH, PANEL_HEIGHT = 4.1, 3.0
"""Inches. On a phone of 390 points a panel is drawn 1.2 times as large: its smallest text, SMALL points, has 10 pixels.
Pages set panels side by side where there is room.
"""
SMALL = 8.5
STAMP_HEIGHT = 0.30
LOOK = Path(__file__).with_name("report.mplstyle")


def marker_face(code: str, colour: str) -> str:
    """Inside of a code's marks: their colour, or the page's where they are hollow."""
    return PAPER if code in HOLLOW_CODES else colour


def _mix(colour: str, other: str, share: float) -> str:
    """`colour` with `share` (0-1) of `other`, as #rrggbb."""
    a, b = (np.array([int(c[i : i + 2], 16) for i in (1, 3, 5)]) for c in (colour, other))
    return "#" + "".join(f"{round(v):02x}" for v in a + (b - a) * share)


def shade(family: str, level: float = 0.0) -> str:
    """Colour of `family` on a light page: paler than its hue for level < 0 (down to -1), deeper for level > 0 (up to
    1).
    """
    return _SHADES.setdefault((family, round(level, 3)), _twin(family, level))[0]


LEAST_CONTRAST = 4.5
"""Of text with the page: WCAG 2, level AA."""


def text_colour(colour: str) -> str:
    """The colour of a curve for its name: the same hue, deepened until it can be read on a light page."""
    known = next((key for key, (light, _) in _SHADES.items() if light == colour), None)
    if known is None:
        return colour
    family, level = known
    while contrast(shade(family, level), PAPER) < LEAST_CONTRAST and level < 1:
        level = round(level + 0.1, 3)
    return shade(family, level)


def contrast(one: str, other: str) -> float:
    """Contrast of two colours #rrggbb, 1 to 21, as WCAG 2 defines it."""

    def luminance(colour: str) -> float:
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in parts]
        return float(np.dot(linear, (0.2126, 0.7152, 0.0722)))

    dark, light = sorted((luminance(one), luminance(other)))
    return (light + 0.05) / (dark + 0.05)


_SHADES: dict[tuple[str, float], tuple[str, str]] = {}


def _twin(family: str, level: float) -> tuple[str, str]:
    light, dark = PALETTE[family]
    if level < 0:
        return _mix(light, PAPER, -0.42 * level), _mix(dark, PALETTE["paper"][1], -0.30 * level)
    return _mix(light, "#000000", 0.42 * level), _mix(dark, "#ffffff", 0.5 * level)


def colour_variables() -> dict[str, tuple[str, str]]:
    """CSS variable -> (light, dark) for the palette and every shade asked for so far."""
    named = {f"--{name}": pair for name, pair in PALETTE.items()}
    return named | {
        f"--{family}-{light[1:]}": (light, dark)
        for (family, _), (light, dark) in sorted(_SHADES.items())
        if light != PALETTE[family][0]
    }


def settings() -> AbstractContextManager:
    """The context in which panels are drawn and saved: the user's own settings of matplotlib do not reach it."""
    return matplotlib.style.context(LOOK, after_reset=True)


@dataclass(frozen=True)
class Panel:
    """One drawing: `svg` for a page, and its files `<name>.svg`, `.png`, `.csv` in the report's figures folder."""

    name: str
    alt: str
    svg: str
    hover: dict | None = None


@dataclass
class Canvas:
    """One panel while it is drawn. `series` collects what hovering shows; `table` is the CSV behind the drawing, SI."""

    name: str
    alt: str
    figure: Figure
    axes: object
    series: list[dict] = field(default_factory=list)
    table: pd.DataFrame = field(default_factory=pd.DataFrame)
    hover_x: str = ""
    hover_unit: str = ""
    labels: list[tuple] = field(default_factory=list)
    """(x, y, text, colour) of what is named beside the axes."""
    leaders: bool = True
    """Names stand at the height of their curves' ends; without, they are a list from the top, in their own order."""


def canvas(
    name: str,
    alt: str,
    *,
    width: float = PANEL_WIDTH,
    height: float = PANEL_HEIGHT,
    left: float = 0.62,
    right: float = 1.25,
    bottom: float = 0.50,
    top: float = 0.32,
) -> Canvas:
    """An empty panel with margins in inches; a strip for the version stamp is added below."""
    figure = Figure(figsize=(width, height + STAMP_HEIGHT))
    FigureCanvasAgg(figure)
    total = height + STAMP_HEIGHT
    axes = figure.add_axes(
        [left / width, (bottom + STAMP_HEIGHT) / total, (width - left - right) / width, (height - bottom - top) / total]
    )
    return Canvas(name, alt, figure, axes)


def end_labels(canvas: Canvas, size: float = SMALL) -> None:
    """Write the collected labels (x, y, text, colour) right of the axes, moved apart vertically where they would
    touch.
    """
    if not canvas.labels:
        return
    _make_room(canvas, size)
    canvas.labels = [(x, y, text, text_colour(colour)) for x, y, text, colour in canvas.labels if x == x and y == y]
    if canvas.leaders:
        _label_ends(canvas, size)
    else:
        _list_labels(canvas, size)


def _list_labels(canvas: Canvas, size: float) -> None:
    """The labels as a list from the top, in their own order."""
    axes, height, step = canvas.axes, canvas.axes.get_window_extent().height, _line_height(canvas, size)
    for n, (_, _, text, colour) in enumerate(canvas.labels):
        y = 1 - (n + 0.5) * step / height
        axes.text(1.04, y, text, transform=axes.transAxes, fontsize=size, color=colour, va="center")


def _label_ends(canvas: Canvas, size: float) -> None:
    """The labels beside the ends of their curves, each with a line to its end."""
    axes, height, step = canvas.axes, canvas.axes.get_window_extent().height, _line_height(canvas, size)
    ends = axes.transAxes.inverted().transform(axes.transData.transform([(x, y) for x, y, _, _ in canvas.labels]))
    wanted = ends[:, 1] * height
    order = np.argsort(wanted, kind="stable")
    placed = _apart(np.clip(wanted[order], 0, height), step, -step / 2, height + step / 2)
    leader = {"arrowstyle": "-", "linewidth": 0.6, "alpha": 0.6, "shrinkA": 1, "shrinkB": 3, "relpos": (0, 0.5)}
    for position, n in zip(placed, order, strict=True):
        _, _, text, colour = canvas.labels[n]
        axes.annotate(
            text,
            xy=ends[n],
            xytext=(1.05, position / height),
            xycoords="axes fraction",
            textcoords="axes fraction",
            fontsize=size,
            color=colour,
            va="center",
            ha="left",
            annotation_clip=False,
            arrowprops=leader | {"color": colour},
        )


def _line_height(canvas: Canvas, size: float) -> float:
    """Of text of `size` points, in pixels."""
    return size * 1.25 * canvas.figure.dpi / 72


def _make_room(canvas: Canvas, size: float) -> None:
    """Narrow the axes until the longest label fits beside them; a browser may draw it a little wider."""
    renderer, widest = canvas.figure.canvas.get_renderer(), 0.0
    for _, _, text, _ in canvas.labels:
        trial = canvas.figure.text(0, 0, text, fontsize=size)
        widest = max(widest, 1.08 * trial.get_window_extent(renderer).width / canvas.figure.bbox.width)
        trial.remove()
    place = canvas.axes.get_position()
    room = (1 - widest - place.x0) / 1.06
    if room < place.width:
        canvas.axes.set_position([place.x0, place.y0, max(room, 0.3), place.height])
        label = canvas.axes.xaxis.label
        width = canvas.figure.text(0, 0, label.get_text(), fontsize=label.get_fontsize())
        if width.get_window_extent(renderer).width > 0.95 * canvas.axes.get_window_extent().width:
            label.set_horizontalalignment("left")
            label.set_x(-0.25)
        width.remove()


def _apart(positions: np.ndarray, step: float, low: float, high: float) -> np.ndarray:
    """Sorted positions moved as little as needed to be `step` apart within low..high (closer where there is no
    room).
    """
    count = len(positions)
    step = min(step, (high - low) / max(count - 1, 1))
    placed = positions.astype(float).copy()
    for _ in range(200):
        moved = False
        for k in range(count - 1):
            lack = step - (placed[k + 1] - placed[k])
            if lack > 1e-6:
                placed[k] -= lack / 2
                placed[k + 1] += lack / 2
                moved = True
        placed = np.clip(placed, low, high)
        if not moved:
            break
    return placed


def save(canvas: Canvas, folder: Path, stamp: str, codes: Sequence[str] = ()) -> Panel:
    """Write `<name>.svg`, `.png` and `.csv` into `folder` and return the panel for a page.

    codes   those whose signs the files must explain; a page does it above the panels
    """
    end_labels(canvas)
    height = canvas.figure.get_size_inches()[1]
    _sign(canvas, stamp, codes)
    hover = _hover(canvas, height)
    with matplotlib.rc_context({"svg.hashsalt": canvas.name}):
        canvas.figure.savefig(
            folder / f"{canvas.name}.png",
            dpi=160,
            facecolor="white",
            metadata={"Software": None},
            pil_kwargs={"compress_level": 3},  # a tenth larger, in a third of the time
        )
        buffer = io.StringIO()
        FigureCanvasSVG(canvas.figure).print_svg(
            buffer, metadata={"Date": None, "Creator": None, "Format": None, "Type": None}
        )
    text = buffer.getvalue()
    backdrop = '<rect width="100%" height="100%" fill="#ffffff"/>'
    (folder / f"{canvas.name}.svg").write_text(re.sub(r"(<svg[^>]*>)", lambda m: m.group(1) + backdrop, text, count=1))
    canvas.table.to_csv(folder / f"{canvas.name}.csv", index=False, float_format="%.9g", lineterminator="\n")
    return Panel(canvas.name, alt_text(canvas), _inline(text, canvas, height), hover)


def _sign(canvas: Canvas, stamp: str, codes: Sequence[str]) -> None:
    """The version stamp at the lower left, and what the signs of several codes mean at the lower right."""
    width, height = canvas.figure.get_size_inches()
    look = {"color": SOFT, "va": "bottom"}
    if len(codes) > 1:
        signs = "\n".join(f"{CODE_SIGNS[code]} {CODE_NAMES[code]}" for code in codes)
        place = 1 - 0.06 / width, (STAMP_HEIGHT + 0.06) / height
        canvas.figure.text(*place, signs, fontsize=7, ha="right", gid="codes", **look)
    place = 0.06 / width, 0.05 / height
    canvas.figure.text(*place, stamp, fontsize=5.5, ha="left", gid="stamp", linespacing=1.25, **look)


TOLD = 6
"""Curves whose ends an alternative text tells."""


def alt_text(canvas: Canvas) -> str:
    """What the panel shows, and where its curves end."""
    ends = []
    for series in canvas.series[:TOLD]:
        at = [(x, y) for x, y in zip(series["x"], series["y"], strict=True) if y is not None]
        if at:
            ends.append(
                f"{series['label']} {at[-1][1]:.3g} {canvas.hover_unit} at {canvas.hover_x} {at[-1][0]:g}".replace(
                    "  ", " "
                )
            )
    return canvas.alt + (f". Ends: {'; '.join(ends)}" if ends else "")


def _hover(canvas: Canvas, height: float) -> dict | None:
    """Where the axes lie in the SVG (points) and what its curves hold, for the page's script."""
    if not canvas.series:
        return None
    axes = canvas.axes
    box = axes.get_position()
    width, total = canvas.figure.get_size_inches() * 72
    return {
        "box": [round(v, 2) for v in (box.x0 * width, (1 - box.y1) * total, box.width * width, box.height * total)],
        "x": [float(v) for v in axes.get_xlim()],
        "y": [float(v) for v in axes.get_ylim()],
        "logx": axes.get_xscale() == "log",
        "logy": axes.get_yscale() == "log",
        "name": canvas.hover_x,
        "unit": canvas.hover_unit,
        "series": canvas.series,
    }


def _inline(text: str, canvas: Canvas, height: float) -> str:
    """The SVG as part of a page: no stamp (the caption has it), colours as CSS variables, no ids that could clash."""
    svg = text[text.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.S)
    svg = re.sub(r'<g id="(stamp|codes)">.*?</g>', "", svg, flags=re.S)
    svg = re.sub(r"<!--.*?-->", "", svg, flags=re.S)
    svg = re.sub(r' id="(?!m[0-9a-f]{6}|p[0-9a-f]{6}|image|C[0-9a-f]{0,3}_|h[0-9a-f]{6})[^"]*"', "", svg)
    width, total = canvas.figure.get_size_inches() * 72
    shown = (height - STAMP_HEIGHT) * 72
    label = alt_text(canvas).replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    svg = re.sub(
        r"<svg[^>]*>",
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        f'viewBox="0 0 {width:g} {shown:g}" role="img" aria-label="{label}">',
        svg,
        count=1,
    )
    for variable, (light, _) in colour_variables().items():
        svg = svg.replace(light, f"var({variable})")
    svg = re.sub(r"data:image/png;base64,([A-Za-z0-9+/=\s]+)", lambda m: _smaller(m.group(1)), svg)
    return re.sub(r"\n\s*", "\n", svg).strip()


def _smaller(png: str) -> str:
    """A picture inside an SVG, as WebP."""
    picture = Image.open(io.BytesIO(base64.b64decode(png)))
    buffer = io.BytesIO()
    picture.save(buffer, "WEBP", quality=84, method=4)
    return "data:image/webp;base64," + base64.b64encode(buffer.getvalue()).decode()
