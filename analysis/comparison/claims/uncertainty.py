"""Means with their uncertainty from few seeds: scatter pooled over scenarios, Student's t, propagation."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats


@dataclass(frozen=True)
class Estimate:
    """A mean with its standard error; nan where one run is all there is and no uncertainty is stated."""

    mean: float
    standard_error: float = math.nan
    degrees: float = math.inf
    seeds: int = 1

    def half_width(self, confidence: float = 0.95) -> float:
        """Half the width of the confidence interval."""
        return coverage(self.degrees, confidence) * self.standard_error


def coverage(degrees: float, confidence: float = 0.95) -> float:
    """Half-width over standard error: Student's t quantile, the normal one for infinitely many degrees of freedom."""
    quantile = 0.5 + confidence / 2
    return float(stats.norm.ppf(quantile) if math.isinf(degrees) else stats.t.ppf(quantile, degrees))


def pooled(groups: Mapping[str, Sequence[float]], relative: bool) -> dict[str, Estimate]:
    """Estimate for each group of runs that differ by seed only, with the scatter pooled over all groups.

    relative   the scatter is a share of the mean (settlement, displacement), else absolute (porosity, shares)
    """
    values = {name: np.asarray(group, dtype=float) for name, group in groups.items()}
    degrees = sum(len(v) - 1 for v in values.values())
    scale = {name: abs(v.mean()) if relative else 1.0 for name, v in values.items()}
    squares = sum((((v - v.mean()) / scale[name]) ** 2).sum() for name, v in values.items() if len(v) > 1)
    deviation = math.sqrt(squares / degrees) if degrees else math.nan
    return {
        name: Estimate(float(v.mean()), deviation * scale[name] / math.sqrt(len(v)), degrees or math.inf, len(v))
        for name, v in values.items()
    }


def propagate(
    function: Callable[..., float], inputs: Sequence[Estimate], confidence: float = 0.95
) -> tuple[float, float]:
    """Value of `function` at the means, and the half-width of its confidence interval; inputs are independent.

    Each input is moved by one standard error to both sides and the larger change counts, which is right for linear
    functions and on the safe side at the kink of an absolute value. The fewest degrees of freedom decide the quantile.
    """
    means = [e.mean for e in inputs]
    value = function(*means)
    variance = 0.0
    for k, e in enumerate(inputs):
        moved = [function(*means[:k], e.mean + sign * e.standard_error, *means[k + 1 :]) for sign in (-1, 1)]
        variance += max(abs(m - value) for m in moved) ** 2 if not math.isnan(e.standard_error) else math.nan
    return value, coverage(min((e.degrees for e in inputs), default=math.inf), confidence) * math.sqrt(variance)
