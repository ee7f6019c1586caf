"""What lies along the circle of a found arc, in directions around its facing: what its centre is voted for by.

All lengths here are cells, all centres continuous cell coordinates (row, column), angles counter-clockwise from
the column axis, so that the direction of an angle is (sin, cos) in (row, column).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.detect.arcs import HALF
from fidmap.detect.cells import pad
from fidmap.detect.polar import look
from fidmap.model import FloatArray

Labels = npt.NDArray[np.uint8]
DIRECTIONS = 48
NEAR = np.arange(-4, 4.01, 0.25)  # cells from the circle: what the raster resolves
FAR = np.array([-0.6, -0.5, -0.4, -0.3, 0.3, 0.4, 0.5, 0.6])  # radii from the circle: what stands about it
BESIDE = np.radians(6)  # how far to look beyond a half circle's ends


@dataclass(frozen=True)
class Strips:
    """K arcs in D directions: labels (K, D, S) at the places near the circle and far, directions (K, D) from facing."""

    labels: Labels
    relative: FloatArray


def strips(labels: Labels, centres: FloatArray, facings: FloatArray, reach: FloatArray, radius: float) -> Strips:
    """Look along 48 directions, evenly over what each arc may cover, at 41 places in each."""
    places = np.maximum(radius + np.concatenate([NEAR, radius * FAR]), 0)
    width = int(places.max()) + 3
    padded = pad(labels, width)
    span = np.where(reach > HALF, np.pi, HALF + BESIDE)
    relative = span[:, None] * ((2 * np.arange(DIRECTIONS) + 1) / DIRECTIONS - 1)
    middle, theta = np.clip(centres, 0, labels.shape) + width, facings[:, None] + relative
    return Strips(look(padded, middle, theta, places), relative)
