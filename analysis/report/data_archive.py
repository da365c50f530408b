"""All numbers of a report in one zip file: what the runs say, and what stands behind each figure."""

from __future__ import annotations

import zipfile
from pathlib import Path

from analysis.files import ROOT

NAME = "ballast-data.zip"
WHEN = (1980, 1, 1, 0, 0, 0)
"""Date of all members, so that the same report gives the same file."""
README = """All numbers of the report, as CSV files in SI units; the unit is in the name of each column.

findings/   what the runs say; findings/columns.csv says what each column means
figures/    what is drawn in each figure of the report, by the figure's name
CITATION.cff, LICENSE.md   how to cite; the data are under CC BY 4.0
"""


def write(out: Path) -> Path:
    """Write the zip file into the folder of a report, from its findings/ and figures/."""
    path = out / NAME
    partial = path.with_name(path.name + ".partial")
    with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as archive:
        add(archive, "README.txt", README.encode())
        for name, source in (("CITATION.cff", "CITATION.cff"), ("LICENSE.md", "reference_data/LICENSE.md")):
            if (ROOT / source).exists():
                add(archive, name, (ROOT / source).read_bytes())
        for folder in ("findings", "figures"):
            for file in sorted((out / folder).glob("*.csv")):
                add(archive, f"{folder}/{file.name}", file.read_bytes())
    partial.replace(path)
    return path


def add(archive: zipfile.ZipFile, name: str, content: bytes) -> None:
    """One member."""
    member = zipfile.ZipInfo(name, WHEN)
    member.external_attr = 0o644 << 16
    archive.writestr(member, content, zipfile.ZIP_DEFLATED)
