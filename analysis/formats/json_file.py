"""JSON files, read so that nothing in them ends in a traceback."""

from __future__ import annotations

import json
import math
from pathlib import Path

from analysis.formats.errors import InputError, reason

LARGEST_BYTES = 64_000_000
LONGEST_WHOLE = 300
"""Digits of a whole number: more is no double."""
REMEDY = "restore the file or move it away"
NAMES = {dict: "table", list: "list"}


def read(path: Path, kind: type = dict, remedy: str = REMEDY):
    """Content of a JSON file, which must be of `kind`; FileNotFoundError without it, InputError where it is damaged.

    Numbers that are no finite double (NaN, 10^400) are refused, too.
    """
    path = Path(path)
    try:
        if path.stat().st_size > LARGEST_BYTES:
            raise InputError(path.name, allowed=f"is larger than {LARGEST_BYTES} bytes; {remedy}")
        content = path.read_bytes()
    except FileNotFoundError:
        raise
    except NotADirectoryError as error:  # something above it is a file: it is not there either
        raise FileNotFoundError(error.errno, error.strerror, str(path)) from None
    except OSError as error:
        raise InputError(path.name, allowed=f"cannot be read ({reason(error)}); {remedy}") from None
    return parse(path.name, content, kind, remedy)


def parse(file: str, content: bytes, kind: type = dict, remedy: str = REMEDY):
    """The same of the content of `file`."""
    try:
        body = json.loads(content.decode("utf-8"), parse_constant=_refuse, parse_float=_finite, parse_int=_whole)
    except (ValueError, RecursionError) as error:
        raise InputError(file, allowed=f"is damaged ({reason(error)}); {remedy}") from None
    if not isinstance(body, kind):
        raise InputError(file, allowed=f"is damaged (it holds no {NAMES[kind]}); {remedy}")
    return body


def _refuse(text: str) -> float:
    raise ValueError(f"{text} is no number")


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text[:20]} is too large")
    return value


def _whole(text: str) -> int:
    if len(text) > LONGEST_WHOLE:
        raise ValueError(f"{text[:20]}... is too large")
    return int(text)
