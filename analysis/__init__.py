"""Analysis of sleeper settlement on railway ballast, the same for YADE and LIGGGHTS.

    from analysis import load_runs
    runs = load_runs("results")
    runs.cycles                     # a tidy data frame, units in the column names
"""


def __getattr__(name: str):
    # Late, because YADE's Python imports analysis.scenario and has no pandas.
    if name == "load_runs":
        from .readers import load_runs
        return load_runs
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
