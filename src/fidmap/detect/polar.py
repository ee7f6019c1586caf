"""Polar windows of a map: what stands in every direction from a centre, from a fifth of the radius outwards.

All lengths here are cells, all centres continuous cell coordinates (row, column), angles counter-clockwise from
the column axis, so that the direction of an angle is (sin, cos) in (row, column).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fidmap.detect.cells import pad
from fidmap.model import FloatArray

Labels = npt.NDArray[np.uint8]
Windows = npt.NDArray[np.uint8]
INNERMOST, OUTERMOST = 0.2, 1.75  # radii
BLOCK = 32  # windows looked up at a time: their indices stay in the cache


class Windower:
    """Cuts polar windows out of one map; keeps the map padded so that no look-up needs a bounds check."""

    def __init__(self, labels: Labels, radius: float) -> None:
        """labels: (H, W) of `Label`; radius in cells."""
        self.radius = radius
        self.pad = int(2.5 * radius) + 8
        self.labels = pad(labels, self.pad)

    def cut(self, centres: FloatArray, facings: FloatArray, angles: int, steps: int) -> Windows:
        """(M, angles, steps) labels about (M, 2) centres: the first angle is the facing, steps go outwards."""
        radii = self.radius * np.linspace(INNERMOST, OUTERMOST, steps)
        theta = facings[:, None] + np.arange(angles) * (2 * np.pi / angles)
        limit = np.array(self.labels.shape) - 2 * self.pad
        middle = np.clip(centres, 0, limit).astype(np.float32) + self.pad
        return look(self.labels, middle, theta, radii)


def look(padded: Labels, middle: npt.NDArray[np.floating], theta: FloatArray, steps: FloatArray) -> Windows:
    """(M, A, S) labels so many steps (S,) from middles (M, 2) in directions (M, A); the padding holds them all.

    In memory the steps come first, which makes all that is done here and in the networks' first layers run along rows.
    """
    flat, away = padded.reshape(-1), steps.astype(np.float32)[:, None, None]
    angle = theta.astype(np.float32)
    sine, cosine = np.sin(angle), np.cos(angle)
    row, column = (np.repeat(start.astype(np.float32)[:, None], theta.shape[1], axis=1) for start in middle.T)
    found = np.empty((len(steps), *theta.shape), np.uint8)
    for block in (slice(k, k + BLOCK) for k in range(0, len(theta), BLOCK)):
        # truncation is floor here: the padding keeps all coordinates positive
        index = (row[block] + sine[block] * away).astype(np.int32)
        index *= padded.shape[1]
        index += (column[block] + cosine[block] * away).astype(np.int32)
        found[:, block] = flat.take(index, mode="clip")
    return found.transpose(1, 2, 0)
