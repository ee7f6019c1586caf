"""The occupied cells near rings: gathered once, then seen from any centre near those of the rings.

Lengths are cells, centres continuous (row, column), angles counter-clockwise from the column axis.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.model import FloatArray, Label

Mask = npt.NDArray[np.bool_]
Labels = npt.NDArray[np.uint8]
Index = npt.NDArray[np.intp]
Number = TypeVar("Number", bound=np.generic)
BLOCK = 128  # rings whose bands are looked up at a time: what is done with them stays in the cache


@dataclass(frozen=True)
class Seen:
    """N cells from their rings' centres: distance, sine and cosine of the direction, cosine relative to the facing."""

    r: FloatArray
    sine: FloatArray
    cosine: FloatArray
    ahead: FloatArray


@dataclass(frozen=True)
class BandCells:
    """Occupied cells near K rings, ring by ring: their middles, rows and columns (N,), and how many are whose (K,)."""

    rows: FloatArray
    columns: FloatArray
    counts: Index

    @cached_property
    def ring(self) -> Index:
        """(N,) whose each cell is."""
        return self.each(np.arange(len(self.counts)))

    @cached_property
    def firsts(self) -> Index:
        """Indices of the first cells of those rings that have any."""
        return (np.cumsum(self.counts) - self.counts)[self.counts > 0]

    def each(self, values: npt.NDArray[Number]) -> npt.NDArray[Number]:
        """(N,) what the rings have (K,), for each of their cells."""
        return np.repeat(values, self.counts)

    def sum(self, values: FloatArray) -> FloatArray:
        """(K,) sums over each ring's cells of what the cells have (N,)."""
        sums = np.zeros(len(self.counts))
        if len(values):
            sums[self.counts > 0] = np.add.reduceat(values, self.firsts)
        return sums

    def take(self, some: Mask) -> BandCells:
        """Some of the cells, of all the rings."""
        return BandCells(self.rows[some], self.columns[some], self.sum(some.astype(np.intp)).astype(np.intp))

    def seen(self, centres: FloatArray, facings: FloatArray) -> Seen:
        """The cells from centres (K, 2) and facings (K,)."""
        down, right = self.rows - self.each(centres[:, 0]), self.columns - self.each(centres[:, 1])
        r = np.sqrt(down * down + right * right)
        inverse = 1 / np.maximum(r, 1e-9)
        sine, cosine = down * inverse, right * inverse
        return Seen(r, sine, cosine, sine * self.each(np.sin(facings)) + cosine * self.each(np.cos(facings)))


def band_cells(labels: Labels, centres: FloatArray, radius: float, width: float) -> BandCells:
    """The occupied cells within about `width` of each ring (K, 2)."""
    reach, beyond = int(np.ceil(radius + width)) + 1, int(radius) + 1  # how far outside of the map a centre may lie
    corner = np.clip(np.floor(centres).astype(np.intp), -beyond, np.array(labels.shape) + beyond - 1) - reach
    grid = np.arange(-reach, reach + 1)
    away = grid[:, None] ** 2 + grid**2
    band = (away <= (radius + width + 1) ** 2) & (away >= max(0, radius - width - 1) ** 2)
    windows = np.lib.stride_tricks.sliding_window_view(pad(labels, reach + beyond), band.shape)
    places, counts = [np.empty(0, np.int32)], [np.empty(0, np.intp)]
    for block in (slice(k, k + BLOCK) for k in range(0, len(corner), BLOCK)):
        row, column = corner[block].T + reach + beyond
        occupied = np.flatnonzero((windows[row, column] == Label.OCCUPIED) & band)
        first = np.arange(len(row) + 1) * band.size
        counts.append(np.diff(np.searchsorted(occupied, first)))
        places.append((occupied - np.repeat(first[:-1], counts[-1])).astype(np.int32))
    whose = np.concatenate(counts)
    row, column = np.divmod(np.concatenate(places), np.int32(len(grid)))
    down, right = np.repeat(corner + 0.5, whose, axis=0).T
    return BandCells(row + down, column + right, whose)


def pad(labels: Labels, width: int) -> Labels:
    """The map with so many unknown cells around it, so that no look-up needs a bounds check."""
    return np.asarray(
        cv2.copyMakeBorder(labels, width, width, width, width, cv2.BORDER_CONSTANT, value=[int(Label.UNKNOWN)]),
        np.uint8,
    )
