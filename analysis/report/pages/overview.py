"""The first page: what is known, what is pending, and the main figures."""

from __future__ import annotations

import math
from collections.abc import Sequence

from analysis.comparison import against_published, quantities, same_bed
from analysis.comparison.claims import evidence
from analysis.comparison.quantities import last_cycle
from analysis.formats import file_columns
from analysis.formats.numbers import plural
from analysis.formats.quantities import GRAVITY_M_S2 as GRAVITY
from analysis.normalised.readers import Run
from analysis.report.figure import family_of
from analysis.report.figures.beds import bed_figure
from analysis.report.figures.lateral import lateral_figure
from analysis.report.figures.load import tracking_figure
from analysis.report.figures.porosity import porosity_figure
from analysis.report.figures.settlement import settlement_figure
from analysis.report.labels import MM, SOURCE_NAMES, short_name
from analysis.report.pages.comparison import AGREEMENT_BRIEF, agreement_table, same_bed_groups
from analysis.report.pages.runs import runs_table
from analysis.report.report_data import (
    KEY_SCENARIOS,
    PAPER_SCENARIOS,
    PROFILE_TEXT,
    ReportData,
    known_scenarios,
    name_of,
    overview_runs,
    tracking_percent,
)
from analysis.report.style import CODE_NAMES
from analysis.report.tables import number
from analysis.scenarios import derived

LEAST_TREND_CYCLES = 10
"""In fewer cycles than this every bed slows down."""


def overview(data: ReportData) -> dict:
    """The first page."""
    verdicts = data.verdicts
    return {
        "known": known(data, verdicts),
        "pending": pending(data, verdicts),
        "sections": [overview_section(data, p) for p in data.profiles],
        "runs_table": runs_table(data.runs),
        "results": data.results,
        "problems": data.problems,
    }


def overview_section(data: ReportData, profile: str) -> dict:
    """Figures and agreement of one profile."""
    g, (runs, more) = data.gallery, overview_runs(data, profile)
    title, text = PROFILE_TEXT.get(profile, (f"Profile {profile}", ""))
    full = data.of(profile)
    seeds = max(
        (sum(1 for r in full if (r.scenario_name, r.code) == key) for key in {(r.scenario_name, r.code) for r in full}),
        default=0,
    )
    band = (
        "Lines are the longest run of each scenario and code, bands span its seeds."
        if seeds > 1
        else "One packing seed per curve, so there is no uncertainty to show."
    )
    ends = "; ".join(f"{name_of(run)} {last_cycle(run)}" for run in runs)
    picture_runs = [run for run in runs if (run.folder / "bed_after.csv").exists() and run.code == "liggghts"] or [
        run for run in runs if (run.folder / "bed_after.csv").exists()
    ]
    best = max(picture_runs, key=lambda run: (run.scenario_name in KEY_SCENARIOS[1:], last_cycle(run)), default=None)
    picture = (
        bed_figure(
            g,
            [best] if best else [],
            f"bed-{profile}",
            "after",
            "The bed after loading",
            "Two-sphere clumps coloured by how far they moved since the end of preload; sleeper and plates as glass, "
            "where they stand at the end. The full bed is cut open along the middle of the sleeper.",
        )
        if best
        else None
    )
    return {
        "profile": profile,
        "title": title,
        "text": text,
        "more": more,
        "picture": picture,
        "settlement": settlement_figure(
            g,
            runs,
            f"settlement-{profile}",
            "Settlement of the sleeper",
            f"At minimum load, zero at the end of preload. {band} Cycles reached: {ends}.",
        ),
        "lateral": lateral_figure(
            g,
            runs,
            f"lateral-{profile}",
            "Lateral displacement of the plates",
            f"Outward, at minimum load, at the mid-height of plates 5 (top) to 1 (bottom). {band} "
            "The law by which the plates are held is an assumption and decides much of this figure.",
        ),
        "porosity": porosity_figure(
            g,
            runs,
            f"porosity-{profile}",
            "Porosity in the three measurement spheres",
            "Of the exact union of spheres over a fixed set of points; standard error about 0.001. Cycle 0 is the end "
            "of preload.",
        ),
        "tracking": tracking_figure(
            g,
            runs,
            f"tracking-{profile}",
            "Load tracking",
            "How closely the contact force on the sleeper follows the prescribed stress: rms error over each cycle, "
            "and the extremes of "
            "each cycle minus their targets of 50 and 460 kPa (paler: minimum).",
        ),
        "agreement": agreement_table(data, profile, AGREEMENT_BRIEF),
    }


def known(data: ReportData, verdicts: Sequence) -> list[str]:
    """What the runs show, in sentences with numbers."""
    lines = []
    for profile in data.profiles:
        runs = data.of(profile)
        codes = [CODE_NAMES.get(code, code) for code in sorted({run.code for run in runs})]
        longest = max(runs, key=last_cycle)
        where = {"full": "At full size", "demo": "On the demo slice"}.get(profile, f"At profile {profile}")
        lines.append(
            f"{where}: {plural(len(runs), 'run')} of {plural(len({r.scenario_name for r in runs}), 'scenario')} in "
            f"{' and '.join(codes)}; "
            f"the longest has {plural(last_cycle(longest), 'cycle')} ({name_of(longest)})."
        )
        if profile != data.profiles[0]:
            continue  # the numbers of a smaller bed would only distract
        for scenario in dict.fromkeys(run.scenario_name for run in overview_runs(data, profile)[0]):
            parts = []
            members = [run for run in runs if run.scenario_name == scenario]
            common = min(last_cycle(run) for run in members)
            for curve in data.gallery.curves(members):
                values = curve.column("settlement_m").reindex([common]).iloc[0]
                spread = (
                    f" ({number(values['low'], 3, MM)} to {number(values['high'], 3, MM)}, {len(curve.runs)} seeds)"
                    if len(curve.runs) > 1
                    else ""
                )
                parts.append(f"{CODE_NAMES.get(curve.code, curve.code)} {number(values['value'], 3, MM)} mm{spread}")
            single = "; single seed, no uncertainty" if len(members) == len({run.code for run in members}) else ""
            lines.append(
                f"{short_name(scenario)}: settlement after {plural(common, 'cycle')} {', '.join(parts)}{single}."
            )
        lines += same_bed_lines(data, profile)
        lines += settling(overview_runs(data, profile)[0])
        if profile == "full":
            lines += packed_beds(runs)
        worst = max(runs, key=lambda run: tracking_percent(run))
        lines.append(
            f"The load is met within {tracking_percent(worst):.2g} % rms of its maximum in every cycle of these runs "
            f"(worst: {name_of(worst)})."
        )
    if len(data.verification):
        passed, total = int(data.verification["passed"].sum()), len(data.verification)
        lines.append(
            f"Verification: {passed} of {total} comparisons of the contact laws and bodies with known answers pass."
        )
    lines += in_hand(data)
    for verdict, one, more in ((evidence.HOLDS, "holds", "hold"), (evidence.FAILS, "does not hold", "do not hold")):
        count = len({v.claim.number for v in verdicts if v.verdict == verdict})
        if count:
            total = len({v.claim.number for v in verdicts})
            lines.append(
                f"{count} of the paper's {total} claims {one if count == 1 else more}: "
                f"{claim_numbers(verdicts, verdict)}."
            )
    return lines


def in_hand(data: ReportData) -> list[str]:
    """Reference curves that are digitised, by whom, and how far the longest run of each code is from them."""
    sources = data.references.sources
    sources = sources[sources["digitised"] > 0]
    if sources.empty:
        return []
    whose = "; ".join(
        f"{plural(int(r.digitised), 'curve')} of {r.sidecar} ({SOURCE_NAMES.get(r.source, r.source)}), "
        f"by {r.digitised_by}"
        for r in sources.itertuples()
    )
    lines = [f"Reference curves in hand: {whose}."]
    scores = against_published.reference_table(data.of(data.profiles[0]) if data.profiles else [], data.references)
    if len(scores):
        texts = [
            f"{short_name(r.scenario)} {CODE_NAMES.get(r.code, r.code)} {number(r.rms_m, 2, MM)} mm"
            for r in scores.sort_values("points").groupby(["scenario", "code"], sort=True).tail(1).itertuples()
        ]
        lines.append(f"Settlement differs from them by (rms over the shared cycles): {', '.join(texts)}; see Figures.")
    return lines


def same_bed_lines(data: ReportData, profile: str) -> list[str]:
    """How closely the codes agree from one bed, beside two time steps of one code."""
    lines = []
    for (basis, _), found in same_bed_groups(data, profile).items():
        spans = {}
        for pair in found:
            ratios = 100 * same_bed.settlements(pair)["difference_ratio"].abs()
            spans.setdefault(pair.differs, []).extend(ratios.dropna())
        texts = [
            f"by {number(min(spans[key]), 2)} to {number(max(spans[key]), 2)} % {what}"
            for key, what in (
                ("code", "between the codes"),
                ("time.step", "between the time step and half of it"),
                ("ranks", "by rounding alone"),
            )
            if spans.get(key)
        ]
        if texts:
            lines.append(
                f"{short_name(basis)} from one and the same bed: settlement in preload and in the first cycles (up to "
                f"{same_bed.SHARED_CYCLES}) differs {', '.join(texts)}."
            )
    return lines


def settling(runs: Sequence[Run]) -> list[str]:
    """Which of the longer runs slow down, and how those that do not go on."""
    slowing, lines = [], []
    for run in runs:
        trend, rates = quantities.settling_trend(run), quantities.settling_rates(run)
        if not trend or last_cycle(run) < LEAST_TREND_CYCLES:
            continue
        if trend == "slowing":
            slowing.append(f"{name_of(run)} ({last_cycle(run)} cycles)")
            continue
        before, last = rates.iloc[-2], rates.iloc[-1]
        lines.append(
            f"{name_of(run)} does not shake down: {number(before['settlement_rate_m'], 2, MM)} mm per cycle from cycle "
            f"{before['first_cycle']:.0f} to {before['last_cycle']:.0f}, {number(last['settlement_rate_m'], 2, MM)} mm "
            f"to {last['last_cycle']:.0f}, while the cribs heave by {number(last['crib_heave_rate_m'], 2, MM)} mm and "
            f"the plates move out by {number(last['lateral_rate_m'], 2, MM)} mm per cycle.{unrest(run)}"
        )
    return ([f"Settling slows down in: {', '.join(slowing)}."] if slowing else []) + lines


def unrest(run: Run) -> str:
    """How far from rest a bed stays between cycles, and whether its stroke throws what lies on it."""
    text, stroke = "", quantities.per_cycle(run).iloc[-1]
    peak = stroke["peak_acceleration_m_s2"] / GRAVITY
    if peak > 1:
        text += (
            f" A resilient stroke of {number(stroke['resilient_stroke_m'], 2, MM)} mm at "
            f"{number(run.scenario['loading.frequency'], 3)} Hz has a peak acceleration of {number(peak, 2)} g, which "
            f"throws the cribs"
        )
        energy = run.microstructure["kinetic_energy_J"].dropna()
        if len(energy):
            speed = math.sqrt(2 * energy.iloc[-1] / derived.clump(run.scenario).mass_kg)
            text += f": at minimum load clumps still move at {number(speed, 2)} m/s (rms)"
        text += "."
    return text


def packed_beds(runs: Sequence[Run]) -> list[str]:
    """Clumps and porosity of the full-size beds at the end of preload, beside the paper's."""
    starts = [
        run.microstructure[run.microstructure["cycle"] == 0] for run in runs if family_of(run.scenario) == "linear"
    ]
    porosity = [row[[f"porosity_{k}" for k in file_columns.SPHERES]].iloc[0].mean() for row in starts if len(row)]
    clumps = [run.cycles["clumps"].iloc[0] for run in runs if family_of(run.scenario) == "linear"]
    if not porosity:
        return []
    held = " to ".join(dict.fromkeys(number(v, 5) for v in (min(clumps), max(clumps))))
    mean = " to ".join(dict.fromkeys(f"{v:.3f}" for v in (min(porosity), max(porosity))))
    return [
        f"Linear beds hold {held} clumps (paper: 4583) at a mean porosity of {mean} under the sleeper (paper: "
        f"about 0.35)."
    ]


def claim_numbers(verdicts: Sequence, verdict: str) -> str:
    """Claims with that verdict by the codes that give it: `no. 1, 2, 9 in both codes; no. 10 in YADE`."""
    codes: dict[int, list[str]] = {}
    for v in verdicts:
        if v.verdict == verdict:
            codes.setdefault(v.claim.number, []).append(CODE_NAMES.get(v.code, v.code))
    groups: dict[str, list[str]] = {}
    for n, found in sorted(codes.items()):
        groups.setdefault("both codes" if len(found) > 1 else found[0], []).append(str(n))
    return "; ".join(f"no. {', '.join(numbers)} in {where}" for where, numbers in groups.items())


def pending(data: ReportData, verdicts: Sequence) -> list[str]:
    """What is missing, and why it matters."""
    lines = []
    full = data.of("full")
    if not full:
        lines.append("No full-size run yet: nothing here is about the paper's bed.")
    else:
        missing = [
            name
            for name in known_scenarios()
            if name in PAPER_SCENARIOS and name not in {run.scenario_name for run in full}
        ]
        if missing:
            lines.append(
                f"{len(missing)} of the paper's {len(PAPER_SCENARIOS)} scenarios have no full-size run: "
                f"{', '.join(missing)}."
            )
        short = [run for run in full if last_cycle(run) < 1000]
        if short:
            which = "No full-size run has" if len(short) == len(full) else f"{len(short)} full-size runs have not"
            lines.append(f"{which} reached the paper's 1000 cycles.")
        groups = {(run.scenario_name, run.code) for run in full}
        single = [key for key in groups if sum((run.scenario_name, run.code) == key for run in full) == 1]
        if single:
            which = "All" if len(single) == len(groups) else f"{len(single)} of {len(groups)}"
            lines.append(f"{which} full-size curves rest on a single packing seed: they have no uncertainty.")
    curves = data.references.pending
    if len(curves):
        there = data.references.sources["digitised"].sum() if len(data.references.sources) else 0
        lines.append(
            f"{plural(len(curves), 'reference curve')} of {plural(curves['sidecar'].nunique(), 'figure')} are not "
            f"digitised yet (experiment, Chen 2015, the paper's own): "
            + ("what they show is compared with nothing" if there else "no comparison with the experiment is possible")
            + " until they are. reference_data/README.md says how to add them."
        )
    open_claims = claim_numbers(verdicts, evidence.OPEN)
    if open_claims:
        lines.append(f"Claims not decidable yet: {open_claims}.")
    if not len(data.verification):
        lines.append("The verification of the contact laws has not been run (make verify).")
    lines.append(
        "Not known from the paper and assumed here: the clump's aspect (calibrated), the law that holds the plates, "
        "the damping limit at small approach speed, and more; see Assumptions."
    )
    return lines
