"""Beds that can be turned in a browser: one HTML file that loads nothing, written by k3d where it is installed.

k3d is the optional dependency `view` of pyproject.toml: pip install -e '.[view]'.
"""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from analysis.files import write_aside
from analysis.normalised import beds
from analysis.report.pictures import panels
from analysis.report.pictures.scene import Scene
from analysis.scenarios import derived

GLASS = 0x5C6B7A
CORNERS = np.array(list(np.ndindex(2, 2, 2)))
SIDES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
"""Of a box, as numbers of CORNERS."""
TRIANGLES = np.array([part for a, b, c, d in SIDES for part in ((a, b, c), (a, c, d))], np.uint32)


def available() -> bool:
    """True where k3d is installed."""
    return importlib.util.find_spec("k3d") is not None


def write_html(path: Path, scenes: Sequence[Scene], title: str) -> Path:
    """Write the spheres of all scenes, one after the other in time where there are several, with sleeper and plates.

    Raises ImportError without k3d. The same scenes give the same file.
    """
    import k3d

    last = scenes[-1]
    top, clump = panels.full_colour(last), derived.clump(last.scenario)
    plot = k3d.plot(grid_visible=False, camera_mode="orbit", camera_up_axis="z", name=title)
    plot += k3d.points(
        _over_time([beds.sphere_centres(s.bed, clump.half_distance_m).astype(np.float32) for s in scenes]),
        colors=_over_time([_packed(np.repeat(panels.colours_of(s, top), 2, axis=0)) for s in scenes]),
        point_size=2 * clump.radius_m,
        shader="3d",
        name="clumps",
    )
    for number, name in enumerate(("sleeper", *(f"plate {k}" for k in range(1, len(last.plates) + 1)))):
        ends = [np.array([[b.low, b.high] for b in (s.sleeper, *s.plates)][number]) for s in scenes]
        corners = [np.take_along_axis(e, CORNERS, axis=0).astype(np.float32) for e in ends]
        plot += k3d.mesh(_over_time(corners), TRIANGLES, color=GLASS, opacity=0.3, side="double", name=name)
    for number, part in enumerate(plot.objects):
        part.id = number  # k3d takes an address in memory
    plot.camera = [1.02, -0.66, 0.72, 0.42, 0.3, 0.2, 0, 0, 1]  # the bed fills a wide window
    text = plot.get_snapshot(9)
    text = re.sub(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d UTC", title, text)
    write_aside(path, text)
    return path


def _over_time(values: list[np.ndarray]) -> np.ndarray | dict[str, np.ndarray]:
    """One array, or one for each second, as k3d takes them."""
    return values[0] if len(values) == 1 else {str(n): value for n, value in enumerate(values)}


def _packed(colours: np.ndarray) -> np.ndarray:
    """RGB 0-1 (n, 3) as k3d's numbers 0xRRGGBB."""
    r, g, b = np.rint(255 * colours).astype(np.uint32).T
    return (r << 16) + (g << 8) + b
