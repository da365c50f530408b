"""What docs/ holds that follows from the code: the sketch of the apparatus, and the tables between marks in method.md,
design.md and glossary.md. `ballast docs` writes them, and PARAMETERS.md; tests hold the files to what it would write.

Imports from this package: `formats`, `scenarios`, `analysis.contact_laws`, `analysis.arguments` and
`analysis.files`."""
