"""Where what stands on a ring ends: the drawn outer edge, in directions around each facing.

All lengths here are cells, all centres continuous cell coordinates (row, column), angles counter-clockwise from
the column axis, so that the direction of an angle is (sin, cos) in (row, column).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.detect.cells import pad
from fidmap.model import FloatArray, Label

STEP = 0.5
NEAR = 4.0
EDGE = 0.5
DIRECTIONS = 48
BLOCK = 64
Labels = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Edges:
    """What K centres show in D directions, each (K, D).

    place: distance of the drawn outer edge (occupied inside, free outside) from where a ring of the radius has it, 0
    where there is none near the ring; there: whether there is. thick: occupied share from the ring four cells
    inwards. sine, cosine: of the directions.
    """

    place: FloatArray
    there: Mask
    thick: FloatArray
    sine: FloatArray
    cosine: FloatArray


def edges(labels: Labels, centres: FloatArray, facings: FloatArray, reach: FloatArray, radius: float) -> Edges:
    """Look along 48 directions within `reach` (K,) of each facing, 17 places in each."""
    near = np.arange(-min(NEAR, radius - 1.0), NEAR + 0.01, STEP)
    relative = reach[:, None] * (np.arange(DIRECTIONS) + 0.5 - DIRECTIONS / 2) / (DIRECTIONS / 2)
    theta = facings[:, None] + relative
    sine, cosine = np.sin(theta), np.cos(theta)
    width = int(radius + NEAR) + 2
    padded = pad(labels, width)
    middle = np.clip(centres, 0, labels.shape) + width
    blocks = [slice(k, k + BLOCK) for k in range(0, max(1, len(centres)), BLOCK)]
    found = [_look(padded, middle[b], sine[b], cosine[b], radius, near) for b in blocks]
    place, there, thick = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return Edges(place, there, thick, sine, cosine)


def _look(
    padded: Labels, middle: FloatArray, sine: FloatArray, cosine: FloatArray, radius: float, near: FloatArray
) -> tuple[FloatArray, Mask, FloatArray]:
    """Place, there and thick of some centres; the places looked at come first, so that each is one array."""
    steps = (radius + near).astype(np.float32)[:, None, None]
    # truncation is floor here: the padding keeps all coordinates positive
    index = (middle[:, 0, None].astype(np.float32) + sine.astype(np.float32) * steps).astype(np.int32)
    index *= padded.shape[1]
    index += (middle[:, 1, None].astype(np.float32) + cosine.astype(np.float32) * steps).astype(np.int32)
    samples = padded.reshape(-1).take(index, mode="clip")
    occupied, free = samples == Label.OCCUPIED, samples == Label.FREE
    ends = occupied[:-4] & (free[1:-3] | free[2:-2] | free[3:-1] | free[4:])
    distances = near[:-4] + STEP / 2 - EDGE
    place, there = np.zeros(ends.shape[1:]), np.zeros(ends.shape[1:], bool)
    for k in np.argsort(-np.abs(distances), kind="stable"):  # the nearest to the ring last: it stays
        place[ends[k]] = distances[k]
        there |= ends[k]
    inward = occupied[near <= 0]
    return place, there, np.asarray(inward.sum(axis=0, dtype=np.float64) / len(inward))
