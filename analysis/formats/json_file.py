"""JSON files, read so that nothing in them ends in a traceback."""

from __future__ import annotations

import json
import math
from pathlib import Path

from analysis.formats.errors import InputError, reason

LARGEST_BYTES = 64_000_000


def read(path: Path, kind: type = dict, remedy: str = "restore the file or move it away"):
    """Content of a JSON file, which must be of `kind`; FileNotFoundError without it, InputError where it is damaged.

    Numbers that are no finite double (NaN, 10^400) are refused, too.
    """
    path = Path(path)
    try:
        if path.stat().st_size > LARGEST_BYTES:
            raise InputError(path.name, allowed=f"is larger than {LARGEST_BYTES} bytes; {remedy}")
        content = json.loads(path.read_bytes().decode("utf-8"), parse_constant=_refuse, parse_float=_finite)
    except FileNotFoundError:
        raise
    except InputError:
        raise
    except OSError as error:
        raise InputError(path.name, allowed=f"cannot be read ({reason(error)}); {remedy}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(path.name, allowed=f"is damaged ({reason(error)}); {remedy}") from None
    if not isinstance(content, kind):
        expected = {dict: "a table", list: "a list"}[kind]
        raise InputError(path.name, allowed=f"is damaged (it holds no {expected[2:]}); {remedy}")
    return content


def _refuse(text: str) -> float:
    raise ValueError(f"{text} is no number")


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text[:20]} is too large")
    return value
