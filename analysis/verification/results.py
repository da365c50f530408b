"""The result table of the verification: one row per compared quantity, and the curves behind it."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from analysis.files import write_csv


@dataclass(frozen=True)
class Row:
    """One comparison. `rel_error` and `tolerance` refer to the expected value, or to what `reason` says."""

    code: str
    case: str
    quantity: str
    expected: float
    measured: float
    abs_error: float
    rel_error: float
    tolerance: float
    passed: bool
    reason: str


class Results:
    """Collects rows and curves of one code and writes them."""

    def __init__(self, code: str):
        self.code, self.rows, self.curves = code, [], {}

    def compare(
        self,
        case: str,
        quantity: str,
        expected: float,
        measured: float,
        tolerance: float,
        reason: str = "",
        scale: float | None = None,
    ) -> None:
        """Add a row; it passes if |measured - expected| <= tolerance x scale, which is |expected| if not given."""
        expected, measured = float(expected), float(measured)
        scale = abs(expected) if scale is None else abs(scale)
        error = abs(measured - expected)
        relative = error / scale if scale else (0.0 if error == 0 else math.inf)
        self.rows.append(
            Row(
                self.code,
                case,
                quantity,
                expected,
                measured,
                error,
                relative,
                tolerance,
                bool(relative <= tolerance),
                reason,
            )
        )

    def compare_curves(self, case: str, quantity: str, expected, measured, tolerance: float, reason: str = "") -> None:
        """Add the worst point of a curve as a row, in relation to the greatest expected value."""
        errors = [abs(e - m) for e, m in zip(expected, measured, strict=True)]
        worst = max(range(len(errors)), key=lambda k: errors[k] if errors[k] == errors[k] else math.inf)
        note = "worst point of the curve, in relation to its greatest value"
        self.compare(
            case,
            quantity,
            expected[worst],
            measured[worst],
            tolerance,
            f"{note}; {reason}" if reason else note,
            scale=max(map(abs, expected)),
        )

    def fail(self, case: str, message: str) -> None:
        """Add a row for a case that could not be run."""
        self.rows.append(Row(self.code, case, "runs", 1.0, 0.0, 1.0, 1.0, 0.0, False, message))

    def curve(self, case: str, series: str, **columns) -> None:
        """Keep a curve for the plots: the first column is the abscissa; NAME_expected goes with NAME."""
        self.curves.setdefault(case, []).append((series, columns))

    def write_curves(self, folder: Path) -> None:
        """Write <case>_<code>.csv with the columns series, abscissa, and NAME and NAME_expected in turn."""
        folder.mkdir(parents=True, exist_ok=True)
        for case, curves in self.curves.items():
            header = ["series", *curves[0][1]]
            lines = []
            for series, columns in curves:
                if list(columns) != header[1:]:
                    raise ValueError(f"{case}: curves with different columns")
                lines += [[series, *(f"{v:.9g}" for v in values)] for values in zip(*columns.values(), strict=True)]
            write_csv(folder / f"{case}_{self.code}.csv", [header, *lines])


def write_rows(path: Path, rows: list[Row]) -> None:
    """Write the table; numbers with nine digits."""
    lines = [[field.name for field in fields(Row)]]
    for row in rows:
        lines.append(
            [f"{v:.9g}" if isinstance(v, float) else str(v).lower() if isinstance(v, bool) else v for v in astuple(row)]
        )
    write_csv(path, lines)
