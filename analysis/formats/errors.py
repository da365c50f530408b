"""The one error of every reader: a line that names file, key, value and what is allowed."""

from __future__ import annotations

import json
import os

LONGEST_VALUE = 80
LONGEST_LINE = 500


class InputError(ValueError):
    """Input that cannot be used. `str(error)` is one line: file, key, value and what is allowed.

    file     name or path of the file, as the user knows it; alone, it is the whole line
    key      place in the file: a dotted key, `line 7`, or empty where the whole file is meant
    value    what stands there; `...` (Ellipsis) leaves it out
    allowed  what may stand there, or what to do
    """

    def __init__(self, file: str | os.PathLike, key: str = "", value: object = ..., allowed: str = ""):
        self.file, self.key, self.value, self.allowed = os.fspath(file), key, value, allowed
        line = self._line()
        super().__init__(line if len(line) <= LONGEST_LINE else line[: LONGEST_LINE - 3] + "...")

    def _line(self) -> str:
        if not self.key and not self.allowed and self.value is ...:
            return one_line(self.file)  # a text of its own
        place = f"{self.file}: {self.key}" if self.key else self.file
        if self.value is ...:
            return one_line(f"{place}{' ' if self.key else ': '}{self.allowed}")
        return one_line(f"{place} = {shown(self.value)} is refused; allowed: {self.allowed}")


def shown(value: object) -> str:
    """A value as a message quotes it: JSON, shortened; never an error itself."""
    try:
        text = json.dumps(value, default=str, ensure_ascii=False)
    except (ValueError, TypeError, RecursionError):  # an integer of 5000 digits, a list a thousand deep
        text = f"a {type(value).__name__} that is too large to show"
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 3] + "..."


def one_line(text: object) -> str:
    """Text without line breaks and control characters."""
    return " ".join("".join(c if c.isprintable() else " " for c in str(text)).split())


def reason(error: BaseException) -> str:
    """What an exception says, in one line and without a path: `No such file or directory`, `UnicodeDecodeError`."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    if isinstance(error, RecursionError):
        return "is nested too deep"
    return one_line(error) or type(error).__name__
