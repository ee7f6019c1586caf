"""Many placements climbed at once: exact matchings and reweighted least squares in turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fidmap.geometry import ComplexArray
from fidmap.model import FloatArray
from fidmap.register.landscape import BoolArray, Landscape
from fidmap.register.near import Matcher, NearPairs
from fidmap.register.prices import matching

SOFTEST = 1e-6
# share of its value that a round of a climb must gain to be followed by another
LEAST_GAIN = 1e-6


@dataclass(frozen=True, eq=False)
class _Pairs:
    """For each of K placements and R rows a fiducial and a barrel part (K, R), and whether there is such a pair."""

    fiducials: ComplexArray
    barrels: ComplexArray
    real: BoolArray

    def distance(self, placements: FloatArray) -> FloatArray:
        """(K, R) metres between the two of every pair, 0 where there is none."""
        turned = placements[:, 3:] * np.exp(1j * placements[:, :1])
        moved = turned * self.barrels + (placements[:, 1:2] + 1j * placements[:, 2:3])
        return np.asarray(np.abs(moved - self.fiducials) * self.real)


def attract(land: Landscape, matcher: Matcher, placements: FloatArray, rounds: int) -> tuple[FloatArray, FloatArray]:
    """Draw placements (K, 4) towards maxima by every row's best partner: (K, 4), and (K,) what they may be worth."""
    best, worth = placements, np.full(len(placements), -1.0)
    softness = 0.25 * land.problem.d_max
    for _ in range(rounds):
        near = matcher.near(as_boxes(placements))
        close = 1 - near.distance / land.problem.d_max
        rows = np.zeros((len(placements), matcher.rows))
        np.maximum.at(rows, (near.box, near.row), close)
        columns = np.zeros((len(placements), matcher.columns))
        np.maximum.at(columns, (near.box, near.column), close)
        now = np.minimum(rows.sum(axis=1), columns.sum(axis=1))
        better = now > worth
        best, worth = np.where(better[:, None], placements, best), np.maximum(now, worth)
        pairs = _pairs(land, matcher, near, (close >= rows[near.box, near.row]) & (close > 0), len(placements))
        placements = _fitted(land, placements, pairs, pairs.real / np.hypot(pairs.distance(placements), softness))
        softness *= 0.6
    return best, worth


def ascend(
    land: Landscape, matcher: Matcher, placements: FloatArray, rounds: int, steps: int, decay: float
) -> tuple[FloatArray, FloatArray]:
    """Climb from placements (K, 4) to local maxima of the continuous score: (K, 4) and (K,) their values.

    In turn the exact matching and `steps` reweighted fits of its pairs, whose smoothing of d near 0 decays; until a
    round gains next to nothing.
    """
    best, worth = placements, np.full(len(placements), -1.0)
    softness = 0.1 * land.problem.d_max
    for _ in range(rounds):
        near = matcher.near(as_boxes(placements))
        close = 1 - near.distance / land.problem.d_max
        mate = matching(matcher, near, close, len(placements))
        now = np.bincount(near.box[mate], close[mate], len(placements))
        better = now > worth
        gain = float((now / np.maximum(worth, 1e-9)).max(initial=0.0)) - 1
        best, worth = np.where(better[:, None], placements, best), np.maximum(now, worth)
        if gain < LEAST_GAIN:
            break
        pairs = _pairs(land, matcher, near, mate, len(placements))
        placements, softness = _refitted(land, best, pairs, steps, softness, decay)
    return best, worth


def _pairs(land: Landscape, matcher: Matcher, near: NearPairs, chosen: BoolArray, count: int) -> _Pairs:
    """The chosen (E,) of the near pairs of `count` placements, by row."""
    at = near.box[chosen], near.row[chosen]
    fiducials, barrels = np.zeros((2, count, matcher.rows), complex)
    real = np.zeros((count, matcher.rows), bool)
    fiducials[at], barrels[at], real[at] = (
        land.fiducials[near.fiducial[chosen]],
        land.barrels[near.barrel[chosen]],
        True,
    )
    kept = real.any(axis=0)
    return _Pairs(fiducials[:, kept], barrels[:, kept], real[:, kept])


def _refitted(
    land: Landscape, placements: FloatArray, pairs: _Pairs, steps: int, softness: float, decay: float
) -> tuple[FloatArray, float]:
    """Reweighted fits of fixed pairs; the best of each placement's, and the smoothing that is left."""
    d_max = land.problem.d_max
    best, worth = placements, np.full(len(placements), -np.inf)
    for _ in range(steps + 1):
        distance = pairs.distance(placements)
        near = pairs.real & (distance < d_max)
        now = (near * (1 - distance / d_max)).sum(axis=1)
        better = now > worth
        best, worth = np.where(better[:, None], placements, best), np.maximum(now, worth)
        placements = _fitted(land, placements, pairs, near / np.hypot(distance, softness) + 1e-9 * pairs.real)
        softness = max(SOFTEST, softness * decay)
    return best, softness


def _fitted(land: Landscape, placements: FloatArray, pairs: _Pairs, weight: FloatArray) -> FloatArray:
    """One weighted least squares fit of every placement, weights (K, R) (closed form in the plane, Umeyama 1991)."""
    total = np.maximum(weight.sum(axis=1), 1e-12)
    heavy = weight * pairs.barrels
    p_mean = (weight * pairs.fiducials).sum(axis=1) / total
    q_mean = heavy.sum(axis=1) / total
    moment = (heavy.conj() * pairs.fiducials).sum(axis=1) - total * q_mean.conj() * p_mean
    size = np.abs(moment)
    turn = np.where(size > 1e-9, moment / np.maximum(size, 1e-9), np.exp(1j * placements[:, 0]))
    scale = placements[:, 3]
    if land.problem.scale_range[0] < land.problem.scale_range[1]:
        spread = (heavy.conj() * pairs.barrels).real.sum(axis=1) - total * np.abs(q_mean) ** 2
        scale = np.clip(size / np.maximum(spread, 1e-9), *land.problem.scale_range)
    shift = p_mean - scale * turn * q_mean
    fitted = np.stack([np.angle(turn), shift.real, shift.imag, scale], axis=1)
    return land.limited(np.where((total > 1e-9)[:, None], fitted, placements))


def as_boxes(placements: FloatArray) -> FloatArray:
    """Placements (K, 4) as boxes (K, 8) without extent."""
    return np.concatenate([placements, np.zeros_like(placements)], axis=1)
