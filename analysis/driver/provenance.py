"""Where a run's numbers come from: time, machine, programs, commit."""

from __future__ import annotations

import os
import platform
import subprocess
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path

from analysis.files import ROOT


def now() -> str:
    """The time as ISO 8601, UTC, whole seconds."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def versions(engine: str) -> dict[str, str]:
    """Versions of engine, analysis, Python and system."""
    system = platform.freedesktop_os_release().get("PRETTY_NAME", platform.system())
    return {
        "engine": engine,
        "analysis": metadata.version("ballast-analysis"),
        "python": platform.python_version(),
        "os": f"{system}, {platform.machine()}",
    }


def git_state(*, beside: tuple[str, ...] = ()) -> dict:
    """Commit of the working tree, and whether tracked files differ from it (None where there is no commit).

    `beside` names folders whose changes do not count, because nothing is read from them. A copy without its own
    repository, perhaps unpacked inside another one, is known by its release only.
    """

    top = _git("rev-parse", "--show-toplevel")
    commit = _git("rev-parse", "HEAD") if top and Path(top).resolve() == ROOT else None
    if not commit:
        return {"git_commit": f"unknown (release {metadata.version('ballast-analysis')})", "git_dirty": None}
    aside = [f":(exclude,top){folder}" for folder in beside]
    changed = _git("status", "--porcelain", "--untracked-files=no", "--", ":(top)", *aside)
    return {"git_commit": commit, "git_dirty": bool(changed)}


def commit_date(commit: str) -> str:
    """The day of a commit, YYYY-MM-DD; empty where it is not known."""
    return (_git("show", "--no-patch", "--format=%cs", commit) or "") if len(commit) == 40 else ""


def _git(*words: str) -> str | None:
    """What git says of this repository; None where it fails."""
    # The folder may belong to somebody else, as under sudo; and a hook may have named another repository.
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    command = ["git", "-c", f"safe.directory={ROOT}", "-C", str(ROOT), *words]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    except OSError:
        return None
    return done.stdout.rstrip("\n") if done.returncode == 0 else None


def short_commit(commit: str) -> str:
    """A commit as people quote it; `unknown (release ...)` as it is."""
    return commit[:10] if len(commit) == 40 else commit


def is_repeatable(parts: list[dict]) -> bool:
    """True where the same command gives the same files bit: each part on one core, all by the same programs."""
    programs = {(part["engine"], part["git_commit"], part["git_dirty"]) for part in parts}
    return len(programs) <= 1 and all(part["ranks"] * part["threads"] == 1 for part in parts)
