"""What errors truly were, given noisy ones: a mean of capped losses with its uncertainty.

Noise makes distances longer: the mean of measured errors says too much, most of all where a map is better than its
survey. So the spread of the true errors is learned from all of them at once (empirical Bayes: Efron 2014, 'Two
modeling strategies for empirical Bayes estimation'), over a grid of spreads and of shares of far greater errors, and
every combination counts by how well it explains what was measured. Nothing is drawn at random.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import i0e, ndtr

from fidmap.model import FloatArray

# spreads from a share of the noise to D; shares of D and of items for errors out of the ordinary
SPREADS, OFFSET_SPREADS = 32, 18
LEAST_SPREAD = 1 / 16
OFFSETS = (0.5, 1.0, 1.5, 2.0, 3.0, 4.5)
WIDE = (1 / 16, 1 / 8, 1 / 4, 1 / 2)
WIDE_SHARES = (0.0, 0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5)
FAR = 5.0  # standard deviations beyond which noise does not reach
STEPS = 400
LEAST_WEIGHT = 1e-4
# half the 95 % quantile of chi-square with one degree of freedom: where 'no error at all' is not refuted
UNREFUTED = 1.92


@dataclass(frozen=True, eq=False)
class Nodes:
    """Where true errors are looked at: places (G,) in metres from 0 up, and the ends of their cells (G + 1,)."""

    at: FloatArray
    ends: FloatArray

    @property
    def mirrored(self) -> Nodes:
        """The same for signed errors."""
        return Nodes(np.concatenate([-self.at[:0:-1], self.at]), np.concatenate([-self.ends[:0:-1], self.ends[1:]]))


@dataclass(frozen=True, eq=False)
class Beliefs:
    """Distributions of the true error over nodes, one a row.

    ordinary: (M, G), the first without any error. chance: (M,) of each beforehand. wide: (V, G), for items that are out
    of the ordinary.
    """

    ordinary: FloatArray
    chance: FloatArray
    wide: FloatArray


def families(some: Sequence[tuple[FloatArray, Sequence[FloatArray]]], wide: Sequence[FloatArray]) -> Beliefs:
    """Beliefs of several families (spreads, distributions), equally probable beforehand.

    Within one every spread is as probable as another (Gelman 2006, 'Prior distributions for variance parameters in
    hierarchical models'); they stand at equal ratios.
    """
    known = [(np.asarray(spreads), rows) for spreads, rows in some if len(rows)]
    chance = np.concatenate([spreads / (len(known) * spreads.sum()) for spreads, _ in known])
    return Beliefs(np.array([row for _, rows in known for row in rows]), chance, np.array(wide))


@dataclass(frozen=True, eq=False)
class Mixture:
    """A mean loss as a mixture of normals: weights, means, deviations (Q,).

    evidence: log of how well all of them together explain what was measured. from_zero: whether no error at all is
    possible. grain: the least step that the mean can make, to which its bounds are rounded outwards.
    """

    weight: FloatArray
    mean: FloatArray
    deviation: FloatArray
    evidence: float
    from_zero: bool
    grain: float

    def quantile(self, share: float) -> float:
        """By bisection; a mean of losses lies in [0, 1]."""
        if float(self.weight @ ndtr(-self.mean / self.deviation)) >= share:
            return 0.0
        low, high = 0.0, 1.0
        for _ in range(26):
            middle = (low + high) / 2
            below = float(self.weight @ ndtr((middle - self.mean) / self.deviation))
            low, high = (middle, high) if below < share else (low, middle)
        return (low + high) / 2

    def span(self) -> tuple[float, float]:
        """The 95 % interval of the mean loss, from 0 where measured errors are no larger than noise alone makes."""
        low = 0.0 if self.from_zero else self.quantile(0.025) - self.grain
        return max(0.0, low), min(1.0, self.quantile(0.975) + self.grain)


def joined(mixtures: Sequence[Mixture]) -> Mixture:
    """Several mixtures, alike beforehand, by their evidence."""
    weight = np.exp(np.array([one.evidence for one in mixtures]) - max(one.evidence for one in mixtures))
    weight /= weight.sum()
    return Mixture(
        np.concatenate([w * one.weight for w, one in zip(weight, mixtures, strict=True)]),
        np.concatenate([one.mean for one in mixtures]),
        np.concatenate([one.deviation for one in mixtures]),
        mixtures[0].evidence,
        any(one.from_zero for one in mixtures),
        mixtures[0].grain,
    )


def nodes(observed: FloatArray, sigma: FloatArray, d_max: float) -> Nodes:
    """Nodes for magnitudes: dense below the least noise, up to what noise leaves possible."""
    reach = FAR * float(sigma.max())
    top = min(float(observed.max()), d_max + reach) + reach
    fine = max(float(sigma.min()), 3 * top / STEPS)
    at = np.concatenate([np.arange(16) * fine / 16, np.arange(fine, top + fine / 3, max(fine / 3, top / STEPS))])
    ends = np.concatenate([[0.0], (at[1:] + at[:-1]) / 2, [2 * at[-1] - at[-2]]])
    return Nodes(at, ends)


def rice(observed: FloatArray, sigma: FloatArray, true: FloatArray) -> FloatArray:
    """Likelihood of lengths (Rice 1945): `true` + noise of sigma per axis is `observed` long; broadcasts."""
    return np.asarray(np.exp(-(((observed - true) / sigma) ** 2) / 2) * i0e(observed * true / sigma**2))


def beliefs_about_positions(grid: Nodes, sigma: float, d_max: float) -> Beliefs:
    """Lengths of errors in the plane: normal about zero (Rayleigh), or about a common offset (Rice)."""
    spreads = _spreads(sigma, d_max)
    about_zero = [_no_error(grid), *(_rayleigh(grid, s) for s in spreads)]
    pairs = [(s, c * s) for s in np.geomspace(sigma / 3, d_max / 2, OFFSET_SPREADS) for c in OFFSETS if c * s < d_max]
    about_offset = [rice(grid.at, s, offset) * grid.at / s**2 * np.diff(grid.ends) for s, offset in pairs]
    return families(
        [(np.append(spreads[0], spreads), about_zero), (np.array([s for s, _ in pairs]), about_offset)],
        [_rayleigh(grid, x * d_max) for x in WIDE],
    )


def beliefs_about_distances(grid: Nodes, sigma: float, d_max: float, length: float | None) -> Beliefs:
    """Errors of distances, signed: normal about zero, or about an offset that all of them share.

    Short ones of a common `length` become longer by errors in the plane, too (Rice).
    """
    spreads, width = _spreads(sigma, d_max), np.diff(grid.ends)
    about_zero = [_no_error(grid), *(_normal(grid, 0.0, s) for s in spreads)]
    pairs = [
        (s, c * s) for s in np.geomspace(sigma / 3, d_max / 2, OFFSET_SPREADS) for c in OFFSETS[:4] if c * s < d_max
    ]
    about_offset = [_normal(grid, sign * offset, s) for s, offset in pairs for sign in (-1, 1)]
    some = [(np.append(spreads[0], spreads), about_zero), (np.repeat([s for s, _ in pairs], 2), about_offset)]
    if length is not None:
        drawn, far = np.maximum(grid.at + length, 0), spreads[SPREADS // 3 :]
        some.append((far, [rice(drawn, s, np.array(length)) * drawn / s**2 * width for s in far]))
    return families(some, [_normal(grid, 0.0, x * d_max) for x in WIDE])


def mean_loss(likelihood: FloatArray, beliefs: Beliefs, loss: FloatArray, share: FloatArray, widen: float) -> Mixture:
    """The weighted mean of K losses.

    Args:
        likelihood: (K, G) of every item at every node.
        beliefs: what the errors may be spread like.
        loss: (G,) of an error at each node.
        share: (K,) weights of the items.
        widen: factor of the variance, for items that share their noise.
    """
    sums = [likelihood @ (rows * f).T for rows in (beliefs.ordinary, beliefs.wide) for f in (1.0, loss, loss**2)]
    (plain, plain1, plain2), (wide, wide1, wide2) = sums[:3], sums[3:]
    logs, chances, means, variances = [], [], [], []
    likely = 1 / 2, 1 / (2 * len(beliefs.wide) * (len(WIDE_SHARES) - 1))
    for k in range(len(beliefs.wide)):
        column = slice(k, k + 1)
        for p in WIDE_SHARES[k > 0 :]:
            total = (1 - p) * plain + p * wide[:, column] + 1e-300
            first = ((1 - p) * plain1 + p * wide1[:, column]) / total
            second = ((1 - p) * plain2 + p * wide2[:, column]) / total
            logs.append(np.log(total).sum(axis=0))
            chances.append(beliefs.chance * likely[p > 0])
            means.append(share @ first)
            variances.append(share**2 @ np.maximum(second - first**2, 0) * widen)
    log = np.concatenate(logs)
    weight = np.exp(log - log.max()) * np.concatenate(chances)
    evidence = float(log.max() + np.log(weight.sum()))
    kept = weight > LEAST_WEIGHT * weight.sum()
    weight, deviation = weight[kept] / weight[kept].sum(), np.sqrt(np.concatenate(variances)[kept]) + 1e-9
    steps = np.diff(np.unique(loss))
    grain = float(share.max() * steps.min()) if len(steps) else 0.0
    unrefuted = bool(log[0] > log.max() - UNREFUTED)
    return Mixture(weight, np.concatenate(means)[kept], deviation, evidence, unrefuted, grain)


def _spreads(sigma: float, d_max: float) -> FloatArray:
    return np.asarray(np.geomspace(LEAST_SPREAD * sigma, d_max, SPREADS))


def _no_error(grid: Nodes) -> FloatArray:
    return np.asarray(grid.at == 0, float)


def _rayleigh(grid: Nodes, spread: float) -> FloatArray:
    return np.asarray(-np.diff(np.exp(-((grid.ends / spread) ** 2) / 2)))


def _normal(grid: Nodes, middle: float, spread: float) -> FloatArray:
    return np.asarray(np.diff(ndtr((grid.ends - middle) / spread)))
