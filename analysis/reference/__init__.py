"""What others published: digitised curves and settlement laws of reference_data/published, each file checked before
anything is compared with it.

Imports from this package: `formats`, `scenarios`, `analysis.arguments` and `analysis.files`."""
