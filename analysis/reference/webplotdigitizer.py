"""Files that WebPlotDigitizer writes: CSV of one dataset, CSV of all datasets side by side, and the project's JSON."""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from analysis.formats import json_file
from analysis.formats.errors import InputError


class DigitiserError(InputError):
    """A file that cannot be used; the message is one line naming the file, the place and the remedy."""


@dataclass(frozen=True)
class Dataset:
    """Points of one dataset: array (n, 2) of x and y in the units of the figure's axes, in the order of the file.

    calibration   the smallest and largest axis values used to calibrate x and y, where the file tells them
    logarithmic   whether x and y are logarithmic, where the file tells it
    problem       why it cannot be used, as one line; empty where it can. A project may hold other figures too, so this
                  is a matter of those who want it
    """

    name: str
    points: np.ndarray
    calibration: tuple[tuple[float, float], tuple[float, float]] | None = None
    logarithmic: tuple[bool, bool] | None = None
    problem: str = ""


def read(path: Path) -> list[Dataset]:
    """All datasets of a .csv or .json file that have points; one without a name is named after the file."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise DigitiserError(f"{path.name}: cannot be read ({error.strerror}); put the exported file here") from None
    except UnicodeDecodeError:
        raise DigitiserError(f"{path.name}: is not UTF-8 text; export it again") from None
    datasets = _from_json(path.name, text) if path.suffix == ".json" else _from_csv(path, text)
    datasets = [d for d in datasets if len(d.points) or d.problem]
    if not datasets:
        raise DigitiserError(f"{path.name}: holds no points; digitise a curve before exporting")
    names = [d.name for d in datasets]
    twice = f"{path.name}: dataset {{!r}} occurs twice; rename one in WebPlotDigitizer"
    return [replace(d, problem=twice.format(d.name)) if names.count(d.name) > 1 else d for d in datasets]


# ------------------------------------------------------------------ CSV


def _from_csv(path: Path, text: str) -> list[Dataset]:
    rows, decimal_comma = _rows(path.name, text)
    if len(rows) > 1 and _axes_names(rows[1][1]):
        return _side_by_side(path.name, rows, decimal_comma)
    if rows and _axes_names(rows[0][1]) and len(rows[0][1]) == 2:
        rows = rows[1:]  # x, y as a heading
    elif rows and not _number(rows[0][1][0], decimal_comma):
        line = rows[min(1, len(rows) - 1)][0]
        raise DigitiserError(
            f"{path.name}: line {line} is neither x, y nor X,Y for each name above; export one dataset, "
            "or all by 'Export All Data', from axes of the kind 2D (X-Y) Plot"
        )
    points = []
    for line, cells in rows:
        if len(cells) != 2:
            raise DigitiserError(
                f"{path.name}: line {line} has {len(cells)} values, not x and y; export one dataset, "
                "or all by 'Export All Data'"
            )
        points.append(_pair(path.name, line, cells, decimal_comma))
    return [Dataset(path.stem, np.array(points))]


def _rows(file: str, text: str) -> tuple[list[tuple[int, list[str]]], bool]:
    """Lines that are not empty, with their numbers; and whether numbers have a decimal comma, as in some locales."""
    lines = text.splitlines()
    first = next((line for line in lines if line.strip()), "")
    separator = next((s for s in (";", "\t") if s in first), ",")
    try:
        rows = [(k, [c.strip() for c in cells]) for k, cells in enumerate(csv.reader(lines, delimiter=separator), 1)]
    except csv.Error as error:  # a field of more than 131072 characters, a quote that is never closed
        raise DigitiserError(f"{file}: is not a CSV ({error}); export it again") from None
    return [(k, cells) for k, cells in rows if any(cells)], separator != ","


def _side_by_side(file: str, rows, decimal_comma: bool) -> list[Dataset]:
    """Two header rows (names, then X,Y for each) and columns of unequal length.

    A name stands over its X column, or over both. It may look like a number (`0.6`, `inf`).
    """
    line, names = rows[0]
    axes = rows[1][1]
    names = names + [""] * (len(axes) - len(names))
    if len(names) > len(axes) or any(y not in ("", x) for x, y in zip(names[::2], names[1::2], strict=True)):
        raise DigitiserError(
            f"{file}: line {line} does not have one name over each X,Y of line {line + 1}; rename the datasets in "
            "WebPlotDigitizer to names without commas"
        )
    datasets = []
    for column in range(0, len(axes), 2):
        if not names[column]:
            raise DigitiserError(f"{file}: the dataset in column {column + 1} has no name; name it in WebPlotDigitizer")
        points = []
        for line, cells in rows[2:]:
            pair = (cells + [""] * len(axes))[column : column + 2]
            if any(pair):
                points.append(_pair(file, line, pair, decimal_comma))
        datasets.append(Dataset(names[column], np.array(points)))
    return datasets


def _axes_names(cells: list[str]) -> bool:
    """X, Y for each of some datasets."""
    return len(cells) >= 2 and [c.upper() for c in cells] == ["X", "Y"] * (len(cells) // 2)


def _number(cell: str, decimal_comma: bool) -> bool:
    try:
        float(cell.replace(",", ".") if decimal_comma else cell)
    except ValueError:
        return False
    return True


def _pair(file: str, line: int, cells: list[str], decimal_comma: bool) -> tuple[float, float]:
    values = []
    for cell in cells:
        if not _number(cell, decimal_comma):
            raise DigitiserError(f"{file}: line {line}: {cell!r} is not a number; export with plain numbers")
        values.append(float(cell.replace(",", ".") if decimal_comma else cell))
    if not np.isfinite(values).all():
        raise DigitiserError(f"{file}: line {line}: {', '.join(cells)} is not finite; delete that point")
    return values[0], values[1]


# ------------------------------------------------------------------ project JSON


def _from_json(file: str, text: str) -> list[Dataset]:
    """Project files of version 4 (datasetColl) and of version 3 (wpd.dataSeries)."""
    try:
        project = json_file.parse(file, text.encode(), object)
    except InputError as error:
        raise DigitiserError(
            f"{file}: is not JSON that can be used ({error.allowed}); save the project again"
        ) from None
    if not isinstance(project, dict):
        raise DigitiserError(f"{file}: is not a WebPlotDigitizer project; give the wpd.json of the saved project")
    try:
        if "wpd" in project:
            old = project["wpd"]
            axes = {None: (old["axesType"], old["calibration"], old.get("axesParameters", {}))}
            series = [(d["name"], None, d["data"]) for d in old["dataSeries"]]
        else:
            axes = {a["name"]: (a["type"], a.get("calibrationPoints", []), a) for a in project["axesColl"]}
            series = [(d["name"], d["axesName"], d["data"]) for d in project["datasetColl"]]
        return [_series(file, str(name), *axes[axis], data) for name, axis, data in series if data]
    except (KeyError, TypeError, AttributeError, ValueError, IndexError) as error:
        raise DigitiserError(
            f"{file}: is not a WebPlotDigitizer project ({type(error).__name__} {error}); give the "
            "wpd.json of the saved project, or export CSV"
        ) from None


def _series(file: str, name: str, axes_type: str, calibration: list, parameters: dict, data: list) -> Dataset:
    if axes_type != "XYAxes":
        problem = (
            f"{file}: dataset {name!r} lies on axes of the kind {axes_type}; digitise it on axes of the kind "
            "2D (X-Y) Plot"
        )
        return Dataset(name, np.empty((0, 2)), problem=problem)
    values = [point.get("value") for point in data]
    try:
        points = np.array(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        points = np.empty(0)
    if points.shape != (len(values), 2) or not np.isfinite(points).all():
        problem = f"{file}: dataset {name!r} has points without calibrated values; calibrate the axes, then save"
        return Dataset(name, np.empty((0, 2)), problem=problem)
    logarithmic = tuple(str(parameters.get(key, False)).lower() == "true" for key in ("isLogX", "isLogY"))
    return Dataset(name, points, _calibration(calibration), logarithmic)


def _calibration(points: list):
    """Axis values of the calibration: the first two points fix x, the next two y."""
    try:
        x, y = [float(p["dx"]) for p in points[:2]], [float(p["dy"]) for p in points[2:4]]
        return (min(x), max(x)), (min(y), max(y))
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
