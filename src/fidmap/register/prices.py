"""Exact matchings in the middle of boxes, and the column prices that prove them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.optimize import linear_sum_assignment

from fidmap.model import FloatArray
from fidmap.register.landscape import BoolArray, IntArray
from fidmap.register.majorant import affine_majorant
from fidmap.register.near import Matcher, NearPairs

Prices = npt.NDArray[np.float32]


def matched(matcher: Matcher, pairs: NearPairs, count: int) -> tuple[FloatArray, Prices]:
    """Value (count,) of a feasible assignment in the middle of every box, and prices (count, C) of the columns.

    With steps the matching is of the majorants, so the value is that of some assignment, not always the best.
    """
    height, slope = affine_majorant(matcher.land, pairs.distance, pairs.reach)
    weight = np.maximum(height - slope * pairs.distance, 0.0)
    worth = np.where(pairs.distance < matcher.land.problem.d_max, matcher.land.worth(pairs.distance), 0.0)
    mate = matching(matcher, pairs, weight, count)
    value = np.zeros(count)
    np.add.at(value, pairs.box[mate], worth[mate])
    return value, _prices(matcher, pairs, weight, mate, count)


def matching(matcher: Matcher, pairs: NearPairs, weight: FloatArray, count: int) -> BoolArray:
    """(E,) which pairs make the assignment of greatest weight (E,) in every of `count` boxes; positive weights only."""
    dense = np.zeros((count, matcher.rows, matcher.columns))
    dense[pairs.box, pairs.row, pairs.column] = np.maximum(weight, 0.0)
    partner = np.full((count, matcher.rows), -1, np.intp)
    for k in range(count):
        rows, columns = linear_sum_assignment(dense[k], maximize=True)
        partner[k, rows] = columns
    return np.asarray((partner[pairs.box, pairs.row] == pairs.column) & (weight > 0))


def _prices(matcher: Matcher, pairs: NearPairs, weight: FloatArray, mate: BoolArray, count: int) -> Prices:
    """Prices that make an optimal matching (E,) of pairs (E,) a proof.

    The least such prices let rows hesitate between columns, the greatest let columns hesitate between rows; half-way
    between them, which is as good in the middle of a box, the bound falls fastest away from it.
    """
    row = pairs.box * matcher.rows + pairs.row
    column = pairs.box * matcher.columns + pairs.column
    other = ~mate & (weight > 0)
    rows, columns = count * matcher.rows, count * matcher.columns
    least = _raised(weight[mate], (column[mate], row[mate]), weight[other], (column[other], row[other]), columns, rows)
    profit = _raised(weight[mate], (row[mate], column[mate]), weight[other], (row[other], column[other]), rows, columns)
    most = np.zeros(columns)
    most[column[mate]] = weight[mate] - profit[row[mate]]
    return ((least + most) / 2).reshape(count, -1).astype(np.float32)


def _raised(
    mated: FloatArray, mates: tuple[IntArray, IntArray], offered: FloatArray, offers: tuple[IntArray, IntArray],
    count: int, others: int,
) -> FloatArray:  # fmt: skip
    """(count,) the least prices at which nobody on the other side (`others`) wants to change: raised until so."""
    price, profit = np.zeros(count), np.zeros(others)
    for _ in range(others + 1):
        profit[mates[1]] = mated - price[mates[0]]
        raised = price.copy()
        np.maximum.at(raised, offers[0], offered - profit[offers[1]])
        if (raised <= price + 1e-9).all():
            break
        price = raised
    return price
