"""The sketch of the apparatus as SVG, to scale, every number from the scenario file.

Two views: along the sleeper (x to the right, z up), cut in the middle, and across it (y to the right). The drawing has
a background of its own and a second set of colours for dark pages.
"""

from __future__ import annotations

import math
from html import escape

from analysis.formats.quantities import SPHERE_NAMES
from analysis.scenarios import derived
from analysis.scenarios.scenario import Scenario, load_scenario
from analysis.scenarios.study_list import key_scenarios

WIDTH, HEIGHT, SCALE = 1000, 444, 520.0
"""Of the drawing, and pixels per metre."""
FLOOR, LEFT, RIGHT = 400, 74, 664
"""Where the floor is, and the left ends of the two views."""
STYLE = """
#apparatus { font: 15px system-ui, 'DejaVu Sans', sans-serif; }
#apparatus .paper { fill: #ffffff; } #apparatus .ballast { fill: #e9e4da; } #apparatus .steel { fill: #b9c4ce; }
#apparatus text { fill: #1b1f24; } #apparatus .soft { fill: #57606a; font-size: 14px; }
#apparatus .line { stroke: #1b1f24; fill: none; stroke-width: 1.5; } #apparatus .wall { stroke-width: 4; }
#apparatus .thin { stroke: #57606a; fill: none; stroke-width: 1; }
#apparatus .sphere { stroke: #006dbd; fill: none; stroke-width: 1.8; stroke-dasharray: 6 4; }
#apparatus .name { fill: #00569a; } #apparatus .load { stroke: #ab2500; stroke-width: 2.2; fill: none; }
#apparatus .head { fill: #ab2500; } #apparatus .told { fill: #ab2500; } #apparatus .stone { fill: #a39781; }
@media (prefers-color-scheme: dark) {
#apparatus .paper { fill: #14181d; } #apparatus .ballast { fill: #332f28; } #apparatus .steel { fill: #4a5560; }
#apparatus text { fill: #e8eaed; } #apparatus .soft { fill: #a8b1ba; }
#apparatus .line { stroke: #e8eaed; } #apparatus .thin { stroke: #a8b1ba; }
#apparatus .sphere { stroke: #59b2f9; } #apparatus .name { fill: #7cc3fb; } #apparatus .load { stroke: #f88c54; }
#apparatus .head { fill: #f88c54; } #apparatus .told { fill: #f9a477; } #apparatus .stone { fill: #8a7f6b; }
}"""


class Drawing:
    """SVG elements one after the other; positions in pixels."""

    def __init__(self):
        self.parts: list[str] = []

    def box(self, kind: str, x: float, y: float, width: float, height: float) -> None:
        self.parts.append(f'<rect class="{kind}" x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"/>')

    def line(self, kind: str, *points: tuple[float, float]) -> None:
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self.parts.append(f'<polyline class="{kind}" points="{path}"/>')

    def circle(self, kind: str, x: float, y: float, radius: float) -> None:
        self.parts.append(f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}"/>')

    def text(self, x: float, y: float, words: str, kind: str = "", anchor: str = "middle") -> None:
        kind = f' class="{kind}"' if kind else ""
        self.parts.append(f'<text{kind} x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(words)}</text>')

    def arrow(self, x: float, y: float, to_x: float, to_y: float, size: float = 8.0) -> None:
        """From (x, y) to a head at (to_x, to_y); along an axis."""
        self.line("load", (x, y), (to_x, to_y))
        length = math.hypot(to_x - x, to_y - y)
        u, v = (to_x - x) / length * size, (to_y - y) / length * size
        corners = ((to_x, to_y), (to_x - u + v / 2, to_y - v - u / 2), (to_x - u - v / 2, to_y - v + u / 2))
        self.parts.append(f'<polygon class="head" points="{" ".join(f"{a:.1f},{b:.1f}" for a, b in corners)}"/>')

    def span(self, x: float, to_x: float, y: float, words: str) -> None:
        """A dimension: a thin line with ticks, its text below."""
        self.line("thin", (x, y), (to_x, y))
        for end in (x, to_x):
            self.line("thin", (end, y - 5), (end, y + 5))
        self.text((x + to_x) / 2, y + 17, words, "soft")


def svg(scenario: Scenario | None = None) -> str:
    """The sketch of a scenario's apparatus, by default the linear key scenario at full size."""
    s = scenario or load_scenario(key_scenarios()[0], "full")
    box, d = derived.apparatus(s), Drawing()
    d.box("paper", 0, 0, WIDTH, HEIGHT)
    _along(d, s, box)
    _across(d, s, box)
    low, high = (s[f"loading.stress_{end}"] * box.sleeper_area_m2 / 1e3 for end in ("min", "max"))
    told = (
        f"Sketch of the test, to scale. A box {_mm(box.length_m)} long, {_mm(box.width_m)} wide and "
        f"{_mm(box.height_m)} high holds the ballast. A sleeper on top presses on it with {low:.3g} to {high:.3g} kN "
        f"at {s['loading.frequency']:g} Hz. Five plates at one end carry {s['preload.plate_stress'] / 1e3:g} kPa. "
        "Three measurement spheres lie under the sleeper."
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" id="apparatus" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'aria-label="{escape(told)}">\n<title>{escape(told)}</title>\n<style>{STYLE}\n</style>\n'
        + "\n".join(d.parts)
        + "\n</svg>\n"
    )


def _mm(metres: float) -> str:
    return f"{metres * 1e3:.4g} mm"


def _along(d: Drawing, scenario: Scenario, box: derived.Apparatus) -> None:
    def x(metres: float) -> float:
        return LEFT + metres * SCALE

    def z(metres: float) -> float:
        return FLOOR - metres * SCALE

    sleeper = box.sleeper
    top, base = z(sleeper.high[2]), z(sleeper.low[2])
    d.text(x(0), 24, "Along the sleeper, cut in the middle", anchor="start")
    d.box("ballast", x(0), base, box.length_m * SCALE, FLOOR - base)
    d.box("steel", x(0), top, sleeper.high[0] * SCALE, base - top)
    d.line("line", (x(0), top), (x(sleeper.high[0]), top), (x(sleeper.high[0]), base), (x(0), base))
    d.line("line wall", (x(0), top), (x(0), FLOOR), (x(box.length_m), FLOOR))
    d.line("line wall", (x(box.length_m) + 4, top), (x(box.length_m) + 4, z(box.fixed_wall.low[2])))
    d.text(x(0.4), top + 24, f"sleeper, {_mm(sleeper.high[0])} long, free in z only")
    for k, (centre, name) in enumerate(zip(box.measurement_centres_m, SPHERE_NAMES, strict=True), start=1):
        d.circle("sphere", x(centre[0]), z(centre[2]), box.measurement_radius_m * SCALE)
        d.text(x(centre[0]), z(centre[2]) - 2, str(k), "name")
        d.text(x(centre[0]), z(centre[2]) + 16, name, "name")
    _plates(d, scenario, box, x, z)
    _load(d, scenario, box, x, top)
    d.span(x(0), x(box.length_m), FLOOR + 18, _mm(box.length_m))
    d.line("thin", (LEFT - 16, FLOOR), (LEFT - 16, top))
    for metres in (0.0, sleeper.low[2], box.height_m):
        d.line("thin", (LEFT - 21, z(metres)), (LEFT - 11, z(metres)))
        d.text(LEFT - 26, z(metres) + 5, f"{metres * 1e3:g}", "soft", "end")
    d.text(LEFT - 26, top - 12, "z, mm", "soft", "end")


def _plates(d: Drawing, scenario: Scenario, box: derived.Apparatus, x, z) -> None:
    right = x(box.plates[0].high[0])
    for k, plate in enumerate(box.plates, start=1):
        height = (plate.high[2] - plate.low[2]) * SCALE
        d.box("steel", x(plate.low[0]), z(plate.high[2]), right - x(plate.low[0]), height)
        d.text((x(plate.low[0]) + right) / 2, z(plate.low[2]) - height / 2 + 5, str(k))
        middle = z((plate.low[2] + plate.high[2]) / 2)
        d.arrow(right + 26, middle, right + 3, middle, 7)
    newton = scenario["preload.plate_stress"] * box.plate_area_m2
    beside = (z(box.plates[-1].high[2]) + FLOOR) / 2
    for n, words in enumerate(
        ("five plates,", "free in x only", f"{scenario['preload.plate_stress'] / 1e3:g} kPa each", f"({newton:.3g} N)")
    ):
        d.text(right + 32, beside - 24 + 18 * n, words, "told" if n > 1 else "", "start")
    d.text(right + 8, z(box.height_m) + 30, "fixed wall", "soft", "start")


def _load(d: Drawing, scenario: Scenario, box: derived.Apparatus, x, top: float) -> None:
    low, high = (scenario[f"loading.stress_{end}"] for end in ("min", "max"))
    middle = x(box.length_m / 2)
    for share in (-0.16, 0, 0.16):
        d.arrow(middle + share * box.length_m * SCALE, top - 44, middle + share * box.length_m * SCALE, top - 4)
    forces = [stress * box.sleeper_area_m2 / 1e3 for stress in (low, high)]
    d.text(
        middle,
        top - 74,
        f"{forces[0]:.3g} to {forces[1]:.3g} kN at {scenario['loading.frequency']:g} Hz, "
        f"{scenario['loading.cycles']} cycles",
        "told",
    )
    d.text(middle, top - 54, f"({low / 1e3:g} to {high / 1e3:g} kPa on the base)", "told")
    start, step, height = middle + 125, 1.6, 16.0
    wave = [(start + step * n, top - 24 + height * math.cos(2 * math.pi * n / 20)) for n in range(41)]
    d.line("load", *wave)


def _across(d: Drawing, scenario: Scenario, box: derived.Apparatus) -> None:
    def y(metres: float) -> float:
        return RIGHT + metres * SCALE

    def z(metres: float) -> float:
        return FLOOR - metres * SCALE

    sleeper, top = box.sleeper, z(box.height_m)
    d.text(y(0), 24, "Across the sleeper", anchor="start")
    d.box("ballast", y(0), top, box.width_m * SCALE, FLOOR - top)
    d.box("steel", y(sleeper.low[1]), top, (sleeper.high[1] - sleeper.low[1]) * SCALE, z(sleeper.low[2]) - top)
    corners = [(sleeper.low[1], box.height_m), (sleeper.low[1], sleeper.low[2])]
    corners += [(sleeper.high[1], sleeper.low[2]), (sleeper.high[1], box.height_m)]
    d.line("line", *((y(a), z(b)) for a, b in corners))
    d.line("line wall", (y(0), top), (y(0), FLOOR), (y(box.width_m), FLOOR), (y(box.width_m), top))
    middle = box.width_m / 2
    d.text(y(middle), top + 24, "sleeper")
    d.arrow(y(middle), top - 44, y(middle), top - 4)
    for side in (sleeper.low[1] / 2, (sleeper.high[1] + box.width_m) / 2):
        d.text(y(side), top + 24, "crib")
    centre = box.measurement_centres_m[0]
    d.circle("sphere", y(middle), z(centre[2]), box.measurement_radius_m * SCALE)
    d.text(y(middle), z(centre[2]) - 2, "sphere", "name")
    d.text(y(middle), z(centre[2]) + 16, f"r = {_mm(box.measurement_radius_m)}", "name")
    crib, wide = sleeper.low[1], sleeper.high[1] - sleeper.low[1]
    for start, end in ((0, crib), (crib, crib + wide), (crib + wide, box.width_m)):
        d.span(y(start), y(end), FLOOR + 18, _mm(end - start))
    _clump(d, scenario, y(0.09), z(0.06))


def _clump(d: Drawing, scenario: Scenario, x: float, y: float) -> None:
    """One clump to scale, with its name."""
    clump = derived.clump(scenario)
    for side in (-1, 1):
        d.circle("stone", x + side * clump.half_distance_m * SCALE, y, clump.radius_m * SCALE)
    d.text(x, y - 16, "a clump", "soft")
