"""Upper bounds of the value over boxes of placements, many boxes at a time.

With any column prices v >= 0, by linear duality of the assignment,

    value(x) <= sum_j v_j + sum_i max(0, max_j (w_ij(x) - v_j)).

Every w_ij is majorised over a box by an affine function of the distance, and the distance, convex in translation and
scale and up to |b| h^2 / 2 in the rotation, is minorised by its tangent plane. So the right side is majorised by a
convex function, whose maximum over the box is at one of its corners.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import numpy.typing as npt

from fidmap.model import FloatArray
from fidmap.register.landscape import IntArray, Landscape
from fidmap.register.majorant import affine_majorant
from fidmap.register.near import Matcher, NearPairs

Prices = npt.NDArray[np.float32]


def greatest(key: IntArray, count: int, amount: FloatArray) -> FloatArray:
    """(count,) the greatest amount of every key, 0 where none is above."""
    found = np.zeros(count)
    np.maximum.at(found, key, amount)
    return found


def loose_bounds(matcher: Matcher, pairs: NearPairs, count: int) -> tuple[FloatArray, FloatArray]:
    """(count,) upper bounds of boxes: the lesser of the sums over rows and columns of the best pair; (E,) its pairs."""
    most = matcher.land.worth(np.maximum(pairs.distance - pairs.reach, 0.0))
    rows = greatest(pairs.box * matcher.rows + pairs.row, count * matcher.rows, most)
    columns = greatest(pairs.box * matcher.columns + pairs.column, count * matcher.columns, most)
    return np.minimum(rows.reshape(count, -1).sum(axis=1), columns.reshape(count, -1).sum(axis=1)), most


def tight_bounds(land: Landscape, boxes: FloatArray, pairs: NearPairs, most: FloatArray, prices: Prices) -> FloatArray:
    """(K,) upper bounds by prices (K, C); most: (E,) what each pair is worth at most in its box."""
    price = prices[pairs.box, pairs.column].astype(float)
    kept = most > price
    pairs, most, price = pairs.take(kept), most[kept], price[kept]
    total = prices.sum(axis=1, dtype=float)
    if len(pairs.box) == 0:
        return np.asarray(total)
    row = np.flatnonzero(np.diff(pairs.box * 1_000_000 + pairs.row, prepend=-1))
    box = np.flatnonzero(np.diff(pairs.box[row], prepend=-1))
    which = pairs.box[row][box]
    at_corners = _at_corners(land, boxes[pairs.box], pairs, price)
    rows = np.maximum.reduceat(at_corners, row, axis=0)
    corners = np.add.reduceat(np.maximum(rows, 0.0), box, axis=0).max(axis=1)
    flat = np.add.reduceat(np.maximum.reduceat(most - price, row), box)
    total[which] += np.minimum(corners, flat)
    return np.asarray(total)


def _at_corners(land: Landscape, boxes: FloatArray, pairs: NearPairs, price: FloatArray) -> FloatArray:
    """(E, 8 or 16) the affine majorant of every pair minus its price, at the corners of its box (E, 8)."""
    height, slope = affine_majorant(land, pairs.distance, pairs.reach)
    half_turn, half_scale = boxes[:, 4], boxes[:, 7]
    along = np.where(pairs.distance > 1e-9, pairs.error / np.maximum(pairs.distance, 1e-9), 0)
    arm = np.exp(1j * boxes[:, 0]) * land.barrels[pairs.barrel]
    bend = land.arms[pairs.barrel] * ((boxes[:, 3] + half_scale) * half_turn**2 / 2 + half_turn * half_scale)
    middle = height - slope * (pairs.distance - bend) - price
    turned = arm * along.conj()
    gradients = [
        -slope * (-turned.imag * boxes[:, 3]) * half_turn,
        -slope * along.real * boxes[:, 5],
        -slope * along.imag * boxes[:, 6],
        -slope * turned.real * half_scale,
    ]
    axes = 4 if half_scale.any() else 3
    corners = np.array(list(product((-1.0, 1.0), repeat=axes))).T
    return np.asarray(middle[:, None] + np.stack(gradients[:axes], axis=1) @ corners)
