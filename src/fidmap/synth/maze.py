"""Mazes of square pallets: which neighbours are open to each other, walls, ways through them.

A pallet is (row, column) with row 0 lowest, so pallet (r, c) covers x in [c, c + 1] and y in [r, r + 1]
pallets.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from fidmap.model import FloatArray

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]
Pallet = tuple[int, int]

STEPS: dict[str, Pallet] = {"E": (0, 1), "N": (1, 0), "W": (0, -1), "S": (-1, 0)}
OPPOSITE = {"E": "W", "W": "E", "N": "S", "S": "N"}


@dataclass(frozen=True, eq=False)
class PalletMaze:
    """A maze of H x W pallets.

    east: (H, W-1) bool, whether one can walk from (r, c) to (r, c+1).
    north: (H-1, W) bool, whether one can walk from (r, c) to (r+1, c).
    void: (H, W) bool, pallets that nobody can enter (walls all around them).
    pallet_m: side of a pallet.
    """

    east: BoolArray
    north: BoolArray
    void: BoolArray
    pallet_m: float = 1.2

    def __post_init__(self) -> None:
        """Check the shapes against each other and freeze the arrays."""
        rows, columns = self.void.shape
        if self.east.shape != (rows, columns - 1) or self.north.shape != (rows - 1, columns):
            raise ValueError(
                f"a maze of {rows} x {columns} pallets needs east {(rows, columns - 1)} and north"
                f" {(rows - 1, columns)}, not {self.east.shape} and {self.north.shape}"
            )
        for name in ("east", "north", "void"):
            copy = np.array(getattr(self, name), bool)
            copy.setflags(write=False)
            object.__setattr__(self, name, copy)

    @property
    def shape(self) -> Pallet:
        """Rows and columns."""
        return int(self.void.shape[0]), int(self.void.shape[1])

    def is_open(self, pallet: Pallet, side: str) -> bool:
        """Whether one can leave a pallet by a side ('E', 'N', 'W' or 'S'); the rim is closed."""
        r, c = pallet
        rows, columns = self.shape
        if side == "E":
            return c + 1 < columns and bool(self.east[r, c])
        if side == "N":
            return r + 1 < rows and bool(self.north[r, c])
        dr, dc = STEPS[side]
        return r + dr >= 0 and c + dc >= 0 and self.is_open((r + dr, c + dc), OPPOSITE[side])

    def neighbours(self, pallet: Pallet) -> list[Pallet]:
        """The pallets one step away, in the fixed order E, N, W, S."""
        r, c = pallet
        return [(r + dr, c + dc) for side, (dr, dc) in STEPS.items() if self.is_open(pallet, side)]


def random_maze(
    rng: np.random.Generator,
    shape: Pallet,
    *,
    void: BoolArray | None = None,
    openness: float = 0.15,
    pallet_m: float = 1.2,
) -> PalletMaze:
    """A maze in which every pallet that is no void can be reached.

    A spanning tree grown from its tips (four in five) or from anywhere, so that there are both corridors and
    short branches; then each remaining wall is left out with probability `openness`, which makes loops.

    Args:
        rng: the only source of randomness.
        shape: rows and columns.
        void: (H, W) bool, pallets that stay closed; the others must hang together.
        openness: share of the remaining inner walls that is left out, 0 to 1.
        pallet_m: side of a pallet in metres.

    Raises:
        ValueError: the pallets that are no void do not hang together.
    """
    void = np.zeros(shape, bool) if void is None else void
    if not hangs_together(void):
        raise ValueError("the pallets that are no void must hang together")
    rows, columns = shape
    east = (rng.random((rows, columns - 1)) < openness) & ~void[:, 1:] & ~void[:, :-1]
    north = (rng.random((rows - 1, columns)) < openness) & ~void[1:] & ~void[:-1]
    for (r, c), (r2, c2) in _spanning_tree(rng, void):
        if r == r2:
            east[r, min(c, c2)] = True
        else:
            north[min(r, r2), c] = True
    return PalletMaze(east, north, void, pallet_m)


def _spanning_tree(rng: np.random.Generator, void: BoolArray) -> list[tuple[Pallet, Pallet]]:
    """Edges of a random tree over all pallets that are no void ('growing tree' method)."""
    rows, columns = void.shape
    seen = void.copy()
    free = np.argwhere(~void)
    first = free[rng.integers(len(free))]
    active: list[Pallet] = [(int(first[0]), int(first[1]))]
    seen[active[0]] = True
    edges = []
    while active:
        index = len(active) - 1 if rng.random() < 0.8 else int(rng.integers(len(active)))
        r, c = active[index]
        around = [(r + dr, c + dc) for dr, dc in STEPS.values()]
        fresh = [p for p in around if 0 <= p[0] < rows and 0 <= p[1] < columns and not seen[p]]
        if not fresh:
            active.pop(index)
            continue
        chosen = fresh[int(rng.integers(len(fresh)))]
        seen[chosen] = True
        edges.append(((r, c), chosen))
        active.append(chosen)
    return edges


def hangs_together(void: BoolArray) -> bool:
    """Whether the pallets that are no void form one piece (over sides, not corners)."""
    return int(ndimage.label(~void)[1]) == 1


def walking_distances(maze: PalletMaze, start: Pallet) -> IntArray:
    """Fewest pallets that a robot traverses from `start` to each pallet, by breadth-first search.

    Neighbouring open pallets are 1 apart (SSRR 2011, III: distance 'measured in pallets').

    Returns:
        (H, W) int64, -1 where there is no way.
    """
    distances = np.full(maze.shape, -1, np.int64)
    distances[start] = 0
    queue = deque([start])
    while queue:
        pallet = queue.popleft()
        for other in maze.neighbours(pallet):
            if distances[other] < 0:
                distances[other] = distances[pallet] + 1
                queue.append(other)
    return distances


def shortest_way(maze: PalletMaze, start: Pallet, wanted: BoolArray) -> list[Pallet]:
    """The pallets after `start` on a shortest way to the nearest wanted pallet; empty where there is none."""
    before: dict[Pallet, Pallet] = {start: start}
    queue = deque([start])
    while queue:
        pallet = queue.popleft()
        if wanted[pallet]:
            way = []
            while pallet != start:
                way.append(pallet)
                pallet = before[pallet]
            return way[::-1]
        for other in maze.neighbours(pallet):
            if other not in before:
                before[other] = pallet
                queue.append(other)
    return []


def walls_of(maze: PalletMaze) -> tuple[BoolArray, BoolArray]:
    """Where walls stand on the lattice lines.

    Returns:
        lying: (H+1, W) bool, wall on the line y = row between columns c and c + 1.
        standing: (W+1, H) bool, wall on the line x = column between rows r and r + 1.
    """
    rows, columns = maze.shape
    lying = np.ones((rows + 1, columns), bool)
    standing = np.ones((columns + 1, rows), bool)
    lying[1:-1] = ~maze.north
    standing[1:-1] = ~maze.east.T
    return lying, standing


def wall_boxes(maze: PalletMaze, thickness_m: float) -> FloatArray:
    """Walls as boxes centred on the lattice lines; walls in one line are one box.

    Returns:
        (K, 4) x_min, y_min, x_max, y_max in metres, arena frame.
    """
    lying, standing = walls_of(maze)
    half = thickness_m / 2
    boxes = []
    for lines, is_lying in ((lying, True), (standing, False)):
        edges = np.diff(np.pad(lines, ((0, 0), (1, 1))).astype(np.int8), axis=1)
        line, begin = np.nonzero(edges == 1)
        end = np.nonzero(edges == -1)[1]  # row by row, each run's end follows its begin
        at, begin_m, end_m = (maze.pallet_m * v for v in (line, begin, end))
        low = [begin_m - half, at - half] if is_lying else [at - half, begin_m - half]
        high = [end_m + half, at + half] if is_lying else [at + half, end_m + half]
        boxes.append(np.stack([*low, *high], axis=1))
    return np.concatenate(boxes)


def wall_count_at_corners(maze: PalletMaze) -> IntArray:
    """How many walls meet in each corner of the lattice: (H+1, W+1), 1 is a wall's free end."""
    lying, standing = (w.astype(np.int64) for w in walls_of(maze))
    count = np.zeros((maze.shape[0] + 1, maze.shape[1] + 1), np.int64)
    count[:, :-1] += lying
    count[:, 1:] += lying
    count[:-1] += standing.T
    count[1:] += standing.T
    return count


def open_around(maze: PalletMaze, corner: Pallet) -> PalletMaze:
    """The maze without the four walls that meet in an inner corner (row, column) of the lattice."""
    r, c = corner
    east, north = maze.east.copy(), maze.north.copy()
    east[r - 1 : r + 1, c - 1] = True
    north[r - 1, c - 1 : c + 1] = True
    return PalletMaze(east, north, maze.void, maze.pallet_m)
