"""Which pairs can be within D of each other: tables of neighbours, looked up for many placements at once."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fidmap.geometry import ComplexArray
from fidmap.model import FloatArray
from fidmap.register.landscape import BoolArray, IntArray, Landscape

# side of a table's cell as a share of D
CELL_SHARE = 0.4
MOST_CELLS = 400_000


class Neighbours:
    """For every cell of the plane the points within `reach` metres of some place in it."""

    def __init__(self, points: ComplexArray, reach: float, cell: float) -> None:
        margin = reach + cell
        self.low = complex(float(points.real.min()) - margin, float(points.imag.min()) - margin)
        width, height = float(np.ptp(points.real)) + 2 * margin, float(np.ptp(points.imag)) + 2 * margin
        self.cell = max(cell, math.sqrt(width * height / MOST_CELLS), max(width, height) / MOST_CELLS)
        self.columns, self.rows = (math.ceil(side / self.cell) + 1 for side in (width, height))
        size = math.ceil(reach / self.cell) + 1
        step = np.arange(-size, size + 1)
        at = (points - self.low) / self.cell
        right = (np.floor(at.real)[:, None, None] + step[None, None, :]).astype(np.intp)
        up = (np.floor(at.imag)[:, None, None] + step[None, :, None]).astype(np.intp)
        aside = np.maximum(np.abs((right + 0.5) - at.real[:, None, None]) - 0.5, 0)
        above = np.maximum(np.abs((up + 0.5) - at.imag[:, None, None]) - 0.5, 0)
        inside = (np.hypot(aside, above) * self.cell <= reach) & (right >= 0) & (up >= 0)
        inside &= (right < self.columns) & (up < self.rows)
        cells = (up * self.columns + right)[inside]
        order = np.argsort(cells, kind="stable")
        self.points = np.broadcast_to(np.arange(len(points))[:, None, None], inside.shape)[inside][order]
        self.starts = np.searchsorted(cells[order], np.arange(self.columns * self.rows + 1))

    def look(self, places: ComplexArray) -> tuple[IntArray, IntArray]:
        """(E,), (E,) indices of places (any of them) and of the points in reach, sorted by place."""
        at = (places - self.low) / self.cell
        right, up = np.floor(at.real), np.floor(at.imag)
        inside = (right >= 0) & (up >= 0) & (right < self.columns) & (up < self.rows)
        cells = np.where(inside, up * self.columns + right, 0).astype(np.intp)
        first = self.starts[cells]
        count = np.where(inside, self.starts[cells + 1] - first, 0)
        who = np.repeat(np.arange(len(places)), count)
        offset = np.arange(len(who)) - np.repeat(np.cumsum(count) - count, count)
        return who, self.points[first[who] + offset]


@dataclass(frozen=True, eq=False)
class NearPairs:
    """E pairs of K boxes that may count, sorted by box and row; rows are the smaller side, columns the larger.

    box, row, column, fiducial, barrel: (E,) indices. error: (E,) moved barrel part minus fiducial part in the middle of
    the box, x + iy metres; distance: its length. reach: (E,) how much nearer they can be elsewhere in the box.
    """

    box: IntArray
    row: IntArray
    column: IntArray
    fiducial: IntArray
    barrel: IntArray
    error: ComplexArray
    distance: FloatArray
    reach: FloatArray

    def take(self, chosen: BoolArray, box: IntArray | None = None) -> NearPairs:
        """Some of the pairs; `box` (as many) numbers their boxes anew."""
        return NearPairs(
            self.box[chosen] if box is None else box, self.row[chosen], self.column[chosen],
            self.fiducial[chosen], self.barrel[chosen], self.error[chosen], self.distance[chosen], self.reach[chosen],
        )  # fmt: skip


class Matcher:
    """Finds the near pairs of boxes (K, 8): rotation, x, y, scale and their half widths."""

    def __init__(self, land: Landscape) -> None:
        self.land = land
        self.by_barrel = len(land.used) <= int(land.possible.any(axis=1).sum())
        self.open_rows = land.used if self.by_barrel else np.flatnonzero(land.possible.any(axis=1))
        self.columns = len(land.fiducials) if self.by_barrel else len(land.barrels)
        self.rows = len(land.barrels) if self.by_barrel else len(land.fiducials)
        self._tables: dict[int, Neighbours] = {}

    @cached_property
    def _smallest(self) -> float:
        return 1.0 if self.by_barrel else self.land.problem.scale_range[0]

    def _table(self, reach: float) -> Neighbours:
        """A table that serves boxes in which parts move by up to `reach`; a few of them serve all."""
        d_max = self.land.problem.d_max
        step = max(0, math.ceil(math.log2(max(reach / d_max, 1e-9) * 16)))
        if step not in self._tables:
            points = self.land.fiducials if self.by_barrel else self.land.barrels
            far = d_max * (1 + 2.0**step / 16) / self._smallest
            self._tables[step] = Neighbours(points, far, CELL_SHARE * d_max)
        return self._tables[step]

    def near(self, boxes: FloatArray) -> NearPairs:
        """All pairs that may be nearer than D, with facings that may agree, somewhere in their box."""
        land = self.land
        turned = np.exp(1j * boxes[:, 0]) * boxes[:, 3]
        at = boxes[:, 1] + 1j * boxes[:, 2]
        swing = land.swing(boxes)
        shift = np.hypot(boxes[:, 5], boxes[:, 6])
        table = self._table(float((swing * land.arms.max() + shift).max(initial=0.0)))
        if self.by_barrel:
            places = turned[:, None] * land.barrels[self.open_rows][None] + at[:, None]
        else:
            places = (land.fiducials[self.open_rows][None] - at[:, None]) / turned[:, None]
        who, column = table.look(places.ravel())
        box, row = who // len(self.open_rows), self.open_rows[who % len(self.open_rows)]
        fiducial, barrel = (column, row) if self.by_barrel else (row, column)
        error = turned[box] * land.barrels[barrel] + at[box] - land.fiducials[fiducial]
        distance = np.abs(error)
        reach = land.arms[barrel] * swing[box] + shift[box]
        good = (distance - reach < land.problem.d_max) & land.possible[fiducial, barrel]
        if land.faced:
            good &= ~land.clash(fiducial, barrel, boxes[box, 0], boxes[box, 4])
        return NearPairs(box, row, column, fiducial, barrel, error, distance, reach).take(good)
