"""Sentences from templates: the words stand in templates/*.txt, the numbers come from the findings."""

from __future__ import annotations

import functools
import re
from pathlib import Path

import jinja2
from markupsafe import Markup, escape

from analysis.formats.numbers import plural
from analysis.formats.quantities import GRAVITY_M_S2 as GRAVITY
from analysis.report.labels import MM, PUBLICATION_NAMES, READING_NAMES, short_name, variant_name
from analysis.report.paper import paper
from analysis.report.style import CODE_NAMES
from analysis.report.tables.table_html import number

TEMPLATES = Path(__file__).resolve().parent / "templates"

VERDICT_WORDS = {
    "holds": ("holds", "hold"),
    "does not hold": ("does not hold", "do not hold"),
    "not decidable yet": ("cannot be decided yet", "cannot be decided yet"),
    "not decidable": ("cannot be decided", "cannot be decided"),
}


def environment(**options) -> jinja2.Environment:
    """Templates with the words for numbers; HTML is escaped, undefined names are errors in texts."""
    made = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=jinja2.select_autoescape(),
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.ChainableUndefined,
        **options,
    )
    made.filters |= {"slug": slug, "symbols": symbols, "breaks": breaks, "strong": strong}
    made.globals |= {
        "zip": zip,
        "number": number,
        "plural": plural,
        "mm": lambda value, digits=3: number(value, digits, MM),
        "rate": lambda value: number(value, 2, MM),
        "kpa": lambda value: number(value, 3, 1e-3),
        "g": lambda value: number(value, 2, 1 / GRAVITY),
        "percent": lambda value, digits=2: number(value, digits, 100),
        "gravity": GRAVITY,
        "paper": paper(),
        "label": short_name,
        "variant_label": variant_name,
        "source_name": source_name,
        "reading_name": lambda reading: READING_NAMES[reading],
        "code_name": lambda code: CODE_NAMES.get(code, code),
        "verdict_words": lambda verdict, count: VERDICT_WORDS.get(verdict, (verdict, verdict))[count != 1],
    }
    return made


def slug(text: str) -> str:
    """A heading as an anchor."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")


def source_name(source: str) -> str:
    """A source of reference curves in words: `chen2015 (simulation)` is the simulation of Chen 2015."""
    name = PUBLICATION_NAMES.get(source.partition(" (")[0], source)
    return name.removeprefix("the ")


def breaks(key: str) -> Markup:
    """A key that may break after its dot and its underscores, nowhere else."""
    return Markup(re.sub(r"([._])", r"\1<wbr>", str(escape(key))))


def strong(line: str) -> Markup:
    """A line of a text with what stands between two pairs of stars in bold."""
    return Markup(re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", str(escape(line))))


def symbols(text: str) -> str:
    """Symbols of data files as figures write them."""
    return text.replace("M_d", "Md").replace("e_n", "eₙ")


@functools.cache
def _texts() -> jinja2.Environment:
    """One for all texts, so that a template is compiled once."""
    return environment()


def lines(template: str, **values) -> list[str]:
    """The sentences of a text template, one per line of it that is not empty."""
    text = _texts().get_template(template).render(**values)
    return [" ".join(line.split()) for line in text.splitlines() if line.strip()]
