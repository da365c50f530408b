"""Analysis of sleeper settlement on railway ballast, the same for YADE and LIGGGHTS.

The sub-packages follow the data: scenarios -> driver (runs the engines) -> normalised -> comparison (with reference)
-> report; verification stands beside them. Each says in its docstring what it may import. `contact_laws` has the
paper's contact laws, `files` how files are written.

    from analysis import load_runs
    runs = load_runs("results")
    runs.cycles                     # a tidy data frame, units in the column names
"""


def __getattr__(name: str):
    # Late, because YADE's Python imports analysis.scenarios and has no pandas.
    if name == "load_runs":
        from analysis.normalised.readers import load_runs

        return load_runs
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
