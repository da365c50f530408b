"""What is simulated: the scenario file, checked and resolved, and what follows from it: clump, bond, apparatus, time
grid, start lattice, the parameters in both engines' terms.

YADE's Python imports these modules under the system's Python, so they need the standard library only (numpy for
`analysis.contact_laws` and `analysis.bond_law`). Imports from this package: `formats`, `analysis.contact_laws`,
`analysis.bond_law` and `analysis.files`."""
