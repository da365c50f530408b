"""The analysis is a one-way flow: each sub-package imports only what stands before it."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ANALYSIS = Path(__file__).resolve().parent.parent / "analysis"
MAY_IMPORT = {
    "contact_laws": set(),
    "bond_law": set(),
    "files": set(),
    "formats": {"files"},
    "arguments": set(),
    "scenarios": {"formats", "contact_laws", "bond_law", "files"},
    "normalised": {"formats", "scenarios", "contact_laws", "bond_law", "files"},
    "driver": {"formats", "scenarios", "normalised", "reference", "files", "arguments"},
    "reference": {"formats", "scenarios", "files", "arguments"},
    "comparison": {"formats", "reference", "normalised", "scenarios", "contact_laws", "files"},
    "docs": {"formats", "scenarios", "contact_laws", "files", "arguments"},
    "report": {
        "verification",
        "formats",
        "docs",
        "comparison",
        "reference",
        "driver",
        "normalised",
        "scenarios",
        "contact_laws",
        "files",
        "arguments",
    },
    "verification": {"formats", "driver", "normalised", "scenarios", "contact_laws", "bond_law", "files", "arguments"},
}
MODULES = sorted(path for path in ANALYSIS.rglob("*.py") if path.parent != ANALYSIS or path.stem in MAY_IMPORT)


def imports(path):
    """Dotted names of what a module imports from this package, wherever in the module that is."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            assert not node.level, "imports are absolute, so that the flow can be read"
            if node.module.split(".")[0] == "analysis":
                yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.split(".")[0] == "analysis")


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ANALYSIS)))
def test_a_module_imports_only_what_stands_before_it(path):
    own = path.relative_to(ANALYSIS).with_suffix("").parts[0]
    assert {name.split(".")[1] for name in imports(path)} <= MAY_IMPORT[own] | {own}


@pytest.mark.parametrize("name", [name for name in MAY_IMPORT if (ANALYSIS / name).is_dir()])
def test_a_sub_package_says_what_it_may_import_and_imports_nothing_itself(name):
    (docstring,) = ast.parse((ANALYSIS / name / "__init__.py").read_text()).body
    listed = " ".join(docstring.value.value.split()).partition("Imports from this package: ")[2]
    assert set(re.findall(r"`(?:analysis\.)?(\w+)`", listed)) == MAY_IMPORT[name]


def test_what_yade_reads_needs_no_more_than_numpy():
    read = {name for path in (ANALYSIS.parent / "yade").glob("*.py") for name in imports(path)}
    assert read
    code = "import sys; sys.modules['pandas'] = sys.modules['scipy'] = sys.modules['matplotlib'] = None\n"
    for name in sorted(read):
        code += f"from {name.rpartition('.')[0]} import {name.rpartition('.')[2]}\n"
    done = subprocess.run([sys.executable, "-c", code], cwd=ANALYSIS.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_no_two_modules_and_no_two_classes_share_a_name():
    """A name alone says which room is meant."""
    paths = [path for folder in (ANALYSIS, ANALYSIS.parent / "yade") for path in folder.rglob("*.py")]
    modules = [path.stem for path in paths if path.stem not in ("__init__", "__main__")]
    assert not {name for name in modules if modules.count(name) > 1}
    classes = [
        node.name for path in paths for node in ast.parse(path.read_text()).body if isinstance(node, ast.ClassDef)
    ]
    assert not {name for name in classes if classes.count(name) > 1}


LONGEST_BODY = 45
"""Lines without the docstring: what fits on a screen, so that nobody has to scroll to understand a function."""


def body_lines(function):
    """Lines from the first statement after the docstring to the end."""
    statements = function.body[1:] if ast.get_docstring(function) is not None else function.body
    return function.end_lineno - statements[0].lineno + 1 if statements else 0


def test_no_function_is_longer_than_a_screen():
    paths = [path for folder in (ANALYSIS, ANALYSIS.parent / "yade") for path in folder.rglob("*.py")]
    functions = [
        (f"{path.name}: {node.name}", body_lines(node))
        for path in paths
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
    ]
    assert functions
    assert not [(name, lines) for name, lines in functions if lines > LONGEST_BODY]
