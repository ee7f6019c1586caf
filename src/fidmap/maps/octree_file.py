"""The trees in OctoMap's files as leaves: `.bt` (two bits per child) and `.ot` (log odds per node).

Format: octomap's `OcTreeBaseImpl.hxx` and `OccupancyOcTreeBase.hxx`. Nodes are written depth first. Let q be the
number of nodes that are still owed before a node: all that lies below the node ends at the first later place with a
smaller q. All ends are found at once by sorting, and the tree is then walked level by level, without recursion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.maps.cursor import BrokenRecordError

DEPTH = 16
MAX_NODES = 20_000_000
NOTHING, FREE, OCCUPIED, INNER = 0, 1, 2, 3
NODES = {
    "OcTree": np.dtype([("odds", "<f4"), ("children", "u1")]),
    "ColorOcTree": np.dtype([("odds", "<f4"), ("rgb", "u1", (3,)), ("children", "u1")]),
}
Index = npt.NDArray[np.int64]
Bytes = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Leaves:
    """Cubes of one size, in cells of the tree.

    corner: (N, 3) lowest cell of each, counted from the tree's centre. side: cells. occupied: (N,).
    """

    corner: npt.NDArray[np.int32]
    side: int
    occupied: Mask


def binary_leaves(data: bytes) -> Iterator[Leaves]:
    """The leaves of a `.bt` tree: each inner node is one word with two bits per child.

    Raises:
        BrokenRecordError: cut off, deeper than 16 levels, or too many nodes.
    """
    words = np.frombuffer(data, "<u2", len(data) // 2)
    _check_count(len(words))
    states = np.empty((len(words), 8), np.uint8)
    for child in range(8):
        states[:, child] = (words >> np.uint16(2 * child)) & np.uint16(3)
    owed = (states == INNER).sum(axis=1, dtype=np.int64)

    def look(nodes: Index, child: int, _: Index) -> tuple[Bytes, Mask]:
        found = states[nodes, child]
        return found, found == INNER

    return _walk(_ends(owed), look)


def full_leaves(data: bytes, kind: str) -> Iterator[Leaves]:
    """The leaves of an `.ot` tree: each node is its log odds and a bit per child.

    Raises:
        BrokenRecordError: another kind of tree, cut off, deeper than 16 levels, or too many nodes.
    """
    if kind not in NODES:
        raise BrokenRecordError(f"it holds the tree {kind[:40]!r}, known are {', '.join(NODES)} (and .bt of any)")
    nodes = np.frombuffer(data, NODES[kind], len(data) // NODES[kind].itemsize)
    _check_count(len(nodes))
    children, odds = nodes["children"].copy(), nodes["odds"].copy()
    owed = np.unpackbits(children).reshape(-1, 8).sum(axis=1, dtype=np.int64)
    own = np.where(children > 0, INNER, np.where(odds > 0, OCCUPIED, np.where(odds <= 0, FREE, NOTHING)))
    states = own.astype(np.uint8)  # log odds that are no number say nothing

    def look(parents: Index, child: int, cursor: Index) -> tuple[Bytes, Mask]:
        there = (children[parents] >> np.uint8(child)) & 1 > 0
        found = np.full(len(parents), NOTHING, np.uint8)
        found[there] = states[cursor[there]]
        return found, there

    return _walk(_ends(owed), look)


def _check_count(count: int) -> None:
    if count > MAX_NODES:
        raise BrokenRecordError(f"it has {count:,} nodes, at most {MAX_NODES:,} are read")


def _ends(owed: Index) -> Index:
    """Per node of a tree (N,) the place after all that lies below it.

    Args:
        owed: how many nodes follow each one as its children.

    Raises:
        BrokenRecordError: nodes are missing.
    """
    before = np.concatenate([[1], 1 + np.cumsum(owed - 1)])
    done = int(np.argmin(before > 0))
    if before[done] > 0:
        raise BrokenRecordError("its tree is cut off")
    places = np.arange(done + 1)
    keys = before[: done + 1] * (done + 2) + places
    sought = keys[:done] - (done + 2)
    ordered = np.sort(keys)
    return np.asarray(ordered[np.searchsorted(ordered, sought, side="right")] % (done + 2))


def _walk(ends: Index, look: Callable[[Index, int, Index], tuple[Bytes, Mask]]) -> Iterator[Leaves]:
    """The leaves level by level.

    Args:
        ends: per node the place after all that lies below it.
        look: given nodes, which child, and the place of that child: what the child is, and whether it has a place.
    """
    nodes = np.zeros(1, np.int64)
    corner = np.full((1, 3), -(1 << DEPTH - 1), np.int32)
    for depth in range(DEPTH):
        side = 1 << DEPTH - 1 - depth
        cursor = nodes + 1
        inner_nodes, inner_corners = [], []
        for child in range(8):
            found, placed = look(nodes, child, cursor)
            below = corner + np.array([child & 1, child >> 1 & 1, child >> 2], np.int32) * np.int32(side)
            leaf = (found == FREE) | (found == OCCUPIED)
            if leaf.any():
                yield Leaves(below[leaf], side, found[leaf] == OCCUPIED)
            inner_nodes.append(cursor[found == INNER])
            inner_corners.append(below[found == INNER])
            cursor[placed] = ends[cursor[placed]]
        nodes, corner = np.concatenate(inner_nodes), np.concatenate(inner_corners)
        if not len(nodes):
            return
    raise BrokenRecordError(f"its tree is deeper than {DEPTH} levels")
