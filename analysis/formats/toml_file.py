"""TOML files, read so that nothing in them ends in a traceback, and one way to check a value with its unit."""

from __future__ import annotations

import difflib
import json
import tomllib
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Protocol

from analysis.formats.errors import InputError, reason

LARGEST_BYTES = 4_000_000
DEEPEST = 20
LONGEST_KEY = 200


class AllowedValues(Protocol):
    """What a key may hold."""

    unit: str

    def accepts(self, value) -> bool: ...

    def allowed(self) -> str: ...


def read(path: Path, kind: str = "TOML file") -> dict:
    """Content of a TOML file; InputError where it is unreadable, not TOML, or nested deeper than anybody would."""
    return parse(Path(path).name, content(path, kind))


def content(path: Path, kind: str = "TOML file") -> bytes:
    """The bytes of a TOML file; InputError where they cannot be read."""
    path = Path(path)
    try:
        if path.stat().st_size > LARGEST_BYTES:
            raise InputError(path.name, allowed=f"is larger than {LARGEST_BYTES} bytes; give a {kind}")
        return path.read_bytes()
    except OSError as error:
        raise InputError(path.name, allowed=f"cannot be read ({reason(error)}); give the path of a {kind}") from None


def parse(file: str, content: bytes) -> dict:
    """The same of the content of `file`."""
    try:
        table = tomllib.loads(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(file, allowed=f"is not valid TOML: {reason(error)}") from None
    _check_depth(file, table)
    return table


def _check_depth(file: str, table: dict) -> None:
    """Without recursion: what is too deep for the reader would be too deep for the check."""
    open_ = [("", table, 1)]
    while open_:
        place, node, depth = open_.pop()
        if depth > DEEPEST or len(place) > LONGEST_KEY:
            raise InputError(file, place[:40] + "...", allowed=f"is nested deeper than {DEEPEST} levels")
        items = node.items() if isinstance(node, dict) else enumerate(node)
        for name, child in items:
            if isinstance(name, str) and len(name) > LONGEST_KEY:
                raise InputError(file, name[:40] + "...", allowed=f"is a key of more than {LONGEST_KEY} characters")
            if isinstance(child, (dict, list)):
                open_.append((f"{place}.{name}" if place else str(name), child, depth + 1))


def leaves(table: dict, known: Collection[str], prefix: str = "") -> Iterator[tuple[str, object]]:
    """(dotted key, leaf) of a table: a leaf is a known key, a table with a `value`, an empty one, or no table."""
    for name, entry in table.items():
        key = f"{prefix}{name}"
        if isinstance(entry, dict) and entry and "value" not in entry and key not in known:
            yield from leaves(entry, known, key + ".")
        else:
            yield key, entry


def checked(
    refuse: Callable[[str, object, str], Exception],
    place: str,
    entry: object,
    key: AllowedValues,
    fields: Collection[str],
) -> object:
    """The value of a table with exactly `fields` (value, unit, ...), of the key's unit and within its limits.

    `refuse(place, value, allowed)` makes the error that is raised.
    """
    if not isinstance(entry, dict) or set(entry) != set(fields):
        *first, last = fields
        raise refuse(place, entry, f"a table of exactly {', '.join(first)} and {last}")
    if entry["unit"] != key.unit:
        raise refuse(f"{place}.unit", entry["unit"], json.dumps(key.unit, ensure_ascii=False))
    if not key.accepts(entry["value"]):
        raise refuse(f"{place}.value", entry["value"], key.allowed())
    return entry["value"]


def nearest(name: str, known: Collection[str]) -> str:
    """`, perhaps friction` where a known name is near, else nothing."""
    near = difflib.get_close_matches(name[:LONGEST_KEY], known, 1)
    return f", perhaps {near[0]}" if near else ""
