"""Takes scenarios through the engines: writes their input, runs and watches them, certifies checkpoints, goes on after
any stop, and tells how far each run is. Also the benchmark and the calibration of the packing.

Imports from this package: `formats`, `scenarios`, `normalised`, `reference`, `analysis.arguments` and
`analysis.files`."""
