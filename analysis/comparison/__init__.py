"""What the normalised runs say: quantities of a run, fits of settlement laws, code against code, runs against reference
curves, and the paper's claims judged with their uncertainty.

Imports from this package: `formats`, `reference`, `normalised`, `scenarios`, `analysis.contact_laws` and
`analysis.files`."""
