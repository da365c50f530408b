"""What the report's pages say: the overview, the paper's figures, the claims, the verification."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from . import claims, compare, figures, laws, settlement, tables, verification_figures
from .figures import CODE_NAMES, MM, family_of, short_name
from .readers import Run, Runs
from .report_book import (
    KEY_SCENARIOS,
    PAPER_SCENARIO,
    PROFILE_TEXT,
    Book,
    known_scenarios,
    last_cycle,
    name_of,
    overview_runs,
    tracking_percent,
)
from .report_comparison import AGREEMENT_BRIEF, agreement_table
from .report_provenance import runs_table
from .report_words import Chip, Column, Table, interval, number, plural
from .scenario import load_scenario

VERDICT_KIND = {claims.HOLDS: "good", claims.FAILS: "bad", claims.OPEN: "open"}


# ------------------------------------------------------------------ overview


def overview(book: Book) -> dict:
    """The first page."""
    verdicts = book.verdicts
    return {
        "known": known(book, verdicts),
        "pending": pending(book, verdicts),
        "sections": [overview_section(book, p) for p in book.profiles],
        "runs_table": runs_table(book.runs),
        "results": book.results,
        "problems": book.problems,
    }


def overview_section(book: Book, profile: str) -> dict:
    """Figures and agreement of one profile."""
    g, (runs, more) = book.gallery, overview_runs(book, profile)
    title, text = PROFILE_TEXT.get(profile, (f"Profile {profile}", ""))
    full = book.of(profile)
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
    best = max(picture_runs, key=lambda run: (run.scenario_name == "nonlinear-en1.0", last_cycle(run)), default=None)
    picture = (
        figures.bed_pictures(
            g,
            [best] if best else [],
            f"bed-{profile}",
            "after",
            "The bed after loading",
            "Two-sphere clumps coloured by how far they moved since the end of preload; sleeper and plates as glass, "
            "where they stand at the end.",
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
        "settlement": figures.settlement(
            g,
            runs,
            f"settlement-{profile}",
            "Settlement of the sleeper",
            f"At minimum load, zero at the end of preload. {band} Cycles reached: {ends}.",
        ),
        "lateral": figures.lateral(
            g,
            runs,
            f"lateral-{profile}",
            "Lateral displacement of the plates",
            f"Outward, at minimum load, at the mid-height of plates 5 (top) to 1 (bottom). {band} "
            "The law by which the plates are held is an assumption and decides much of this figure.",
        ),
        "porosity": figures.porosity(
            g,
            runs,
            f"porosity-{profile}",
            "Porosity in the three measurement spheres",
            "Of the exact union of spheres over a fixed set of points; standard error about 0.001. Cycle 0 is the end "
            "of preload.",
        ),
        "tracking": figures.tracking(
            g,
            runs,
            f"tracking-{profile}",
            "Load tracking",
            "How closely the contact force on the sleeper follows the prescribed stress: rms error over each cycle, "
            "and the extremes of "
            "each cycle minus their targets of 50 and 460 kPa (paler: minimum).",
        ),
        "agreement": agreement_table(book, profile, AGREEMENT_BRIEF),
    }


def known(book: Book, verdicts: Sequence) -> list[str]:
    """What the runs show, in sentences with numbers."""
    lines = []
    for profile in book.profiles:
        runs = book.of(profile)
        codes = [CODE_NAMES.get(code, code) for code in sorted({run.code for run in runs})]
        longest = max(runs, key=last_cycle)
        where = {"full": "At full size", "demo": "On the demo slice"}.get(profile, f"At profile {profile}")
        lines.append(
            f"{where}: {plural(len(runs), 'run')} of {plural(len({r.scenario_name for r in runs}), 'scenario')} in "
            f"{' and '.join(codes)}; "
            f"the longest has {plural(last_cycle(longest), 'cycle')} ({name_of(longest)})."
        )
        if profile != book.profiles[0]:
            continue  # the numbers of a smaller bed would only distract
        for scenario in dict.fromkeys(run.scenario_name for run in overview_runs(book, profile)[0]):
            parts = []
            members = [run for run in runs if run.scenario_name == scenario]
            common = min(last_cycle(run) for run in members)
            for curve in book.gallery.curves(members):
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
        if profile == "full":
            lines += packed_beds(runs)
        worst = max(runs, key=lambda run: tracking_percent(run))
        lines.append(
            f"The load is met within {tracking_percent(worst):.2g} % rms of its maximum in every cycle of these runs "
            f"(worst: {name_of(worst)})."
        )
    if len(book.verification):
        passed, total = int(book.verification["passed"].sum()), len(book.verification)
        lines.append(
            f"Verification: {passed} of {total} comparisons of the contact laws and bodies with known answers pass."
        )
    for verdict, words in ((claims.HOLDS, "hold"), (claims.FAILS, "do not hold")):
        found = claim_numbers(verdicts, verdict)
        if found:
            lines.append(f"Of the paper's eleven claims these {words}: {found}.")
    return lines


def packed_beds(runs: Sequence[Run]) -> list[str]:
    """Clumps and porosity of the full-size beds at the end of preload, beside the paper's."""
    starts = [
        run.microstructure[run.microstructure["cycle"] == 0] for run in runs if family_of(run.scenario) == "linear"
    ]
    porosity = [row[[f"porosity_{k}" for k in tables.SPHERES]].iloc[0].mean() for row in starts if len(row)]
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
    """Claims with that verdict by the codes that give it: `1, 2, 9 in both codes; 10 in YADE`."""
    codes: dict[int, list[str]] = {}
    for v in verdicts:
        if v.verdict == verdict:
            codes.setdefault(v.claim.number, []).append(CODE_NAMES.get(v.code, v.code))
    groups: dict[str, list[str]] = {}
    for n, found in sorted(codes.items()):
        groups.setdefault("both codes" if len(found) > 1 else found[0], []).append(str(n))
    return "; ".join(f"{', '.join(numbers)} in {where}" for where, numbers in groups.items())


def pending(book: Book, verdicts: Sequence) -> list[str]:
    """What is missing, and why it matters."""
    lines = []
    full = book.of("full")
    if not full:
        lines.append("No full-size run yet: nothing here is about the paper's bed.")
    else:
        missing = [
            name
            for name in known_scenarios()
            if PAPER_SCENARIO.fullmatch(name) and name not in {run.scenario_name for run in full}
        ]
        if missing:
            lines.append(f"{len(missing)} of the paper's 14 scenarios have no full-size run: {', '.join(missing)}.")
        short = [run for run in full if last_cycle(run) < 1000]
        if short:
            which = "No full-size run has" if len(short) == len(full) else f"{len(short)} full-size runs have not"
            lines.append(f"{which} reached the paper's 1000 cycles.")
        groups = {(run.scenario_name, run.code) for run in full}
        single = [key for key in groups if sum((run.scenario_name, run.code) == key for run in full) == 1]
        if single:
            which = "All" if len(single) == len(groups) else f"{len(single)} of {len(groups)}"
            lines.append(f"{which} full-size curves rest on a single packing seed: they have no uncertainty.")
    curves = book.references.pending
    if len(curves):
        lines.append(
            f"{plural(len(curves), 'reference curve')} of {plural(curves['sidecar'].nunique(), 'figure')} are not "
            f"digitised yet (experiment, Chen 2015, the paper's own): "
            "no comparison with the experiment is possible until they are. reference_data/README.md says how to add "
            "them."
        )
    open_claims = claim_numbers(verdicts, claims.OPEN)
    if open_claims:
        lines.append(f"Claims not decidable yet: {open_claims}.")
    if not len(book.verification):
        lines.append("The verification of the contact laws has not been run (make verify).")
    lines.append(
        "Not known from the paper and assumed here: the clump's aspect (calibrated), the law that holds the plates, "
        "the damping limit at small approach speed, and more; see Assumptions."
    )
    return lines


# ------------------------------------------------------------------ the paper's figures


def paper_figures(book: Book) -> dict:
    """Figures 5, 6 and 9 to 13 remade, from full-size runs where there are any."""
    g = book.gallery
    profile = book.profiles[0] if book.profiles else "full"
    runs = book.of(profile)
    by_name = {
        name: [run for run in runs if run.scenario_name == name]
        for name in dict.fromkeys(run.scenario_name for run in runs)
    }
    size = {"full": "full-size runs", "demo": "demo runs, a slice that is not the paper's bed"}.get(
        profile, f"runs of profile {profile}"
    )
    waits = "It appears as soon as a run of one of its scenarios has finished a cycle."

    def family(*names: str) -> Runs:
        return Runs(run for run in runs if figures.family_of(run.scenario) in names)

    linear, undamped = family("linear"), family("nonlinear")
    groups = [
        bed_group(book, profile),
        {
            "title": "Figure 6: the load",
            "missing": waits,
            "figures": [
                figures.stress_signal(
                    g,
                    [run for run in runs if run.scenario_name in KEY_SCENARIOS and run.seed == 1] or runs[:2],
                    "figure6",
                    "Figure 6 remade: stress on the sleeper",
                    "255 − 205 cos(2π · 20 Hz · t) kPa: the target (broad) and the contact force on the sleeper over "
                    "its area.",
                )
            ],
        },
        {"title": "Figure 9: the damping modes", "figures": [figures.restitution(g)], "tables": [restitution_table()]},
        {
            "title": "Figure 10: the linear model",
            "missing": waits,
            "figures": [
                figures.settlement(
                    g,
                    linear,
                    "figure10-settlement",
                    "Figure 10 remade: settlement, linear contacts",
                    "Friction 0.7, 0.8 and 0.9, between clumps and at walls.",
                ),
                figures.lateral(
                    g,
                    linear,
                    "figure10-lateral",
                    "Figure 10 remade: lateral displacement, linear contacts",
                    "Over depth below the sleeper.",
                ),
            ],
        },
        {
            "title": "Figure 11: settlement, nonlinear model",
            "missing": waits,
            "figures": [
                figures.settlement(
                    g,
                    Runs([*undamped, *family(f"md{mode}")]),
                    f"figure11-md{mode}",
                    f"Figure 11 remade: settlement, Md {mode} ({figures.MODE_NAMES[mode]})",
                    "eₙ is the nominal restitution; eₙ = 1 is the same law in all modes.",
                )
                for mode in (0, 1, 2)
                if family(f"md{mode}")
            ]
            or [
                figures.settlement(
                    g,
                    undamped,
                    "figure11-en1",
                    "Figure 11 remade: settlement, nonlinear contacts, eₙ = 1",
                    "The only nonlinear scenario with a run so far; eₙ = 1 is the same law in all damping modes.",
                )
            ],
        },
        {
            "title": "Figure 12: lateral displacement, nonlinear model",
            "missing": waits,
            "figures": [
                figures.lateral(
                    g,
                    Runs([*undamped, *family(f"md{mode}")]),
                    f"figure12-md{mode}",
                    f"Figure 12 remade: lateral displacement, Md {mode} ({figures.MODE_NAMES[mode]})",
                    "Over depth below the sleeper.",
                )
                for mode in (0, 1, 2)
                if family(f"md{mode}")
            ]
            or [
                figures.lateral(
                    g,
                    undamped,
                    "figure12-en1",
                    "Figure 12 remade: lateral displacement, nonlinear contacts, eₙ = 1",
                    "Over depth below the sleeper.",
                )
            ],
        },
        {
            "title": "Figure 13: porosity",
            "missing": waits,
            "figures": [
                figures.measurement_spheres(g, load_scenario("linear-mu0.8", "full"))
                if "linear-mu0.8" in known_scenarios()
                else None,
                figures.porosity(
                    g,
                    Runs(run for name in by_name if name in KEY_SCENARIOS for run in by_name[name]),
                    "figure13",
                    "Figure 13b, c remade: porosity during loading",
                    "Of the exact union of spheres over a fixed set of points; standard error about 0.001. Cycle 0 is "
                    "the end of preload.",
                ),
            ],
        },
    ]
    groups.append(
        {
            "title": "The shape of settlement",
            "missing": waits,
            "figures": [
                figures.shapes(
                    g,
                    overview_runs(book, profile)[0],
                    "settlement-shape",
                    "Settlement over that of the first cycle",
                    "Published laws as shapes (broken grey): their absolute size belongs to other loads and beds. "
                    "Coefficients are transcribed from secondary quotation.",
                )
            ],
            "tables": [law_table(book, profile), reference_scores(book)],
        }
    )
    others = Runs(run for run in runs if not PAPER_SCENARIO.fullmatch(run.scenario_name))
    if others:
        groups.append(
            {
                "title": "Scenarios that are not the paper's",
                "figures": [
                    figures.settlement(
                        g,
                        others,
                        "own-settlement",
                        "Settlement, further scenarios",
                        "Scenarios added to scenarios.toml.",
                    ),
                    figures.lateral(
                        g,
                        others,
                        "own-lateral",
                        "Lateral displacement, further scenarios",
                        "Over depth below the sleeper.",
                    ),
                ],
            }
        )
    for group in groups:
        group["figures"] = [f for f in group["figures"] if f]
    note = ""
    if len(book.references.pending):
        note = (
            f"{len(book.references.pending)} reference curves are pending: no point of them is in the paper's text, "
            f"and none is invented here. "
            "Once digitised (reference_data/README.md) they are drawn in these figures and the claims are judged "
            "against them."
        )
    return {
        "lead": f"Drawn from {size}, in every code that has one."
        if runs
        else "There is no run yet; what needs none is shown.",
        "groups": groups,
        "reference_note": note,
        "reference_problems": book.references.problems,
    }


def bed_group(book: Book, profile: str) -> dict:
    """Figure 5: packed beds, and the force chains after loading."""
    g = book.gallery
    candidates = [run for run in book.of(profile) if run.scenario_name in KEY_SCENARIOS and run.seed == 1]
    candidates = candidates or list(book.of(profile))[:2]
    packed, label = [run for run in candidates if (run.folder / "raw" / "bed_packed.csv").exists()], "packed"
    packed = [run for run in packed if run.scenario and not run.scenario["packing.bed_from"]] or packed
    if not packed:
        packed, label = [run for run in candidates if (run.folder / "bed_before.csv").exists()], "before"
    what = (
        "after packing, before preload" if label == "packed" else "at the end of preload (the packed bed was not kept)"
    )
    return {
        "title": "Figure 5: the bed",
        "missing": "It needs a run whose beds are on this machine; committed runs have none.",
        "figures": [
            figures.bed_pictures(
                g,
                packed[:2],
                "figure5",
                label,
                f"Figure 5 remade: the bed {what}",
                "Each code packs its own bed by the paper's procedure from the same lattice and orientations.",
            ),
            figures.bed_pictures(
                g,
                candidates,
                "force-chains",
                "after",
                "Force chains",
                "Normal forces in a slab along the middle of the sleeper at minimum load; width and colour by force. "
                "Not a figure of the paper.",
                chains=True,
            ),
        ],
    }


def law_table(book: Book, profile: str) -> Table | None:
    """Which law describes each settlement curve, and whether it has the exponential start."""
    table = Table(
        "Does settlement start exponentially? S = a + b (1 − exp(−N/c)) + d N against a logarithm, a power law and a "
        "straight line",
        [
            Column("run"),
            Column("cycles", True),
            Column("best law"),
            Column("exponential start"),
            Column("b, mm", True),
            Column("c, cycles", True),
            Column("d, mm per 1000 cycles", True),
            Column("why", wide=True),
        ],
    )
    for run in book.of(profile):
        choice = settlement.choose(run.cycles["cycle"], run.cycles["settlement_m"])
        fit = choice.fits.get("exponential")
        kind = {"yes": "good", "no": "bad"}.get(choice.exponential_start, "open")
        cells = [interval(fit, name, factor) for name, factor in (("b", MM), ("c", 1.0), ("d", 1e6))]
        table.rows.append(
            [
                name_of(run),
                str(last_cycle(run)),
                choice.best or "–",
                Chip(choice.exponential_start, kind),
                *cells,
                choice.reason,
            ]
        )
    table.note = (
        "Chosen by the Bayesian information criterion; brackets: 95 % confidence intervals of the "
        "exponential law, whichever law is best."
    )
    return table if table.rows else None


def reference_scores(book: Book) -> Table | None:
    """Runs against the reference curves that are there."""
    rows = compare.reference_table([run for run in book.runs if len(run.cycles)], book.references)
    table = Table(
        "Settlement against the reference curves",
        [
            Column("run"),
            Column("reference"),
            Column("points", True),
            Column("rms, mm", True),
            Column("shift, mm", True),
            Column("rms after the shift, mm", True),
            Column("late slope, ratio", True),
            Column("first cycle, ratio", True),
            Column("within its error, %", True),
            Column("after the shift, %", True),
        ],
    )
    for r in rows.itertuples():
        table.rows.append(
            [
                f"{r.profile}, {short_name(r.scenario)}, "
                f"{CODE_NAMES.get(r.code, r.code)}{f', seed {r.seed}' if r.seed != 1 else ''}",
                f"{figures.SOURCE_NAMES.get(r.source, r.source)}: {r.curve}",
                str(r.points),
                number(r.rms_m, 3, MM),
                number(r.shift_m, 3, MM),
                number(r.rms_shifted_m, 3, MM),
                number(r.late_slope_ratio, 3),
                number(r.first_cycle_ratio, 3),
                number(r.within_error, 3, 100),
                number(r.within_error_shifted, 3, 100),
            ]
        )
    table.note = (
        "Over the cycles that both have, at the points of the reference. Shift: run minus reference, mean; "
        "removed, it leaves the difference in shape."
    )
    return table if table.rows else None


def restitution_table() -> Table:
    """Nominal against effective restitution at the paper's values of e_n."""
    values = (0.0, 0.3, 0.6, 0.9, 1.0)
    table = Table(
        "What comes out of a free impact at the paper's nominal restitutions",
        [Column("damping mode"), *(Column(f"eₙ = {e:g}", True) for e in values)],
    )
    for mode in (0, 1, 2):
        cells = [
            "–" if mode == 0 and e == 0 else f"{laws.effective_restitution(laws.damping_factor(mode, e)):.4f}"
            for e in values
        ]
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
        table = Table(
            "",
            [
                Column("code"),
                Column("part of the claim", wide=True),
                Column("verdict"),
                Column("numbers", wide=True),
                Column("missing", wide=True),
            ],
        )
        for v in members:
            for check in v.checks:
                table.rows.append(
                    [
                        CODE_NAMES.get(v.code, v.code),
                        check.what,
                        Chip(check.verdict, VERDICT_KIND[check.verdict]),
                        check.numbers.replace("+-", "±") or "–",
                        "; ".join(check.missing) or "–",
                    ]
                )
        bases = "; ".join(dict.fromkeys(f"{CODE_NAMES.get(v.code, v.code)}: {v.uncertainty}" for v in members))
        notes = list(dict.fromkeys(note for v in members for note in v.notes))
        table.note = f"Uncertainty: {bases}." + (
            " Runs used: " + ", ".join(dict.fromkeys(r for v in members for r in v.runs)) + "."
            if any(v.runs for v in members)
            else ""
        )
        entries.append(
            {
                "id": n,
                "title": claim.sentence,
                "where": f"{claim.where}. {claim.quantity}",
                "criterion": claim.criterion,
                "table": table,
                "notes": notes,
            }
        )
    return {"summary": summary, "claims": entries}


# ------------------------------------------------------------------ verification


def verification(book: Book) -> dict:
    """The result of `make verify`: a figure and a table per case."""
    rows = book.verification
    codes = sorted(set(rows["code"]), key=lambda code: (code not in CODE_NAMES, code))
    summary = Table("Comparisons that pass", [Column("case"), *(Column(CODE_NAMES.get(code, code)) for code in codes)])
    cases = []
    for case in dict.fromkeys(rows["case"]):
        part = rows[rows["case"] == case].sort_values("passed", kind="stable")
        title = verification_figures.case_name(case)
        figure = verification_figures.case_figure(book.gallery, book.verification_folder, case, part)
        passed = int(part["passed"].sum())
        cases.append(
            {"name": case, "title": title, "passed": passed, "total": len(part), "figure": figure}
            | {"failed": case_table(part[~part["passed"]]), "table": case_table(part[part["passed"]])}
        )
        engines = set(part["code"]) & set(CODE_NAMES)
        cells = []
        for code in codes:
            mine = part[part["code"] == code]
            if len(mine):
                count = f"{int(mine['passed'].sum())} of {len(mine)}"
                cells.append(Chip(count, "good" if mine["passed"].all() else "bad"))
            else:
                cells.append(Chip("not run", "open") if engines and code in CODE_NAMES else "–")
        summary.rows.append([title, *cells])
    total = len(rows)
    return {"rows": total > 0, "passed": int(rows["passed"].sum()), "total": total, "cases": cases, "summary": summary}


def case_table(rows: pd.DataFrame) -> Table:
    """Comparisons of one case."""
    columns = [Column("code"), Column("quantity"), Column("expected", True), Column("measured", True)]
    columns += [
        Column("relative error", True),
        Column("tolerance", True),
        Column("verdict"),
        Column("reason", wide=True),
    ]
    table = Table("", columns)
    for r in rows.itertuples():
        verdict = Chip("pass", "good") if r.passed else Chip("fail", "bad")
        numbers = [number(r.expected, 6), number(r.measured, 6), number(r.rel_error, 2), number(r.tolerance, 2)]
        table.rows.append([CODE_NAMES.get(r.code, r.code), r.quantity, *numbers, verdict, r.reason])
    return table
