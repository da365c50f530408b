"""Laws of settlement against cycles, fitted and compared: does a curve have the exponential start?

Laws, S settlement and N cycles:
    exponential   S = a + b (1 - exp(-N / c)) + d N     an exponential start, then a line (the paper's description)
    logarithm     S = a + b ln N
    power         S = a N^b
    line          S = a + b N

Each is fitted by maximum likelihood. The scatter about the law is either the same in all cycles or proportional to the
settlement, and has a memory of one cycle (first-order autoregressive): settlement accumulates, so what one cycle adds
by chance stays. Without that memory a thousand smooth points would "prove" any law with enough parameters. The Bayesian
information criterion (BIC) chooses law and scatter together. AICc does not serve here: the exponential law contains the
line, and AICc would take it for a noisy line of 1000 cycles in one case out of five.

All laws are linear in all parameters but one (c, or the power), so the fit is a search along that one with linear least
squares inside: no starting values, no missed minima. Confidence intervals are those of the profile of the restricted
likelihood (Harville 1977): all values of a parameter that some choice of the others, and of the memory, makes likely
enough; they need not be symmetric. With the fitted memory taken as known they would cover 82 to 92 % instead of 95
where neighbouring cycles are alike, because a fit takes part of a long memory for trend.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import t as student

LEAST_CYCLES = 20
"""Fewer cycles than this cannot tell five unknowns (four parameters and the scatter) from chance."""
STRONG = 6.0
"""BIC difference from which evidence is strong (Kass and Raftery 1995)."""
COMPLETE = 0.9999
"""Memory of a random walk: a little less than 1, where the likelihood is not defined."""
WALK = 21.8
"""Count x (1 - correlation) below which a random walk is not excluded: Dickey and Fuller (1979) with trend, 5 %."""
CHOICES = ("exponential", "logarithm", "power", "line")


@dataclass(frozen=True)
class Law:
    """A law that is linear in all parameters but at most one, `inner`, which is searched between its limits."""

    name: str
    formula: str
    parameters: tuple[str, ...]
    columns: Callable[[np.ndarray, float], np.ndarray]
    """Columns of the linear part for cycles N and the inner parameter, shape (n, number of linear parameters)."""
    inner: str | None = None
    limits: Callable[[np.ndarray], tuple[float, float]] = lambda n: (0.0, 0.0)
    logarithmic: bool = False

    def scale(self, inner: float) -> float:
        """The inner parameter as it is searched."""
        return float(np.log(inner)) if self.logarithmic else inner

    def unscale(self, searched: float) -> float:
        """Inverse of `scale`."""
        return float(np.exp(searched)) if self.logarithmic else float(searched)


def _exponential_columns(n, c):
    return np.column_stack([np.ones_like(n), -np.expm1(-n / c), n])


LAWS = {
    law.name: law
    for law in (
        Law(
            "exponential",
            "a + b (1 - exp(-N/c)) + d N",
            ("a", "b", "d", "c"),
            _exponential_columns,
            "c",
            lambda n: (0.3, n.max()),
            logarithmic=True,
        ),
        Law("logarithm", "a + b ln N", ("a", "b"), lambda n, _: np.column_stack([np.ones_like(n), np.log(n)])),
        Law("power", "a N^b", ("a", "b"), lambda n, b: (n**b)[:, None], "b", lambda n: (-1.0, 3.0)),
        Law("line", "a + b N", ("a", "b"), lambda n, _: np.column_stack([np.ones_like(n), n])),
    )
}


@dataclass(frozen=True)
class Fit:
    """A fitted law. Parameters in metres and cycles; intervals at the level given to `fit`."""

    law: str
    values: dict[str, float]
    intervals: dict[str, tuple[float, float]]
    scatter: str
    """"constant": standard deviation in m; "proportional": as a share of the settlement."""
    deviation: float
    memory: float
    """Correlation of the scatter of neighbouring cycles, 0 to 1."""
    bic: float
    cycles: tuple[int, int]
    at_limit: bool
    """The search for c or the power ended at its limit: the curve does not determine it."""

    def settlement(self, cycles) -> np.ndarray:
        """The law after these cycles, m."""
        return evaluate(self.law, self.values, cycles)


def evaluate(law: str, values: dict[str, float], cycles) -> np.ndarray:
    """Settlement (m) after `cycles` by a named law with its parameters."""
    cycles = np.asarray(cycles, dtype=float)
    rule = LAWS[law]
    inner = values[rule.inner] if rule.inner else 0.0
    return rule.columns(cycles, inner) @ np.array([values[p] for p in rule.parameters if p != rule.inner])


# ---------------------------------------------------------------------- one law


def fit(
    law: str, cycles: Sequence[float], settlements: Sequence[float], scatter: str = "constant", level: float = 0.95
) -> Fit:
    """Fit one law to `settlements` (m) after `cycles` (>= 1, rising).

    Raises ValueError where there are too few points or values that are no number.
    """
    return _best(law, cycles, settlements, scatter).describe(level)


def _best(law: str, n: Sequence[float], s: Sequence[float], scatter: str) -> _Fitted:
    """The most likely parameters; raises ValueError as `fit` does."""
    n, s = np.asarray(n, dtype=float), np.asarray(s, dtype=float)
    rule = LAWS[law]
    if len(n) < len(rule.parameters) + 2:
        raise ValueError(f"{len(n)} cycles are too few for the law {law}: give at least {len(rule.parameters) + 2}")
    if not (np.isfinite(n).all() and np.isfinite(s).all() and (n >= 1).all() and (np.diff(n) > 0).all()):
        raise ValueError("cycles must rise from 1 and settlements be finite; drop rows that are not")
    unit = np.std(s) or 1.0  # in units of its own spread the problem is well scaled
    weight, memory = np.ones_like(s), 0.0
    for _ in range(8):
        problem = _Problem(rule, n, s / unit, weight, memory)
        x = problem.search()
        model = rule.columns(n, rule.unscale(x)) @ problem.solve(x)[1]
        new_weight = 1 / np.maximum(np.abs(model), 1e-3 * np.abs(model).max()) if scatter == "proportional" else weight
        new_memory = _memory(new_weight * (s / unit - model))
        if max(np.max(np.abs(new_weight / weight - 1)), abs(new_memory - memory)) < 1e-3:
            break
        weight, memory = new_weight, new_memory
    return _Fitted(problem, x, unit, scatter)


def _whiten(columns: np.ndarray, weight: np.ndarray, memory: float) -> np.ndarray:
    """Scale by the weights and take the memory out (Prais and Winsten), along the first axis."""
    scaled = columns * (weight if columns.ndim == 1 else weight[:, None])
    if memory == 0:
        return scaled
    white = scaled.copy()
    white[1:] -= memory * scaled[:-1]
    white[0] *= np.sqrt(1 - memory**2)
    return white


def _memory(residual: np.ndarray) -> float:
    """Lag-one correlation of the residuals, 0 to COMPLETE.

    What chance gives scatter without memory counts as 0, and what it gives a random walk about a fitted trend counts as
    complete (the 5 % limit of Dickey and Fuller 1979 with trend): between walk and almost-walk lie most of the late
    slope's uncertainty.
    """
    count = len(residual)
    r = float(np.sum(residual[1:] * residual[:-1]) / max(np.sum(residual**2), 1e-300))
    if r < 2 / np.sqrt(count):
        return 0.0
    return COMPLETE if count * (1 - r) < WALK else r


def _likely_memories(memory: float, count: int) -> list[float]:
    """Memories to profile over: some standard errors about the fitted one (in artanh), more of them above, because a
    fit takes part of a long memory for trend; always a random walk, and from a walk down to what is excluded as one.
    """
    if memory == COMPLETE:
        return sorted(1 - np.geomspace(min(1.0, WALK / count), 1 - COMPLETE, 8))
    steps = np.arctanh(memory) + np.array([-3, -2, -1, 0, 1, 2, 3, 4.5, 6]) / np.sqrt(count)
    return sorted({*np.clip(np.tanh(steps), 0, COMPLETE), memory, COMPLETE})


class _Problem:
    """One law on one curve at given weights and memory: least squares in the linear parameters, by the inner one."""

    def __init__(self, rule: Law, n: np.ndarray, s: np.ndarray, weight: np.ndarray, memory: float):
        self.rule, self.n, self.s, self.weight, self.memory = rule, n, s, weight, memory
        self._target = _whiten(s, weight, memory)
        self.low, self.high = (rule.scale(v) for v in rule.limits(n)) if rule.inner else (0.0, 0.0)

    def solve(self, x: float) -> tuple[float, np.ndarray, np.ndarray]:
        """Sum of squares, linear parameters and the diagonal of their inverse normal matrix at scaled inner `x`."""
        matrix = _whiten(self.rule.columns(self.n, self.rule.unscale(x)), self.weight, self.memory)
        size = np.sqrt(np.einsum("ij,ij->j", matrix, matrix))
        matrix = matrix / size  # columns of length 1: the normal equations are then good enough
        inverse = np.linalg.inv(matrix.T @ matrix + 1e-14 * np.eye(len(size)))
        linear = inverse @ (matrix.T @ self._target)
        residual = self._target - matrix @ linear
        return float(residual @ residual), linear / size, np.diag(inverse) / size**2

    def sum(self, x: float) -> float:
        """Sum of squares at `x`."""
        return self.solve(x)[0]

    def search(self) -> float:
        """The best `x`."""
        if self.rule.inner is None:
            return 0.0
        grid = np.linspace(self.low, self.high, 21)
        sums = [self.sum(x) for x in grid]
        k = int(np.argmin(sums))
        best = minimize_scalar(
            self.sum, method="bounded", bounds=(grid[max(k - 1, 0)], grid[min(k + 1, 20)]), options={"xatol": 1e-7}
        )
        return float(best.x if best.fun <= sums[k] else grid[k])

    def at_memory(self, memory: float) -> _Problem:
        """The same curve at another memory."""
        return _Problem(self.rule, self.n, self.s, self.weight, memory)

    def search_near(self, x: float) -> float:
        """The best `x`, no farther than a fifth of the range from this."""
        if self.rule.inner is None:
            return 0.0
        reach = (self.high - self.low) / 5
        ends = max(self.low, x - reach), min(self.high, x + reach)
        return float(minimize_scalar(self.sum, method="bounded", bounds=ends, options={"xatol": 1e-5}).x)

    def information(self, x: float) -> float:
        """Logarithm of the determinant of the normal matrix at `x`, all parameters, in units free of the memory."""
        columns = self.rule.columns(self.n, self.rule.unscale(x))
        if self.rule.inner is not None:
            step = 1e-5
            ahead, behind = (self.rule.columns(self.n, self.rule.unscale(x + d)) for d in (step, -step))
            columns = np.column_stack([columns, (ahead - behind) @ self.solve(x)[1] / (2 * step)])
        size = np.sqrt(np.einsum("ij,ij->j", columns, columns))
        white = _whiten(columns / np.where(size > 0, size, 1), self.weight, self.memory)
        return float(np.linalg.slogdet(white.T @ white + 1e-14 * np.eye(len(size)))[1])

    def accepted(self, x: float, allowed: float) -> tuple[float, float]:
        """The range about `x` in which the sum of squares stays below `allowed`."""
        if self.rule.inner is None:
            return 0.0, 0.0
        ends = []
        for limit in (self.low, self.high):
            crosses = self.sum(limit) > allowed > self.sum(x)
            ends.append(brentq(lambda y: self.sum(y) - allowed, *sorted((x, limit)), xtol=1e-6) if crosses else limit)
        return ends[0], ends[1]

    def intervals(self, x: float, allowed: float) -> dict[str, tuple[float, float]]:
        """Range of each parameter over all that keep the sum of squares below `allowed`."""
        low, high = self.accepted(x, allowed)
        below, above = [], []
        for y in (x, *np.linspace(low, high, 25)) if self.rule.inner else (x,):
            total, linear, inverse = self.solve(y)
            reach = np.sqrt(inverse * max(allowed - total, 0.0))
            below.append(linear - reach)
            above.append(linear + reach)
        names = [p for p in self.rule.parameters if p != self.rule.inner]
        ranges = dict(zip(names, zip(np.min(below, axis=0), np.max(above, axis=0), strict=True), strict=True))
        if self.rule.inner:
            ranges[self.rule.inner] = (self.rule.unscale(low), self.rule.unscale(high))
        return ranges


@dataclass(frozen=True)
class _Fitted:
    """The most likely parameters of one law, before anybody asks how certain they are."""

    problem: _Problem
    x: float
    unit: float
    scatter: str

    @property
    def bic(self) -> float:
        """Bayesian information criterion; the scatter's unknowns are its size and, where there is any, its memory."""
        problem, count = self.problem, len(self.problem.n)
        likelihood = (  # -2 log
            count * (np.log(2 * np.pi * max(problem.sum(self.x) / count, 1e-300)) + 1)
            - 2 * np.sum(np.log(problem.weight))
            - np.log(1 - problem.memory**2)
            + 2 * count * np.log(self.unit)
        )
        return float(likelihood + (len(problem.rule.parameters) + 1 + (problem.memory > 0)) * np.log(count))

    def intervals(self, level: float) -> dict[str, tuple[float, float]]:
        """Range of each parameter, in the problem's units, over all memories that are likely enough."""
        degrees = len(self.problem.n) - len(self.problem.rule.parameters)
        reach = degrees * np.log1p(student.ppf(0.5 + level / 2, degrees) ** 2 / degrees)

        def likelihood(problem: _Problem, x: float) -> tuple[float, float]:
            """-2 log of the restricted likelihood, degrees log(sum of squares) + rest, and the rest."""
            rest = problem.information(x) - np.log(1 - problem.memory**2)
            return degrees * np.log(max(problem.sum(x), 1e-300)) + rest, rest

        found, least = [], likelihood(self.problem, self.x)[0]
        for memory in _likely_memories(self.problem.memory, len(self.problem.n)):
            problem = self.problem.at_memory(memory)
            if likelihood(problem, self.x)[0] > least + reach + 6:
                continue  # a better x would not make up for that
            x = problem.search_near(self.x)
            found.append((*likelihood(problem, x), problem, x))
        least = min(value for value, *_ in found)
        ranges = [
            problem.intervals(x, float(np.exp((least + reach - rest) / degrees)))
            for value, rest, problem, x in found
            if value <= least + reach
        ]
        return {p: (min(r[p][0] for r in ranges), max(r[p][1] for r in ranges)) for p in ranges[0]}

    def describe(self, level: float) -> Fit:
        """The fit in metres and cycles, with its confidence intervals."""
        problem, x, rule = self.problem, self.x, self.problem.rule
        total, linear, _ = problem.solve(x)
        ranges = self.intervals(level)
        values = dict(zip((p for p in rule.parameters if p != rule.inner), linear, strict=True))
        if rule.inner:
            values[rule.inner] = rule.unscale(x)
        sized = {p: 1.0 if p == rule.inner else self.unit for p in sorted(values)}
        deviation = np.sqrt(total / (len(problem.n) - len(rule.parameters)))
        return Fit(
            rule.name,
            {p: float(values[p] * f) for p, f in sized.items()},
            {p: (float(ranges[p][0] * f), float(ranges[p][1] * f)) for p, f in sized.items()},
            self.scatter,
            float(deviation * (self.unit if self.scatter == "constant" else 1.0)),
            problem.memory,
            self.bic,
            (int(problem.n[0]), int(problem.n[-1])),
            bool(rule.inner) and not problem.low + 1e-3 < x < problem.high - 1e-3,
        )


# ---------------------------------------------------------------------- the choice between them


@dataclass(frozen=True)
class Choice:
    """All laws fitted to one curve, and what follows."""

    best: str | None
    """Name of the law with the least BIC; None where the curve is too short or damaged."""
    fits: dict[str, Fit] = field(default_factory=dict)
    """The better of both kinds of scatter for each law."""
    differences: dict[str, float] = field(default_factory=dict)
    """BIC of each law minus the least: above 6 a law is strongly disfavoured, above 10 very strongly."""
    exponential_start: str = "undecided"
    """"yes", "no" or "undecided"."""
    reason: str = ""
    """One sentence for people."""


def choose(cycles: Sequence[float], settlements: Sequence[float], level: float = 0.95) -> Choice:
    """Fit all laws to `settlements` (m) after `cycles` and choose by BIC; rows with nan are left out."""
    n, s = np.asarray(cycles, dtype=float), np.asarray(settlements, dtype=float)
    usable = np.isfinite(n) & np.isfinite(s) & (n >= 1)
    n, first = np.unique(n[usable], return_index=True)
    s = s[usable][first]
    if len(n) < LEAST_CYCLES:
        return Choice(
            None, reason=f"{len(n)} cycles are too few to tell the laws apart; it takes at least {LEAST_CYCLES}"
        )
    if np.ptp(s) == 0:
        return Choice(None, reason="the settlement does not change")
    return _chosen(tuple(n), tuple(s), level)


@functools.lru_cache(256)
def _chosen(n: tuple[float, ...], s: tuple[float, ...], level: float) -> Choice:
    """Cached, because several tables and claims ask for the same curve and the fits take their time."""
    n, s, fits = np.array(n), np.array(s), {}
    for law in CHOICES:
        kinds = [_best(law, n, s, scatter) for scatter in ("constant", "proportional")]
        fits[law] = min(kinds, key=lambda f: f.bic).describe(level)
    best = min(fits, key=lambda law: fits[law].bic)
    differences = {law: f.bic - fits[best].bic for law, f in fits.items()}
    return Choice(best, fits, differences, *_verdict(best, fits, differences))


def _verdict(best: str, fits: dict[str, Fit], differences: dict[str, float]) -> tuple[str, str]:
    exponential = fits["exponential"]
    rival = min((law for law in differences if law != "exponential"), key=differences.get)
    first, last = exponential.cycles
    if best != "exponential":
        if differences["exponential"] < STRONG:
            return "undecided", (
                f"S = {LAWS[best].formula} is best, but a start by exponential is hardly worse "
                f"(BIC difference {differences['exponential']:.1f} over cycles {first} to {last})"
            )
        return "no", (
            f"S = {LAWS[best].formula} describes cycles {first} to {last} better than an exponential start "
            f"(BIC difference {differences['exponential']:.1f})"
        )
    if differences[rival] < STRONG:
        return "undecided", (
            f"an exponential start is best, but S = {LAWS[rival].formula} is hardly worse "
            f"(BIC difference {differences[rival]:.1f} over cycles {first} to {last})"
        )
    b, c = exponential.values["b"], exponential.values["c"]
    if c > last / 3:
        return "undecided", f"the curve bends, but the scale c = {c:.3g} cycles is not short against {last} cycles"
    if c < 1:
        return "undecided", f"the start is over within the first cycle (c = {c:.3g} cycles): a step, not a curve"
    if b < 0:
        return (
            "no",
            f"the exponential part is negative (b = {1e3 * b:.3g} mm): settlement starts slower than it goes on",
        )
    if exponential.intervals["b"][0] <= 0:
        return "undecided", f"the exponential part b = {1e3 * b:.3g} mm is not distinguishable from 0"
    return "yes", (
        f"an exponential start of {1e3 * b:.3g} mm with scale c = {c:.3g} cycles describes cycles {first} to {last} "
        f"better than S = {LAWS[rival].formula} (BIC difference {differences[rival]:.1f})"
    )
