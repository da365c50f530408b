"""`ballast mutations`: does the verification notice a wrong law?

Each mutation changes a line of the LIGGGHTS models (or of YADE's scripts) in a copy, builds it, and runs the
verification cases on it. The command prints which cases caught it, and ends non-zero if one goes unnoticed or does not
fit the source any more.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from analysis.arguments import Parser
from analysis.driver.engines import LIGGGHTS
from analysis.files import ROOT
from analysis.verification import probes
from analysis.verification.verify_command import verify

SOURCE = ROOT / "liggghts"
CASES = (
    "head-on",
    "wall-dashpot",
    "oblique",
    "no-approach",
    "path",
    "block",
    "free-rotation",
    "clump-bounce",
    "clump-pair",
)
BOND_CASES = ("bond-path", "bond-cantilever", "bond-energy", "bond-clumps")


@dataclass(frozen=True)
class Mutation:
    """A wrong law: texts of source files, each of which must occur exactly once, and what they become."""

    name: str
    changes: tuple[tuple[str, str, str], ...]
    cases: tuple[str, ...] = CASES
    """Those that must notice."""
    code: str = "liggghts"


MUTATIONS = (
    Mutation(
        "wrong exponent in eq. 8 (1.45 instead of 1.5)",
        (
            (
                "contact_laws.h",
                "const double elastic = 2.0 * contact_size * overlap / (3.0 * (1.0 - poisson_ratio));",
                "const double elastic = 2.0 * contact_size * std::pow(overlap, 0.95) / (3.0 * (1.0 - poisson_ratio));",
            ),
        ),
    ),
    Mutation(
        "shear stiffness without the factor 2 in eq. 11",
        (
            (
                "contact_laws.h",
                "const double shear_stiffness = 2.0 * contact_size",
                "const double shear_stiffness = contact_size",
            ),
        ),
    ),
    Mutation(
        "friction includes the dashpot (eq. 4 and 12)",
        (
            (
                "contact_batch.cpp",
                "const double limit = c.friction * response.elastic_force;",
                "const double limit = c.friction * response.total_force;",
            ),
        ),
    ),
    Mutation(
        "mass of the sphere instead of the clump's in the dashpot (eq. 6-7)",
        (
            (
                "contact_batch.cpp",
                "const double mass = c.mass_share * b.effective_mass[k];",
                "const double mass = 0.5 * c.mass_share * b.effective_mass[k];",
            ),
        ),
    ),
    Mutation(
        "eq. 3 left out",
        (
            (
                "contact_laws.h",
                "return approach > overlap ? overlap / approach : 1.0;",
                "return 1.0 + 0.0 * approach * overlap;",
            ),
        ),
    ),
    Mutation(
        "M_d 0 and 1 swapped (eq. 16)",
        (
            (
                "contact_laws.h",
                "if (damping_mode == 0) return loss / restitution;",
                "if (damping_mode == 1) return loss / (restitution > 0.01 ? restitution : 0.01);",
            ),
        ),
    ),
    Mutation(
        "M_d 2 without its exponential (eq. 16)",
        (
            (
                "contact_laws.h",
                "return damping_mode == 2 ? factor * std::exp(2.0 * (1.0 - restitution)) : factor;",
                "return factor;",
            ),
        ),
    ),
    Mutation(
        "no limit of the dashpot at small approach speed",
        (
            (
                "contact_laws.h",
                "const bool at_limit = damping * elastic >= highest * impact_speed;",
                "const bool at_limit = impact_speed <= 0.0;",
            ),
        ),
    ),
    Mutation(
        "the hysteretic dashpot may pull",
        (
            (
                "contact_laws.h",
                "damping == 0.0 ? elastic : (damped > 0.0 ? damped : 0.0);",
                "damping == 0.0 ? elastic : damped;",
            ),
        ),
    ),
    Mutation(
        "shear history kept over a separation",
        (
            (
                "contact_laws.h",
                "return last_touch_step == 0.0 || (last_touch_step != step && last_touch_step != step - 1.0);",
                "return last_touch_step == 0.0 || step < 0.0;",
            ),
        ),
    ),
    Mutation(
        "approach speed renewed at every step (eq. 15)",
        (
            (
                "contact_batch.cpp",
                "const double impact_speed = is_new ? first_speed : b.impact_speed[k];",
                "const double impact_speed = is_new ? first_speed : closing;",
            ),
        ),
    ),
    Mutation(
        "slip limit without friction's coefficient (eq. 4)",
        (
            (
                "contact_batch.cpp",
                "const double limit = c.friction * response.elastic_force;",
                "const double limit = response.elastic_force;",
            ),
        ),
    ),
    Mutation(
        "arm of the shear force to the surface instead of the middle of the overlap",
        (
            (
                "contact_batch.cpp",
                "const double arm_i = b.radius_i[k] - 0.5 * overlap,",
                "const double arm_i = 1.1 * b.radius_i[k],",
            ),
        ),
    ),
    Mutation(
        "clump spins about its axis with the transverse inertia",
        (
            (
                "clump_motion.cpp",
                "difference = 1.0 / c.inertia_axial - across, half",
                "difference = 0.0, half",
            ),
            (
                "clump_motion.cpp",
                "const double difference = 1.0 / c.inertia_axial - across;\n  double *const velocity",
                "const double difference = 0.0;\n  double *const velocity",
            ),
        ),
    ),
    Mutation(
        "a block has faces only, no edges",
        (
            (
                "fix_wall.cpp",
                "    length2 += distance[d] * distance[d];\n  }\n  side = 1.0;",
                "    length2 += distance[d] * distance[d];\n  }\n"
                "  const int nearest = std::max_element(distance, distance + 3,\n"
                "    [](double a, double b) { return std::abs(a) < std::abs(b); }) - distance;\n"
                "  for (int d = 0; d < 3; d++) distance[d] *= d == nearest;\n"
                "  length2 = distance[nearest] * distance[nearest];\n  side = 1.0;",
            ),
        ),
    ),
)
MUTATIONS += tuple(
    Mutation(name, changes, BOND_CASES)
    for name, *changes in (
        (
            "bond: area for I in bending",
            (
                "bond_law.h",
                "disc.normal_stiffness * disc.moment_of_inertia * (bend",
                "disc.normal_stiffness * disc.area * (bend",
            ),
        ),
        (
            "bond: I for J in twisting",
            ("bond_law.h", "          2.0 * moment_of_inertia,", "          moment_of_inertia,"),
        ),
        ("bond: radius of the larger sphere", ("bond_law.h", "(radius_1 < radius_2 ?", "(radius_1 > radius_2 ?")),
        (
            "bond: no bending in the stress",
            ("bond_law.h", "+ bending * disc.radius / disc.moment_of_inertia;", "+ 0.0 * bending;"),
        ),
        (
            "bond: acts in touch only",
            (
                "bond_law.h",
                "(m.distance - state.rest_distance);",
                "(m.distance < state.rest_distance ? m.distance - state.rest_distance : 0.0);",
            ),
        ),
        ("bond: old shear force not turned", ("bond_law.h", "  carry(state.shear, m.normal, angle);\n", "")),
        ("bond: made within clumps", ("fix_bonds.cpp", "|| body(i) == body(j)) continue;", "|| i == j) continue;")),
        (
            "bond: heals",
            (
                "fix_bonds.cpp",
                "      if (bond.fate != HOLDS) continue;\n      const int j",
                "      bond.fate = HOLDS;\n      const int j",
            ),
        ),
    )
)
MUTATIONS += tuple(
    Mutation(name, changes, BOND_CASES, "yade")
    for name, *changes in (
        (
            "bond in YADE: area for I",
            (
                "bond.py",
                "phys.kr, phys.ktw = law.normal_stiffness * law.moment_of_inertia",
                "phys.kr, phys.ktw = law.area",
            ),
        ),
        (
            "bond in YADE: radius of the larger sphere",
            (
                "bond.py",
                "interaction.geom.refR1, interaction.geom.refR2",
                "1.0, max(interaction.geom.refR1, interaction.geom.refR2)",
            ),
        ),
        ("bond in YADE: made within clumps", ("bond.py", "one.clumpId == two.clumpId", "one.id == two.id")),
        ("bond in YADE: heals", ("bond.py", "NO_STIFFNESS = 1e-20", "NO_STIFFNESS = 1e9")),
        ("bond in YADE: moments do not break it", ("bond.py", "if max(tensile, shear) < 1:", "if True:")),
    )
)


class MutationError(RuntimeError):
    """A mutation that cannot be made; the message is one line."""


def mutate(mutation: Mutation, source: Path) -> None:
    """Change the files of `source` (a copy of liggghts/src or yade).

    MutationError where a text does not occur exactly once.
    """
    for name, old, new in mutation.changes:
        path = source / name
        text = path.read_text()
        if text.count(old) != 1:
            raise MutationError(
                f"{mutation.name}: {name} holds {text.count(old)} times `{old}`, expected once; renew the mutation"
            )
        path.write_text(text.replace(old, new))


def build(mutation: Mutation | None, source: Path, folder: Path) -> Path:
    """Copy the LIGGGHTS sources to `folder`, mutate and build them; return the executable."""
    shutil.copytree(source / "src", folder / "src")
    shutil.copy(source / "Makefile", folder)
    if mutation:
        mutate(mutation, folder / "src")
    made = subprocess.run(["make", "-j2", "OPTIMISE=-O1"], cwd=folder, capture_output=True, text=True)
    if made.returncode:
        errors = [line for line in made.stderr.splitlines() if "error" in line.lower()]
        raise MutationError(
            f"{mutation.name if mutation else 'unchanged'}: does not build: {errors[0] if errors else made.stderr}"
        )
    return folder / "build" / "ballast"


def copy_scripts(mutation: Mutation, folder: Path) -> Path:
    """Copy what YADE needs to `folder`, which takes the place of the repository, and mutate it; return `folder`."""
    for name in ("yade", "analysis"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    mutate(mutation, folder / "yade")
    return folder


def catching_cases(code: str, cases: tuple[str, ...], folder: Path) -> list[str]:
    """Names of the cases with a failed row."""
    rows = [row for results in verify([code], folder, list(cases)) for row in results.rows]
    return [
        f"{case} ({sum(r.case == case and not r.passed for r in rows)} of {sum(r.case == case for r in rows)} rows)"
        for case in dict.fromkeys(row.case for row in rows if not row.passed)
    ]


def main(argv: list[str]) -> int:
    """Command line."""
    parser = Parser(prog="ballast mutations", description=__doc__.split("\n")[0])
    parser.add_argument(
        "--only", type=int, action="append", metavar="N", help="only mutation N, from 1 (may be given again)"
    )
    arguments = parser.parse_args(argv)
    original, unnoticed = Path(tempfile.mkdtemp(prefix="mutations-")), 0
    shutil.copytree(SOURCE / "src", original / "src")
    shutil.copy(SOURCE / "Makefile", original)
    for number, mutation in [(0, None), *enumerate(MUTATIONS, start=1)]:
        if mutation and arguments.only and number not in arguments.only:
            continue
        folder = Path(tempfile.mkdtemp(prefix="mutation-"))
        try:
            if mutation and mutation.code == "yade":
                probes.ROOT = copy_scripts(mutation, folder)
            else:
                LIGGGHTS.host, probes.ROOT = build(mutation, original, folder), ROOT
            cases = mutation.cases if mutation else (*CASES, *BOND_CASES)
            caught = catching_cases(mutation.code if mutation else "liggghts", cases, folder / "cases")
        except MutationError as error:
            print(f"mutations: {error}", file=sys.stderr)
            shutil.rmtree(original)
            return 2
        finally:
            shutil.rmtree(folder, ignore_errors=True)
        wrong = bool(caught) if mutation is None else not caught
        unnoticed += wrong
        print(
            f"{number:2}. {mutation.name if mutation else 'unchanged'}: "
            + (f"caught by {', '.join(caught)}" if caught else "no case fails")
            + (" <- WRONG" if wrong else ""),
            flush=True,
        )
    shutil.rmtree(original)
    return 1 if unnoticed else 0
