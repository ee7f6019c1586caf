"""What lies along the circle of a found arc, in directions around its facing: what its centre is voted for by.

All lengths here are cells, all centres continuous cell coordinates (row, column), angles counter-clockwise from
the column axis, so that the direction of an angle is (sin, cos) in (row, column).
"""

from __future__ import annotations

import math
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
BESIDE = math.radians(6)  # how far to look beyond a half circle's ends
WIDEST = 0.75  # cells between neighbouring directions on a half circle


@dataclass(frozen=True)
class Strips:
    """K arcs in D directions: labels (K, D, S) at the places near the circle and far, directions (K, D) from facing."""

    labels: Labels
    relative: FloatArray


def row_offsets(radius: float) -> list[float]:
    """How far to turn each of as many rows of directions as leave out no cell of a half circle, one between the others.

    In halves of the angle between a row's directions.
    """
    rows = math.ceil((math.pi + 2 * BESIDE) * radius / (WIDEST * DIRECTIONS))
    return [(2 * k + 1) / rows - 1 for k in range(rows)]


def strips(
    labels: Labels, centres: FloatArray, facings: FloatArray, reach: FloatArray, radius: float, offset: float = 0.0
) -> Strips:
    """Look along 48 directions, evenly over what each arc may cover, at 41 places in each.

    offset: how far all directions are turned, as `row_offsets` says.
    """
    places = np.maximum(radius + np.concatenate([NEAR, radius * FAR]), 0)
    width = int(places.max()) + 3
    padded = pad(labels, width)
    span = np.where(reach > HALF, np.pi, HALF + BESIDE)
    relative = span[:, None] * ((2 * np.arange(DIRECTIONS) + 1 + offset) / DIRECTIONS - 1)
    middle, theta = np.clip(centres, 0, labels.shape) + width, facings[:, None] + relative
    return Strips(look(padded, middle, theta, places), relative)
