"""What is simulated: the scenario file, checked and resolved, and what follows from it: clump, bond, apparatus, time
grid, start lattice, the parameters in both engines' terms.

YADE's Python imports these modules under the system's Python, so they need the standard library only (numpy for
`analysis.laws` and `analysis.laws_bond`). Imports from this package: `formats`, `analysis.laws`,
`analysis.laws_bond` and `analysis.files`."""
