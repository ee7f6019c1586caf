"""Pixels to cells: how often a picture was enlarged, and one label for the pixels of each cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.maps.robocup.palette import Kind
from fidmap.model import Label

Bytes = npt.NDArray[np.uint8]
COVERED = 3
"""Beside the three labels: a cell whose pixels are drawn over."""
MOST = 12


@dataclass(frozen=True)
class Enlargement:
    """Pixels per cell, and the first row and column that begin a cell."""

    factor: int = 1
    top: int = 0
    left: int = 0


def enlargement(kinds: Bytes, least: float) -> Enlargement:
    """The largest factor at which the edges of walls lie on a raster, rows and columns alike; 1 where none does.

    Args:
        kinds: (H, W) of `Kind`.
        least: share of the edges that must lie on the raster.

    A multiple of the true factor holds edges too where walls stand on a grid of their own, but fewer of them.
    """
    solid = kinds <= Kind.WALL
    wall = kinds == Kind.WALL
    down = _edges(wall, solid)
    across = _edges(wall.T, solid.T)
    if min(down.sum(), across.sum()) < 50:
        return Enlargement()
    phases = {k: (_phase(down, k), _phase(across, k)) for k in range(2, MOST + 1)}
    share = {k: min(rows[1], columns[1]) for k, (rows, columns) in phases.items()}
    for k in range(MOST, 1, -1):
        if share[k] >= max([least, *(0.95 * share[d] for d in range(2, k) if k % d == 0)]):
            return Enlargement(k, phases[k][0][0], phases[k][1][0])
    return Enlargement()


def _edges(wall: npt.NDArray[np.bool_], solid: npt.NDArray[np.bool_]) -> npt.NDArray[np.int64]:
    """(H,) how many edges of walls lie between a row and the one before; what is drawn over has none."""
    edges = (wall[1:] != wall[:-1]) & solid[1:] & solid[:-1]
    return np.concatenate([[0], edges.sum(axis=1)])


def _phase(edges: npt.NDArray[np.int64], factor: int) -> tuple[int, float]:
    """The offset at which most edges lie on a raster, and their share."""
    padded = np.zeros(-(-len(edges) // factor) * factor, np.int64)
    padded[: len(edges)] = edges
    by_offset = padded.reshape(-1, factor).sum(axis=0)
    best = int(by_offset.argmax())
    return best, float(by_offset[best] / edges.sum())


def to_cells(kinds: Bytes, scale: Enlargement) -> Bytes:
    """(h, w) labels, or COVERED: the label that most of a cell's pixels show, of those that are not drawn over.

    A cell is covered when fewer than a fifth of its pixels show the map. Cells cut by the rim are left out.
    """
    k = scale.factor
    h, w = (kinds.shape[0] - scale.top) // k, (kinds.shape[1] - scale.left) // k
    cut = kinds[scale.top : scale.top + h * k, scale.left : scale.left + w * k]
    if k == 1:
        return np.minimum(cut, COVERED)
    counts = [_count(cut == kind, k) for kind in (Kind.FREE, Kind.UNKNOWN, Kind.WALL)]
    seen = np.add(np.add(counts[0], counts[1]), counts[2])
    labels = np.full((h, w), Label.FREE, np.uint8)
    labels[counts[1] > counts[0]] = Label.UNKNOWN
    labels[counts[2] > np.maximum(counts[0], counts[1])] = Label.OCCUPIED
    labels[5 * seen.astype(np.uint16) < k * k] = COVERED
    return labels


def _count(mask: npt.NDArray[np.bool_], k: int) -> Bytes:
    """(h, w) how many pixels of each cell are True; strips of rows first, since these stay bytes."""
    rows: Bytes = mask[0::k].view(np.uint8).copy()
    for n in range(1, k):
        rows += mask[n::k].view(np.uint8)
    total: Bytes = rows[:, 0::k].copy()
    for n in range(1, k):
        total += rows[:, n::k]
    return total
