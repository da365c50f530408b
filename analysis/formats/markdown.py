"""Markdown: tables, and sections of a file that a command writes between two comments with their names."""

from __future__ import annotations

from collections.abc import Sequence


def marks(name: str, command: str) -> tuple[str, str]:
    """The lines before and after the section `name`."""
    return f"<!-- {name}: begin, made by `{command}` -->", f"<!-- {name}: end -->"


def replaced(text: str, name: str, command: str, body: str, file: str) -> str:
    """`text` with `body` as its section. Raises ValueError where the marks are missing; `file` is named there."""
    begin, end = marks(name, command)
    head, found_begin, rest = text.partition(begin)
    _, found_end, tail = rest.partition(end)
    if not found_begin or not found_end:
        raise ValueError(f"{file}: the lines {begin} and {end} are missing; put them around the section")
    return head + begin + "\n\n" + body.strip("\n") + "\n\n" + end + tail


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table; bars within cells are escaped."""
    lines = [header, ["---"] * len(header), *rows]
    return "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |\n" for line in lines)
