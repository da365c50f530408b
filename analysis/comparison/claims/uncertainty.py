"""Means with their uncertainty from few seeds: own scatter or lent by scenarios alike, Student's t, propagation."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

OWN_SEEDS = 3
"""Seeds from which on a scenario has its own scatter: that of two, with one degree of freedom, says next to nothing."""


@dataclass(frozen=True)
class Estimate:
    """A mean with its standard error; nan where one run is all there is and nothing says how runs scatter.

    degrees   of freedom of the standard error; infinite where it is stated
    seeds     that the mean is of
    lent      whose scatter it is, where it is not its own: errors lent by the same runs are wrong together
    """

    mean: float
    standard_error: float = math.nan
    degrees: float = math.inf
    seeds: int = 1
    lent: str = ""

    def half_width(self, confidence: float = 0.95) -> float:
        """Half the width of the confidence interval."""
        return coverage(self.degrees, confidence) * self.standard_error


@functools.lru_cache(4096)
def coverage(degrees: float, confidence: float = 0.95) -> float:
    """Half-width over standard error: Student's t quantile, the normal one for infinitely many degrees of freedom."""
    quantile = 0.5 + confidence / 2
    return float(stats.norm.ppf(quantile) if math.isinf(degrees) else stats.t.ppf(quantile, degrees))


def scatters(values: Sequence[float]) -> bool:
    """Whether a group of runs can tell its own scatter: two seeds, and not all alike (a share that is 0 in each)."""
    return len(values) > 1 and float(np.ptp(values)) > 0


def pooled(groups: Mapping[str, Sequence[float]], relative: bool) -> tuple[float, int]:
    """Standard deviation between seeds over all groups that can tell it, and its degrees of freedom; nan and 0 without.

    relative   the deviation is a share of each group's mean (settlement, displacement), else absolute (porosity)
    """
    found = [np.asarray(group, dtype=float) for group in groups.values() if scatters(group)]
    found = [v / abs(v.mean()) for v in found if v.mean()] if relative else found
    degrees = sum(len(v) - 1 for v in found)
    squares = sum(float(np.sum((v - v.mean()) ** 2)) for v in found)
    return (math.sqrt(squares / degrees), degrees) if degrees else (math.nan, 0)


def estimates(
    groups: Mapping[str, Sequence[float]], lenders: Mapping[str, Mapping[str, Sequence[float]]], relative: bool
) -> dict[str, Estimate]:
    """Estimate for each group of runs that differ by seed only.

    A group of OWN_SEEDS has its own scatter and no other: pooled with groups that scatter less it would be taken for
    surer than it is. A smaller one has that of the groups alike, itself among them.
    lenders    for each group, the groups alike that lend it their scatter, by name
    """
    found = {}
    for name, group in groups.items():
        values = np.asarray(group, dtype=float)
        mean, count = float(values.mean()), len(values)
        if scatters(group) and count >= OWN_SEEDS:
            found[name] = Estimate(mean, float(values.std(ddof=1)) / math.sqrt(count), count - 1, count)
            continue
        alike = lenders.get(name, {})
        deviation, degrees = pooled(alike if any(map(scatters, alike.values())) else {name: group}, relative)
        if degrees:
            error = deviation * (abs(mean) if relative else 1.0) / math.sqrt(count)
            found[name] = Estimate(mean, error, degrees, count, ", ".join(n for n, v in alike.items() if scatters(v)))
        else:  # the same value in each of several seeds, and nobody to borrow from: it does not scatter
            found[name] = Estimate(mean, 0.0 if count > 1 else math.nan, math.inf, count)
    return found


def one_run(of_seeds: Estimate, value: float) -> Estimate:
    """The value of a single run that scatters as the seeds of an estimate do."""
    deviation = of_seeds.standard_error * math.sqrt(of_seeds.seeds)
    return Estimate(value, deviation, of_seeds.degrees, 1, of_seeds.lent)


def combined(variances: Sequence[float], degrees: Sequence[float]) -> float:
    """Degrees of freedom of a sum of independent estimated variances (Welch and Satterthwaite)."""
    total = sum(variances)
    if not total > 0 or math.isnan(total):
        return math.inf
    share = sum(v**2 / d for v, d in zip(variances, degrees, strict=True) if v > 0)
    return total**2 / share if share > 0 else math.inf


def propagate(function: Callable[..., float], inputs: Sequence[Estimate]) -> tuple[float, float, float]:
    """Value of `function` at the means, its standard error and the degrees of freedom of that; inputs are independent.

    Each input is moved by one standard error to both sides and the larger change counts, which is right for linear
    functions and on the safe side at the kink of an absolute value.
    """
    means = [e.mean for e in inputs]
    value = function(*means)
    by_source: dict[str, tuple[float, float]] = {}
    for k, e in enumerate(inputs):
        moved = [function(*means[:k], e.mean + sign * e.standard_error, *means[k + 1 :]) for sign in (-1, 1)]
        variance = max(abs(m - value) for m in moved) ** 2 if not math.isnan(e.standard_error) else math.nan
        source = e.lent or f"own {k}"
        by_source[source] = (by_source.get(source, (0.0, 0.0))[0] + variance, e.degrees)
    variances = [v for v, _ in by_source.values()]
    return value, math.sqrt(sum(variances)), combined(variances, [d for _, d in by_source.values()])
