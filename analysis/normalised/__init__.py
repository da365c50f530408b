"""From raw output to the normalised run, one form for both codes: its tables, the porosity and microstructure measured
on each bed, and the readers that turn run folders into data frames.

The driver calls `normalise` cycle by cycle; everything downstream reads runs through `readers`. Imports from this
package: `formats`, `scenarios`, `contact_laws`, `bond_law` and `analysis.files`."""
