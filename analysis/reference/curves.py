"""Reference curves: what is there, what is pending, and a check of every file before anything is compared with it.

Each folder of reference_data/published is one source; each .toml in it is the sidecar of one figure panel and names
the files that WebPlotDigitizer wrote. Values are converted to SI by the unit that the sidecar declares, and by nothing
else.
"""

from __future__ import annotations

import difflib
import json
import re
from dataclasses import dataclass, field, replace
from datetime import date, timedelta
from pathlib import Path

import jsonschema
import numpy as np
import pandas as pd

from analysis.files import PUBLISHED
from analysis.formats import toml_file
from analysis.formats.errors import InputError, reason, shown
from analysis.reference import webplotdigitizer
from analysis.reference.webplotdigitizer import Dataset, DigitiserError
from analysis.scenarios.scenario import load_scenario, scenario_names

NOT_CURVES = ("ballast_stiffness", "settlement_laws", "settlement_shapes")

REPORTED = "reported.toml"

COLUMNS = (
    "source",
    "figure",
    "curve",
    "kind",
    "scenario",
    "quantity",
    "cycle",
    "depth_m",
    "sphere",
    "value",
    "unit",
    "error",
    "status",
    "licence",
    "sidecar",
)

SOURCE_COLUMNS = (
    "sidecar",
    "source",
    "figure",
    "kind",
    "status",
    "curves",
    "digitised",
    "points",
    "error",
    "digitised_by",
    "date",
    "method",
    "licence",
)

PENDING_COLUMNS = ("source", "figure", "curve", "kind", "scenario", "quantity", "cycle", "sphere", "sidecar")

SI = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "-": 1.0, "%": 1e-2}

UNIT_WORDS = {"-": "- (cycles, shares)"}

VALUES = {"settlement": "m", "lateral_displacement": "m", "porosity": "-"}

ABSCISSAE = {"settlement": "cycle", "lateral_displacement": "depth", "porosity": "cycle"}

# Wide on purpose: only a wrong unit, sign or axis falls outside. SI units, as converted.
PLAUSIBLE = {
    "cycle": (-20.0, 1e7),
    "depth": (-0.2, 0.5),
    "settlement": (-0.01, 0.2),
    "lateral_displacement": (-0.02, 0.2),
    "porosity": (0.1, 0.7),
}

AXIS_SLACK = 0.02  # share of the axis that a point may lie outside of it

LEAST_POINTS = 3

LARGEST_NUMBER = 1e9

EARLIEST = date(2000, 1, 1)
"""Nobody digitised a figure with WebPlotDigitizer before."""

LEAST_COVER = {"coordinate": 0.1, "value": 0.01}  # share of its axis that a curve spans; less is a wrong unit

MOST_CYCLES_BY_TIME = 1e4  # an axis of seconds that means more cycles is one of cycles

MOST_ERROR = 0.5  # of the value axis


class ReferenceError(InputError):
    """Reference data that cannot be used; the message is one line naming file, key and remedy."""


@dataclass
class References:
    """All reference data of a folder.

    curves    tidy table (COLUMNS), one row per point. `value` and `error` are in `unit` (m or -), settlement positive
              downward, lateral displacement positive outward; `cycle` is a coordinate for settlement and porosity and
              constant for a profile over `depth_m` (below the sleeper's base); absent coordinates are nan.
    pending   one row per curve that is still to be digitised (PENDING_COLUMNS)
    sources   one row per sidecar that can be used (SOURCE_COLUMNS): where its points come from, how many there are
    problems  one line for each file that cannot be used; its curves are in neither table
    """

    curves: pd.DataFrame
    pending: pd.DataFrame
    problems: list[str] = field(default_factory=list)
    sources: pd.DataFrame = field(default_factory=lambda: pd.DataFrame(columns=SOURCE_COLUMNS))

    def curve(
        self,
        quantity: str,
        kind: str | None = None,
        source: str | None = None,
        scenario: str | None = None,
        cycle: int | None = None,
        sphere: int | None = None,
    ) -> pd.DataFrame:
        """Rows of the curves that match, in the order of their coordinate; empty where nothing has come in yet.

        `cycle` chooses among profiles over depth.
        """
        wanted = {
            "quantity": quantity,
            "kind": kind,
            "source": source,
            "scenario": scenario,
            "cycle": cycle,
            "sphere": sphere,
        }
        rows = self.curves
        for column, value in wanted.items():
            if value is not None:
                rows = rows[rows[column] == value]
        return rows.sort_values(["curve", ABSCISSAE[quantity].replace("depth", "depth_m")], kind="stable")


def load_references(folder: Path = PUBLISHED) -> References:
    """Read and check all sidecars of `folder`; a bad one becomes a line in `problems` and does not hide the others."""
    folder = Path(folder)
    curves, pending, sources, silent = [], [], [], []
    heads, named, problems = _read_heads(folder)
    for sidecar, head in heads.items():
        try:
            there, missing = _load(sidecar, head)
        except (ReferenceError, DigitiserError) as error:
            problems.append(f"{sidecar.parent.name}/{error}")
        else:
            if not there and head["status"] != "pending":
                silent.append(sidecar)
            curves += there
            pending += missing
            sources.append(_source(sidecar, head, there))
    problems += _named_by_none(folder, named)
    unclaimed = _claimed_by_none(heads)
    problems += unclaimed + [
        f"{sidecar.parent.name}/{sidecar.name}: none of its curves is in {', '.join(heads[sidecar]['files'])}; rename "
        "the dataset in WebPlotDigitizer as it is named in curves"
        for sidecar in silent
        if not any(f"{sidecar.parent.name}/{file}:" in line for file in heads[sidecar]["files"] for line in unclaimed)
    ]
    table = pd.concat(curves, ignore_index=True) if curves else pd.DataFrame(columns=COLUMNS)
    return References(
        table[list(COLUMNS)],
        pd.DataFrame(pending, columns=PENDING_COLUMNS),
        problems,
        pd.DataFrame(sources, columns=SOURCE_COLUMNS),
    )


def _read_heads(folder: Path) -> tuple[dict[Path, dict], set[Path], list[str]]:
    """The sidecars that can be read, the files that they name, and a line for each sidecar that cannot be read."""
    heads, named, problems = {}, set(), []
    for sidecar in sidecars(folder):
        try:
            heads[sidecar] = _read_sidecar(sidecar)
        except ReferenceError as error:
            problems.append(f"{sidecar.parent.name}/{error}")
            named |= set(sidecar.parent.iterdir())  # whose files they are is unknown now
        else:
            named |= {sidecar.parent / file for file in heads[sidecar].get("files", [])}
    return heads, named, problems


def _named_by_none(folder: Path, named: set[Path]) -> list[str]:
    """A line for each file of WebPlotDigitizer that no sidecar names."""
    return [
        f"{path.parent.name}/{path.name}: is named by no sidecar; add it to `files` of the sidecar "
        "of its figure and set its status"
        for path in sorted(folder.glob("*/*"))
        if path.suffix in (".csv", ".json") and path.parent.name not in NOT_CURVES and path not in named
    ]


def _claimed_by_none(heads: dict[Path, dict]) -> list[str]:
    """A line for each dataset of a file that is a curve of no sidecar which names the file."""
    by_file: dict[Path, list[Path]] = {}
    for sidecar, head in heads.items():
        for file in head.get("files", []):
            by_file.setdefault(sidecar.parent / file, []).append(sidecar)
    problems = []
    for path, claimants in by_file.items():
        try:
            datasets = webplotdigitizer.read(path)
        except DigitiserError:
            continue  # the sidecar says so
        if any(_takes_any_name(heads[sidecar], datasets) for sidecar in claimants):
            continue
        names = [curve["dataset"] for sidecar in claimants for curve in heads[sidecar]["curves"]]
        unclaimed = list(dict.fromkeys(d.name for d in datasets if d.name not in names))
        if unclaimed:
            near = difflib.get_close_matches(unclaimed[0], names, 1)
            known = f"its curves, perhaps {near[0]!r}" if near else ", ".join(map(repr, names[:4]))
            further = f"; likewise {', '.join(map(repr, unclaimed[1:4]))}" if unclaimed[1:] else ""
            problems.append(
                f"{path.parent.name}/{path.name}: dataset {unclaimed[0]!r} is not a curve of "
                f"{' or '.join(s.name for s in claimants)}; rename it in WebPlotDigitizer to one of {known}, or "
                f"delete it{further}"
            )
    return problems


def _takes_any_name(head: dict, datasets: list[Dataset]) -> bool:
    """A sidecar of one curve and one file takes the file's only dataset, whatever its name."""
    return len(head["curves"]) == len(datasets) == len(head["files"]) == 1


def sidecars(folder: Path = PUBLISHED) -> list[Path]:
    """Paths of all sidecars of `folder`, in alphabetical order."""
    found = (p for p in Path(folder).glob("*/*.toml") if p.parent.name not in NOT_CURVES)
    return sorted(p for p in found if p.name != REPORTED)


def _source(sidecar: Path, head: dict, curves: list[pd.DataFrame]) -> dict:
    """What the sidecar says of its points; empty where it is pending."""
    there = head["status"] != "pending"
    error = head["error"] if there else {}
    return {
        "sidecar": f"{sidecar.parent.name}/{sidecar.name}",
        "curves": len(head["curves"]),
        "digitised": len(curves),
        "points": sum(map(len, curves)),
        "error": f"{error['value']:g} {error['unit']}, {error['source']}" if there else "",
        **{key: head[key] for key in ("source", "figure", "kind", "status", "licence")},
        **{key: head[key] if there else "" for key in ("digitised_by", "date", "method")},
    }


def _load(sidecar: Path, head: dict) -> tuple[list[pd.DataFrame], list[dict]]:
    if head["status"] == "pending" and head.get("files"):
        raise ReferenceError(
            f'{sidecar.name}: status = "pending", but files = {head["files"]}; set status = "digitised"'
        )
    value_axis, other_axis = _axes(sidecar, head)
    datasets = _datasets(sidecar, head) if head["status"] != "pending" else {}
    there, missing = [], []
    for curve in head["curves"]:
        row = {
            "source": head["source"],
            "figure": head["figure"],
            "curve": curve["dataset"],
            "kind": head["kind"],
            "scenario": curve.get("scenario", ""),
            "quantity": head["axes"][value_axis]["quantity"],
            "cycle": curve.get("cycle", np.nan),
            "sphere": curve.get("sphere", np.nan),
            "sidecar": f"{sidecar.parent.name}/{sidecar.name}",
        }
        if curve["dataset"] in datasets:
            file, dataset = datasets[curve["dataset"]]
            there.append(_tidy(sidecar, head, row, value_axis, other_axis, file, dataset))
        else:
            missing.append(row)
    return there, missing


def _read_sidecar(sidecar: Path) -> dict:
    try:
        head = toml_file.read(sidecar, "sidecar")
    except InputError as error:
        raise ReferenceError(str(error)) from None
    _check_numbers(sidecar, head)
    head = json.loads(json.dumps(head, default=str))  # a date becomes its text
    schema = json.loads((PUBLISHED / "schema.json").read_text(encoding="utf-8"))
    errors = list(jsonschema.Draft202012Validator(schema).iter_errors(head))
    still_open = dict.fromkeys(_place(error) for error in errors if error.instance == "?")
    if still_open:
        raise ReferenceError(
            f'{sidecar.name}: {", ".join(still_open)} = "?" is still open; fill it in, or set status = "pending"'
        )
    error = jsonschema.exceptions.best_match(errors)
    if error is not None:
        raise ReferenceError(f"{sidecar.name}: {_say(error)}")
    names = [c["dataset"] for c in head["curves"]]
    for name in names:
        if names.count(name) > 1:
            raise ReferenceError(f"{sidecar.name}: curves: dataset {name!r} occurs twice; give each its own name")
    known = ("", *scenario_names())
    for curve in head["curves"]:
        if curve.get("scenario", "") not in known:
            raise ReferenceError(
                f"{sidecar.name}: curves: scenario {curve['scenario']!r} is unknown; use a name of "
                "scenarios.toml or leave it out"
            )
    if head["status"] != "pending":
        _check_date(sidecar, head["date"])
    _check_citation(sidecar, head["source"])
    return head


def _check_numbers(sidecar: Path, node, place: str = "") -> None:
    """Every number of a sidecar is finite and of a size that a figure's axis can have."""
    for key, child in node.items() if isinstance(node, dict) else enumerate(node):
        where = f"{place}.{key}" if place else str(key)
        if isinstance(child, (dict, list)):
            _check_numbers(sidecar, child, where)
        elif isinstance(child, (int, float)) and not abs(child) <= LARGEST_NUMBER:
            raise ReferenceError(sidecar.name, where, child, f"a number up to {LARGEST_NUMBER:g}")


def _check_date(sidecar: Path, text: str) -> None:
    """A day of the calendar, at most one day ahead, for the other side of the world."""
    try:
        day = date.fromisoformat(text)
    except ValueError:
        raise ReferenceError(sidecar.name, "date", text, 'a day, as "2026-03-01"') from None
    if not EARLIEST <= day <= date.today() + timedelta(days=1):
        raise ReferenceError(sidecar.name, "date", text, f"a day from {EARLIEST} to today")


def _place(error: jsonschema.ValidationError) -> str:
    return ".".join(map(str, error.absolute_path)) or "the file"


def _say(error: jsonschema.ValidationError) -> str:
    """One line: where, what is there, and what may be there."""
    where = _place(error)
    known = error.schema.get("description", "") if isinstance(error.schema, dict) else ""
    value = json.dumps(error.instance)
    if error.validator == "required":
        name = error.message.split("'")[1]
        near = difflib.get_close_matches(name, error.instance, 1, 0.8)
        return f"{where}: {error.message}; " + (f"rename {near[0]!r}" if near else "add it")
    if error.validator == "enum":
        return (
            f"{where} = {value} is refused; allowed: "
            f"{', '.join(UNIT_WORDS.get(v, str(v)) for v in error.validator_value if v != '?')}"
        )
    if error.validator == "pattern" and where == "date":
        return f'date = {value} is refused; write it as "2026-03-01"'
    if error.validator == "additionalProperties":
        return f"{where}: {error.message}; allowed: {', '.join(error.schema['properties'])}"
    refused = f"{where} = {value[:80]} is refused ({error.validator}: {error.validator_value})"
    return refused + (f": {known}" if known else "")


def _check_citation(sidecar: Path, source: str) -> None:
    bibliography = sidecar.parent / "reference.bib"
    if not bibliography.is_file():
        raise ReferenceError(f"{sidecar.name}: source: no reference.bib beside it; add one with the entry {source}")
    if source not in citation_keys(bibliography):
        raise ReferenceError(
            f"{sidecar.name}: source = {source!r} is not in reference.bib; add the entry or correct the key"
        )


def citation_keys(bibliography: Path) -> list[str]:
    """Keys of all entries of a BibTeX file; ReferenceError where it is no text in UTF-8."""
    try:
        text = bibliography.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise ReferenceError(
            bibliography.name, f"line {line}", allowed="is not UTF-8; save the file as UTF-8"
        ) from None
    except OSError as error:
        raise ReferenceError(bibliography.name, allowed=f"cannot be read ({reason(error)})") from None
    return re.findall(r"^@\w+\{\s*([^,\s]+)\s*,", text, re.MULTILINE)


def require_texts(*values: object) -> None:
    """TypeError where one of the values is no text."""
    for value in values:
        if not isinstance(value, str):
            raise TypeError(f"{shown(value)} stands where a text is expected")


def _axes(sidecar: Path, head: dict) -> tuple[str, str]:
    """Which axis (x or y) holds the value and which the coordinate."""
    quantities = {name: axis["quantity"] for name, axis in head["axes"].items()}
    values = [name for name, quantity in quantities.items() if quantity in VALUES]
    if len(values) != 1 or quantities["y" if values[0] == "x" else "x"] != ABSCISSAE[quantities[values[0]]]:
        raise ReferenceError(
            f"{sidecar.name}: axes: {quantities['x']} and {quantities['y']} make no curve; allowed: "
            + ", ".join(f"{v} with {a}" for v, a in ABSCISSAE.items())
        )
    quantity = quantities[values[0]]
    need = {"lateral_displacement": "cycle", "porosity": "sphere"}.get(quantity)
    for curve in head["curves"]:
        for key in ("cycle", "sphere"):
            if (key == need) != (key in curve):
                what = f"needs {key}; add it" if key == need else f"has {key}; a curve of {quantity} has none"
                raise ReferenceError(f"{sidecar.name}: curves: {curve['dataset']!r} {what}")
    return values[0], "y" if values[0] == "x" else "x"


def _datasets(sidecar: Path, head: dict) -> dict[str, tuple[str, Dataset]]:
    """Datasets of all files that the sidecar names as its curves; a file's only dataset may have any name where the
    sidecar has one curve. A file may hold other sidecars' curves as well.
    """
    wanted = [c["dataset"] for c in head["curves"]]
    found: dict[str, tuple[str, Dataset]] = {}
    for file in head["files"]:
        datasets = webplotdigitizer.read(sidecar.parent / file)
        if _takes_any_name(head, datasets):
            datasets = [replace(datasets[0], name=wanted[0])]
        for dataset in datasets:
            if dataset.name not in wanted:
                continue
            if dataset.problem:
                raise ReferenceError(dataset.problem)
            if dataset.name in found:
                raise ReferenceError(f"{file}: dataset {dataset.name!r} is also in {found[dataset.name][0]}; keep one")
            found[dataset.name] = (file, dataset)
    return found


def _tidy(sidecar, head, row, value_axis, other_axis, file, dataset) -> pd.DataFrame:
    """Check the points of one curve against the declared axes and convert them to SI."""

    def refuse(what: str) -> ReferenceError:
        return ReferenceError(f"{file}: dataset {dataset.name!r}: {what}")

    if len(dataset.points) < LEAST_POINTS:
        raise refuse(f"{len(dataset.points)} points; at least {LEAST_POINTS} are needed")
    # in the order of the coordinate, whatever the order of clicking: exports do not sort
    points = dataset.points[np.argsort(dataset.points[:, "xy".index(other_axis)], kind="stable")]
    columns = {}
    for index, name in enumerate("xy"):
        axis, raw = head["axes"][name], points[:, index]
        logarithmic = _logarithmic(refuse, name, axis, dataset.logarithmic and dataset.logarithmic[index])
        calibration = dataset.calibration and dataset.calibration[index]
        _check_on_axis(refuse, name, axis, raw, calibration, sidecar.name, logarithmic)
        columns[name] = _to_si(axis, raw)
        least = LEAST_COVER["value" if name == value_axis else "coordinate"]
        _check_values(refuse, name, axis, raw, columns[name], least, logarithmic)
    coordinate, value = columns[other_axis], columns[value_axis]
    if row["quantity"] == "settlement" and np.median(value) < 0:
        raise refuse(f"settlement is negative; set axes.{value_axis}.reversed = true where the numbers grow upward")
    quantity = head["axes"][other_axis]["quantity"]
    _check_no_double(refuse, quantity, coordinate, points[:, "xy".index(other_axis)])
    places = {"cycle": coordinate, "depth_m": np.nan}
    if quantity == "depth":
        places = {"cycle": row["cycle"], "depth_m": coordinate}
    return pd.DataFrame({"value": value, **places}).assign(
        **{k: v for k, v in row.items() if k != "cycle"},
        unit=VALUES[row["quantity"]],
        error=_error_si(sidecar, head, row["quantity"], value_axis),
        status=head["status"],
        licence=head["licence"],
    )


def _check_no_double(refuse, quantity: str, coordinate: np.ndarray, raw: np.ndarray) -> None:
    """No two points of a curve have one coordinate; `raw` is that of the file, which the message tells."""
    same = np.diff(coordinate) == 0
    if same.any():
        raise refuse(
            f"two points at {quantity} {raw[int(np.argmax(same))]:.6g}; delete one of them in WebPlotDigitizer"
        )


def _check_values(
    refuse, name: str, axis: dict, raw: np.ndarray, values: np.ndarray, least: float, logarithmic: bool
) -> None:
    """Values (SI) of one axis are plausible and span at least the share `least` of it, on paper."""
    low, high = PLAUSIBLE[axis["quantity"]]
    outside = (values < low) | (values > high)
    if outside.any():
        worst = values[outside][0]
        keys = "unit, reversed" + (", at_sleeper_base" if axis["quantity"] == "depth" else "")
        raise refuse(
            f"{axis['quantity']} {worst:.6g} {_si_unit(axis)} is outside {low:g} to {high:g}; check axes.{name}: {keys}"
        )
    low, high = sorted(axis["range"])
    on_paper = np.log10 if logarithmic else np.asarray
    if np.ptp(on_paper(raw)) < least * np.ptp(on_paper([low, high])):
        raise refuse(
            f"{name} spans {raw.min():.4g} to {raw.max():.4g}, next to nothing of its axis, {low:g} to "
            f"{high:g} {axis['unit']}; check axes.{name}: unit and range, and whether the axes are swapped"
        )
    if axis["unit"] == "s" and values.max() > MOST_CYCLES_BY_TIME:
        raise refuse(
            f'{raw.max():.6g} s are {values.max():.6g} cycles; set axes.{name}.unit = "-" where the axis counts cycles'
        )


def _error_si(sidecar: Path, head: dict, quantity: str, value_axis: str) -> float:
    """The stated error in the unit of the values; it fits them and is smaller than half of their axis."""
    error = head["error"]
    if (error["unit"] in ("-", "%")) != (VALUES[quantity] == "-"):
        raise ReferenceError(
            f"{sidecar.name}: error.unit = {error['unit']} does not fit {quantity}; use the unit of its axis"
        )
    low, high = sorted(head["axes"][value_axis]["range"])
    whole = (high - low) * SI[head["axes"][value_axis]["unit"]]
    if error["value"] * SI[error["unit"]] > MOST_ERROR * whole:
        raise ReferenceError(
            f"{sidecar.name}: error.value = {error['value']:g} {error['unit']} is more than half of "
            f"the axis, {low:g} to {high:g} {head['axes'][value_axis]['unit']}; check error: value "
            "and unit"
        )
    return error["value"] * SI[error["unit"]]


def _logarithmic(refuse, name: str, axis: dict, project: bool | None) -> bool:
    """Whether an axis is logarithmic: the sidecar says it, or the project does; they may not contradict each other."""
    declared = axis.get("scale")
    if declared and project is not None and (declared == "log") != project:
        told = "log" if project else "linear"
        raise refuse(f'axes.{name}.scale = "{declared}", but the project has it {told}; set scale = "{told}"')
    logarithmic = project if declared is None and project is not None else declared == "log"
    if logarithmic and min(axis["range"]) <= 0:
        raise refuse(
            f"axes.{name}.range = {axis['range']} cannot be logarithmic; give the first and last printed value, above 0"
        )
    return bool(logarithmic)


def _check_on_axis(refuse, name, axis, raw, calibration, sidecar, logarithmic) -> None:
    """Points, and the values that calibrated the axis, lie on the axis as printed."""
    low, high = sorted(axis["range"])
    if low == high:
        raise ReferenceError(
            f"{sidecar}: axes.{name}.range = {axis['range']} is empty; give the first and last printed value"
        )
    factor = (high / low) ** AXIS_SLACK if logarithmic else 1.0
    slack = 0.0 if logarithmic else AXIS_SLACK * (high - low)
    least, most = low / factor - slack, high * factor + slack
    for value in raw:
        if not least <= value <= most:
            raise refuse(
                f"{name} = {value:.6g} is off the axis, {low:g} to {high:g} {axis['unit']}; "
                f"check axes.{name}.range, the calibration and whether the axes are swapped"
            )
    if calibration and not (least <= calibration[0] and calibration[1] <= most):
        raise refuse(
            f"axis {name} was calibrated from {calibration[0]:g} to {calibration[1]:g}, beyond {low:g} to "
            f"{high:g} {axis['unit']}; check axes.{name}: unit and range"
        )


def _to_si(axis: dict, raw: np.ndarray) -> np.ndarray:
    if axis["unit"] == "s":
        return raw * load_scenario(scenario_names()[0])["loading.frequency"]
    sign = -1.0 if axis.get("reversed", False) else 1.0
    return sign * (raw - axis.get("at_sleeper_base", 0.0)) * SI[axis["unit"]]


def _si_unit(axis: dict) -> str:
    return {"cycle": "cycles", "porosity": ""}.get(axis["quantity"], "m")
