"""The site that `make report` builds: `build` gathers runs and findings into the report's data, `pages` says what it
shows, `figures` draws, `pictures` renders beds (also for `make view`), `templates` holds HTML and sentences.

The end of the flow: nothing imports it. Imports from this package: `formats`, `docs`, `comparison`, `reference`,
`driver`, `normalised`, `verification`, `scenarios`, `analysis.contact_laws`, `analysis.arguments` and
`analysis.files`."""
