"""Both engines against known answers: small cases with closed forms, an oracle that integrates the paper's equations
without them, any impact of a user's own, and wrong laws that the cases must notice.

It stands beside the flow: the report asks it what its cases are, and reads the files that it writes. Imports from this
package: `formats`, `driver`, `normalised`, `scenarios`, `analysis.contact_laws`, `analysis.bond_law`,
`analysis.arguments` and `analysis.files`."""
