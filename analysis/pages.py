"""What each page of the report says: sentences, tables and figures from runs, references and claims, and nothing about HTML."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from . import claims, derived, figures, status, style, tables, verification_figures
from .figures import CODE_NAMES, KPA, MM, Figure, Gallery, short_name
from .readers import Run, Runs
from .reference import References
from .scenario import Scenario, ScenarioError, load_scenario, scenario_names
from .schema import STATUSES

KEY_SCENARIOS = ("linear-mu0.8", "nonlinear-en1.0")
"""The two the paper's discussion rests on; the overview shows them, and scenarios that are not the paper's."""
PAPER_SCENARIO = re.compile(r"linear-mu0\.[789]|nonlinear-en1\.0|nonlinear-md[012]-en0\.[0369]")
STATUS_KIND = {"reported": "good", "derived": "calm", "assumed": "open", "calibrated": "bad"}
STATUS_TEXT = {"reported": "Printed in the paper.", "derived": "Follows from reported values; the source says how.",
               "assumed": "Nobody's value is known: a knob for sensitivity studies.",
               "calibrated": "Tuned by this project; the source says to what. What it was tuned to is no evidence any more."}
STATE_KIND = {"finished": "good", "running": "calm", "interrupted": "open", "failed": "bad"}
VERDICT_KIND = {claims.HOLDS: "good", claims.FAILS: "bad", claims.OPEN: "open"}
PROFILE_TEXT = {
    "full": ("The full-size bed", "The paper's box and sleeper."),
    "demo": ("The demo slice", "A thin slice of the bed, a few hundred clumps and a few cycles: it shows that the whole chain works in both codes. Its side walls are "
             "close, so it is not the paper's bed, and its numbers answer none of the paper's questions."),
}


@dataclass(frozen=True)
class Column:
    """Heading of a table's column; numbers stand to the right, `wide` ones hold sentences."""

    title: str
    number: bool = False
    wide: bool = False


@dataclass
class Table:
    """Rows of texts under their columns."""

    caption: str
    columns: list[Column]
    rows: list[list] = field(default_factory=list)
    note: str = ""


@dataclass(frozen=True)
class Chip:
    """A word in a coloured box: kind is good, bad, open or calm."""

    text: str
    kind: str

    def __html__(self) -> str:
        return f'<span class="chip {self.kind}">{self.text}</span>'


@dataclass
class Book:
    """Everything the pages are made of."""

    runs: Runs
    """The runs that are drawn: one for each profile, scenario, code and seed."""
    left_out: list[tuple[Run, str]]
    references: References
    gallery: Gallery
    verification: pd.DataFrame
    verification_folder: Path
    problems: list[str]
    results: str

    @cached_property
    def verdicts(self) -> list:
        """The paper's claims, judged on the drawn runs."""
        return claims.evaluate_claims(self.runs, self.references)

    def of(self, profile: str) -> Runs:
        """Drawn runs of a profile with at least one finished cycle."""
        return Runs(run for run in self.runs if run.profile == profile and len(run.cycles))

    @property
    def profiles(self) -> list[str]:
        """Profiles with a finished cycle; the paper's size first."""
        found = dict.fromkeys(run.profile for run in self.runs if len(run.cycles))
        return sorted(found, key=lambda p: (p != "full", p))


def number(value, digits: int = 3, factor: float = 1.0) -> str:
    """A number as tables show it, or a dash where there is none."""
    try:
        value = factor * float(value)
    except (TypeError, ValueError):
        return "–"
    if not np.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    if "e" in text:
        mantissa, power = text.split("e")
        return f"{value:.0f}" if 0 <= int(power) < 6 else f"{mantissa}·10{str(int(power)).translate(str.maketrans('-0123456789', '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'))}"
    return text.replace("-", "−")


def plural(count: int, noun: str) -> str:
    """`1 run`, `2 runs`."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def name_of(run: Run) -> str:
    """A run in words."""
    seed = f", seed {run.seed}" if run.seed != 1 else ""
    return f"{short_name(run.scenario_name)}, {CODE_NAMES.get(run.code, run.code)}{seed}"


def last_cycle(run: Run) -> int:
    """Number of the last finished cycle; 0 without one."""
    return int(run.cycles["cycle"].iloc[-1]) if len(run.cycles) else 0


def state_of(run: Run) -> tuple[str, str]:
    """State and reason; what says it is running but belongs to no process was interrupted."""
    state, reason = run.info.get("state", "unknown"), run.info.get("reason") or ""
    if state == "running":
        try:
            state, reason = status.state_of(run.folder, run.info)
        except (KeyError, TypeError, ValueError, OSError):
            return "interrupted", "its run.json is incomplete"
    return state, reason


def timing(run: Run) -> dict:
    """The part of run.json that differs between equal runs."""
    found = run.info.get("timing")
    return found if isinstance(found, dict) else {key: run.info.get(key) for key in ("start", "end", "steps_per_second", "host")}


def speed(run: Run) -> float:
    """Steps per second of cyclic loading; nan where it is not known."""
    speeds = timing(run).get("steps_per_second")
    value = speeds.get("cyclic") if isinstance(speeds, dict) else None
    return float(value) if isinstance(value, (int, float)) else float("nan")


# ------------------------------------------------------------------ overview

def overview(book: Book) -> dict:
    """The first page."""
    verdicts = book.verdicts
    return {"known": known(book, verdicts), "pending": pending(book, verdicts), "sections": [overview_section(book, p) for p in book.profiles],
            "runs_table": runs_table(book.runs), "results": book.results, "problems": book.problems}


def overview_runs(book: Book, profile: str) -> tuple[Runs, str]:
    """Runs for the overview, and where the others are."""
    runs = book.of(profile)
    if len({run.scenario_name for run in runs}) <= 3:
        return runs, ""
    chosen = Runs(run for run in runs if run.scenario_name in KEY_SCENARIOS or not PAPER_SCENARIO.fullmatch(run.scenario_name))
    chosen = chosen or runs
    others = sorted({run.scenario_name for run in runs} - {run.scenario_name for run in chosen})
    return chosen, (f"Not drawn here but on the page Figures: {', '.join(others)}." if others else "")


def overview_section(book: Book, profile: str) -> dict:
    """Figures and agreement of one profile."""
    g, (runs, more) = book.gallery, overview_runs(book, profile)
    title, text = PROFILE_TEXT.get(profile, (f"Profile {profile}", ""))
    full = book.of(profile)
    seeds = max((sum(1 for r in full if (r.scenario_name, r.code) == key) for key in {(r.scenario_name, r.code) for r in full}), default=0)
    band = "Bands span the seeds." if seeds > 1 else "One packing seed per curve, so there is no uncertainty to show."
    ends = "; ".join(f"{name_of(run)} {last_cycle(run)}" for run in runs)
    picture_runs = [run for run in runs if (run.folder / "bed_after.csv").exists() and run.code == "liggghts"] or \
        [run for run in runs if (run.folder / "bed_after.csv").exists()]
    best = max(picture_runs, key=lambda run: (run.scenario_name == "nonlinear-en1.0", last_cycle(run)), default=None)
    picture = figures.bed_pictures(
        g, [best] if best else [], f"bed-{profile}", "after", "The bed after loading",
        "Two-sphere clumps coloured by how far they moved since the end of preload; sleeper and plates as glass, where they stand at the end.") if best else None
    return {
        "profile": profile, "title": title, "text": text, "more": more, "picture": picture,
        "settlement": figures.settlement(g, runs, f"settlement-{profile}", "Settlement of the sleeper",
                                         f"At minimum load, zero at the end of preload. {band} Cycles reached: {ends}."),
        "lateral": figures.lateral(g, runs, f"lateral-{profile}", "Lateral displacement of the plates",
                                   f"Outward, at minimum load, at the mid-height of plates 5 (top) to 1 (bottom). {band} "
                                   "The law by which the plates are held is an assumption and decides much of this figure."),
        "porosity": figures.porosity(g, runs, f"porosity-{profile}", "Porosity in the three measurement spheres",
                                     "Of the exact union of spheres over a fixed set of points; standard error about 0.001. Cycle 0 is the end of preload."),
        "tracking": figures.tracking(g, runs, f"tracking-{profile}", "Load tracking",
                                     "How closely the contact force on the sleeper follows the prescribed stress: rms error over each cycle, and the extremes of "
                                     "each cycle minus their targets of 50 and 460 kPa (paler: minimum)."),
        "agreement": agreement_table(book, profile),
    }


def known(book: Book, verdicts: Sequence) -> list[str]:
    """What the runs show, in sentences with numbers."""
    lines = []
    for profile in book.profiles:
        runs = book.of(profile)
        codes = [CODE_NAMES.get(code, code) for code in sorted({run.code for run in runs})]
        longest = max(runs, key=last_cycle)
        where = {"full": "At full size", "demo": "On the demo slice"}.get(profile, f"At profile {profile}")
        lines.append(f"{where}: {plural(len(runs), 'run')} of {plural(len({r.scenario_name for r in runs}), 'scenario')} in {' and '.join(codes)}; "
                     f"the longest has {plural(last_cycle(longest), 'cycle')} ({name_of(longest)}).")
        if profile != book.profiles[0]:
            continue                            # the numbers of a smaller bed would only distract
        for scenario in dict.fromkeys(run.scenario_name for run in overview_runs(book, profile)[0]):
            parts = []
            members = [run for run in runs if run.scenario_name == scenario]
            common = min(last_cycle(run) for run in members)
            for curve in book.gallery.curves(members):
                values = curve.column("settlement_m").loc[common]
                spread = f" ({MM * values['low']:.2f} to {MM * values['high']:.2f}, {len(curve.runs)} seeds)" if len(curve.runs) > 1 else ""
                parts.append(f"{CODE_NAMES.get(curve.code, curve.code)} {number(values['median'], 3, MM)} mm{spread}")
            single = "; single seed, no uncertainty" if len(members) == len({run.code for run in members}) else ""
            lines.append(f"{short_name(scenario)}: settlement after {plural(common, 'cycle')} {', '.join(parts)}{single}.")
        worst = max(runs, key=lambda run: tracking_percent(run))
        lines.append(f"The load is met within {tracking_percent(worst):.2g} % rms of its maximum in every cycle of these runs (worst: {name_of(worst)}).")
    if len(book.verification):
        passed, total = int(book.verification["passed"].sum()), len(book.verification)
        lines.append(f"Verification: {passed} of {total} comparisons of the contact laws and bodies with known answers pass.")
    for verdict, words in ((claims.HOLDS, "hold"), (claims.FAILS, "do not hold")):
        found = claim_numbers(verdicts, verdict)
        if found:
            lines.append(f"Of the paper's eleven claims these {words} in at least one code: {found}.")
    return lines


def claim_numbers(verdicts: Sequence, verdict: str) -> str:
    """Claims with that verdict and the codes: `1 (LIGGGHTS), 9 (both)`."""
    codes: dict[int, list[str]] = {}
    for v in verdicts:
        if v.verdict == verdict:
            codes.setdefault(v.claim.number, []).append(v.code)
    return ", ".join(f"{n} ({'both codes' if len(found) > 1 else CODE_NAMES.get(found[0], found[0])})" for n, found in sorted(codes.items()))


def tracking_percent(run: Run) -> float:
    """Worst tracking error of the run, rms over a cycle, % of the maximum stress; nan without values."""
    top = run.scenario["loading.stress_max"] if run.scenario else 460e3
    values = run.cycles["tracking_rms_Pa"].dropna()
    return 100 * float(values.max()) / top if len(values) else float("nan")


def pending(book: Book, verdicts: Sequence) -> list[str]:
    """What is missing, and why it matters."""
    lines = []
    full = book.of("full")
    if not full:
        lines.append("No full-size run yet: nothing here is about the paper's bed.")
    else:
        missing = [name for name in known_scenarios() if PAPER_SCENARIO.fullmatch(name) and name not in {run.scenario_name for run in full}]
        if missing:
            lines.append(f"{len(missing)} of the paper's 14 scenarios have no full-size run: {', '.join(missing)}.")
        short = [run for run in full if last_cycle(run) < 1000]
        if short:
            lines.append(f"{len(short)} of {plural(len(full), 'full-size run')} have fewer than the paper's 1000 cycles.")
        groups = {(run.scenario_name, run.code) for run in full}
        single = [key for key in groups if sum((run.scenario_name, run.code) == key for run in full) == 1]
        if single:
            lines.append(f"{len(single)} of {len(groups)} full-size curves rest on a single packing seed and have no uncertainty.")
    curves = book.references.pending
    if len(curves):
        lines.append(f"{plural(len(curves), 'reference curve')} of {plural(curves['sidecar'].nunique(), 'figure')} are not digitised yet (experiment, Chen 2015, the paper's own): "
                     "no comparison with the experiment is possible until they are. reference_data/README.md says how to add them.")
    open_claims = claim_numbers(verdicts, claims.OPEN)
    if open_claims:
        lines.append(f"Claims not decidable yet: {open_claims}.")
    if not len(book.verification):
        lines.append("The verification of the contact laws has not been run (make verify).")
    lines.append("Not known from the paper and assumed here: the clump's aspect (calibrated), the law that holds the plates, the damping limit at small approach speed, and more; see Assumptions.")
    return lines


def known_scenarios() -> list[str]:
    """Names in the scenario file; none where it cannot be read."""
    try:
        return scenario_names()
    except ScenarioError:
        return []


def runs_table(runs: Sequence[Run]) -> Table:
    """One line per run: what, how far, how well."""
    table = Table("All runs. Settlement at minimum load and tracking error (worst cycle, rms) are of the cycles reached.",
                  [Column("run"), Column("size"), Column("state"), Column("cycles", True), Column("clumps", True), Column("settlement, mm", True),
                   Column("plates, mm", True), Column("tracking, %", True), Column("steps/s", True), Column("bed")])
    for run in runs:
        state, _ = state_of(run)
        goal = run.scenario["loading.cycles"] if run.scenario else None
        last = run.cycles.iloc[-1] if len(run.cycles) else None
        lateral = last[[f"lateral_{k}_m" for k in tables.PLATES]] if last is not None else None
        table.rows.append([name_of(run), run.profile, Chip(state, STATE_KIND.get(state, "open")),
                           f"{last_cycle(run)}{f' of {goal}' if goal else ''}",
                           number(last["clumps"] if last is not None else run.info.get("clumps"), 6),
                           number(last["settlement_m"], 3, MM) if last is not None else "–",
                           f"{number(lateral.min(), 2, MM)} to {number(lateral.max(), 2, MM)}" if last is not None else "–",
                           number(tracking_percent(run), 2), number(speed(run), 3), run.info.get("bed", "–")])
    return table


def agreement_table(book: Book, profile: str) -> Table | None:
    """The codes next to each other after the last cycle that all runs of a scenario share."""
    return None


# ------------------------------------------------------------------ the paper's figures

def paper_figures(book: Book) -> dict:
    """Figures 5, 6 and 9 to 13 remade, from full-size runs where there are any."""
    g = book.gallery
    profile = book.profiles[0] if book.profiles else "full"
    runs = book.of(profile)
    by_name = {name: [run for run in runs if run.scenario_name == name] for name in dict.fromkeys(run.scenario_name for run in runs)}
    size = {"full": "full-size runs", "demo": "demo runs, a slice that is not the paper's bed"}.get(profile, f"runs of profile {profile}")
    waits = "It appears as soon as a run of one of its scenarios has finished a cycle."

    def family(*names: str) -> Runs:
        return Runs(run for run in runs if figures.family_of(run.scenario) in names)

    linear, undamped = family("linear"), family("nonlinear")
    groups = [
        bed_group(book, profile),
        {"title": "Figure 6: the load", "missing": waits, "figures": [figures.stress_signal(
            g, [run for run in runs if run.scenario_name in KEY_SCENARIOS and run.seed == 1] or runs[:2], "figure6", "Figure 6 remade: stress on the sleeper",
            "255 − 205 cos(2π · 20 Hz · t) kPa: the target (broad) and the contact force on the sleeper over its area.")]},
        {"title": "Figure 9: the damping modes", "figures": [figures.restitution(g)], "tables": [restitution_table()]},
        {"title": "Figure 10: the linear model", "missing": waits, "figures": [
            figures.settlement(g, linear, "figure10-settlement", "Figure 10 remade: settlement, linear contacts", "Friction 0.7, 0.8 and 0.9, between clumps and at walls."),
            figures.lateral(g, linear, "figure10-lateral", "Figure 10 remade: lateral displacement, linear contacts", "Over depth below the sleeper.")]},
        {"title": "Figure 11: settlement, nonlinear model", "missing": waits, "figures": [
            figures.settlement(g, Runs([*undamped, *family(f"md{mode}")]), f"figure11-md{mode}",
                               f"Figure 11 remade: settlement, Md {mode} ({figures.MODE_NAMES[mode]})", "eₙ is the nominal restitution; eₙ = 1 is the same law in all modes.")
            for mode in (0, 1, 2) if family(f"md{mode}")]
            or [figures.settlement(g, undamped, "figure11-en1", "Figure 11 remade: settlement, nonlinear contacts, eₙ = 1",
                                   "The only nonlinear scenario with a run so far; eₙ = 1 is the same law in all damping modes.")]},
        {"title": "Figure 12: lateral displacement, nonlinear model", "missing": waits, "figures": [
            figures.lateral(g, Runs([*undamped, *family(f"md{mode}")]), f"figure12-md{mode}",
                            f"Figure 12 remade: lateral displacement, Md {mode} ({figures.MODE_NAMES[mode]})", "Over depth below the sleeper.")
            for mode in (0, 1, 2) if family(f"md{mode}")]
            or [figures.lateral(g, undamped, "figure12-en1", "Figure 12 remade: lateral displacement, nonlinear contacts, eₙ = 1", "Over depth below the sleeper.")]},
        {"title": "Figure 13: porosity", "missing": waits, "figures": [
            figures.measurement_spheres(g, load_scenario("linear-mu0.8", "full")) if "linear-mu0.8" in known_scenarios() else None,
            figures.porosity(g, Runs(run for name in by_name if name in KEY_SCENARIOS for run in by_name[name]), "figure13", "Figure 13b, c remade: porosity during loading",
                             "Of the exact union of spheres over a fixed set of points; standard error about 0.001. Cycle 0 is the end of preload.")]},
    ]
    others = Runs(run for run in runs if not PAPER_SCENARIO.fullmatch(run.scenario_name))
    if others:
        groups.append({"title": "Scenarios that are not the paper's", "figures": [
            figures.settlement(g, others, "own-settlement", "Settlement, further scenarios", "Scenarios added to scenarios.toml."),
            figures.lateral(g, others, "own-lateral", "Lateral displacement, further scenarios", "Over depth below the sleeper.")]})
    for group in groups:
        group["figures"] = [f for f in group["figures"] if f]
    note = ""
    if len(book.references.pending):
        note = (f"{len(book.references.pending)} reference curves are pending: no point of them is in the paper's text, and none is invented here. "
                "Once digitised (reference_data/README.md) they are drawn in these figures and the claims are judged against them.")
    return {"lead": f"Each figure with both codes, from {size}." if runs else "There is no run yet; what needs none is shown.", "groups": groups,
            "reference_note": note, "reference_problems": book.references.problems}


def bed_group(book: Book, profile: str) -> dict:
    """Figure 5: packed beds, and the force chains after loading."""
    g = book.gallery
    candidates = [run for run in book.of(profile) if run.scenario_name in KEY_SCENARIOS and run.seed == 1] or list(book.of(profile))[:2]
    packed, label = [run for run in candidates if (run.folder / "raw" / "bed_packed.csv").exists() and not run.info.get("bed", "own").startswith("results")], "packed"
    packed = [run for run in packed if run.scenario is not None and not run.scenario["packing.bed_from"]] or packed
    if not packed:
        packed, label = [run for run in candidates if (run.folder / "bed_before.csv").exists()], "before"
    what = "after packing, before preload" if label == "packed" else "at the end of preload (the packed bed was not kept)"
    return {"title": "Figure 5: the bed", "missing": "It needs a run whose beds are on this machine; committed runs have none.", "figures": [
        figures.bed_pictures(g, packed[:2], "figure5", label, f"Figure 5 remade: the bed {what}", "Each code packs its own bed by the paper's procedure from the same lattice and orientations."),
        figures.bed_pictures(g, candidates, "force-chains", "after", "Force chains",
                             "Normal forces in a slab along the middle of the sleeper at minimum load; width and colour by force. Not a figure of the paper.", chains=True)]}


def restitution_table() -> Table:
    """Nominal against effective restitution at the paper's values of e_n."""
    from . import laws
    values = (0.0, 0.3, 0.6, 0.9, 1.0)
    table = Table("What comes out of a free impact at the paper's nominal restitutions", [Column("damping mode"), *(Column(f"eₙ = {e:g}", True) for e in values)])
    for mode in (0, 1, 2):
        cells = ["–" if mode == 0 and e == 0 else f"{laws.effective_restitution(laws.damping_factor(mode, e)):.4f}" for e in values]
        table.rows.append([f"Md {mode}, {figures.MODE_NAMES[mode]}", *cells])
    return table


# ------------------------------------------------------------------ claims

def claims_page(book: Book) -> dict:
    """Every claim with its verdict per code, the numbers, and what is missing."""
    grouped: dict[int, list] = {}
    for v in book.verdicts:
        grouped.setdefault(v.claim.number, []).append(v)
    codes = list(dict.fromkeys(v.code for v in book.verdicts))
    summary = Table("Verdicts per code", [Column("claim"), *(Column(CODE_NAMES.get(code, code)) for code in codes)])
    entries = []
    for n, members in sorted(grouped.items()):
        claim = members[0].claim
        summary.rows.append([f"{n}. {claim.sentence}", *(Chip(v.verdict, VERDICT_KIND[v.verdict]) for v in members)])
        table = Table("", [Column("code"), Column("part of the claim", wide=True), Column("verdict"), Column("numbers", wide=True), Column("missing", wide=True)])
        for v in members:
            for check in v.checks:
                table.rows.append([CODE_NAMES.get(v.code, v.code), check.what, Chip(check.verdict, VERDICT_KIND[check.verdict]), check.numbers.replace("+-", "±") or "–",
                                   "; ".join(check.missing) or "–"])
        bases = "; ".join(dict.fromkeys(f"{CODE_NAMES.get(v.code, v.code)}: {v.uncertainty}" for v in members))
        notes = list(dict.fromkeys(note for v in members for note in v.notes))
        table.note = f"Uncertainty: {bases}." + (" Runs used: " + ", ".join(dict.fromkeys(r for v in members for r in v.runs)) + "." if any(v.runs for v in members) else "")
        entries.append({"id": n, "title": claim.sentence, "where": f"{claim.where}. {claim.quantity}", "criterion": claim.criterion, "table": table, "notes": notes})
    return {"summary": summary, "claims": entries}


# ------------------------------------------------------------------ cross-code comparison

def comparison(book: Book) -> dict:
    """Both codes next to each other."""
    sections = []
    for profile in book.profiles:
        runs, g = book.of(profile), book.gallery
        title, _ = PROFILE_TEXT.get(profile, (f"Profile {profile}", ""))
        parts = [
            {"heading": "After the same cycle", "table": agreement_table(book, profile)},
            {"heading": "Inside the bed", "figure": figures.micro(
                g, overview_runs(book, profile)[0], f"micro-{profile}", "Inside the bed",
                "Contacts per clump, largest overlap, share of sliding contacts, mean rotation since the end of preload, heave of the cribs, and shoulder bulge.",
                [("coordination_number", "contacts per clump", 1, ""), ("overlap_max_ratio", "largest overlap, % of radius", 100, "%"),
                 ("sliding_share", "sliding contacts, %", 100, "%"), ("rotation_mean_rad", "mean rotation, degrees", 180 / np.pi, "°"),
                 ("crib_heave_m", "heave of the cribs, mm", MM, "mm"), ("bulge_volume_m3", "shoulder bulge, cm³", 1e6, "cm³")])},
            {"heading": "Load and settlement within a cycle", "figure": figures.loops(
                g, [run for run in overview_runs(book, profile)[0] if run.seed == 1], f"loops-{profile}", "Stress against settlement",
                "First (paler) and last cycle. The area of a loop is the work lost in the cycle; its extent along the settlement axis is the resilient stroke.")},
        ]
        sections.append({"title": title, "text": "", "parts": parts})
    return {"sections": sections}


# ------------------------------------------------------------------ verification

def verification(book: Book) -> dict:
    """The result of `make verify`: a plot and a table per case."""
    rows = book.verification
    cases = []
    summary = Table("Comparisons that pass, per case and code", [Column("case"), *(Column(CODE_NAMES.get(code, code)) for code in sorted(set(rows["code"])))])
    for case in dict.fromkeys(rows["case"]):
        part = rows[rows["case"] == case].sort_values("passed", kind="stable")
        table = Table("", [Column("code"), Column("quantity"), Column("expected", True), Column("measured", True), Column("relative error", True),
                           Column("tolerance", True), Column("verdict"), Column("reason", wide=True)])
        for r in part.itertuples():
            table.rows.append([CODE_NAMES.get(r.code, r.code), r.quantity, number(r.expected, 6), number(r.measured, 6), number(r.rel_error, 2), number(r.tolerance, 2),
                               Chip("pass", "good") if r.passed else Chip("fail", "bad"), r.reason])
        cases.append({"name": case, "title": case.replace("_", " ").replace("-", " ").capitalize(), "passed": int(part["passed"].sum()), "total": len(part), "table": table,
                      "figure": verification_figures.case_figure(book.gallery, book.verification_folder, case)})
        counts = []
        for code in sorted(set(rows["code"])):
            mine = part[part["code"] == code]
            counts.append(Chip(f"{int(mine['passed'].sum())} of {len(mine)}", "good" if mine["passed"].all() else "bad") if len(mine) else Chip("not run", "open"))
        summary.rows.append([cases[-1]["title"], *counts])
    return {"rows": len(rows) > 0, "passed": int(rows["passed"].sum()) if len(rows) else 0, "total": len(rows), "cases": cases, "summary": summary}


# ------------------------------------------------------------------ runs and provenance

def runs_page(book: Book) -> dict:
    """Every run with where it comes from."""
    summary = Table("Provenance", [Column("run"), Column("parameters"), Column("engine"), Column("analysis"), Column("commit"), Column("seed", True), Column("bed"), Column("state")])
    entries = []
    for run in book.runs:
        versions = run.info.get("versions", {})
        state, reason = state_of(run)
        commit = str(run.info.get("git_commit") or "")[:10] or "–"
        summary.rows.append([run.id, figures.run_id(run).rpartition("@")[2], versions.get("engine", "–"), versions.get("analysis", "–"),
                             commit + ("+" if run.info.get("git_dirty") else ""), str(run.seed), run.info.get("bed", "–"), Chip(state, STATE_KIND.get(state, "open"))])
        entries.append(run_entry(run, state, reason))
    summary.note = "A commit with + had changes that were not committed. Runs below runs/ are the ones kept in the repository; they have no beds."
    left_out = Table("Runs that are not drawn", [Column("run"), Column("why", wide=True)], [[run.id, why] for run, why in book.left_out])
    tracking = [figures.tracking(book.gallery, book.of(profile), f"tracking-all-{profile}", f"Load tracking, all runs of profile {profile}",
                                 "rms error over each cycle, and the extremes of each cycle minus their targets (paler: minimum).") for profile in book.profiles]
    return {"summary": summary, "runs": entries, "tables": [left_out], "figures": tracking, "results": book.results, "problems": book.problems}


def run_entry(run: Run, state: str, reason: str) -> dict:
    """One run in a few sentences."""
    times, info = timing(run), run.info
    text = [f"{info.get('title') or (run.scenario.title if run.scenario else run.scenario_name)}; profile {run.profile}, seed {run.seed}."]
    if reason:
        text.append(f"Reason: {reason}.")
    if run.last_error():
        text.append(f"Last error in its logs: {run.last_error()}.")
    text.append(f"{last_cycle(run)} cycles" + (f" of {run.scenario['loading.cycles']}" if run.scenario else "") + f", stage {info.get('stage', 'unknown')}, "
                f"{plural(int(info.get('ranks') or 1), 'rank')}, {plural(int(info.get('threads') or 1), 'thread')}"
                + (f", {plural(len(info['resumes']), 'resume')}" if info.get("resumes") else "") + ".")
    speeds = times.get("steps_per_second")
    if isinstance(speeds, dict) and speeds:
        text.append("Steps per second: " + ", ".join(f"{stage} {number(value, 3)}" for stage, value in speeds.items()) + ".")
    if times.get("start"):
        text.append(f"From {times['start']} to {times.get('end') or 'now'}{' on ' + str(times['host']) if times.get('host') else ''}.")
    if len(run.cycles):
        text.append(f"Tracking error {number(tracking_percent(run), 2)} % rms in the worst cycle; sleeper stress {number(run.cycles['sleeper_stress_min_Pa'].min(), 3, KPA)} to "
                    f"{number(run.cycles['sleeper_stress_max_Pa'].max(), 3, KPA)} kPa.")
        text.extend(plate_sentence(run))
    versions = info.get("versions", {})
    if versions:
        text.append("Versions: " + ", ".join(f"{key} {value}" for key, value in versions.items()) + ".")
    return {"anchor": re.sub(r"[^a-z0-9]+", "-", run.id.lower()), "name": run.id, "state": state, "kind": STATE_KIND.get(state, "open"), "text": " ".join(text),
            "deviations": [str(d) for d in info.get("deviations", [])], "problems": run.problems, "command": info.get("command", "command unknown")}


def plate_sentence(run: Run) -> list[str]:
    """Mean stress on each plate over the run, where the history is there."""
    columns = [f"plate_{k}_stress_Pa" for k in tables.PLATES]
    means = run.history[columns].mean() if len(run.history) else pd.Series(dtype=float)
    if not len(means) or not np.isfinite(means).any():
        return []
    return ["Mean stress on plates 1 to 5: " + ", ".join(number(v, 3, KPA) for v in means) + " kPa."]


# ------------------------------------------------------------------ assumptions

def assumptions(book: Book) -> dict:
    """Every parameter with status and source, and what runs say about the assumed ones."""
    names = known_scenarios()
    base = load_scenario(names[0], "full") if names else None
    groups: dict[str, list] = {}
    for key, p in (base.parameters if base else {}).items():
        section = key.rpartition(".")[0]
        groups.setdefault(section, []).append({"key": key, "value": shown(p.value), "unit": p.unit if p.unit != "-" else "", "status": p.status,
                                               "kind": STATUS_KIND[p.status], "source": p.source})
    counts = {s: sum(p["status"] == s for group in groups.values() for p in group) for s in STATUSES}
    differences = Table("Only what is not as in the first scenario", [Column("scenario"), Column("parameter"), Column("value", True), Column("unit"), Column("status"), Column("source", wide=True)])
    for name in names[1:]:
        scenario = load_scenario(name, "full")
        for key, p in scenario.parameters.items():
            if base is not None and p.value != base[key]:
                differences.rows.append([name, key, shown(p.value), p.unit if p.unit != "-" else "", Chip(p.status, STATUS_KIND[p.status]), p.source])
    table, missing = sensitivity(book)
    return {"statuses": [{"name": s, "kind": STATUS_KIND[s], "count": counts[s], "text": STATUS_TEXT[s]} for s in STATUSES],
            "groups": [{"name": name, "parameters": entries} for name, entries in groups.items()], "derived": derived_table(base) if base else None, "differences": differences,
            "sensitivity": table, "sensitivity_missing": missing}


def shown(value) -> str:
    """A parameter's value for people."""
    if isinstance(value, list):
        return ", ".join(shown(v) for v in value)
    if isinstance(value, float):
        return number(value, 6)
    return str(value) if value != "" else "–"


def derived_table(s: Scenario) -> Table:
    """Quantities that follow from the parameters."""
    clump, box, grid = derived.clump(s), derived.apparatus(s), derived.time_grid(s)
    rows = [("radius of the two spheres", number(clump.radius_m, 5, MM), "mm"), ("distance of their centres", number(2 * clump.half_distance_m, 5, MM), "mm"),
            ("clump volume", number(clump.volume_m3, 5, 1e6), "cm³"), ("clump mass", number(clump.mass_kg, 5, 1e3), "g"),
            ("inertia about the axis", number(clump.inertia_axial_kgm2, 5), "kg m²"), ("inertia across it", number(clump.inertia_transverse_kgm2, 5), "kg m²"),
            ("sleeper area", number(box.sleeper_area_m2, 5), "m²"), ("area of a plate", number(box.plate_area_m2, 5), "m²"),
            ("force on the sleeper at 50 and 460 kPa", f"{number(50e3 * box.sleeper_area_m2, 4, 1e-3)}, {number(460e3 * box.sleeper_area_m2, 4, 1e-3)}", "kN"),
            ("space for ballast", number(box.ballast_volume_m3, 4), "m³"), ("time step", number(grid.step_s, 4), "s"), ("steps per cycle", str(grid.steps_per_cycle), "")]
    return Table(f"Of {s.name} at full size", [Column("quantity"), Column("value", True), Column("unit")], [list(r) for r in rows])


FREE = ("loading.cycles", "output.", "limits.")


def sensitivity(book: Book) -> tuple[Table, str]:
    """Pairs of runs of one code, profile and seed that differ in a single assumed or calibrated parameter."""
    table = Table("Runs that differ in one assumed or calibrated parameter only, after the last cycle they share",
                  [Column("parameter"), Column("value", True), Column("against", True), Column("run"), Column("against run"), Column("cycle", True),
                   Column("settlement, mm", True), Column("against", True), Column("change, %", True)])
    runs = [run for run in book.runs if len(run.cycles) and run.scenario is not None]
    for n, run in enumerate(runs):
        for other in runs[n + 1:]:
            if (run.profile, run.code, run.seed) != (other.profile, other.code, other.seed):
                continue
            keys = [key for key in run.scenario.parameters if key in other.scenario.parameters and run.scenario[key] != other.scenario[key] and not key.startswith(FREE)]
            if len(keys) != 1 or not {run.scenario.parameters[keys[0]].status, other.scenario.parameters[keys[0]].status} & {"assumed", "calibrated"}:
                continue
            cycle = min(last_cycle(run), last_cycle(other))
            a, b = (float(r.cycles.set_index("cycle")["settlement_m"].loc[cycle]) for r in (run, other))
            table.rows.append([keys[0], shown(other.scenario[keys[0]]), shown(run.scenario[keys[0]]), other.id, run.id, str(cycle), number(b, 3, MM), number(a, 3, MM),
                               number(100 * (b / a - 1), 2) if a else "–"])
    return table, ("No two runs of one code and seed differ in just one assumed or calibrated parameter yet. Add a scenario to scenarios.toml that is based on another and changes "
                   "one such value, run it, and it is listed here.")


def verification_rows(folder: Path) -> tuple[pd.DataFrame, list[str]]:
    """verification.csv as a table (no rows where there is none), and a line per problem."""
    columns = ["code", "case", "quantity", "expected", "measured", "abs_error", "rel_error", "tolerance", "passed", "reason"]
    path = folder / "verification.csv"
    if not path.exists():
        return pd.DataFrame(columns=columns), []
    try:
        rows = pd.read_csv(path, dtype={"code": str, "case": str, "quantity": str, "reason": str, "passed": str})[columns]
    except (OSError, ValueError, KeyError) as error:
        return pd.DataFrame(columns=columns), [f"verification.csv: cannot be read ({' '.join(str(error).split())}); run `make verify` again"]
    rows = rows.dropna(subset=["code", "case"])
    rows["passed"] = rows["passed"].str.lower().eq("true")
    rows[["quantity", "reason"]] = rows[["quantity", "reason"]].fillna("")
    return rows, []


def page_data(values: dict) -> str:
    """Data for a page's script, safe inside HTML."""
    return json.dumps(values).replace("<", "\\u003c")
