"""The figures of the report, each drawn from whatever runs there are: one function per figure.

A figure is a few panels with one caption. Runs of one scenario and code with several seeds become one curve, the
longest of them, with a band.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.patches import Circle, Rectangle
from matplotlib.ticker import MaxNLocator, NullFormatter

from . import compare, derived, laws, quantities, style, tables, view
from .readers import Run, Runs
from .reference import References, settlement_laws
from .scenario import Scenario
from .style import CODE_NAMES, CODE_SIGNS, CODE_STYLES, OTHER_STYLE, PAPER, SOFT, Canvas, Panel

MM, KPA = 1e3, 1e-3
PROFILE_CYCLES = (1, 100, 1000)
"""Cycles after which the paper shows lateral displacement over depth."""
SPHERE_NAMES = ("rail seat", "middle", "shoulder")
MODE_NAMES = {0: "Gonthier", 1: "Lankarani–Nikravesh", 2: "Zhiying–Qishao"}


SOURCE_NAMES = {
    "indraratna2013": "experiment of Indraratna 2013",
    "chen2015": "simulation of Chen 2015",
    "talebiahooie2021": "the paper's own simulation",
}


@dataclass
class Figure:
    """Panels with a caption; `pending` names the reference curves that would be drawn, were they there."""

    name: str
    title: str
    caption: str
    panels: list[Panel]
    runs: list[str] = field(default_factory=list)
    key: list[dict] = field(default_factory=list)
    pending: list[str] = field(default_factory=list)
    layout: str = ""


@dataclass
class Curve:
    """All runs of one scenario and code, one per seed, and how they are drawn."""

    scenario: str
    code: str
    runs: list[Run]
    colour: str
    look: dict
    label: str
    """In full, for hovering."""
    tag: str
    """Short, beside the curve: the code is a sign."""
    family: str

    @property
    def setup(self) -> Scenario | None:
        return self.runs[0].scenario

    @property
    def main(self) -> Run:
        """The run that is drawn as a line: the longest, of equals that with the lowest seed."""
        return max(self.runs, key=lambda run: (run.cycles["cycle"].max(), -run.seed))

    def column(self, name: str, table: str = "cycles") -> pd.DataFrame:
        """The main run's values against `cycle`, and the lowest and highest of all seeds there, SI; rows with a
        value.
        """
        values = getattr(self.main, table).set_index("cycle")[name].rename("value")
        if len(self.runs) == 1:
            return pd.DataFrame({"value": values, "low": values, "high": values}).dropna()
        bands = compare.seed_bands(getattr(Runs(self.runs), table), [name]).set_index("cycle")
        return pd.DataFrame({"value": values, "low": bands[f"{name}_low"], "high": bands[f"{name}_high"]}).dropna()


def family_of(scenario: Scenario | None) -> str:
    """Which hue a scenario gets: linear, nonlinear (e_n = 1), md0, md1, md2, or other where its parameters are
    unknown.
    """
    if scenario is None:
        return "other"
    if scenario["contact.model"] == "linear":
        return "linear"
    if scenario["contact.particle_particle.restitution"] == 1:
        return "nonlinear"
    return f"md{scenario['contact.particle_particle.damping_mode']}"


def short_name(scenario: str) -> str:
    """`linear-mu0.8` as a reader of the paper writes it: linear μ 0.8."""
    for pattern, text in (
        (r"linear-mu([\d.]+)", r"linear μ \1"),
        (r"nonlinear-en1(?:\.0)?", "nonlinear eₙ 1"),
        (r"nonlinear-md(\d)-en([\d.]+)", r"M_d \1, eₙ \2"),
    ):
        if re.fullmatch(pattern, scenario):
            return re.sub(pattern, text, scenario).replace("M_d ", "Md ")
    return scenario


class Gallery:
    """Draws figures into `folder`, with the same look for the same scenario and code throughout."""

    def __init__(
        self,
        folder: Path,
        stamp: str,
        runs: Runs,
        references: References,
        order: Sequence[str],
        problems: list[str] | None = None,
    ):
        """`problems` collects what could not be drawn, one line each."""
        self.folder, self.stamp, self.references = folder, stamp, references
        folder.mkdir(parents=True, exist_ok=True)
        self.figures: list[Figure] = []
        self.problems = [] if problems is None else problems
        self._levels = self._shades(runs, order)

    @staticmethod
    def _shades(runs: Runs, order: Sequence[str]) -> dict[str, tuple[str, float]]:
        """Scenario -> (family, level): members of a family go from pale to deep in the order of the scenario file."""
        families: dict[str, list[str]] = {}
        setups = {run.scenario_name: run.scenario for run in runs}
        for name in [*order, *sorted(set(setups) - set(order))]:
            families.setdefault(
                _family_by_name(name) if setups.get(name) is None else family_of(setups[name]), []
            ).append(name)
        levels = {}
        for family, names in families.items():
            for n, name in enumerate(names):
                levels[name] = (family, 0.0 if len(names) == 1 else -1 + 2 * n / (len(names) - 1))
        return levels

    def complain(self, line: str) -> None:
        """Say once what could not be drawn."""
        if line not in self.problems:
            self.problems.append(line)
            print(f"warning: {line}", file=sys.stderr)

    def look(self, scenario: str) -> tuple[str, str]:
        """(colour, family) of a scenario."""
        family, level = self._levels.get(scenario, ("other", 0.0))
        return style.shade(family, level), family

    def curves(self, runs: Iterable[Run]) -> list[Curve]:
        """Runs with at least one cycle, gathered by scenario and code."""
        groups: dict[tuple[str, str], list[Run]] = {}
        for run in runs:
            if len(run.cycles):
                groups.setdefault((run.scenario_name, run.code), []).append(run)
        codes = {code for _, code in groups}
        found = []
        for (scenario, code), members in groups.items():
            colour, family = self.look(scenario)
            sign = f" {CODE_SIGNS.get(code, '◆')}" if len(codes) > 1 else ""
            label = f"{short_name(scenario)} {CODE_NAMES.get(code, code)}" + (
                f", {len(members)} seeds" if len(members) > 1 else ""
            )
            found.append(
                Curve(
                    scenario,
                    code,
                    members,
                    colour,
                    CODE_STYLES.get(code, OTHER_STYLE),
                    label,
                    short_name(scenario) + sign,
                    family,
                )
            )
        rank = list(self._levels)
        return sorted(found, key=lambda c: (rank.index(c.scenario) if c.scenario in rank else len(rank), c.code))

    def finish(
        self,
        name: str,
        title: str,
        caption: str,
        drawn: Iterable[Canvas | None],
        runs: Iterable[Run],
        curves: Sequence[Curve] = (),
        pending: Sequence[str] = (),
        layout: str = "",
    ) -> Figure | None:
        """Save the panels and keep the figure; None where nothing was drawn."""
        drawn = [c for c in drawn if c is not None]
        if not drawn:
            return None
        ids = list(dict.fromkeys(run_id(run) for run in runs))
        stamp = self.stamp + ("\n" + _shortened(ids) if ids else "")
        panels = [style.save(c, self.folder, stamp) for c in drawn]
        figure = Figure(name, title, caption, panels, ids, _key(curves), list(pending), layout)
        self.figures.append(figure)
        return figure


def run_id(run: Run) -> str:
    """What a run is, in one word: its folder and the hash of its parameters."""
    known = run.info.get("scenario_hash") or (run.scenario.hash if run.scenario else "unknown")
    return f"{run.id}@{known[:8]}"


def _shortened(ids: list[str], room: int = 230) -> str:
    text = "runs: " + ", ".join(ids)
    if len(text) <= room:
        return "\n".join(text[n : n + 118] for n in range(0, len(text), 118))
    return f"{len(ids)} runs, listed under the figure in the report"


def _family_by_name(name: str) -> str:
    if name.startswith("linear"):
        return "linear"
    found = re.match(r"nonlinear-md([012])", name)
    return f"md{found.group(1)}" if found else "nonlinear" if name.startswith("nonlinear") else "other"


def _key(curves: Sequence[Curve]) -> list[dict]:
    """What the line styles mean: one entry per code, where there is more than one."""
    codes = sorted({c.code for c in curves})
    if len(codes) < 2:
        return [{"label": f"all {CODE_NAMES.get(code, code)}", "code": code} for code in codes]
    return [{"label": CODE_NAMES.get(code, code), "code": code} for code in codes]


def thin(cycles: np.ndarray, most: int = 140) -> np.ndarray:
    """Positions of at most about `most` cycles, dense at the start and even later on: enough for a line and for
    hovering.
    """
    count = len(cycles)
    if count <= most:
        return np.arange(count)
    early = np.unique(np.geomspace(1, count, most // 2).astype(int)) - 1
    late = np.linspace(0, count - 1, most // 2).astype(int)
    return np.unique(np.concatenate([early, late]))


# ------------------------------------------------------------------ drawing helpers


def draw(
    c: Canvas,
    curve: Curve,
    table: pd.DataFrame,
    factor: float,
    label: bool = True,
    hover: bool = True,
    colour: str | None = None,
    name: str | None = None,
    tag: str | None = None,
    **look,
) -> None:
    """One curve (index = abscissa; value, low, high in SI) with its band, markers, end label and hover values."""
    if table.empty:
        return
    colour, name, tag = colour or curve.colour, name or curve.label, tag or curve.tag
    x, y = table.index.to_numpy(float), factor * table["value"].to_numpy()
    kept = thin(x)
    x, y = x[kept], y[kept]
    if (table["high"] > table["low"]).any():
        c.axes.fill_between(
            x,
            factor * table["low"].to_numpy()[kept],
            factor * table["high"].to_numpy()[kept],
            color=colour,
            alpha=0.18,
            linewidth=0,
        )
    options = (
        curve.look
        | {
            "markersize": 3.8,
            "markevery": _marks(x),
            "markeredgewidth": 1.0,
            "linewidth": 1.5 if len(x) < 30 else 1.2,
            "markerfacecolor": PAPER if curve.code == "yade" else colour,
        }
        | look
    )
    c.axes.plot(x, y, color=colour, **options)
    if label:
        c.labels.append((x[-1], y[-1], tag, colour))
    if hover:
        c.series.append(
            {
                "label": name,
                "colour": css(colour),
                "x": [float(v) for v in x],
                "y": [None if v != v else float(f"{v:.5g}") for v in y],
            }
        )


def css(colour: str) -> str:
    """A colour of a light page as the CSS variable that also has its dark twin."""
    return next((f"var({name})" for name, (light, _) in style.colour_variables().items() if light == colour), colour)


def _marks(x: np.ndarray) -> list[int]:
    if len(x) <= 12:
        return list(range(len(x)))
    wanted = np.unique(np.round(np.geomspace(max(x[0], 1), x[-1], 7)))
    return sorted({int(np.argmin(np.abs(x - w))) for w in wanted})


def _with_start(table: pd.DataFrame) -> pd.DataFrame:
    """The curve with its zero at the end of preload."""
    start = pd.DataFrame({"value": [0.0], "low": [0.0], "high": [0.0]}, index=[0])
    return pd.concat([start, table])


def _cycle_axis(c: Canvas, last: float, log: bool) -> None:
    c.axes.set_xlabel("load cycle" + (" (logarithmic)" if log else ""))
    c.hover_x = "cycle"
    if log:
        c.axes.set_xscale("log")
        c.axes.set_xlim(0.9, max(last, 2) * 1.12)
        steps = (1, 2, 5) if last <= 200 else (1,)
        ticks = [k * 10**n for n in range(7) for k in steps if k * 10**n <= max(last, 2) * 1.12]
        c.axes.set_xticks(ticks, [f"{v:g}" for v in ticks])
        c.axes.xaxis.set_minor_formatter(NullFormatter())
    else:
        c.axes.set_xlim(-0.015 * last, last * 1.015)
        c.axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))


def _rows(curves: Sequence[Curve], columns: Sequence[str], table: str = "cycles") -> pd.DataFrame:
    """The CSV behind a figure: the runs' own columns below each other."""
    frames = [
        getattr(run, table).assign(run=run.id, **run.identity)[["run", "profile", "scenario", "code", "seed", *columns]]
        for curve in curves
        for run in curve.runs
    ]
    return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=["run", *columns])


def _last(curves: Sequence[Curve]) -> float:
    return max((run.cycles["cycle"].max() for curve in curves for run in curve.runs), default=1)


def _draw_references(
    c: Canvas, rows: pd.DataFrame, coordinate: str, factor: float, across: bool = False, scale: float = 1.0
) -> None:
    """Reference curves: the experiment bold with its error band, simulations thin; named at their ends.

    across   the value is on the x axis (profiles over depth); `scale` multiplies the coordinate
    """
    for (kind, source, curve), part in rows.groupby(["kind", "source", "curve"], sort=True):
        part = part.sort_values(coordinate)
        at, value = scale * part[coordinate].to_numpy(float), factor * part["value"].to_numpy(float)
        error = factor * part["error"].fillna(0).to_numpy(float)
        experiment = kind == "experiment"
        colour = style.shade("reference") if experiment else SOFT
        look = {
            "color": colour,
            "linewidth": 2.4 if experiment else 1.3,
            "linestyle": "-" if experiment else (0, (4, 1.5, 1, 1.5)),
            "zorder": 1.9,
        }
        name = reference_name(kind, source, curve)
        if across:
            c.axes.plot(value, at, **look)
            c.axes.fill_betweenx(at, value - error, value + error, color=colour, alpha=0.15, linewidth=0)
            c.labels.append((value[-1], at[-1], name, colour))
        else:
            c.axes.plot(at, value, **look)
            c.axes.fill_between(at, value - error, value + error, color=colour, alpha=0.15, linewidth=0)
            c.labels.append((at[-1], value[-1], name, colour))
            c.series.append(
                {
                    "label": name,
                    "colour": css(colour),
                    "x": [float(f"{v:.6g}") for v in at],
                    "y": [float(f"{v:.5g}") for v in value],
                }
            )


def reference_name(kind: str, source: str, curve: str) -> str:
    """How a reference curve is named in figures."""
    if kind == "experiment":
        return "experiment"
    return {"chen2015": "Chen 2015", "talebiahooie2021": f"paper {short_name(curve)}"}.get(source, f"{source} {curve}")


def pending_names(references: References, quantity: str, scenarios: Iterable[str] = ()) -> list[str]:
    """Reference curves of a quantity that are not digitised yet: those of no scenario, and of the given scenarios."""
    rows = references.pending
    rows = rows[(rows["quantity"] == quantity) & (rows["scenario"].isin(["", *scenarios]))]
    return [
        f"{SOURCE_NAMES.get(source, source)} ({len(part)} curve{'s' if len(part) > 1 else ''})"
        for (source, kind), part in rows.groupby(["source", "kind"], sort=True)
    ]


def _pending_mark(c: Canvas, pending: Sequence[str]) -> None:
    if pending:
        c.axes.text(
            1,
            1.02,
            "reference curves pending",
            transform=c.axes.transAxes,
            fontsize=7.5,
            color=SOFT,
            ha="right",
            va="bottom",
            style="italic",
        )


def _reference_rows(references: References, quantity: str, scenarios: Iterable[str], **wanted) -> pd.DataFrame:
    rows = references.curve(quantity, **wanted)
    return rows[rows["scenario"].isin(["", *scenarios])]


# ------------------------------------------------------------------ settlement


def settlement(
    g: Gallery,
    runs: Sequence[Run],
    name: str,
    title: str,
    caption: str,
    references: bool = True,
    log_only: bool = False,
) -> Figure | None:
    """Settlement at minimum load against cycles, on a linear and on a logarithmic axis."""
    curves = g.curves(runs)
    if not curves:
        return None
    scenarios = {curve.scenario for curve in curves}
    pending = pending_names(g.references, "settlement", scenarios) if references else []
    rows = _reference_rows(g.references, "settlement", scenarios) if references else None
    drawn = []
    for log in (True,) if log_only else (False, True):
        c = style.canvas(
            f"{name}-{'log' if log else 'linear'}", f"{title}, {'logarithmic' if log else 'linear'} cycle axis"
        )
        for curve in curves:
            table = curve.column("settlement_m")
            draw(c, curve, table if log else _with_start(table), MM)
        if rows is not None and len(rows):
            _draw_references(c, rows[rows["cycle"] > 0] if log else rows, "cycle", MM)
        c.axes.invert_yaxis()
        c.axes.set_ylabel("settlement at minimum load, mm")
        c.hover_unit = "mm"
        _cycle_axis(c, _last(curves), log)
        _pending_mark(c, pending)
        c.table = _rows(curves, ["cycle", "settlement_m", "settlement_peak_m"])
        drawn.append(c)
    return g.finish(name, title, caption, drawn, runs, curves, pending)


def lateral(
    g: Gallery,
    runs: Sequence[Run],
    name: str,
    title: str,
    caption: str,
    cycles: Sequence[int] | None = None,
    references: bool = True,
) -> Figure | None:
    """Lateral displacement of the plates over depth, one panel per number of cycles."""
    curves = g.curves(runs)
    if not curves:
        return None
    cycles = cycles or shown_cycles(runs)
    scenarios = {curve.scenario for curve in curves}
    pending = pending_names(g.references, "lateral_displacement", scenarios) if references else []
    drawn = []
    for cycle in cycles:
        c = style.canvas(f"{name}-{cycle}", f"{title} after {cycle} cycle{'s' if cycle > 1 else ''}")
        c.leaders = False
        frames = []
        for curve in curves:
            table = lateral_profile(curve, cycle)
            if table.empty:
                continue
            depth = MM * table.index.to_numpy()
            colour = curve.colour
            if (table["high"] > table["low"]).any():
                c.axes.fill_betweenx(
                    depth, MM * table["low"], MM * table["high"], color=colour, alpha=0.18, linewidth=0
                )
            c.axes.plot(
                MM * table["value"],
                depth,
                color=colour,
                markersize=4.2,
                markeredgewidth=1.0,
                markerfacecolor=PAPER if curve.code == "yade" else colour,
                **curve.look,
            )
            c.labels.append((0.0, depth[-1], curve.tag, colour))
            frames.append(
                table.rename(columns={k: f"lateral_{k}_m" for k in table})
                .rename_axis("depth_m")
                .reset_index()
                .assign(
                    profile=curve.main.profile,
                    scenario=curve.scenario,
                    code=curve.code,
                    seeds=len(curve.runs),
                    cycle=cycle,
                )
            )
        if not frames:
            c.axes.text(
                0.5,
                0.5,
                f"no run has reached\ncycle {cycle} yet",
                transform=c.axes.transAxes,
                ha="center",
                va="center",
                color=SOFT,
                fontsize=9,
            )
        rows = (
            _reference_rows(g.references, "lateral_displacement", scenarios, cycle=cycle)
            if references
            else pd.DataFrame()
        )
        if len(rows):
            _draw_references(c, rows, "depth_m", MM, across=True, scale=MM)
        c.axes.set_ylim(335, -8)
        c.axes.axvline(0, color=SOFT, linewidth=0.7, zorder=1)
        c.axes.set(xlabel="outward displacement of the plates, mm", ylabel="depth below the sleeper, mm")
        c.axes.set_title(f"after {cycle} cycle{'s' if cycle > 1 else ''}")
        _pending_mark(c, pending)
        c.table = pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=["depth_m", "cycle"])
        drawn.append(c)
    return g.finish(name, title, caption, drawn, runs, curves, pending)


def lateral_profile(curve: Curve, cycle: int) -> pd.DataFrame:
    """Value, low and high of lateral displacement (m) against the depth of the plates' middles below the sleeper base
    (m).
    """
    profiles = {
        run.id: quantities.lateral_profile(run, [cycle]).dropna().set_index("depth_m")["lateral_m"]
        for run in curve.runs
    }
    together = pd.DataFrame({name: profile for name, profile in profiles.items() if len(profile)}).sort_index()
    if together.empty:
        return pd.DataFrame(columns=["value", "low", "high"])
    shown = together.get(curve.main.id, together.iloc[:, 0])
    return pd.DataFrame({"value": shown, "low": together.min(axis=1), "high": together.max(axis=1)})


def shown_cycles(runs: Iterable[Run]) -> list[int]:
    """Cycles to show profiles at: the paper's 1, 100, 1000 where some run has them, and the last that most runs
    share.
    """
    ends = [int(run.cycles["cycle"].max()) for run in runs if len(run.cycles)]
    if not ends:
        return []
    chosen = {n for n in PROFILE_CYCLES if n <= max(ends)}
    if max(chosen) * 2 <= min(ends) or len(chosen) == 1:
        chosen.add(min(ends))
    return sorted(chosen)


# ------------------------------------------------------------------ porosity, load tracking, stiffness


def porosity(g: Gallery, runs: Sequence[Run], name: str, title: str, caption: str) -> Figure | None:
    """Porosity of the three measurement spheres against cycles, one panel per scenario."""
    curves = g.curves(runs)
    drawn = []
    pending = pending_names(g.references, "porosity", {c.scenario for c in curves})
    for scenario in dict.fromkeys(curve.scenario for curve in curves):
        members = [curve for curve in curves if curve.scenario == scenario]
        family = members[0].family
        c = style.canvas(f"{name}-{scenario}", f"Porosity in the three spheres, {short_name(scenario)}")
        for curve in members:
            for k, sphere in enumerate(SPHERE_NAMES, start=1):
                colour = style.shade(family, k - 2.0)
                table = curve.column(f"porosity_{k}", "microstructure")
                if table.empty:
                    table = curve.column(f"porosity_{k}")
                draw(
                    c,
                    curve,
                    table,
                    1.0,
                    colour=colour,
                    name=f"{k} {sphere} {CODE_NAMES.get(curve.code, curve.code)}",
                    tag=f"{k} {sphere}" + (f" {CODE_SIGNS.get(curve.code, '◆')}" if len(members) > 1 else ""),
                )
        rows = g.references.curve("porosity", scenario=scenario)
        if len(rows):
            _draw_references(c, rows, "cycle", 1.0)
        c.axes.set_ylabel("porosity")
        _cycle_axis(c, _last(members), False)
        c.axes.set_title(short_name(scenario))
        _pending_mark(c, pending)
        c.table = _rows(
            members, ["cycle", *(f"porosity_{k}" for k in tables.SPHERES), "porosity_error"], "microstructure"
        )
        drawn.append(c)
    return g.finish(name, title, caption, drawn, runs, curves, pending)


def tracking(g: Gallery, runs: Sequence[Run], name: str, title: str, caption: str) -> Figure | None:
    """Tracking error per cycle, and the extremes of the measured stress against their targets."""
    curves = g.curves(runs)
    if not curves:
        return None
    error = style.canvas(f"{name}-error", "Load tracking error per cycle, rms in percent of the maximum stress")
    for curve in curves:
        top = curve.setup["loading.stress_max"] if curve.setup else 460e3
        draw(error, curve, curve.column("tracking_rms_Pa"), 100 / top)
    for limit, text in ((1, "aim, linear bed"), (2, "aim, nonlinear bed")):
        error.axes.axhline(limit, color=SOFT, linewidth=0.9, linestyle=(0, (2, 2)), zorder=1)
        error.axes.text(
            0.015,
            limit,
            text,
            fontsize=7,
            color=SOFT,
            va="bottom",
            ha="left",
            transform=error.axes.get_yaxis_transform(),
        )
    error.axes.set_ylabel("rms error, % of maximum stress")
    error.axes.set_ylim(bottom=0)
    error.hover_unit = "%"
    _cycle_axis(error, _last(curves), False)
    error.table = _rows(curves, ["cycle", "tracking_rms_Pa"])

    extremes = style.canvas(f"{name}-extremes", "Largest and smallest sleeper stress per cycle minus their targets")
    for curve in curves:
        if curve.setup is None:
            continue
        for column, target, end in (
            ("sleeper_stress_max_Pa", "loading.stress_max", "max"),
            ("sleeper_stress_min_Pa", "loading.stress_min", "min"),
        ):
            draw(
                extremes,
                curve,
                curve.column(column) - curve.setup[target],
                KPA,
                name=f"{curve.label} {end}",
                label=end == "max",
                alpha=1.0 if end == "max" else 0.55,
            )
    extremes.axes.axhline(0, color=SOFT, linewidth=0.7, zorder=1)
    extremes.axes.set_ylabel("measured minus target stress, kPa")
    extremes.hover_unit = "kPa"
    _cycle_axis(extremes, _last(curves), False)
    extremes.table = _rows(curves, ["cycle", "sleeper_stress_min_Pa", "sleeper_stress_max_Pa"])
    return g.finish(name, title, caption, [error, extremes], runs, curves)


def stress_signal(
    g: Gallery, runs: Sequence[Run], name: str, title: str, caption: str, cycles: int = 3
) -> Figure | None:
    """The paper's Figure 6: vertical stress on the sleeper against time, target and what each run measured."""
    curves = [curve for curve in g.curves(runs) if len(curve.main.history)]
    setup = next((curve.setup for curve in curves if curve.setup is not None), None)
    if setup is None:
        return None
    panels = []
    for code in sorted({curve.code for curve in curves}):
        c = style.canvas(
            f"{name}-{code}",
            f"Vertical stress on the sleeper, target and measured, {CODE_NAMES.get(code, code)}",
            right=1.2,
        )
        time = np.linspace(0, cycles / setup["loading.frequency"], 400)
        low, high = setup["loading.stress_min"], setup["loading.stress_max"]
        target = (high + low) / 2 - (high - low) / 2 * np.cos(2 * np.pi * setup["loading.frequency"] * time)
        c.axes.plot(1e3 * time, KPA * target, color=SOFT, linewidth=3.4, alpha=0.35, solid_capstyle="butt")
        c.labels.append((1e3 * time[-1], KPA * target[-1], "target", SOFT))
        frames = []
        for curve in (curve for curve in curves if curve.code == code):
            history = curve.main.history
            part = history[history["cycle"] <= cycles + 1e-9]
            c.axes.plot(1e3 * part["time_s"], KPA * part["sleeper_stress_Pa"], color=curve.colour, linewidth=1.1)
            c.labels.append(
                (
                    1e3 * part["time_s"].iloc[-1],
                    KPA * part["sleeper_stress_Pa"].iloc[-1],
                    short_name(curve.scenario),
                    curve.colour,
                )
            )
            frames.append(part[["time_s", "cycle", "sleeper_target_Pa", "sleeper_stress_Pa"]].assign(run=curve.main.id))
        c.axes.set(xlabel="time from the start of loading, ms", ylabel="stress on the sleeper, kPa")
        c.axes.set_title(CODE_NAMES.get(code, code))
        c.axes.set_ylim(0, 1.12 * KPA * high)
        c.table = pd.concat(frames, ignore_index=True)
        panels.append(c)
    return g.finish(name, title, caption, panels, [curve.main for curve in curves])


def micro(
    g: Gallery,
    runs: Sequence[Run],
    name: str,
    title: str,
    caption: str,
    quantities: Sequence[tuple[str, str, float, str]],
) -> Figure | None:
    """Columns of microstructure.csv against cycles, one panel each: (column, axis label, factor, unit)."""
    curves = [curve for curve in g.curves(runs) if len(curve.main.microstructure)]
    drawn = []
    for column, label, factor, unit in quantities:
        c = style.canvas(f"{name}-{column}", label, height=2.7)
        for curve in curves:
            draw(c, curve, curve.column(column, "microstructure"), factor)
        if not c.series:
            continue
        c.axes.set_ylabel(label)
        c.hover_unit = unit
        _cycle_axis(c, _last(curves), False)
        c.table = _rows(curves, ["cycle", column], "microstructure")
        drawn.append(c)
    return g.finish(name, title, caption, drawn, runs, curves)


def strokes(g: Gallery, runs: Sequence[Run], name: str, title: str, caption: str) -> Figure | None:
    """Resilient stroke, secant stiffness and loop energy per cycle."""
    curves = g.curves(runs)
    measured = {curve.label: quantities.per_cycle(curve.main).set_index("cycle") for curve in curves}
    drawn = []
    for column, label, factor, unit in (
        ("resilient_stroke_m", "resilient stroke, mm", MM, "mm"),
        ("secant_stiffness_N_m", "secant stiffness, kN/mm", 1e-6, "kN/mm"),
        ("loop_energy_J", "work lost per cycle, J", 1.0, "J"),
    ):
        c = style.canvas(f"{name}-{column}", label, height=2.7)
        for curve in curves:
            values = measured[curve.label][column].dropna()
            draw(c, curve, pd.DataFrame({"value": values, "low": values, "high": values}), factor)
        if not c.series:
            continue
        c.axes.set_ylabel(label)
        c.hover_unit = unit
        _cycle_axis(c, _last(curves), False)
        c.table = pd.concat(
            [measured[curve.label][[column]].reset_index().assign(run=curve.main.id) for curve in curves],
            ignore_index=True,
        )
        drawn.append(c)
    return g.finish(name, title, caption, drawn, [curve.main for curve in curves], curves)


def shapes(g: Gallery, runs: Sequence[Run], name: str, title: str, caption: str) -> Figure | None:
    """Settlement over that after the first cycle, with published laws: shapes alone."""
    curves = [curve for curve in g.curves(runs) if curve.main.cycles["cycle"].max() >= 2]
    if not curves:
        return None
    c = style.canvas(name, title, right=1.9, width=5.6)
    last, frames = _last(curves), []
    for curve in curves:
        table = curve.column("settlement_m")[["value"]]
        first = table["value"].get(1, np.nan)
        if not first > 0:
            continue
        draw(c, curve, pd.DataFrame({n: table["value"] / first for n in ("value", "low", "high")}), 1.0)
        frames.append(pd.DataFrame({"cycle": table.index, "shape": table["value"] / first, "curve": curve.main.id}))
    cycles = np.geomspace(1, max(last, 2), 60)
    for law in settlement_laws():
        shape = law.ratio(cycles)
        c.axes.plot(cycles, shape, color=SOFT, linewidth=1, linestyle=(0, (3, 1.5)), zorder=1)
        c.labels.append((cycles[-1], shape[-1], law.label, SOFT))
        frames.append(pd.DataFrame({"cycle": cycles, "shape": shape, "curve": law.id}))
    c.axes.set_ylabel("settlement over that after the first cycle")
    _cycle_axis(c, last, True)
    c.table = pd.concat(frames, ignore_index=True)
    return g.finish(name, title, caption, [c], [curve.main for curve in curves], curves)


def loops(g: Gallery, runs: Sequence[Run], name: str, title: str, caption: str) -> Figure | None:
    """Stress on the sleeper against its settlement in a few cycles, one panel per scenario."""
    curves = [curve for curve in g.curves(runs) if len(curve.main.history)]
    drawn = []
    for scenario in dict.fromkeys(curve.scenario for curve in curves):
        members = [curve for curve in curves if curve.scenario == scenario]
        c = style.canvas(f"{name}-{scenario}", f"Stress against settlement, {short_name(scenario)}", right=1.2)
        frames = []
        for curve in members:
            history = curve.main.history
            last = int(np.floor(history["cycle"].max() + 1e-9))
            for cycle in sorted({1, last}):
                part = history[(history["cycle"] >= cycle - 1 - 1e-9) & (history["cycle"] <= cycle + 1e-9)]
                if len(part) < 8:
                    continue
                c.axes.plot(
                    MM * part["settlement_m"],
                    KPA * part["sleeper_stress_Pa"],
                    color=curve.colour,
                    linestyle=curve.look["linestyle"],
                    linewidth=1.3,
                    alpha=0.5 if cycle == 1 and last > 1 else 1,
                )
                end = part.loc[part["sleeper_stress_Pa"].idxmax()]
                if curve is members[0]:
                    c.axes.annotate(
                        f"cycle {cycle}",
                        (MM * end["settlement_m"], KPA * end["sleeper_stress_Pa"]),
                        (0, 4),
                        textcoords="offset points",
                        fontsize=7.5,
                        color=curve.colour,
                        ha="center",
                    )
                frames.append(part[["cycle", "settlement_m", "sleeper_stress_Pa"]].assign(run=curve.main.id))
            if frames:
                c.labels.append(
                    (
                        MM * part["settlement_m"].iloc[-1],
                        KPA * part["sleeper_stress_Pa"].iloc[-1],
                        CODE_NAMES.get(curve.code, curve.code),
                        curve.colour,
                    )
                )
        if not frames:
            continue
        c.axes.set(xlabel="settlement, mm", ylabel="stress on the sleeper, kPa")
        c.axes.set_ylim(0, 520)
        c.axes.set_title(short_name(scenario))
        c.table = pd.concat(frames, ignore_index=True)
        drawn.append(c)
    return g.finish(name, title, caption, drawn, [curve.main for curve in curves], curves)


# ------------------------------------------------------------------ figures without runs


def restitution(g: Gallery) -> Figure:
    """The paper's Figure 9 and what follows from it: damping factor and effective restitution against nominal e_n."""
    nominal = np.linspace(0, 1, 101)
    factor = style.canvas(
        "figure9-damping-factor", "Damping factor D against nominal restitution for the three damping modes", right=1.5
    )
    effect = style.canvas("figure9-restitution", "Restitution of a free impact against nominal restitution", right=1.5)
    rows = []
    for mode in (0, 1, 2):
        colour, text = style.shade(f"md{mode}"), f"Md {mode}, {MODE_NAMES[mode].split('–')[0]}"
        e = nominal[1:] if mode == 0 else nominal
        d = np.array([laws.damping_factor(mode, float(v)) for v in e])
        out = np.array([laws.effective_restitution(float(v)) for v in d])
        factor.axes.plot(e, d, color=colour)
        effect.axes.plot(e, out, color=colour)
        for c in (factor, effect):
            c.labels.append((0.0, 0.0, text, colour))
            c.leaders = False
        rows.append(
            pd.DataFrame(
                {"damping_mode": mode, "nominal_restitution": e, "damping_factor": d, "effective_restitution": out}
            )
        )
    factor.axes.set(xlabel="nominal restitution eₙ", ylabel="damping factor D", xlim=(0, 1), ylim=(0, 6))
    effect.axes.plot([0, 1], [0, 1], color=SOFT, linewidth=0.9, linestyle=(0, (2, 2)))
    effect.axes.text(0.46, 0.40, "out = in", color=SOFT, fontsize=7.5, rotation=33, rotation_mode="anchor")
    effect.axes.set(xlabel="nominal restitution eₙ", ylabel="restitution of a free impact", xlim=(0, 1), ylim=(0, 1.02))
    factor.table = effect.table = pd.concat(rows, ignore_index=True)
    return g.finish(
        "figure9",
        "Figure 9 remade: the three damping modes",
        "Left: the damping factor D of eq. 16 in the forms that two independent sources give (the equation is damaged "
        "in the "
        "text). Right: the restitution that comes out of a free impact, D (1 + e′) = ln((1 + D)/(1 − D e′)), whatever "
        "mass, "
        "stiffness and speed. At eₙ = 1 all three modes are the same undamped Hertz law, so the paper's best case "
        "says nothing "
        "about the damping mode; for Md 1, eₙ = 0 still gives 0.66.",
        [factor, effect],
        [],
    )


def measurement_spheres(g: Gallery, setup: Scenario) -> Figure:
    """The paper's Figure 13a: where the measurement spheres are."""
    box = derived.apparatus(setup)
    c = style.canvas(
        "figure13a-spheres",
        "Measurement spheres under the sleeper, side view",
        width=4.7,
        height=3.0,
        left=0.62,
        right=0.2,
    )
    c.axes.add_patch(Rectangle((0, 0), MM * box.length_m, MM * box.height_m, fill=False, edgecolor=SOFT, linewidth=1))
    low, high = box.sleeper.low, box.sleeper.high
    c.axes.add_patch(
        Rectangle((0, MM * low[2]), MM * high[0], MM * (high[2] - low[2]), facecolor=SOFT, alpha=0.35, linewidth=0)
    )
    c.axes.text(MM * high[0] / 2, MM * (low[2] + high[2]) / 2, "sleeper", ha="center", va="center", fontsize=8.5)
    for number, plate in enumerate(box.plates, start=1):
        c.axes.add_patch(
            Rectangle(
                (MM * plate.low[0], MM * plate.low[2]),
                24,
                MM * (plate.high[2] - plate.low[2]),
                facecolor=SOFT,
                linewidth=0,
            )
        )
        c.axes.text(
            MM * plate.low[0] + 34, MM * (plate.low[2] + plate.high[2]) / 2, str(number), va="center", fontsize=8
        )
    for k, (x, _, z) in enumerate(box.measurement_centres_m):
        colour = style.shade("linear", k - 1.0)
        c.axes.add_patch(
            Circle((MM * x, MM * z), MM * box.measurement_radius_m, facecolor=colour, alpha=0.25, edgecolor=colour)
        )
        c.axes.text(MM * x, MM * z, f"{k + 1}\n{SPHERE_NAMES[k]}", ha="center", va="center", fontsize=8.5, color=colour)
    c.axes.set(
        xlim=(-20, 880), ylim=(-12, 495), xlabel="along the sleeper x, mm", ylabel="height z, mm", aspect="equal"
    )
    c.axes.grid(False)
    c.table = pd.DataFrame(
        [
            {"sphere": k + 1, "x_m": x, "y_m": y, "z_m": z, "radius_m": box.measurement_radius_m}
            for k, (x, y, z) in enumerate(box.measurement_centres_m)
        ]
    )
    return g.finish(
        "figure13a",
        "Figure 13a remade: the measurement spheres",
        "Radius 134 mm (reported); the centres follow from the "
        "apparatus (derived). 1 lies under the rail seat, 3 at the shoulder, behind the movable plates 1 to 5.",
        [c],
        [],
    )


# ------------------------------------------------------------------ beds


def bed_pictures(
    g: Gallery, runs: Sequence[Run], name: str, label: str, title: str, caption: str, *, chains: bool = False
) -> Figure | None:
    """The bed of each run as a picture, and its force chains where contacts were kept."""
    drawn, used = [], []
    for run in runs:
        try:
            scene = view.load_scene(run.folder, (view.last_with_contacts(run.folder) if chains else None) or label)
        except view.ViewError as error:
            if not isinstance(error, view.NoBed):
                g.complain(f"{run.id}/{error}")
            continue
        key = f"{name}-{run.scenario_name}-{run.code}" + (f"-seed{run.seed}" if run.seed != 1 else "")
        heading = f"{short_name(run.scenario_name)}, {CODE_NAMES.get(run.code, run.code)}, {scene.title}"
        c = (
            view.chain_panel(scene, key, heading)
            if chains
            else view.bed_panel(scene, key, heading, azimuth_deg=-28, elevation_deg=20, pixels=1200)
        )
        if c is None:
            continue
        drawn.append(c)
        used.append(run)
    return g.finish(name, title, caption, drawn, used, layout="picture")
