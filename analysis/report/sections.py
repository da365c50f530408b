"""Sections of pages: figures and tables that belong together."""

from __future__ import annotations

from collections.abc import Callable

from analysis.comparison.findings.agreement import pairs_by_bed
from analysis.comparison.findings.members import READINGS, SERVO, SERVO_VARIANT, member
from analysis.normalised.readers import Run, Runs
from analysis.reference.settlement_shapes import settlement_shapes
from analysis.report.figures.same_bed_figures import same_bed_figure
from analysis.report.labels import short_name
from analysis.report.report_data import KEY_SCENARIOS, ReportData, key_runs
from analysis.report.tables.agreement_tables import pairs_table
from analysis.scenarios.scenario import join_id

WAITS = "It appears as soon as a run of one of its scenarios has finished a cycle."


def section(title: str, figures: list | None = None, tables: list | None = None, missing: str = "") -> dict:
    """One section; `missing` says what it waits for where it has no figure."""
    return {"title": title, "figures": figures or [], "tables": tables or [], "folded": [], "missing": missing}


def with_what_is_there(part: dict) -> dict:
    """A section without the figures and tables for which there is nothing."""
    return part | {kind: [one for one in part.get(kind, ()) if one] for kind in ("figures", "tables", "folded")}


def in_readings(title: str, data: ReportData, runs: Runs, draw: Callable, before: list | None = None) -> dict:
    """Figures that are drawn for every reading that has runs."""
    figures = list(before or [])
    for reading in READINGS:
        mine = Runs(run for run in runs if member(run).reading == reading)
        figures += draw(data.gallery, mine, reading) if mine else []
    return section(title, figures, missing=WAITS)


def tests_note() -> str:
    """What the triaxial tests decide, and what they cannot."""
    known = settlement_shapes()
    return (
        f"The triaxial tests: {known.provenance}. They decide {known.decides}. They cannot decide "
        f"{known.cannot_decide}. Their weakness: {known.weakness}."
    )


def key_runs_of_both(data: ReportData, profile: str) -> Runs:
    """The runs of the key scenarios in every reading that has runs."""
    found: list[Run] = []
    for reading in READINGS:
        if any(member(run).reading == reading for run in data.of(profile)):
            found += key_runs(data, profile, reading)
    return Runs(found)


def same_bed_parts(data: ReportData, profile: str) -> list[dict]:
    """Figures and tables of runs from one bed that differ in one thing alone; the key scenarios only."""
    members = [m for m in data.findings.members if m.run.profile == profile and m.scenario in KEY_SCENARIOS]
    parts = []
    for (scenario, reading, bed), found in pairs_by_bed(members).items():
        basis = join_id(scenario, (SERVO_VARIANT,) if reading == SERVO else ())
        figure = same_bed_figure(data.gallery, found, f"same-bed-{profile}-{bed[:6]}-{basis}", short_name(basis))
        parts.append({"table": pairs_table(found, f"{short_name(basis)}, bed {bed[:8]}"), "figure": figure})
    return parts
