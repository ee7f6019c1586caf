"""Branch and bound over placements: the greatest value, and a proof of how much greater it could be."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fidmap.model import FloatArray
from fidmap.register.bounds import loose_bounds, tight_bounds
from fidmap.register.landscape import BoolArray, IntArray, Landscape
from fidmap.register.near import Matcher, NearPairs
from fidmap.register.prices import Prices, matched
from fidmap.register.rivals import Rivals

# boxes that are split together, pairs that are looked at together: a processor's cache holds them
BATCH = 384
PAIRS = 20_000
FIRST = 2_000
# parts move less than this share of D inside a box before its matching is looked at
CLOSE_SHARE = 0.75
# parts move less than this (metres) inside the smallest boxes
LEAST_MOVE = 1e-6
# maxima are climbed to from the middle of boxes that are worth at least this share of the best
HOPEFUL = 0.9
BETTER = 1e-5
CLIMBS = 40

Improve = Callable[[FloatArray], tuple[float, FloatArray]]
Stop = Callable[[float], float]


@dataclass(frozen=True, eq=False)
class Proof:
    """The greatest value found, an upper bound of all values, and how many boxes were looked at."""

    value: float
    upper_bound: float
    nodes: int


@dataclass(frozen=True, eq=False)
class Open:
    """Boxes (K, 8) that may hold something better, their bounds (K,) and prices (K, C) of the boxes they came from."""

    boxes: FloatArray
    bounds: FloatArray
    prices: Prices

    def take(self, chosen: IntArray | BoolArray) -> Open:
        """Some of them."""
        return Open(self.boxes[chosen], self.bounds[chosen], self.prices[chosen])

    def bounded(self, bounds: FloatArray) -> Open:
        """The same with bounds (K,) that are no greater than before."""
        return Open(self.boxes, np.minimum(self.bounds, bounds), self.prices)


def join(some: list[Open]) -> Open:
    """All of them."""
    return Open(
        np.concatenate([one.boxes for one in some]),
        np.concatenate([one.bounds for one in some]),
        np.concatenate([one.prices for one in some]),
    )


class Search:
    """Best first in batches; boxes whose bound is not above `stop(value)` are closed.

    improve(placement) climbs from a placement (4,): the value there and the placement; it must be attained. With
    `rivals` only placements that are others than the best one count.
    """

    def __init__(
        self, land: Landscape, matcher: Matcher, value: float, improve: Improve, stop: Stop, most_nodes: int,
        rivals: Rivals | None = None,
    ) -> None:  # fmt: skip
        self.land, self.matcher = land, matcher
        self.value, self.improve, self.stop = value, improve, stop
        self.most_nodes = most_nodes
        self.rivals = rivals
        self.nodes = 0
        self.closed = 0.0
        self._tried: list[FloatArray] = []

    def run(self, boxes: FloatArray, bounds: FloatArray) -> Proof:
        """Search boxes (K, 8) with upper bounds (K,): rotation, x, y, scale and their half widths."""
        waiting = self._first(boxes, bounds)
        while len(waiting.boxes) and self.nodes < self.most_nodes:
            order = np.argsort(-waiting.bounds, kind="stable")
            batch = self._still(waiting.take(order[:BATCH]))
            waiting = waiting.take(order[BATCH:])
            if len(batch.boxes):
                waiting = self._still(join([waiting, self._examine(self._split(batch))]))
        self.closed = max(self.closed, float(waiting.bounds.max(initial=0.0)))
        return Proof(self.value, max(self.value, self.closed), self.nodes)

    def _first(self, boxes: FloatArray, bounds: FloatArray) -> Open:
        """Examine the boxes that the search starts from, the most promising first."""
        order = np.argsort(-bounds, kind="stable")
        found = [Open(boxes[:0], bounds[:0], np.zeros((0, self.matcher.columns), np.float32))]
        for k in range(0, len(order), FIRST):
            some = order[k : k + FIRST]
            if self.nodes >= self.most_nodes or bounds[some[0]] <= self.stop(self.value):
                self.closed = max(self.closed, float(bounds[some[0]]))
                break
            none = np.zeros((len(some), self.matcher.columns), np.float32)
            found.append(self._examine(self._still(Open(boxes[some], bounds[some], none))))
        return self._still(join(found))

    def _still(self, some: Open) -> Open:
        """Those that are worth a closer look."""
        kept = some.bounds > self.stop(self.value)
        self.closed = max(self.closed, float(some.bounds[~kept].max(initial=0.0)))
        return some.take(kept)

    def _examine(self, some: Open) -> Open:
        """Bound boxes from above, a cache's worth at a time; those still open."""
        some = some.take(~self.land.outside(some.boxes))
        self.nodes += len(some.boxes)
        size = max(16, PAIRS // (4 * max(1, len(self.matcher.open_rows))))
        found = [
            self._examined(some.take(np.arange(k, min(k + size, len(some.boxes)))))
            for k in range(0, len(some.boxes), size)
        ]
        return self._still(join(found)) if found else some

    def _examined(self, some: Open) -> Open:
        """First by the best partner of every part, then by the prices of the box it came from, then by its own."""
        pairs = self.matcher.near(some.boxes)
        bounds, most = loose_bounds(self.matcher, pairs, len(some.boxes))
        if self.rivals is not None:
            bounds = np.minimum(bounds, self.rivals.narrowed(self.land, some.boxes, pairs, most))
        some, pairs, most = self._open(some.bounded(bounds), pairs, most)
        if some.prices.any():
            bounds = tight_bounds(self.land, some.boxes, pairs, most, some.prices)
            some, pairs, most = self._open(some.bounded(bounds), pairs, most)
        close = moves(self.land, some.boxes).sum(axis=1) < CLOSE_SHARE * self.land.problem.d_max
        if not close.any():
            return some
        far, some = some.take(~close), some.take(close)
        pairs, most = _of_boxes(pairs, most, close)
        values, prices = matched(self.matcher, pairs, len(some.boxes))
        bounds = tight_bounds(self.land, some.boxes, pairs, most, prices)
        some = Open(some.boxes, np.minimum(some.bounds, bounds), prices)
        self._climb(some, values)
        return join([far, self._finest(some)])

    def _open(self, some: Open, pairs: NearPairs, most: FloatArray) -> tuple[Open, NearPairs, FloatArray]:
        """Those that are still worth a closer look, with their pairs."""
        kept = some.bounds > self.stop(self.value)
        return self._still(some), *_of_boxes(pairs, most, kept)

    def _finest(self, some: Open) -> Open:
        """Boxes that can be split; what the smallest may hold stays in the upper bound."""
        tiny = moves(self.land, some.boxes).sum(axis=1) < LEAST_MOVE
        self.closed = max(self.closed, float(some.bounds[tiny].max(initial=0.0)))
        return some.take(~tiny)

    def _climb(self, some: Open, values: FloatArray) -> None:
        """Climb from the middle of the best boxes, where nothing near was climbed from or to."""
        for k in np.argsort(-values, kind="stable")[:2]:
            here = some.boxes[k, :4]
            hopeful = some.bounds[k] > self.stop(self.value) and values[k] > HOPEFUL * self.value
            hopeful &= len(self._tried) < 2 * CLIMBS
            better = values[k] > self.value * (1 + BETTER)
            fresh = not any(self._beside(here, one) for one in self._tried)
            if (better and (fresh or self.rivals is None)) or (hopeful and fresh):
                value, placement = self.improve(here)
                self._tried += [here, placement]
                self.value = max(self.value, value)

    def _beside(self, a: FloatArray, b: FloatArray) -> bool:
        """Whether two placements are as good as the same to climb from."""
        turn = abs(math.remainder(a[0] - b[0], 2 * math.pi)) + abs(a[3] - b[3])
        return bool(turn * self.land.arm + math.hypot(a[1] - b[1], a[2] - b[2]) < self.land.problem.d_max / 8)

    def _split(self, some: Open) -> Open:
        """Halve boxes where their parts move most: in rotation, in x and y, or in scale."""
        longest = moves(self.land, some.boxes).argmax(axis=1)
        parts = []
        for k, axes in enumerate(((0,), (1, 2), (3,))):
            halves = [some.take(longest == k)]
            for axis in axes:
                halves = [_half(one, axis, side) for one in halves for side in (-1, 1)]
            parts += halves
        return join(parts)


def _half(some: Open, axis: int, side: int) -> Open:
    """The lower (-1) or upper (1) half of boxes along an axis."""
    boxes = some.boxes.copy()
    boxes[:, 4 + axis] /= 2
    boxes[:, axis] += side * boxes[:, 4 + axis]
    return Open(boxes, some.bounds, some.prices)


def _of_boxes(pairs: NearPairs, most: FloatArray, kept: BoolArray) -> tuple[NearPairs, FloatArray]:
    """The pairs of some boxes, which are numbered anew."""
    if kept.all():
        return pairs, most
    chosen = kept[pairs.box]
    return pairs.take(chosen, (np.cumsum(kept) - 1)[pairs.box[chosen]]), most[chosen]


def moves(land: Landscape, boxes: FloatArray) -> FloatArray:
    """(K, 3) metres (rms) that parts move within boxes (K, 8) by rotation, by x and y, and by scale."""
    turn = 2 * np.sin(np.minimum(boxes[:, 4], math.pi) / 2) * (boxes[:, 3] + boxes[:, 7])
    return np.stack([turn * land.arm, np.hypot(boxes[:, 5], boxes[:, 6]), boxes[:, 7] * land.arm], axis=1)
