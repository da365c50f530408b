"""Locks between processes that die with their holder, also when it is killed.

Where the file system has no locks (some network file systems), the holder renews the lock file now and then instead,
and a file that nobody has renewed for a minute belongs to nobody.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from analysis.formats import json_file
from analysis.formats.errors import InputError

PATIENCE_S = 1.0  # `is_held` holds a lock for a moment: long enough not to be mistaken for a run
RENEW_S = 10.0
STALE_S = 60.0
HAS_NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)


class Busy(RuntimeError):
    """The lock belongs to another process; `holder` says which: its `pid` and `host`, as far as they are known."""

    def __init__(self, path: Path):
        super().__init__(path.name)
        self.holder = holder(path)


class Lock:
    """A lock that is held. Its holder calls `renew` at least every few seconds."""

    def __init__(self, path: Path, by_heartbeat: bool):
        self._path, self._by_heartbeat, self._renewed = path, by_heartbeat, time.monotonic()

    def renew(self) -> None:
        """Tell others that the holder lives; needed only where the file system has no locks."""
        if self._by_heartbeat and time.monotonic() - self._renewed > RENEW_S:
            self._renewed = time.monotonic()
            os.utime(self._path)


@contextlib.contextmanager
def hold(path: Path, wait: Callable[[], bool] | None = None) -> Iterator[Lock]:
    """Hold the lock file `path`; raise Busy where another process has it.

    With `wait`, try again for as long as wait() returns true; it is called once per try and may report progress.
    The kernel drops the lock when the process ends in whatever way, so no stale lock can remain.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "a+") as file:
        give_up, by_heartbeat = time.monotonic() + PATIENCE_S, False
        while True:
            try:
                if _try(file):
                    break
            except OSError as error:
                if error.errno not in HAS_NO_LOCKS:
                    raise
                if not _beats(path) and _take(path):
                    by_heartbeat = True
                    break
            if wait is None and time.monotonic() > give_up or wait is not None and not wait():
                raise Busy(path)
            time.sleep(0.2)
        _sign(file)
        try:
            yield Lock(path, by_heartbeat)
        finally:
            with contextlib.suppress(OSError):
                file.truncate(0)


def is_held(path: Path) -> bool:
    """True where some process holds the lock file `path`."""
    try:
        with open(path) as file:
            return not _try(file, fcntl.LOCK_SH)
    except FileNotFoundError:
        return False
    except OSError as error:
        if error.errno not in HAS_NO_LOCKS:
            raise
        return _beats(path)


def holder(path: Path) -> dict[str, int | str]:
    """`pid` and `host` of whoever holds, or held, the lock file; {} where it does not say."""
    try:
        body = json_file.read(path)
    except (OSError, InputError):
        return {}
    return body if {"pid", "host"} <= set(body) else {}


def _try(file, kind: int = fcntl.LOCK_EX) -> bool:
    try:
        fcntl.flock(file, kind | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            return False
        raise
    return True


def _sign(file) -> None:
    file.truncate(0)
    file.write(json.dumps({"pid": os.getpid(), "host": socket.gethostname()}))
    file.flush()


def _beats(path: Path) -> bool:
    """True where the lock file has a holder and was renewed within the last minute, by the clock of its own disk."""
    if not holder(path):
        return False
    probe = path.with_name(f"{path.name}.{socket.gethostname()}.{os.getpid()}")
    try:
        probe.touch()
        now = probe.stat().st_mtime
        probe.unlink()
    except OSError:  # a folder that may only be read
        now = time.time()
    return abs(now - path.stat().st_mtime) < STALE_S


def _take(path: Path) -> bool:
    """Put this process into the lock file; of several that do so at once the last one has it."""
    mine = {"pid": os.getpid(), "host": socket.gethostname()}
    path.write_text(json.dumps(mine))
    time.sleep(PATIENCE_S)
    return holder(path) == mine
