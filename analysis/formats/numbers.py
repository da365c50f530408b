"""Numbers as files hold them and as people read them."""

from __future__ import annotations

import math

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def exact(value: float) -> str:
    """The shortest text that reads back as the same double, whole numbers without a point; nan is an empty cell."""
    if value != value:
        return ""
    if isinstance(value, int) or float(value).is_integer() and abs(value) < 1e15:
        return str(int(value))
    return repr(float(value))


def short(value: float) -> str:
    """Nine digits, for tables that are large and only looked at; nan is an empty cell."""
    return "" if value != value else f"{value:.9g}"


def readable(value, digits: int = 3, factor: float = 1.0) -> str:
    """A number for people: `digits` significant digits of factor x value, 1.2·10⁻⁷, and a dash where there is none."""
    try:
        value = factor * float(value)
    except (TypeError, ValueError, OverflowError):
        return "–"
    if not math.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    mantissa, _, power = text.partition("e")
    if power and 0 <= int(power) < 6:
        text = f"{value:.0f}"
    elif power:
        text = f"{mantissa}·10" + str(int(power)).translate(SUPERSCRIPT)
    return text.replace("-", "−")


def signed(value: float, form: str) -> str:
    """A number in a format of Python's, with a minus sign instead of a hyphen."""
    return f"{value:{form}}".replace("-", "−")


def plural(count: int, noun: str) -> str:
    """`1 run`, `2 runs`."""
    return f"{count} {noun}{'' if count == 1 else 's'}"
