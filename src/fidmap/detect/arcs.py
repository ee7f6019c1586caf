"""Which half circles stand around a candidate centre: facing, centre and ring of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.detect.ring import Ring, RingSampler
from fidmap.model import FloatArray

HALF = np.pi / 2
LEAST_SCORE = 0.25
LEAST_REFINED = 0.35
FACINGS_TRIED = 4
ROUNDS = 4


@dataclass(frozen=True)
class Arcs:
    """H hypotheses: centres (H, 2) in cells, facings (H,), and the ring seen from each centre."""

    centres: FloatArray
    facings: FloatArray
    ring: Ring

    def take(self, index: npt.NDArray[np.intp]) -> Arcs:
        """The hypotheses of these indices."""
        return Arcs(self.centres[index], self.facings[index], self.ring.take(index))


def difference(a: FloatArray, b: FloatArray) -> FloatArray:
    """Signed angle a - b in [-pi, pi); broadcasts."""
    return (a - b + np.pi) % (2 * np.pi) - np.pi


def windows(theta: FloatArray, facings: FloatArray, half: float = HALF) -> FloatArray:
    """(H, A) weight 1 where an angle lies within `half` of the facing, with a soft border of one angle."""
    away = np.abs(difference(theta, facings[..., None]))
    return np.asarray(np.clip((half - away) / (theta[1] - theta[0]) + 0.5, 0.0, 1.0))


def support(ring: Ring, tolerance: float) -> FloatArray:
    """(M, A) how well the edge stands on the ring: 1 on it, 0 at `tolerance` cells away from it."""
    away = np.abs(np.nan_to_num(ring.edge, nan=np.inf)) / tolerance
    return np.where(away < 1, 1 - np.minimum(away, 1) ** 2, 0.0)


def close_tolerance(radius: float) -> float:
    """How far, in cells, an edge may lie from the ring once the centre is known."""
    return max(1.3, 0.15 * radius)


def loose_tolerance(radius: float) -> float:
    """How far, in cells, an edge may lie from the ring while the centre is only a candidate."""
    return max(2.0, 0.25 * radius)


def hypotheses(sampler: RingSampler, candidates: FloatArray) -> Arcs:
    """The best few half circles around each candidate centre (N, 2), moved and turned to where they fit best."""
    scores = facing_scores(sampler, sampler.look(candidates), loose_tolerance(sampler.radius))
    theta = sampler.theta
    near = np.abs(difference(theta[None, :], theta[:, None])) < np.radians(50)
    centres, facings = [], []
    for _ in range(FACINGS_TRIED):
        best = scores.argmax(axis=1)
        enough = scores.max(axis=1) > LEAST_SCORE
        centres.append(candidates[enough])
        facings.append(theta[best[enough]])
        scores = np.where(near[best], -np.inf, scores)
    return refine(sampler, np.concatenate(centres), np.concatenate(facings))


def facing_scores(sampler: RingSampler, ring: Ring, tolerance: float) -> FloatArray:
    """(M, A) how well a half circle of each facing would stand.

    Its support, less the walls that leave it between its ends (a half barrel stands on a wall, none stands in it),
    and a little for walls at its ends.
    """
    count = sampler.angles
    around = windows(sampler.theta, sampler.theta)
    middle = windows(sampler.theta, sampler.theta, np.radians(70))
    # a thin wall is widened to 12 degrees, so that its weight does not depend on the size of cells
    walls = _widened(np.clip(2 * ring.wall - 1, 0, 1), round(count / 60))
    ends = _widened(walls, round(count / 45))
    at_ends = np.roll(ends, count // 4, axis=1) + np.roll(ends, -(count // 4), axis=1)
    total = around.sum(axis=1)[0]
    return np.asarray((support(ring, tolerance) @ around.T - 3 * walls @ middle.T) / total + 0.1 * at_ends)


def _widened(values: FloatArray, steps: int) -> FloatArray:
    """(M, A) the greatest value within so many angles to both sides."""
    return np.asarray(np.max([np.roll(values, k, axis=1) for k in range(-steps, steps + 1)], axis=0))


def refine(sampler: RingSampler, centres: FloatArray, facings: FloatArray) -> Arcs:
    """Move each centre so that its half's edge lies on the ring (fixed radius), and turn its facing."""
    start, ring = centres, sampler.look(centres)
    for k in range(ROUNDS):
        tolerance = (loose_tolerance if k == 0 else close_tolerance)(sampler.radius)
        weight = support(ring, tolerance) * windows(sampler.theta, facings)
        drift = centres + _shift(sampler.directions, weight, np.nan_to_num(ring.edge)) - start
        far = np.maximum(np.hypot(drift[:, 0], drift[:, 1]) / (0.4 * sampler.radius), 1.0)
        centres = start + drift / far[:, None]
        ring = sampler.look(centres)
        facings, scores = _turn(sampler.theta, facing_scores(sampler, ring, tolerance), facings)
        kept = _distinct(centres / (0.12 * sampler.radius), facings / np.radians(12), scores)
        start, centres, facings, ring = start[kept], centres[kept], facings[kept], ring.take(kept)
    return Arcs(centres, facings, ring)


def fit_all_around(sampler: RingSampler, centres: FloatArray, ring: Ring) -> tuple[FloatArray, Ring]:
    """Centres (H, 2) moved so that the edges in all directions lie on the ring, and the rings seen from there."""
    for _ in range(2):
        weight = support(ring, loose_tolerance(sampler.radius))
        centres = centres + _shift(sampler.directions, weight, np.nan_to_num(ring.edge))
        ring = sampler.look(centres)
    return centres, ring


def _distinct(centres: FloatArray, facings: FloatArray, scores: FloatArray) -> npt.NDArray[np.intp]:
    """Of hypotheses that came to the same place (within about a unit) the best one each, in their order."""
    worth = scores > LEAST_REFINED
    keys = np.column_stack([np.rint(centres), np.rint(facings)]).astype(np.int64)
    order = np.lexsort((-scores, keys[:, 2], keys[:, 1], keys[:, 0]))
    fresh = np.ones(len(order), bool)
    fresh[1:] = (np.diff(keys[order], axis=0) != 0).any(axis=1)
    return np.sort(order[fresh & worth[order]])


def _shift(directions: FloatArray, weight: FloatArray, residual: FloatArray, ridge: float = 0.5) -> FloatArray:
    """Least-squares shift (H, 2) of fixed-radius circles: residual = direction . shift."""
    products = (directions[:, :, None] * directions[:, None, :]).reshape(-1, 4)
    normal = (weight @ products).reshape(-1, 2, 2) + ridge * np.eye(2)
    right = (weight * residual) @ directions
    return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])


def _turn(
    theta: FloatArray, scores: FloatArray, facings: FloatArray, reach: float = np.radians(25)
) -> tuple[FloatArray, FloatArray]:
    """The facing near the present one whose half circle stands best (the middle of the plateau), and its score."""
    turns = difference(theta[None, :], facings[:, None])
    scores = np.where(np.abs(turns) <= reach, scores, -np.inf)
    highest = scores.max(axis=1)
    best = scores >= highest[:, None] - 0.015
    return np.asarray(facings + (best * turns).sum(axis=1) / best.sum(axis=1)), highest
