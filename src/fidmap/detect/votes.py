"""Where could centres be? Free cells that touch an occupied cell vote for the centre behind it."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.model import FloatArray, Label

Image = npt.NDArray[np.uint8]
Votes = npt.NDArray[np.uint16]
MOST_VOTES = 255
REACH = 0.45


def centre_candidates(labels: Image, radius: float, min_votes: float = 0.42) -> FloatArray:
    """Places that at least a share `min_votes` of a half ring's boundary votes for.

    labels: (H, W) of `Label`; radius in cells. Returns (N, 2) (row, column) continuous cell coordinates, most
    votes first. Eight passes over the map: two masks, dilation, difference, two blurs, maximum filter, comparison.
    """
    occupied, free = mask(labels, Label.OCCUPIED), mask(labels, Label.FREE)
    boundary = cv2.subtract(cv2.dilate(occupied, np.ones((3, 3), np.uint8)), occupied)
    found = cv2.findNonZero(boundary)
    if found is None:
        return np.empty((0, 2))
    cells = found.reshape(-1, 2)[:, ::-1].astype(np.intp)
    inward = _towards_occupied(occupied, cells, radius)
    seen = _free_outside(free, cells, inward)
    votes = _accumulate(labels.shape, cells[seen] + (radius + 1.0) * inward[seen])
    return _peaks(votes, radius, min_votes)


def mask(labels: Image, label: Label) -> Image:
    """(H, W) 255 where a cell has the label, else 0."""
    return np.asarray(cv2.inRange(labels, np.array([int(label)]), np.array([int(label)])), np.uint8)


def _towards_occupied(occupied: Image, cells: npt.NDArray[np.intp], radius: float) -> FloatArray:
    """Unit vectors (N, 2) (row, column) from the boundary cells into the obstacle: the blurred map's gradient."""
    sigma = min(max(0.17 * radius, 0.9), 2.5)
    blurred = cv2.GaussianBlur(occupied, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE)
    rows, columns = cells[:, 0], cells[:, 1]
    last_row, last_column = blurred.shape[0] - 1, blurred.shape[1] - 1

    def at(r: npt.NDArray[np.intp], c: npt.NDArray[np.intp]) -> FloatArray:
        return np.asarray(blurred[np.clip(r, 0, last_row), np.clip(c, 0, last_column)], np.float64)

    gradient = np.stack(
        [at(rows + 1, columns) - at(rows - 1, columns), at(rows, columns + 1) - at(rows, columns - 1)], axis=1
    )
    length = np.hypot(gradient[:, 0], gradient[:, 1])
    return np.asarray(gradient / np.maximum(length, 1e-9)[:, None], np.float64)


def _free_outside(free: Image, cells: npt.NDArray[np.intp], inward: FloatArray) -> npt.NDArray[np.bool_]:
    """Whether the map is free at the boundary cell or up to two cells further out (grey ramps lie between)."""
    seen = free[cells[:, 0], cells[:, 1]] > 0
    for step in (1.0, 2.0):
        out = np.clip(np.rint(cells - step * inward).astype(np.intp), 0, np.array(free.shape) - 1)
        seen |= free[out[:, 0], out[:, 1]] > 0
    return seen


def _accumulate(shape: tuple[int, ...], centres: FloatArray) -> Votes:
    """Count votes per cell, in 256ths; votes that fall outside of the map are dropped."""
    cells = np.floor(centres + 0.5).astype(np.intp)
    inside = ((cells >= 0) & (cells < shape[:2])).all(axis=1)
    places, counts = np.unique(cells[inside, 0] * shape[1] + cells[inside, 1], return_counts=True)
    votes = np.zeros(shape[:2], np.uint16)
    votes.reshape(-1)[places] = np.minimum(counts, MOST_VOTES) * 256
    return votes


def _peaks(votes: Votes, radius: float, min_votes: float) -> FloatArray:
    """Local maxima of the smoothed votes, as continuous cell coordinates."""
    sigma = max(1.0, 0.14 * radius)
    smooth = cv2.GaussianBlur(votes, (0, 0), sigma)
    reach = max(1, round(REACH * radius))
    highest = cv2.dilate(smooth, np.ones((2 * reach + 1, 2 * reach + 1), np.uint8))
    # a half ring has about pi * radius boundary cells; a blurred pile of n votes peaks at n / (2 pi sigma^2)
    enough = 256 * min_votes * np.pi * radius / (2 * np.pi * (sigma**2 + (0.12 * radius) ** 2))
    strong = cv2.threshold(smooth, enough, 255, cv2.THRESH_BINARY)[1].astype(np.uint8)
    found = cv2.findNonZero(cv2.bitwise_and(cv2.compare(smooth, highest, cv2.CMP_EQ), strong))
    if found is None:
        return np.empty((0, 2))
    cells = found.reshape(-1, 2)[:, ::-1]
    order = np.argsort(-smooth[cells[:, 0], cells[:, 1]].astype(np.int64), kind="stable")
    return np.asarray(cells[order] + 0.5, np.float64)
