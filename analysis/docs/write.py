"""`ballast docs`: writes what follows from the code: docs/apparatus.svg, sections of docs/*.md, PARAMETERS.md."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from analysis.arguments import Parser
from analysis.docs import design, glossary, method, sketch
from analysis.files import ROOT, write_aside
from analysis.formats import markdown
from analysis.scenarios import parameter_table
from analysis.scenarios.scenario import ScenarioError

COMMAND = "make docs"
SECTIONS = {
    "docs/method.md": method.SECTIONS,
    "docs/design.md": design.SECTIONS,
    "docs/glossary.md": glossary.SECTIONS,
}


def files(root: Path = ROOT) -> dict[Path, str]:
    """Every file that the command writes, with what it should hold. ValueError where marks are missing."""
    wanted = {root / "docs" / "apparatus.svg": sketch.svg(), root / "PARAMETERS.md": parameter_table.render()}
    for name, sections in SECTIONS.items():
        text = (root / name).read_text(encoding="utf-8")
        for section, body in sections.items():
            text = markdown.replaced(text, section, COMMAND, body(), name)
        wanted[root / name] = text
    return wanted


def add_arguments(parser: Parser) -> None:
    """Arguments of `ballast docs`."""
    parser.add_argument("--check", action="store_true", help="say what is out of date, and change nothing")


def execute(chosen: argparse.Namespace) -> int:
    """`ballast docs`; exit code 1 where --check finds a file out of date, or a file cannot be made."""
    try:
        wanted = files()
    except (ValueError, OSError, ScenarioError) as error:
        print(f"docs: {error}", file=sys.stderr)
        return 1
    old = [path for path, text in wanted.items() if not path.exists() or path.read_text(encoding="utf-8") != text]
    for path in old:
        if not chosen.check:
            write_aside(path, wanted[path])
        print(f"docs: {path.relative_to(ROOT)} {'is out of date; run `make docs`' if chosen.check else 'written'}")
    if not old:
        print("docs: up to date")
    return 1 if old and chosen.check else 0
