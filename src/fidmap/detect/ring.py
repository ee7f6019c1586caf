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
Labels = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Ring:
    """What A angles around M centres show, each (M, A).

    edge: distance of the drawn outer edge (occupied inside, free outside) from where a ring of the radius has
    it, in cells, NaN where there is none near the ring. wall: an obstacle leaves the ring outwards.
    inner: occupied share inside of the ring. hollow: free share inside. outer: free share just outside.
    """

    edge: FloatArray
    wall: FloatArray
    inner: FloatArray
    hollow: FloatArray
    outer: FloatArray

    def take(self, index: npt.NDArray[np.intp]) -> Ring:
        """The rings of these centres."""
        return Ring(self.edge[index], self.wall[index], self.inner[index], self.hollow[index], self.outer[index])


class RingSampler:
    """Looks around centres on one map; keeps the map padded so that no look-up needs a bounds check."""

    def __init__(self, labels: Labels, radius: float) -> None:
        """labels: (H, W) of `Label`; radius in cells."""
        self.radius = radius
        self.angles = int(np.clip(16 * np.ceil(2 * np.pi * (radius + 2) / 0.8 / 16), 64, 256))
        self.theta: FloatArray = np.linspace(0, 2 * np.pi, self.angles, endpoint=False)
        self.directions: FloatArray = np.stack([np.sin(self.theta), np.cos(self.theta)], axis=1)
        self.near = np.arange(-min(NEAR, radius - 1.0), NEAR + 0.01, STEP)
        self.deep = -radius * np.array([0.75, 0.6, 0.45, 0.3])
        self.far = np.maximum(2.0, radius * np.array([0.15, 0.3, 0.45, 0.6]) + [0, 0.5, 1.0, 1.5])
        self.pad = int(1.7 * radius) + 8
        self.labels = cv2.copyMakeBorder(
            labels, self.pad, self.pad, self.pad, self.pad, cv2.BORDER_CONSTANT, value=[int(Label.UNKNOWN)]
        )

    def look(self, centres: FloatArray) -> Ring:
        """Sample the rings of (M, 2) centres: about 25 look-ups per angle."""
        count = len(self.near)
        radii = self.radius + np.concatenate([self.near, self.deep, self.far])
        offsets = self.directions[:, None, :] * radii[None, :, None] + self.pad
        index = (centres[:, None, None, :] + offsets).astype(np.int32)
        height, width = self.labels.shape
        np.clip(index[..., 0], 0, height - 1, out=index[..., 0])
        np.clip(index[..., 1], 0, width - 1, out=index[..., 1])
        samples = self.labels[index[..., 0], index[..., 1]]
        occupied, free = samples == Label.OCCUPIED, samples == Label.FREE
        deep, far = slice(count, count + len(self.deep)), slice(count + len(self.deep), None)
        return Ring(
            edge=self._edge(occupied[..., :count], free[..., :count]),
            wall=occupied[..., far].mean(axis=2),
            inner=occupied[..., deep].mean(axis=2),
            hollow=free[..., deep].mean(axis=2),
            outer=free[..., far].mean(axis=2),
        )

    def _edge(self, occupied: Mask, free: Mask) -> FloatArray:
        """Where an obstacle with free space outside of it (within two cells) ends nearest to the ring."""
        ends = occupied[..., :-4] & ~occupied[..., 1:-3]
        beyond = free[..., 1:-3] | free[..., 2:-2] | free[..., 3:-1] | free[..., 4:]
        distance = self.near[:-4] + STEP / 2 - EDGE
        cost = np.where(ends & beyond, np.abs(distance), np.inf)
        best = cost.argmin(axis=2)
        return np.where(np.isfinite(cost.min(axis=2)), distance[best], np.nan)
