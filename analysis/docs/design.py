"""Tables of docs/design.md: sub-packages with what they may import, and the columns of every file."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from analysis.files import ROOT
from analysis.formats import file_columns
from analysis.formats.markdown import table

PACKAGE = ROOT / "analysis"
ORDER = ("formats", "scenarios", "driver", "normalised", "reference", "comparison", "report", "verification", "docs")


def _docstring(path: Path) -> str:
    return " ".join((ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").split())


def _packages() -> str:
    rows = []
    for name in ORDER:
        text, _, imports = _docstring(PACKAGE / name / "__init__.py").partition("Imports from this package: ")
        first = re.split(r"(?<=\.) (?=[A-Z`])", text.strip())[0]
        allowed = re.findall(r"`(?:analysis\.)?(\w+)`", imports)
        rows.append([f"[`{name}/`](../analysis/{name})", first, ", ".join(allowed)])
    return table(["sub-package", "what it does", "may import"], rows)


def _documented() -> dict[str, str]:
    """Constant -> the text below it in file_columns.py."""
    body = ast.parse(Path(file_columns.__file__).read_text(encoding="utf-8")).body
    found = {}
    for assignment, text in zip(body, body[1:], strict=False):
        is_text = isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant)
        if isinstance(assignment, ast.Assign) and is_text:
            found[assignment.targets[0].id] = " ".join(text.value.value.split())
    return found


def shortened(columns: tuple[str, ...]) -> str:
    """Columns as code, a row of plates or spheres once: `lateral_1_m` to `lateral_5_m`."""
    shown: list[str] = []
    families: dict[str, list[str]] = {}
    for name in columns:
        families.setdefault(re.sub(r"(?<=_)\d(?=_|$)", "{}", name), []).append(name)
    for members in families.values():
        shown.append(f"`{members[0]}`" + (f" to `{members[-1]}`" if len(members) > 1 else ""))
    return ", ".join(shown)


def _columns() -> str:
    rows = []
    for name, text in _documented().items():
        file, _, about = text.partition(": ")
        file = re.sub(r"([\w./*]+\.csv)", r"`\1`", file)
        rows.append([file, about, shortened(getattr(file_columns, name))])
    return table(["file", "rows", "columns"], rows)


SECTIONS = {"packages": _packages, "columns": _columns}
