"""The paper's claims as checks on runs and reference curves, judged with their uncertainty: `verdicts` is the
entrance.
"""
