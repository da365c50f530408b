"""Whole files, written aside and then renamed, so that nobody ever sees half of one."""

import os
from pathlib import Path


def write_aside(path: Path, text: str) -> None:
    """Write `text` to `path` in one move."""
    aside = path.with_name(path.name + ".partial")
    aside.write_text(text, encoding="ascii")
    os.replace(aside, path)
