"""`ballast impact FILE.toml`: impacts of two spheres, or of a sphere on a plane or wall, in both codes.

`docs/examples` has files to start from; the head of analysis/verification/impact_file.py lists all keys:

{keys}

Writes <out>/<file>.csv, a row per impact and code, <file>.png and .svg, and without a sweep <file>_series.csv with
forces over time. Results along and across the line of centres at first touch:

    restitution              normal relative speed after over before; below 0 where body 1 glances past
    tangential_restitution   the same of the tangential relative velocity of the centres
    rebound_angle_degrees    of the contact patch: tangential over normal velocity after, negative where it slides back
    impulse_ratio            tangential over normal impulse
    expected_...             the same by the paper's law, also beside YADE, which has another one at e_n < 1; for rigid
                             bodies whose line of centres does not turn
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver import engines
from analysis.driver.engine import EngineError
from analysis.files import write_csv
from analysis.scenarios.scenario import ScenarioError, scenario_names
from analysis.verification import impact_figure, impact_file
from analysis.verification.impact_file import KEYS, ImpactFile, of_scenario, read_impacts
from analysis.verification.impact_results import column_of, measured
from analysis.verification.probes import EngineFailure, run_probes


def run(file: ImpactFile, codes: list[str], out: Path) -> list[Path]:
    """Run all impacts of a file in the codes; return the files that were written. EngineFailure where one fails."""
    probes, rows, series = [impact.probe() for impact in file.impacts], [], {}
    folder = Path(tempfile.mkdtemp(prefix="impact-"))
    try:
        for code in codes:
            found, failures = run_probes(code, probes, folder / code)
            if failures:
                raise EngineFailure("; ".join(dict.fromkeys(failures.values())))
            for impact, probe in zip(file.impacts, probes, strict=True):
                row, curves = measured(impact, probe, code, found[probe.name])
                swept = {
                    column_of(key, KEYS[key].unit): " ".join(f"{v:.9g}" for v in value)
                    if isinstance(value, tuple)
                    else value
                    for key, value in impact.swept
                }
                rows.append({"code": code, "curve": impact.curve} | swept | row)
                if not file.swept:
                    series[impact.curve, code] = curves
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    if unknown := impact_figure.unknown_columns(file, rows[0]):
        raise ScenarioError(f"{file.name}.toml", "figure", unknown[0], "a column of the result: " + ", ".join(rows[0]))
    written = [out / f"{file.name}.csv"]
    write_csv(written[0], [list(rows[0]), *([shown(value) for value in row.values()] for row in rows)])
    if series:
        written.append(out / f"{file.name}_series.csv")
        lines = [
            (curve, code, *map(shown, point)) for (curve, code), curves in series.items() for point in curves.T.tolist()
        ]
        write_csv(written[-1], [("curve", "code", "time_s", "overlap_m", "normal_force_N", "shear_force_N"), *lines])
    written.append(out / f"{file.name}.png")
    impact_figure.draw(written[-1], file, rows, series)
    print(table(file, rows))
    return written


def shown(value) -> str:
    """A value as the tables hold it."""
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def table(file: ImpactFile, rows: list[dict]) -> str:
    """The results as text: a line per quantity without a sweep, else a line per impact with what is drawn."""
    if not file.swept:
        lines = [[name, *(row[name] for row in rows)] for name in rows[0]]
    else:
        names = ["code", "curve", *(column_of(key, KEYS[key].unit) for key in file.swept)]
        names += file.figure or impact_figure.DRAWN
        lines = [names, *([row[name] for name in names] for row in rows)]
    cells = [[f"{cell:.6g}" if isinstance(cell, float) else str(cell) for cell in line] for line in lines]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return "\n".join("  ".join(c.ljust(w) for c, w in zip(line, widths, strict=True)).rstrip() for line in cells)


def files_of(case: str) -> list[ImpactFile]:
    """The impact file, all those of a folder, or a scenario's law head-on; ScenarioError for anything else."""
    if case in scenario_names():
        return [of_scenario(case)]
    if Path(case).is_dir():
        if not (found := sorted(Path(case).glob("*.toml"))):
            raise ScenarioError(f"{case}: holds no impact file (.toml)")
        return [read_impacts(path) for path in found]
    return [read_impacts(Path(case))]


def main(argv: list[str]) -> int:
    """Command line."""
    help_text = __doc__.replace("{keys}", impact_file.__doc__.partition("\n\n")[2].rstrip())
    parser = Parser(prog="ballast impact", description=help_text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", help="an impact file, a folder of them, or a scenario: its law, head-on at 1 m/s")
    parser.add_argument("--code", choices=engines.CODES, action="append", help="only this code")
    parser.add_argument("--out", type=Path, default=Path("report/impact"), help="folder of the result")
    arguments = parser.parse_args(argv)
    codes = arguments.code or list(engines.CODES)
    try:
        files = files_of(arguments.case)
        for code in codes:
            engines.ENGINES[code].version()
        for file in files:
            if len(files) > 1:
                print(f"\n{file.title}")
            for path in run(file, codes, arguments.out):
                print(path)
    except EngineFailure as error:
        print(f"impact: {error}", file=sys.stderr)
        return 1
    except (ScenarioError, EngineError) as error:
        print(f"impact: {error}", file=sys.stderr)
        return 2
    return 0
