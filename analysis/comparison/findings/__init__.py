"""What the runs say, as tidy tables in SI units, before any sentence or figure: `find.find` is the entrance."""
