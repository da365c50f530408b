"""How to cite this project, from CITATION.cff."""

from __future__ import annotations

import re

from analysis.files import ROOT


def citation() -> str:
    """Authors and title of CITATION.cff."""
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    title = re.search(r'^title: "(.*)"$', text, re.M)
    author = re.search(r"^ {2}- name: (.*)$", text, re.M)
    return ". ".join(found.group(1) for found in (author, title) if found) + "."
