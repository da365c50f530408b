"""`ballast verify`: both codes against closed forms and the oracle, on cases with known answers.

Writes report/verification.csv, one row per compared quantity, and report/verification/<case>_<code>.csv, the curves
behind them. Ends non-zero if a row fails.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import engines
from analysis.driver.engine import EngineError
from analysis.verification.cases import (
    block_cases,
    bond_cases,
    clump_cases,
    impact_cases,
    load_cases,
    path_cases,
    porosity_cases,
)
from analysis.verification.cases.case import Case, OwnCase, ProbedCase, StagedCase
from analysis.verification.probes import EngineFailure, run_probes
from analysis.verification.results import Results, write_rows

PROBED: tuple[type[ProbedCase], ...] = (
    *impact_cases.CASES,
    *path_cases.CASES,
    *block_cases.CASES,
    *clump_cases.CASES,
    *bond_cases.CASES,
)
STAGED: tuple[type[StagedCase], ...] = load_cases.CASES
OWN: tuple[type[OwnCase], ...] = porosity_cases.CASES
CASES: tuple[type[Case], ...] = (*PROBED, *STAGED, *OWN)


def verify(codes: list[str], folder: Path, chosen: list[str] | None = None) -> list[Results]:
    """Run the cases (all, or the `chosen` names) in the codes, side by side, below `folder`; return the results of
    each code.

    Last come the results of what needs no engine. Cases that an engine does not finish are failed rows.
    """
    for code in codes:
        engines.ENGINES[code].version()  # refuses an engine that is missing
    workers = max(1, (os.cpu_count() or 1) // len(codes)) if codes else 1
    with ThreadPoolExecutor(max(1, len(codes))) as pool:
        all_results = list(pool.map(lambda code: _verify_code(code, folder / code, chosen, workers), codes))
    own = Results("analysis")
    for case in OWN:
        if not chosen or case.name in chosen:
            case().judge(own)
    return [*all_results, own]


def _verify_code(code: str, folder: Path, chosen: list[str] | None, workers: int) -> Results:
    results = Results(code)
    wanted = [case(code) for case in PROBED if not chosen or case.name in chosen]
    found, failures = run_probes(
        code, [probe for case in wanted for probe in case.probes()], folder / "probes", workers
    )
    for case in wanted:
        failed = [failures[probe.name] for probe in case.probes() if probe.name in failures]
        if failed:
            results.fail(case.name, failed[0])
        else:
            case.judge(found, results)
    for make in STAGED:
        if chosen and make.name not in chosen:
            continue
        case = make(code)
        try:
            case.run(folder / case.name, workers)
        except EngineFailure as error:
            results.fail(case.name, str(error))
        else:
            case.judge(folder / case.name, results)
    return results


def main(argv: list[str]) -> int:
    """Command line."""
    parser = Parser(prog="ballast verify", description=__doc__.split("\n")[0])
    parser.add_argument("--code", choices=engines.CODES, action="append", help="only this code (may be given twice)")
    parser.add_argument(
        "--case", choices=[case.name for case in CASES], action="append", help="only this case (may be given again)"
    )
    parser.add_argument("--out", type=Path, default=Path("report"), help="folder of verification.csv")
    parser.add_argument("--keep", type=Path, help="keep the engines' input, output and logs in this folder")
    parser.add_argument("--host", type=Path, help="another LIGGGHTS executable, e.g. liggghts/build/ballast-sanitize")
    arguments = parser.parse_args(argv)
    if arguments.host:
        if not arguments.host.exists():
            print(f"verify: --host {arguments.host} does not exist; build it first", file=sys.stderr)
            return 2
        engines.LIGGGHTS.host = arguments.host.resolve()

    start = time.monotonic()
    folder = arguments.keep or Path(tempfile.mkdtemp(prefix="verify-"))
    try:
        all_results = verify(arguments.code or list(engines.CODES), folder, arguments.case)
    except EngineError as error:
        print(f"verify: {error}", file=sys.stderr)
        return 2
    finally:
        if not arguments.keep:
            shutil.rmtree(folder, ignore_errors=True)
    rows = [row for results in all_results for row in results.rows]
    write_rows(arguments.out / "verification.csv", rows)
    for results in all_results:
        results.write_curves(arguments.out / "verification")
    print(summary(rows))
    failed = [row for row in rows if not row.passed]
    print(
        f"{len(rows) - len(failed)} of {len(rows)} comparisons pass; {time.monotonic() - start:.0f} s; "
        f"{arguments.out / 'verification.csv'}"
    )
    return 1 if failed or not rows else 0


def summary(rows) -> str:
    """A line per case, passed/all of each code, then the rows that failed."""
    codes = list(dict.fromkeys(row.code for row in rows))
    lines = [f"{'case':18}" + "".join(f"{code:>12}" for code in codes)]
    for case in dict.fromkeys(row.case for row in rows):
        line = f"{case:18}"
        for code in codes:
            mine = [row for row in rows if row.case == case and row.code == code]
            line += f"{f'{sum(row.passed for row in mine)}/{len(mine)}' if mine else '-':>12}"
        lines.append(line)
    lines += [
        f"FAILED {row.code} {row.case}: {row.quantity}: expected {row.expected:.6g}, measured {row.measured:.6g}, "
        f"error {row.rel_error:.2g} > {row.tolerance:g}; {row.reason}"
        for row in rows
        if not row.passed
    ]
    return "\n".join(lines)
