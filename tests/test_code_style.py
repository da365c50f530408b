"""The code is written in one hand: `ruff check` and `ruff format` (pyproject.toml), `clang-format` (.clang-format)."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.mark.parametrize("rule", [["check"], ["format", "--check"]], ids=["lint", "format"])
def test_all_python_follows_the_rules_of_pyproject(rule):
    done = subprocess.run(
        [sys.executable, "-m", "ruff", *rule, "--no-cache", "--quiet", "."], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, f"run `.venv/bin/python -m ruff {rule[0]} .`\n{done.stdout}{done.stderr}"


def test_the_hosts_sources_are_formatted():
    sources = [*(ROOT / "liggghts" / "src").glob("*.cpp"), *(ROOT / "liggghts" / "src").glob("*.h")]
    command = Path(sys.executable).with_name("clang-format")
    done = subprocess.run([command, "--dry-run", "-Werror", *sources], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, f"run `.venv/bin/clang-format -i liggghts/src/*`\n{done.stderr[:2000]}"
