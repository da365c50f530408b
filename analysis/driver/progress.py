"""What the user sees while something runs: one line that renews itself, or a line now and then in a log."""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections import deque

LINE_EVERY_S = 30.0
WINDOW_S = 60.0


class Progress:
    """One renewed line on a terminal; elsewhere, or with `lines`, a line every half minute."""

    def __init__(self, name: str, lines: bool = False):
        self.name = name
        self._renew = sys.stdout.isatty() and not lines
        self._open, self._next = False, 0.0

    def update(self, text: str) -> None:
        """Show the present state; may be called as often as one likes."""
        if self._renew:
            width = shutil.get_terminal_size().columns - 1
            _write("\r\033[K" + f"{self.name} | {text}"[:width], end="")
            self._open = True
        elif time.monotonic() >= self._next:
            self._print(text)
            self._next = time.monotonic() + LINE_EVERY_S

    def say(self, text: str) -> None:
        """Print a line that stays."""
        if self._open:
            _write("\r\033[K", end="")
            self._open = False
        self._print(text)
        self._next = time.monotonic() + LINE_EVERY_S

    def _print(self, text: str) -> None:
        _write(f"{self.name} | {text}")


def _write(text: str, end: str = "\n") -> None:
    """Print; where nobody listens any more (a closed terminal, `| head`) a run goes on in silence."""
    try:
        print(text, end=end, flush=True)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class Meter:
    """Steps per second: over the last minute for the progress line, and since the first report for the record."""

    def __init__(self):
        self._seen: deque[tuple[float, int]] = deque()
        self._first: tuple[float, int] | None = None

    def add(self, step: int) -> None:
        """Note that `step` has been reached just now."""
        entry = (time.monotonic(), step)
        self._first = self._first or entry
        self._seen.append(entry)
        while entry[0] - self._seen[0][0] > WINDOW_S and len(self._seen) > 2:
            self._seen.popleft()

    def recent(self) -> float:
        """Steps per second of the last minute; 0 while unknown."""
        return _rate(self._seen[0], self._seen[-1]) if self._seen else 0.0

    def mean(self) -> float:
        """Steps per second since the first report; 0 while unknown."""
        return _rate(self._first, self._seen[-1]) if self._seen else 0.0


def _rate(first: tuple[float, int], last: tuple[float, int]) -> float:
    return (last[1] - first[1]) / (last[0] - first[0]) if last[0] > first[0] else 0.0


def duration(seconds: float) -> str:
    """Time in words of a clock, e.g. `0:42`, `12:03`, `3:07:00`."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
