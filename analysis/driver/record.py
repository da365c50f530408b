"""run.json: what a run is and how far it got. Everything that differs between two equal runs is under `timing`."""

from __future__ import annotations

import json
import os
import platform
import socket
import subprocess
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path

from analysis.files import ROOT, write_aside

FILE = "run.json"


def now() -> str:
    """The time as ISO 8601, UTC, whole seconds."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def read(run_dir: Path) -> dict | None:
    """Content of run.json, or None where there is none that can be read."""
    try:
        return json.loads((run_dir / FILE).read_text())
    except (OSError, ValueError):
        return None


def write(run_dir: Path, body: dict) -> None:
    """Replace run.json in one go."""
    write_aside(run_dir / FILE, json.dumps(body, indent=1) + "\n")


def host() -> str:
    """Name of this machine."""
    return socket.gethostname()


def versions(engine: str) -> dict[str, str]:
    """Versions of engine, analysis, Python and system."""
    system = platform.freedesktop_os_release().get("PRETTY_NAME", platform.system())
    return {
        "engine": engine,
        "analysis": metadata.version("ballast-analysis"),
        "python": platform.python_version(),
        "os": f"{system}, {platform.machine()}",
    }


def git() -> dict:
    """Commit of the working tree, and whether tracked files differ from it (None where there is no commit).

    A copy without its own repository, perhaps unpacked inside another one, is known by its release only.
    """

    def ask(*words: str) -> str | None:
        # The folder may belong to somebody else, as under sudo; and a hook may have named another repository.
        environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
        command = ["git", "-c", f"safe.directory={ROOT}", "-C", str(ROOT), *words]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
        except OSError:
            return None
        return done.stdout.rstrip("\n") if done.returncode == 0 else None

    top = ask("rev-parse", "--show-toplevel")
    commit = ask("rev-parse", "HEAD") if top and Path(top).resolve() == ROOT else None
    if not commit:
        return {"git_commit": f"unknown (release {metadata.version('ballast-analysis')})", "git_dirty": None}
    return {"git_commit": commit, "git_dirty": bool(ask("status", "--porcelain", "--untracked-files=no"))}


def short_commit(commit: str) -> str:
    """A commit as people quote it; `unknown (release ...)` as it is."""
    return commit[:10] if len(commit) == 40 else commit


def relative(path: Path) -> str:
    """A path as run.json may hold it: relative to the repository, or outside of it the name alone."""
    path = path.resolve()
    return str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else path.name
