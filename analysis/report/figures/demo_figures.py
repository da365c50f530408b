"""The figures of the demo's page."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.comparison.findings.members import READINGS, TRUE_LOAD, Member
from analysis.formats.quantities import row_of
from analysis.report.figure import Figure, Gallery
from analysis.report.figures.bed_figures import bed_figure
from analysis.report.figures.lateral_figures import lateral_figure
from analysis.report.figures.load_figures import tracking_figure
from analysis.report.figures.overview_figures import demo_settlement_figure
from analysis.report.figures.porosity_figures import porosity_figure
from analysis.report.labels import READING_NAMES
from analysis.report.sentences import slug


def demo_figures(gallery: Gallery, members: Sequence[Member]) -> list[Figure | None]:
    """Settlement, the bed, lateral displacement, porosity where it was measured, and load tracking."""
    runs = [m.run for m in members]
    by_reading = {reading: [m.run for m in members if m.reading == reading] for reading in READINGS}
    pictured = [run for run in runs if (run.folder / "bed_after.csv").exists()][:1]
    measured = [run for run in runs if run.cycles[list(row_of("porosity_{}"))].notna().any(axis=None)]
    after = "Outward, at minimum load."
    zero = "Cycle 0 is the end of preload."
    return [
        demo_settlement_figure(gallery, members),
        bed_figure(gallery, pictured, "bed-demo", "after", "The demo bed after loading", "Coloured by displacement."),
        *(
            lateral_figure(
                gallery,
                part,
                f"lateral-demo-{slug(reading)}",
                f"Lateral displacement of the plates, {READING_NAMES[reading]}",
                after,
                references=False,
            )
            for reading, part in by_reading.items()
        ),
        porosity_figure(gallery, runs, "porosity-demo", "Porosity in the measurement spheres", zero, references=False)
        if measured
        else None,
        tracking_figure(gallery, by_reading[TRUE_LOAD], "tracking-demo", "Load tracking under the true load"),
    ]
