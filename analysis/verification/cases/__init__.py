"""One module for each family of cases: what is run, and what must come out."""
