"""Tables of docs/glossary.md: every quantity of the files, by name."""

from __future__ import annotations

from analysis.formats import quantities
from analysis.formats.markdown import table


def _quantities() -> str:
    rows = [
        [f"`{row.name}`", row.heading.replace("{}", "k").replace("{name}", "rail seat to shoulder"), row.meaning]
        for row in quantities.glossary()
    ]
    return table(["column", "shown in the report as", "meaning"], rows)


SECTIONS = {"quantities": _quantities}
