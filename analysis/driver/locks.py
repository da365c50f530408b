"""Locks between processes that die with their holder, also when it is killed."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import time
from collections.abc import Callable, Iterator
from pathlib import Path

PATIENCE_S = 1.0  # `is_held` holds a lock for a moment: long enough not to be mistaken for a run


class Busy(RuntimeError):
    """The lock belongs to another process."""


@contextlib.contextmanager
def hold(path: Path, wait: Callable[[], bool] | None = None) -> Iterator[None]:
    """Hold the lock file `path`; raise Busy where another process has it.

    With `wait`, try again for as long as wait() returns true; it is called once per try and may report progress.
    The kernel drops the lock when the process ends in whatever way, so no stale lock can remain.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "a") as file:
        give_up = time.monotonic() + PATIENCE_S
        while not _try(file):
            if wait is None and time.monotonic() > give_up or wait is not None and not wait():
                raise Busy(path.name)
            time.sleep(0.2)
        yield


def is_held(path: Path) -> bool:
    """True where some process holds the lock file `path`."""
    try:
        with open(path) as file:
            return not _try(file, fcntl.LOCK_SH)
    except FileNotFoundError:
        return False


def _try(file, kind: int = fcntl.LOCK_EX) -> bool:
    try:
        fcntl.flock(file, kind | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            return False
        raise
    return True
