"""Where a robot can go between walls and things that stand anywhere, and its way from goal to goal."""

from __future__ import annotations

import math
from collections.abc import Iterable

import cv2
import numpy as np
import numpy.typing as npt
from scipy import ndimage, sparse
from scipy.sparse import csgraph

from fidmap.model import FloatArray
from fidmap.synth.maze import PalletMaze

CELL_M = 0.25
CLEAR_M = 0.26  # from a cell's centre to the next obstacle; doors of 0.8 m keep a lane of one cell
RASTER_M = 0.05
SNAP_M = 1.5  # how far a goal may lie from where the robot can stand
STRIDE = 3  # cells between the points of a way: people do not drive in steps of 0.25 m


class FreeSpace:
    """Cells in which a robot can stand, and shortest ways through them that keep off the walls.

    maze: the cells as pallets; all but those of the largest connected piece are void.
    """

    def __init__(self, walls: FloatArray, arcs: FloatArray, size: tuple[float, float]) -> None:
        clearance = _clearance(walls, arcs, size)
        pieces, count = ndimage.label(clearance > CLEAR_M)
        largest = int(np.argmax(np.bincount(pieces.ravel())[1:])) + 1 if count else 1
        self.free: npt.NDArray[np.bool_] = pieces == largest
        free = self.free
        self.maze = PalletMaze(free[:, 1:] & free[:, :-1], free[1:] & free[:-1], ~free, CELL_M)
        self.centres: FloatArray = CELL_M * (np.argwhere(free)[:, ::-1].astype(np.float64) + 0.5)
        self._graph = _graph(free, clearance)

    def nearest(self, point: tuple[float, float], within_m: float = SNAP_M) -> int | None:
        """The number of the free cell nearest to a point, None where all are farther than `within_m`."""
        if not len(self.centres):
            return None
        away = np.hypot(*(self.centres - point).T)
        best = int(np.argmin(away))
        return best if away[best] <= within_m else None

    def distance_m(self, first: tuple[float, float], second: tuple[float, float]) -> float:
        """Length of the way a robot takes between two points; through walls where there is none."""
        ends = self.nearest(first), self.nearest(second)
        if ends[0] is None or ends[1] is None:
            return math.dist(first, second)
        return math.dist(first, second) if ends[0] == ends[1] else self._length_m(ends[0], ends[1])

    def _length_m(self, first: int, second: int) -> float:
        _, before = csgraph.dijkstra(self._graph, indices=first, return_predecessors=True)
        way = self.centres[_back(before, first, second)]
        return float(np.hypot(*np.diff(way, axis=0).T).sum())

    def tour(self, goals: Iterable[tuple[float, float]]) -> FloatArray:
        """The way (N, 2) over all goals in reach, always on to the nearest one left; begins at the first."""
        wanted = [cell for goal in goals if (cell := self.nearest(goal)) is not None]
        if not wanted:
            return self.centres[:1]
        here = wanted[0]
        left = set(wanted)
        cells = [here]
        while left := left - {here}:
            cost, before = csgraph.dijkstra(self._graph, indices=here, return_predecessors=True)
            goal = min(left, key=lambda cell: (cost[cell], cell))
            step = _back(before, here, goal)[1:]
            cells += [*step[STRIDE - 1 : -1 : STRIDE], goal]
            here = goal
        return self.centres[cells]


def _back(before: npt.NDArray[np.int32], start: int, goal: int) -> list[int]:
    way = [goal]
    while way[-1] != start:
        way.append(int(before[way[-1]]))
    return way[::-1]


def _clearance(walls: FloatArray, arcs: FloatArray, size: tuple[float, float]) -> FloatArray:
    """(rows, columns) distance of each cell's centre to the nearest obstacle or to the rim, metres."""
    columns, rows = (math.ceil(side / CELL_M) for side in size)
    per_cell = round(CELL_M / RASTER_M)
    canvas = np.ones((rows * per_cell, columns * per_cell), np.uint8)
    ends = np.rint(walls / RASTER_M - 0.5).astype(int)
    for x0, y0, x1, y1 in ends.tolist():
        cv2.line(canvas, (x0, y0), (x1, y1), 0)
    for x, y, radius_m, facing, opening in arcs.tolist():
        at = (round(x / RASTER_M - 0.5), round(y / RASTER_M - 0.5))
        low, high = math.degrees(facing - opening / 2), math.degrees(facing + opening / 2)
        cv2.ellipse(canvas, at, (max(1, round(radius_m / RASTER_M)),) * 2, 0, low, high, 0)
    canvas[[0, -1]] = canvas[:, [0, -1]] = 0
    middle = slice(per_cell // 2, None, per_cell)
    distance = cv2.distanceTransform(canvas, cv2.DIST_L2, 5)[middle, middle]
    return np.asarray(distance, np.float64) * RASTER_M


def _graph(free: npt.NDArray[np.bool_], clearance: FloatArray) -> sparse.csr_matrix:
    """Steps to the eight neighbours; a metre near a wall costs up to twice one in the open."""
    number = np.full(free.shape, -1)
    number[free] = np.arange(free.sum())
    price = 1 + np.clip(1 - (clearance - CLEAR_M) / 0.5, 0, 1)
    rows: list[FloatArray] = []
    for dr, dc in ((0, 1), (1, 0), (1, 1), (1, -1)):
        a = (slice(0, free.shape[0] - dr), slice(max(0, -dc), free.shape[1] - max(0, dc)))
        b = (slice(dr, None), slice(max(0, dc), free.shape[1] + min(0, dc)))
        both = free[a] & free[b]
        cost = math.hypot(dr, dc) * CELL_M * (price[a] + price[b])[both] / 2
        rows.append(np.stack([number[a][both], number[b][both], cost]))
    first, second, cost = np.concatenate(rows, axis=1)
    count = int(free.sum())
    graph = sparse.coo_matrix((cost, (first.astype(int), second.astype(int))), (count, count)).tocsr()
    return (graph + graph.T).tocsr()
