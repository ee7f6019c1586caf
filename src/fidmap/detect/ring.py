"""What stands on the ring: polar samples of the map around centres, one row of angles per centre.

All lengths here are cells, all centres continuous cell coordinates (row, column), angles counter-clockwise from
the column axis, so that the direction of an angle is (sin, cos) in (row, column).
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.model import FloatArray, Label

STEP = 0.5
NEAR = 4.0
EDGE = 0.5
BLOCK = 256
Labels = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Ring:
    """What A angles around M centres show, each (M, A).

    edge: distance of the drawn outer edge (occupied inside, free outside) from where a ring of the radius has
    it, in cells, NaN where there is none near the ring. thick: occupied share from the ring
    four cells inwards.
    """

    edge: FloatArray
    thick: FloatArray


class RingSampler:
    """Looks around centres on one map; keeps the map padded so that no look-up needs a bounds check."""

    def __init__(self, labels: Labels, radius: float) -> None:
        """labels: (H, W) of `Label`; radius in cells."""
        self.radius = radius
        self.angles = int(np.clip(16 * np.ceil(2 * np.pi * (radius + 2) / 0.8 / 16), 64, 256))
        self.theta: FloatArray = np.linspace(0, 2 * np.pi, self.angles, endpoint=False)
        self.directions: FloatArray = np.stack([np.sin(self.theta), np.cos(self.theta)], axis=1)
        self.near = np.arange(-min(NEAR, radius - 1.0), NEAR + 0.01, STEP)
        self.pad = int(1.7 * radius) + 8
        self.labels = cv2.copyMakeBorder(
            labels, self.pad, self.pad, self.pad, self.pad, cv2.BORDER_CONSTANT, value=[int(Label.UNKNOWN)]
        )
        distances = self.near[:-4] + STEP / 2 - EDGE
        self.nearest_first = np.argsort(np.abs(distances), kind="stable")
        self.edges = distances[self.nearest_first]
        radii = radius + self.near
        self.reach = [(axis[:, None] * radii + self.pad).astype(np.float32) for axis in self.directions.T]
        self.inward = int((self.near <= 0).sum())

    def look(self, centres: FloatArray) -> Ring:
        """Sample the rings of (M, 2) centres: 17 look-ups per angle, in blocks that stay in the cache."""
        blocks = [self._look(centres[k : k + BLOCK]) for k in range(0, max(1, len(centres)), BLOCK)]
        return Ring(*(np.concatenate(parts) for parts in zip(*blocks, strict=True)))

    def _look(self, centres: FloatArray) -> tuple[FloatArray, ...]:
        """The fields of `Ring` for a block of centres."""
        # truncation is floor here: the padding keeps all coordinates positive, and the sums fit into float32
        rows = (centres[:, 0].astype(np.float32)[:, None, None] + self.reach[0]).astype(np.int32)
        columns = (centres[:, 1].astype(np.float32)[:, None, None] + self.reach[1]).astype(np.int32)
        rows *= self.labels.shape[1]
        rows += columns
        samples = self.labels.reshape(-1).take(rows, mode="clip")
        occupied, free = samples == Label.OCCUPIED, samples == Label.FREE
        return (
            self._edge(occupied, free),
            share(occupied[..., : self.inward]),
        )

    def _edge(self, occupied: Mask, free: Mask) -> FloatArray:
        """Where an obstacle with free space outside of it (within two cells) ends nearest to the ring."""
        beyond = free[..., 1:-3] | free[..., 2:-2]
        beyond |= free[..., 3:-1]
        beyond |= free[..., 4:]
        beyond &= occupied[..., :-4]
        beyond &= ~occupied[..., 1:-3]
        # distances sorted by how near they are to the ring, so that the first hit is the nearest edge
        hits = beyond[..., self.nearest_first]
        first = hits.argmax(axis=2)
        there = np.take_along_axis(hits, first[..., None], axis=2)[..., 0]
        return np.where(there, self.edges[first], np.nan)


def share(mask: Mask) -> FloatArray:
    """(M, A) mean of a few samples; faster than numpy's mean over a short last axis."""
    total = mask[..., 0].astype(np.float64)
    for k in range(1, mask.shape[-1]):
        total += mask[..., k]
    return np.asarray(total / mask.shape[-1])


def support(ring: Ring, tolerance: float) -> FloatArray:
    """(M, A) how well the edge stands on the ring: 1 on it, 0 at `tolerance` cells away from it."""
    away = np.abs(np.nan_to_num(ring.edge, nan=np.inf)) / tolerance
    return np.where(away < 1, 1 - np.minimum(away, 1) ** 2, 0.0)


def shift(directions: FloatArray, weight: FloatArray, residual: FloatArray, ridge: float = 0.5) -> FloatArray:
    """Least-squares shift (H, 2) of fixed-radius circles: residual = direction . shift."""
    products = (directions[:, :, None] * directions[:, None, :]).reshape(-1, 4)
    normal = (weight @ products).reshape(-1, 2, 2) + ridge * np.eye(2)
    right = (weight * residual) @ directions
    return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])
