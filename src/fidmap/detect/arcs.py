"""Which arcs stand around a candidate centre: facing, centre and support of each half."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fidmap.detect.ring import Ring, RingSampler
from fidmap.model import FloatArray

HALF = np.pi / 2


@dataclass(frozen=True)
class Arcs:
    """H hypotheses: centres (H, 2) in cells, facings (H,), and the ring seen from each final centre."""

    centres: FloatArray
    facings: FloatArray
    ring: Ring


def difference(a: FloatArray, b: FloatArray) -> FloatArray:
    """Signed angle a - b in (-pi, pi]."""
    return (a - b + np.pi) % (2 * np.pi) - np.pi


def windows(theta: FloatArray, facings: FloatArray, half: float = HALF) -> FloatArray:
    """(H, A) weight 1 where an angle lies within `half` of the facing, with a soft border of one angle."""
    away = np.abs(difference(theta, facings[..., None]))
    return np.clip((half - away) / (theta[1] - theta[0]) + 0.5, 0.0, 1.0)


def support(ring: Ring, tolerance: float) -> FloatArray:
    """(M, A) how well the edge stands on the ring: 1 on it, 0 at `tolerance` cells away from it."""
    away = np.abs(np.nan_to_num(ring.edge, nan=np.inf)) / tolerance
    return np.where(away < 1, 1 - np.minimum(away, 1) ** 2, 0.0)


def facing_scores(theta, ring: Ring, tolerance: float) -> FloatArray:
    """(M, A) how well a half circle facing each angle would stand: its support, less the walls in it."""
    from scipy.ndimage import maximum_filter1d

    n = len(theta)
    around = windows(theta, theta)
    middle = windows(theta, theta, np.radians(70))
    walls = maximum_filter1d(
        np.clip(ring.wall - 0.5, 0, 0.5) * 2, 2 * round(n * 6 / 360) + 1, axis=1, mode="wrap"
    )
    ends = maximum_filter1d(walls, 2 * round(n * 8 / 360) + 1, axis=1, mode="wrap")
    return (
        support(ring, tolerance) @ around.T / around.sum(1)[0]
        - 3 * walls @ middle.T / around.sum(1)[0]
        + 0.1 * (np.roll(ends, n // 4, 1) + np.roll(ends, -n // 4, 1))
    )


def hypotheses(sampler: RingSampler, candidates: FloatArray, least: float = 0.25) -> Arcs:
    """Up to two half circles per candidate centre: the best facing, and the best one opposite to it."""
    tolerance = max(2.0, 0.25 * sampler.radius)
    scores = facing_scores(sampler.theta, sampler.look(candidates), tolerance)
    C = []
    F = []
    gap = np.abs(difference(sampler.theta[None, :], sampler.theta[:, None])) < np.radians(50)
    for _ in range(4):
        best = scores.argmax(1)
        v = scores.max(1)
        ok = v > least
        C.append(candidates[ok])
        F.append(sampler.theta[best[ok]])
        scores = np.where(gap[best], -9, scores)
    return refine(sampler, np.concatenate(C), np.concatenate(F))


def refine(sampler: RingSampler, centres: FloatArray, facings: FloatArray, rounds: int = 4) -> Arcs:
    """Move each centre so that its half's edge lies on the ring (fixed radius), and turn its facing."""
    start = centres
    ring = sampler.look(centres)
    for k in range(rounds):
        tolerance = max(2.0, 0.25 * sampler.radius) if k == 0 else max(1.3, 0.15 * sampler.radius)
        weight = support(ring, tolerance) * windows(sampler.theta, facings)
        centres = centres + step(sampler.directions, weight, np.nan_to_num(ring.edge))
        drift = centres - start
        far = np.maximum(np.hypot(drift[:, 0], drift[:, 1]) / (0.4 * sampler.radius), 1.0)
        centres = start + drift / far[:, None]
        ring = sampler.look(centres)
        facings = turn(sampler.theta, facing_scores(sampler.theta, ring, tolerance), facings)
    return Arcs(centres, facings, ring)


def step(directions: FloatArray, weight: FloatArray, residual: FloatArray, ridge: float = 0.5) -> FloatArray:
    """Least-squares shift (H, 2) of fixed-radius circles: residual = direction . shift."""
    products = (directions[:, :, None] * directions[:, None, :]).reshape(-1, 4)
    normal = (weight @ products).reshape(-1, 2, 2) + ridge * np.eye(2)
    right = (weight * residual) @ directions
    return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])


def turn(
    theta: FloatArray, scores: FloatArray, facings: FloatArray, reach: float = np.radians(25)
) -> FloatArray:
    """The facing near the present one whose half circle holds the most support (middle of the plateau)."""
    turns = difference(theta[None, :], facings[:, None])
    scores = np.where(np.abs(turns) <= reach, scores, -np.inf)
    best = scores >= scores.max(axis=1, keepdims=True) - 0.015
    return np.asarray(facings + (best * turns).sum(axis=1) / best.sum(axis=1))
