"""Where could centres be? Free cells that touch an occupied cell vote for the centre behind it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.detect.cells import pad
from fidmap.model import FloatArray, Label

Image = npt.NDArray[np.uint8]
Votes = npt.NDArray[np.int16]
Whole = npt.NDArray[np.int32]
Numbers = npt.NDArray[np.float32]
VOTE = np.int16(256)  # what one counts: what is left of it after blurring is still a whole number
REACH = 0.35
FINE = 100  # steps of a blurred map between a byte's


@dataclass(frozen=True)
class Boundary:
    """N cells that touch an obstacle and are none, of a map with a margin that keeps every look-up around them inside.

    rows, columns: (N,) in the padded map. down, right: (N,) unit vectors into the obstacle.
    """

    padded: Image
    margin: int
    rows: Whole
    columns: Whole
    down: Numbers
    right: Numbers


def boundary(labels: Image, radius: float) -> Boundary:
    """The boundary of a map's obstacles; labels: (H, W) of `Label`; radius in cells.

    Few passes over the map: mask, dilation, difference, one blur.
    """
    margin = int(radius) + 4
    padded = pad(labels, margin)
    occupied = mask(padded, Label.OCCUPIED)
    touched = cv2.dilate(occupied, np.ones((3, 3), np.uint8))
    cv2.subtract(touched, occupied, dst=touched)
    for side in (touched, touched.T):
        side[:margin] = side[-margin:] = 0
    place = np.flatnonzero(touched > 0).astype(np.int32)  # much faster than looking for numbers
    rows, columns = np.divmod(place, np.int32(padded.shape[1]))
    return Boundary(padded, margin, rows, columns, *_towards_occupied(occupied, rows, columns, radius))


def centre_candidates(edge: Boundary, radius: float, min_votes: float = 0.42) -> FloatArray:
    """Places that at least a share `min_votes` of a half ring's boundary votes for; radius in cells.

    Returns (N, 2) (row, column) continuous cell coordinates, most votes first. Few passes over the map: a blur, maximum
    filter, comparison.
    """
    if len(edge.rows) == 0:
        return np.empty((0, 2))
    votes = np.zeros(edge.padded.shape, np.int16)
    # at most 96 cells lie a radius (below 11) and one away from another: no count reaches the 127 that fit
    behind = _flat(edge.padded, edge.rows + (radius + 1) * edge.down, edge.columns + (radius + 1) * edge.right)
    np.add.at(votes.reshape(-1), behind[_free_outside(edge)], VOTE)
    inside = slice(edge.margin, -edge.margin)
    return _peaks(votes[inside, inside], radius, min_votes)


def mask(labels: Image, label: Label) -> Image:
    """(H, W) 255 where a cell has the label, else 0."""
    return np.asarray(cv2.inRange(labels, np.array([int(label)]), np.array([int(label)])), np.uint8)


def _flat(image: Image, row: Numbers | FloatArray, column: Numbers | FloatArray) -> Whole:
    """Where in the flat image the cells nearest to places (N,) are."""
    rows, columns = (row + np.float32(0.5)).astype(np.int32), (column + np.float32(0.5)).astype(np.int32)
    return np.asarray(rows * np.int32(image.shape[1]) + columns, np.int32)


def _towards_occupied(occupied: Image, row: Whole, column: Whole, radius: float) -> tuple[Numbers, Numbers]:
    """Unit vectors, rows and columns (N,), from the boundary cells into the obstacle: the blurred map's gradient."""
    sigma = min(max(0.17 * radius, 0.9), 2.5)
    # twice as fast as GaussianBlur, whose arithmetic for bytes is exact, and finer
    kernel = cv2.getGaussianKernel(2 * round(3 * sigma) + 1, sigma, cv2.CV_32F)
    blurred = cv2.sepFilter2D(occupied, cv2.CV_16S, kernel, FINE * kernel, borderType=cv2.BORDER_REPLICATE)
    place, wide = row * np.int32(occupied.shape[1]) + column, occupied.shape[1]
    above, below, after, before = (
        blurred.reshape(-1).take(place + step).astype(np.float32) for step in (wide, -wide, 1, -1)
    )
    down, right = above - below, after - before
    length = np.maximum(np.sqrt(down * down + right * right), np.float32(1e-9))
    return down / length, right / length


def _free_outside(edge: Boundary) -> npt.NDArray[np.bool_]:
    """Whether the map is free at the boundary cell or up to two cells further out (grey ramps lie between)."""
    labels, flat = edge.padded, edge.padded.reshape(-1)
    seen = flat.take(edge.rows * np.int32(labels.shape[1]) + edge.columns) == Label.FREE
    for step in (1, 2):
        other = np.flatnonzero(~seen)
        beyond = edge.rows[other] - step * edge.down[other], edge.columns[other] - step * edge.right[other]
        seen[other] = flat.take(_flat(labels, *beyond)) == Label.FREE
    return np.asarray(seen)


def _peaks(votes: Votes, radius: float, min_votes: float) -> FloatArray:
    """Local maxima of the smoothed votes, as continuous cell coordinates."""
    sigma = max(1.0, 0.14 * radius)
    smooth = np.asarray(cv2.GaussianBlur(votes, (0, 0), sigma), np.int16)
    reach = max(1, round(REACH * radius))
    highest = cv2.dilate(smooth, np.ones((2 * reach + 1, 2 * reach + 1), np.uint8))
    # a half ring has about pi * radius boundary cells; a blurred pile of n votes peaks at n / (2 pi sigma^2)
    enough = VOTE * min_votes * np.pi * radius / (2 * np.pi * (sigma**2 + (0.12 * radius) ** 2))
    found = np.flatnonzero((smooth == highest) & (smooth > np.int16(enough)))
    found = _firsts(smooth.reshape(-1), found, smooth.shape[1])
    order = np.argsort(-smooth.reshape(-1)[found].astype(np.int64), kind="stable")
    return np.column_stack(np.divmod(found[order], smooth.shape[1])) + 0.5


def _firsts(flat: Votes, peaks: npt.NDArray[np.intp], width: int) -> npt.NDArray[np.intp]:
    """Of cells with as many votes as their neighbours the first: hatched maps have votes as even as they are wide."""
    # left and above; beyond the left edge that is the end of the row above, which is no neighbour and hardly as even
    before = peaks[:, None] - np.array([1, width - 1, width, width + 1])
    even = (before >= 0) & (flat[np.maximum(before, 0)] == flat[peaks, None])
    return np.asarray(peaks[~even.any(axis=1)])
