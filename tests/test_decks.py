"""Decks and scripts of the two codes: the same stages in the same rooms, and what the host's commands refuse."""

import re
import subprocess
from pathlib import Path

import pytest

from analysis.driver.engines import LIGGGHTS

ROOT = Path(__file__).resolve().parent.parent
STAGES = ("packing", "preload", "cyclic")
ROOMS = (*STAGES, "apparatus", "bed", "bond", "contact", "load_control", "stage", "state")


def deck(name):
    return (ROOT / "liggghts" / f"{name}.in").read_text()


def script(name):
    return (ROOT / "yade" / f"{name}.py").read_text()


@pytest.mark.parametrize("room", ROOMS)
def test_both_codes_have_a_file_of_that_name(room):
    assert deck(room) and script(room)


@pytest.mark.parametrize("stage", STAGES)
def test_the_steps_of_a_stage_are_numbered_and_called_alike(stage):
    headings = [re.findall(r"^ *# (\d\. .+)$", text, re.MULTILINE) for text in (deck(stage), script(stage))]
    assert headings[0] == headings[1] and [int(h[0]) for h in headings[0]] == list(range(1, len(headings[0]) + 1))


@pytest.mark.parametrize("stage", [*STAGES, "unload"])
def test_a_stage_is_read_from_top_to_bottom(stage):
    assert not re.findall(r"^\s*(?:label|jump|next|if)\b", deck(stage), re.MULTILINE)


def run(tmp_path, *lines):
    """Output and exit status of a deck."""
    (tmp_path / "deck.in").write_text("".join(f"{line}\n" for line in lines))
    command = [LIGGGHTS.host, "-in", tmp_path / "deck.in", "-log", "none"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60)
    return done.stdout + done.stderr, done.returncode


def test_for_each_puts_every_item_in_turn_also_into_names_of_variables(tmp_path):
    (tmp_path / "part.in").write_text("variable &\n  sum equal v_size+1\nprint 'sum ${sum}'\n")
    output, status = run(
        tmp_path,
        "variable size_left index 3",
        "variable size_right index 5",
        f'for_each side in left right do "variable size equal v_size_${{side}}" "include {tmp_path}/part.in"',
        "for_each side in do \"print 'never'\"",
        "print 'end'",
    )
    printed = [line for line in output.splitlines() if line.startswith(("sum", "never", "end"))]
    assert status == 0 and printed == ["sum 4", "sum 6", "end"]


@pytest.mark.parametrize(
    "command, says",
    [
        ("advance", "STEPS [block N]"),
        ("advance 10 block 0", "STEPS [block N]"),
        ("advance 10", "ballast/stage"),
        ("advance_to_rest block 10", "is missing or not positive"),
        ("advance_to_rest unbalanced_ratio 1 kinetic_energy 1 time_limit 1 block 1 patience 1", "[stress_tolerance S]"),
        ("advance_cycles 3 steps 10", "CYCLES steps N block M"),
        ("advance_cycles 3 steps 10 block 3", "whole number of blocks"),
        ('advance_cycles 3 steps 10 block 5 "print x"', "every K"),
        ("for_each plate 1 2", 'NAME in ITEM ... do "COMMAND"'),
        ("pair_property kn kn particles 1", "walls VALUE"),
        ("remove_outside 0 1", "XLO XHI"),
    ],
)
def test_a_command_that_is_written_wrongly_is_one_line_with_what_is_expected(tmp_path, command, says):
    output, status = run(tmp_path, command)
    errors = [line for line in output.splitlines() if line.startswith("ERROR")]
    assert status == 1 and len(errors) == 1 and says in errors[0]
