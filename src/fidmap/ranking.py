"""Ranks with ties, and how far two rankings of the same maps agree. No files: values in, values out.

The paper compares its metric with a human judge by ranks (SSRR 2011, IV, Table III) and leaves the treatment
of near ties and a measure of agreement open; both are here.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from fidmap.model import FloatArray, Value

Orders = npt.NDArray[np.intp]  # (M, n): M permutations of n maps

EXACT_UP_TO = 8
DRAWS = 10_000
TIE_WITHIN = 0.5
PERMUTED_UP_TO = 200

_SLACK = 1e-9  # 0.5 points apart must not depend on how a percentage was rounded to a double


@dataclass(frozen=True, order=True)
class Rank:
    """The places that a map shares with its ties, from 1: '4-5', or '3' where it is alone."""

    first: int
    last: int

    def __str__(self) -> str:
        return str(self.first) if self.first == self.last else f"{self.first}-{self.last}"

    @property
    def middle(self) -> float:
        """The mean of the shared places, as rank correlations use it."""
        return (self.first + self.last) / 2


@dataclass(frozen=True)
class Correlation:
    """A rank correlation in [-1, 1], its 95 % interval, and the share of permutations as strong (two-sided)."""

    value: Value
    p_value: Value
    interval: tuple[float, float] | None = None


def fisher_interval(value: float, n: int, kind: Literal["spearman", "kendall"]) -> tuple[float, float] | None:
    """The 95 % interval of a rank correlation of n maps, None below five.

    tanh(atanh r -+ 1.96 c), c^2 = (1 + r^2/2) / (n - 3) for rho and 0.437 / (n - 4) for tau (Bonett, Wright 2000,
    'Sample size requirements for estimating Pearson, Kendall and Spearman correlations').
    """
    if n < 5:
        return None
    inside = min(1 - 1e-12, max(-1 + 1e-12, value))
    variance = (1 + inside**2 / 2) / (n - 3) if kind == "spearman" else 0.437 / (n - 4)
    reach = 1.959964 * math.sqrt(variance)
    return math.tanh(math.atanh(inside) - reach), math.tanh(math.atanh(inside) + reach)


@dataclass(frozen=True)
class Agreement:
    """How far two rankings agree over the `n` maps that both rank."""

    n: int
    spearman: Correlation
    kendall: Correlation


def ranks(values: Sequence[float | None], tie_within: float = TIE_WITHIN) -> tuple[Rank | None, ...]:
    """Rank values, higher is better; a value that is not computable has no rank.

    Values are sorted; neighbours at most `tie_within` apart share a rank, chained (60, 60.4, 60.8: one tie).

    Args:
        values: one per map, in the unit of `tie_within` (percent by default), None where not computable.
        tie_within: greatest distance of neighbours in a tie, >= 0.

    Returns:
        One rank per value, in the order given.
    """
    order = sorted((i for i, value in enumerate(values) if value is not None), key=lambda i: -_number(values[i]))
    result: list[Rank | None] = [None] * len(values)
    start = 0
    for end in range(1, len(order) + 1):
        alone = end == len(order)
        if alone or _number(values[order[end - 1]]) - _number(values[order[end]]) > tie_within + _SLACK:
            for i in order[start:end]:
                result[i] = Rank(start + 1, end)
            start = end
    return tuple(result)


def _number(value: float | None) -> float:
    """A value that is known to be there, and to be a number: NaN would sort anywhere."""
    if value is None or not math.isfinite(value):
        raise ValueError(f"ranks need finite numbers or None, not {value}")
    return value


def agreement(ours: Sequence[Rank | None], theirs: Sequence[Rank | None], seed: int = 0) -> Agreement:
    """Spearman's rho and Kendall's tau-b of two rankings of the same maps, each with a permutation p-value.

    The p-value is the share of permutations of one ranking whose |correlation| is at least the one found: all
    n! of them up to n = 8; else 10,000 seeded draws, the one found counted among them (Phipson, Smyth 2010).
    Over 200 maps, where draws cost much and tell little, scipy's approximations for large n take their place.

    Args:
        ours: one rank per map, None where there is none.
        theirs: the other ranking, same maps in the same order.
        seed: of the draws.

    Returns:
        Correlations over the maps that have both ranks; not computable below three, or where all tie.
    """
    pairs = [(a.middle, b.middle) for a, b in zip(ours, theirs, strict=True) if a and b]
    n = len(pairs)
    reason = None
    if n < 3:
        reason = f"{n} map{'s' * (n != 1)} ranked by both, three are needed"
    elif any(len({pair[side] for pair in pairs}) == 1 for side in (0, 1)):
        reason = "all maps share one rank"
    if reason:
        nothing = Correlation(Value(None, reason), Value(None, reason))
        return Agreement(n, nothing, nothing)
    x, y = (average_ranks(np.array(side, float)) for side in zip(*pairs, strict=True))
    if n > PERMUTED_UP_TO:
        return _large(x, y)
    order = _permutations(n, seed)
    return Agreement(n, _spearman(x, y, order), _kendall(x, y, order))


def average_ranks(values: FloatArray) -> FloatArray:
    """Ranks of values (N,) from 1, lowest first, ties sharing the mean of their places."""
    _, inverse, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    return np.asarray((last - (counts - 1) / 2)[inverse], float)


def _permutations(n: int, seed: int) -> Orders:
    """Orders (M, n): all of them for small n, else `DRAWS` seeded ones."""
    if n <= EXACT_UP_TO:
        return np.array(list(itertools.permutations(range(n))), np.intp)
    generator = np.random.default_rng(seed)
    return generator.permuted(np.tile(np.arange(n, dtype=np.intp), (DRAWS, 1)), axis=1)


def _correlation(value: float, permuted: FloatArray, n: int, kind: Literal["spearman", "kendall"]) -> Correlation:
    """Put a value beside the values (M,) of its permutations."""
    as_strong = int(np.count_nonzero(np.abs(permuted) >= abs(value) - _SLACK))
    exact = n <= EXACT_UP_TO
    p_value = as_strong / len(permuted) if exact else (as_strong + 1) / (len(permuted) + 1)
    return Correlation(Value(min(1.0, max(-1.0, value))), Value(p_value), fisher_interval(value, n, kind))


def _spearman(x: FloatArray, y: FloatArray, order: Orders) -> Correlation:
    """Pearson's correlation of average ranks, which is Spearman's rho with ties."""
    x, y = x - x.mean(), y - y.mean()
    norm = math.sqrt(float(x @ x) * float(y @ y))
    return _correlation(float(x @ y) / norm, y[order] @ x / norm, len(x), "spearman")


def _kendall(x: FloatArray, y: FloatArray, order: Orders) -> Correlation:
    """tau-b = sum sign(dx) sign(dy) / sqrt(sum sign(dx)^2 sum sign(dy)^2) over all pairs (Kendall 1945)."""
    sign_x, sign_y = (np.sign(np.subtract.outer(v, v)) for v in (x, y))
    norm = math.sqrt(float((sign_x**2).sum()) * float((sign_y**2).sum()))
    value = float((sign_x * sign_y).sum()) / norm
    batches = np.array_split(order, max(1, order.size * len(x) // 1_000_000))
    permuted = [np.tensordot(sign_y[one[:, :, None], one[:, None, :]], sign_x, 2) for one in batches]
    return _correlation(value, np.concatenate(permuted) / norm, len(x), "kendall")


def _large(x: FloatArray, y: FloatArray) -> Agreement:
    """Both correlations of many maps, with approximate p-values (t for rho, normal for tau)."""
    from scipy.stats import kendalltau, spearmanr

    rho, tau = (scipy(x, y) for scipy in (spearmanr, kendalltau))
    kinds: tuple[Literal["spearman", "kendall"], ...] = ("spearman", "kendall")
    spearman, kendall = (
        Correlation(
            Value(float(r.statistic)), Value(float(r.pvalue)), fisher_interval(float(r.statistic), len(x), kind)
        )
        for r, kind in zip((rho, tau), kinds, strict=True)
    )
    return Agreement(len(x), spearman, kendall)
