"""Tiles of the first page: one number each, and a link to the evidence."""

from __future__ import annotations

from dataclasses import dataclass

from analysis.comparison.findings.agreement import AGREES
from analysis.report.answer import influences, of_the_paper, only, servo_filter, states
from analysis.report.labels import short_name, variant_name
from analysis.report.report_data import KEY_SCENARIOS, ReportData
from analysis.report.tables.table_html import number


@dataclass(frozen=True)
class Tile:
    """A number, what it is, and where it comes from."""

    value: str
    text: str
    href: str


def tiles(data: ReportData, profile: str) -> list[Tile]:
    """The tiles that there is something for."""
    made = [_claims(data), _agreement(data, profile), _servo(data, profile), _influence(data, profile)]
    made += [_cost(data, profile), _verification(data), _runs(data, profile)]
    return [tile for tile in made if tile is not None]


def _claims(data: ReportData) -> Tile | None:
    verdicts = of_the_paper(data.findings.verdicts)
    if verdicts.empty:
        return None
    each = verdicts.drop_duplicates(["number", "code", *(["reading"] if "reading" in verdicts else [])])
    decided = each[each["verdict"].isin(["holds", "does not hold"])]["number"].nunique()
    return Tile(
        f"{decided} of {each['number'].nunique()}",
        "of the paper's claims decided, in at least one code and load",
        "claims.html",
    )


def _agreement(data: ReportData, profile: str) -> Tile | None:
    found = states(only(data.findings.agreement, profile=profile))
    if not found:
        return None
    return Tile(
        f"{found[AGREES]} of {sum(found.values())}", "quantities agree between YADE and LIGGGHTS", "comparison.html"
    )


def _servo(data: ReportData, profile: str) -> Tile | None:
    passed = servo_filter(data.findings.servo, KEY_SCENARIOS[-1] if KEY_SCENARIOS else "", profile)
    if not passed:
        return None
    ratio = passed["amplitude_ratio"]
    return Tile(
        f"{number(ratio, 2, 100)} %", "of the load's amplitude passes PFC's servo, nonlinear model", "servo.html"
    )


def _influence(data: ReportData, profile: str) -> Tile | None:
    rows = influences(data.findings, KEY_SCENARIOS, profile)
    if rows.empty:
        return None
    largest = rows.iloc[-1]
    low, high = sorted([largest["base"], largest["changed"]])
    return Tile(
        f"{number(high / low, 2)} times",
        f"{'less' if largest['changed'] == low else 'more'} settlement by {variant_name(largest['variant'])} in "
        f"{short_name(largest['scenario'])}, the largest effect of what the paper leaves open",
        "influence.html",
    )


def _cost(data: ReportData, profile: str) -> Tile | None:
    rows = only(data.findings.computing_time, profile=profile, code="liggghts")
    rows = rows[rows["variant"] == ""]
    if rows.empty or rows["scenario"].nunique() < 2:
        return None
    hours = rows.groupby("scenario")["hours_per_1000_cycles"].min()
    low, high = number(hours.min(), 2), number(hours.max(), 2)
    return Tile(
        f"{low} to {high} h",
        "for 1000 cycles in LIGGGHTS on one core, by the speed of the runs",
        "comparison.html#computing-time",
    )


def _verification(data: ReportData) -> Tile | None:
    if not len(data.verification):
        return None
    passed = int(data.verification["passed"].sum())
    return Tile(f"{passed} of {len(data.verification)}", "comparisons with known answers pass", "verification.html")


def _runs(data: ReportData, profile: str) -> Tile | None:
    rows = only(data.findings.coverage, profile=profile)
    if rows.empty:
        return None
    return Tile(str(len(rows)), f"runs of the full bed, the longest of {rows['cycles'].max()} cycles", "runs.html")
