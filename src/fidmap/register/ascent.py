"""Many placements climbed at once: exact matchings and reweighted least squares in turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fidmap.geometry import ComplexArray
from fidmap.model import FloatArray
from fidmap.register.landscape import IntArray, Landscape
from fidmap.register.near import Matcher
from fidmap.register.prices import matching

SOFTEST = 1e-6


@dataclass(frozen=True, eq=False)
class _Pairs:
    """E pairs of K placements: placement, fiducial part, barrel part; weight says which pairs count."""

    placement: IntArray
    fiducials: ComplexArray
    barrels: ComplexArray
    count: int

    def sums(self, values: ComplexArray | FloatArray) -> ComplexArray:
        """(K,) sums of values (E,) of every placement."""
        real = np.bincount(self.placement, values.real, self.count)
        return real + 1j * np.bincount(self.placement, values.imag, self.count)


def attract(land: Landscape, matcher: Matcher, placements: FloatArray, rounds: int) -> tuple[FloatArray, FloatArray]:
    """Draw placements (K, 4) towards maxima by every row's best partner: (K, 4), and (K,) what they may be worth."""
    best, worth = placements, np.full(len(placements), -1.0)
    softness = 0.25 * land.problem.d_max
    for _ in range(rounds):
        pairs = matcher.near(as_boxes(placements))
        close = 1 - pairs.distance / land.problem.d_max
        rows = np.zeros((len(placements), matcher.rows))
        np.maximum.at(rows, (pairs.box, pairs.row), close)
        columns = np.zeros((len(placements), matcher.columns))
        np.maximum.at(columns, (pairs.box, pairs.column), close)
        now = np.minimum(rows.sum(axis=1), columns.sum(axis=1))
        better = now > worth
        best, worth = np.where(better[:, None], placements, best), np.maximum(now, worth)
        chosen = pairs.take((close >= rows[pairs.box, pairs.row]) & (close > 0))
        kept = _Pairs(chosen.box, land.fiducials[chosen.fiducial], land.barrels[chosen.barrel], len(placements))
        placements = _fitted(land, placements, kept, 1 / np.hypot(chosen.distance, softness))
        softness *= 0.6
    return best, worth


def ascend(
    land: Landscape, matcher: Matcher, placements: FloatArray, rounds: int, steps: int, decay: float
) -> tuple[FloatArray, FloatArray]:
    """Climb from placements (K, 4) to local maxima of the continuous score: (K, 4) and (K,) their values.

    In turn the exact matching and `steps` reweighted fits of its pairs, whose smoothing of d near 0 decays.
    """
    best, worth = placements, np.full(len(placements), -1.0)
    softness = 0.1 * land.problem.d_max
    for _ in range(rounds):
        pairs = matcher.near(as_boxes(placements))
        close = 1 - pairs.distance / land.problem.d_max
        mate = matching(matcher, pairs, close, len(placements))
        now = np.bincount(pairs.box[mate], close[mate], len(placements))
        better = now > worth
        best, worth = np.where(better[:, None], placements, best), np.maximum(now, worth)
        chosen = pairs.take(mate)
        kept = _Pairs(chosen.box, land.fiducials[chosen.fiducial], land.barrels[chosen.barrel], len(placements))
        placements, softness = _refitted(land, best, kept, steps, softness, decay)
    return best, worth


def _refitted(
    land: Landscape, placements: FloatArray, pairs: _Pairs, steps: int, softness: float, decay: float
) -> tuple[FloatArray, float]:
    """Reweighted fits of fixed pairs; the best of each placement's, and the smoothing that is left."""
    best, worth = placements, np.full(len(placements), -np.inf)
    for _ in range(steps + 1):
        distance = np.abs(_moved(placements, pairs) - pairs.fiducials)
        near = distance < land.problem.d_max
        now = np.bincount(pairs.placement, np.where(near, 1 - distance / land.problem.d_max, 0.0), pairs.count)
        better = now > worth
        best, worth = np.where(better[:, None], placements, best), np.maximum(now, worth)
        placements = _fitted(land, placements, pairs, near / np.hypot(distance, softness) + 1e-9)
        softness = max(SOFTEST, softness * decay)
    return best, softness


def _moved(placements: FloatArray, pairs: _Pairs) -> ComplexArray:
    turned = (placements[:, 3] * np.exp(1j * placements[:, 0]))[pairs.placement]
    return np.asarray(turned * pairs.barrels + (placements[:, 1] + 1j * placements[:, 2])[pairs.placement])


def _fitted(land: Landscape, placements: FloatArray, pairs: _Pairs, weight: FloatArray) -> FloatArray:
    """One weighted least squares fit of every placement (closed form in the plane, Umeyama 1991)."""
    total = np.maximum(np.bincount(pairs.placement, weight, pairs.count), 1e-12)
    p_mean, q_mean = (pairs.sums(weight * points) / total for points in (pairs.fiducials, pairs.barrels))
    arms = pairs.barrels - q_mean[pairs.placement]
    moment = pairs.sums(weight * arms.conj() * pairs.fiducials)
    size = np.abs(moment)
    turn = np.where(size > 1e-9, moment / np.maximum(size, 1e-9), np.exp(1j * placements[:, 0]))
    scale = placements[:, 3]
    if land.problem.scale_range[0] < land.problem.scale_range[1]:
        spread = np.maximum(np.bincount(pairs.placement, weight * np.abs(arms) ** 2, pairs.count), 1e-9)
        scale = np.clip(size / spread, *land.problem.scale_range)
    shift = p_mean - scale * turn * q_mean
    fitted = np.stack([np.angle(turn), shift.real, shift.imag, scale], axis=1)
    return land.limited(np.where((total > 1e-9)[:, None], fitted, placements))


def as_boxes(placements: FloatArray) -> FloatArray:
    """Placements (K, 4) as boxes (K, 8) without extent."""
    return np.concatenate([placements, np.zeros_like(placements)], axis=1)
