"""Where labels go in a drawing: near their arc, never over each other, rarely over something drawn.

A plain greedy search: each label tries rings of places around its arc and takes the cheapest free one. One
that finds none is left out rather than printed over another.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.model import FloatArray

RINGS = (3.0, 9.0, 18.0, 30.0, 45.0, 65.0, 95.0, 140.0, 200.0, 280.0)
DIRECTIONS = 16
HIT_COST = 12.0  # per sampled point of something drawn under the label
TURN_COST = 4.0  # per radian away from the wished direction
GAP = 2.0  # between two labels


@dataclass(frozen=True)
class Caption:
    """A text that wants to stand near (x, y), outside `clearance`, best in direction `wish` (y down)."""

    text: str
    x: float
    y: float
    width: float
    height: float
    clearance: float
    wish: float = 0.0


@dataclass(frozen=True)
class Place:
    """The box of a placed label; `is_far` where a line should lead back to its arc."""

    box: tuple[float, float, float, float]  # left, top, right, bottom
    is_far: bool


def place_labels(
    labels: Sequence[Caption], drawn_xy: FloatArray, bounds: tuple[float, float, float, float]
) -> list[Place | None]:
    """Place labels one after the other, the most important first.

    Args:
        labels: in order of importance.
        drawn_xy: (N, 2) points of what is drawn; covering them costs.
        bounds: left, top, right, bottom of the area that labels may use.

    Returns:
        One place per label, None where no free place was found.
    """
    boxes = np.empty((0, 4))
    places: list[Place | None] = []
    for label in labels:
        place = _best_place(label, drawn_xy, boxes, bounds)
        places.append(place)
        if place is not None:
            boxes = np.vstack([boxes, place.box])
    return places


def _best_place(
    label: Caption, drawn_xy: FloatArray, boxes: FloatArray, bounds: tuple[float, float, float, float]
) -> Place | None:
    candidates, distance, turn = _candidates(label)
    left, top, right, bottom = bounds
    free = (candidates[:, 0] >= left) & (candidates[:, 1] >= top)
    free &= (candidates[:, 2] <= right) & (candidates[:, 3] <= bottom)
    for box in boxes:
        free &= ~_overlaps(candidates, box, GAP)
    if not free.any():
        return None
    candidates, distance, turn = candidates[free], distance[free], turn[free]
    cost = distance + TURN_COST * turn + HIT_COST * _hits(candidates, drawn_xy)
    best = int(np.argmin(cost))
    left, top, right, bottom = (float(v) for v in candidates[best])
    return Place((left, top, right, bottom), is_far=bool(distance[best] > RINGS[1]))


def _candidates(label: Caption) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Boxes (M, 4), their distance from the arc (M,) and how far they turn from the wish (M,)."""
    angles = label.wish + np.arange(DIRECTIONS) * (2 * math.pi / DIRECTIONS)
    angle, ring = (grid.ravel() for grid in np.meshgrid(angles, np.array(RINGS)))
    cos, sin = np.cos(angle), np.sin(angle)
    half_w, half_h = label.width / 2, label.height / 2
    # The box touches the circle of radius clearance + ring from outside, whatever its direction.
    with np.errstate(divide="ignore"):
        reach = np.minimum(half_w / np.abs(cos), half_h / np.abs(sin))
    distance = label.clearance + ring + reach
    x, y = label.x + distance * cos, label.y + distance * sin
    turn = np.abs((angle - label.wish + math.pi) % (2 * math.pi) - math.pi)
    return np.stack([x - half_w, y - half_h, x + half_w, y + half_h], axis=1), ring, turn


def _overlaps(boxes: FloatArray, other: FloatArray, gap: float) -> npt.NDArray[np.bool_]:
    wide = (boxes[:, 0] < other[2] + gap) & (boxes[:, 2] > other[0] - gap)
    high = (boxes[:, 1] < other[3] + gap) & (boxes[:, 3] > other[1] - gap)
    return np.asarray(wide & high, bool)


def _hits(boxes: FloatArray, points: FloatArray) -> FloatArray:
    """How many points (N, 2) lie in each box (M, 4); only points in reach of the boxes are looked at."""
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    near = points[((points >= low) & (points <= high)).all(axis=1)]
    x, y = near[None, :, 0], near[None, :, 1]
    inside = (x >= boxes[:, :1]) & (x <= boxes[:, 2:3]) & (y >= boxes[:, 1:2]) & (y <= boxes[:, 3:])
    return np.asarray(inside.sum(axis=1), float)
