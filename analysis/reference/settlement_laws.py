"""Published laws of settlement as shapes, from settlement_laws/laws.toml."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.files import PUBLISHED
from analysis.formats import toml_file
from analysis.reference.curves import ReferenceError, citation_keys, require_texts


@dataclass(frozen=True)
class SettlementLaw:
    """A published law as a shape, settlement over that of the first cycle; `source` are BibTeX keys."""

    id: str
    label: str
    form: str
    coefficient: float
    source: tuple[str, ...]
    status: str
    note: str

    def ratio(self, cycles, reference_cycle: float = 1.0) -> np.ndarray:
        """S_N / S_reference for `cycles` >= 1."""

        def shape(n):
            n = np.asarray(n, dtype=float)
            return 1 + self.coefficient * np.log(n) if self.form == "logarithm" else n**self.coefficient

        return shape(cycles) / shape(reference_cycle)


def settlement_laws(folder: Path = PUBLISHED) -> list[SettlementLaw]:
    """The laws of settlement_laws/laws.toml, checked."""
    path = Path(folder) / "settlement_laws" / "laws.toml"
    try:
        entries = toml_file.read(path)["law"]
        laws = [SettlementLaw(**(e | {"source": tuple(e["source"])})) for e in entries]
        for law in laws:
            require_texts(law.id, law.label, law.form, *law.source, law.status, law.note)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise ReferenceError(
            f"{path.name}: cannot be used ({error}); each [[law]] has id, label, form, coefficient, "
            "source, status and note"
        ) from None
    known = citation_keys(path.with_name("reference.bib"))
    for law in laws:
        known_form = law.form in ("logarithm", "power")
        if not known_form or not isinstance(law.coefficient, (int, float)) or not 0 < law.coefficient < 2:
            raise ReferenceError(
                f"{path.name}: {law.id}: form = {law.form}, coefficient = {law.coefficient} is "
                "refused; allowed: logarithm or power, > 0 and < 2"
            )
        for key in law.source:
            if key not in known:
                raise ReferenceError(f"{path.name}: {law.id}: source {key!r} is not in reference.bib; add the entry")
    return laws
