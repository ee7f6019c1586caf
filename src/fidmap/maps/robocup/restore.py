"""The map under what was drawn over it: walls go on where both their ends show, the rest is as around it."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.maps.robocup.cells import COVERED
from fidmap.model import Label

Bytes = npt.NDArray[np.uint8]
LONGEST_GAP_M = 0.4
"""A wall goes on under a mark of at most this length: a victim's disc is 0.35 m wide."""


def restored(cells: Bytes, resolution_m: float) -> Bytes:
    """(H, W) labels of cells that may be COVERED; a covered cell becomes what its surroundings say.

    1. A small hole in a mark, such as the white figure on a victim's disc, belongs to the mark.
    2. A wall that ends at a mark on either side, in one of eight directions, goes on under it.
    3. What is left takes the label of the nearest cell that shows free or unknown space.
    """
    covered = cells == COVERED
    if not covered.any():
        return cells
    rows, columns = np.flatnonzero(covered.any(axis=1)), np.flatnonzero(covered.any(axis=0))
    reach = int(np.ceil(LONGEST_GAP_M / resolution_m)) + 1
    box = (
        slice(max(0, rows[0] - reach), rows[-1] + 1 + reach),
        slice(max(0, columns[0] - reach), columns[-1] + 1 + reach),
    )
    result = cells.copy()
    result[box] = _restored(cells[box], reach - 1)
    return result


def _restored(cells: Bytes, gap: int) -> Bytes:
    wall = (cells == Label.OCCUPIED).view(np.uint8)
    covered = (cells == COVERED).view(np.uint8)
    covered = cv2.morphologyEx(covered, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)) & (1 - wall)
    walls = wall | _bridges(wall, covered, gap)
    shown = (covered | walls) == 0
    result = np.where(walls, Label.OCCUPIED, Label.FREE)
    result[shown] = cells[shown]
    left = (covered & (1 - walls)).astype(bool)
    if left.any() and shown.any():
        _, nearest = cv2.distanceTransformWithLabels(
            (~shown).view(np.uint8), cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL
        )
        label_of = np.zeros(int(nearest.max()) + 1, np.uint8)
        label_of[nearest[shown]] = cells[shown]
        result[left] = label_of[nearest[left]]
    return result


def _bridges(wall: Bytes, covered: Bytes, gap: int) -> Bytes:
    """Covered cells between two walls: the straight run through them is covered, and no longer than the gap."""
    found = np.zeros_like(wall)
    for step in ((0, 1), (1, 0), (1, 1), (1, -1), (1, 2), (2, 1), (1, -2), (2, -1)):
        length = max(2, int(gap / np.hypot(*step)))
        forward = _reached(wall, covered, step, length)
        back = _reached(wall, covered, (-step[0], -step[1]), length)
        found |= ((forward > 0) & (back > 0) & (forward.astype(np.uint16) + back <= length + 1)).view(np.uint8)
    return found


def _reached(wall: Bytes, covered: Bytes, step: tuple[int, int], length: int) -> Bytes:
    """For covered cells the number of steps from the wall behind them, through covered cells alone; 0 beyond."""
    count = np.zeros_like(wall)
    front = wall
    for n in range(1, length + 1):
        front = _moved(front, step) & covered
        fresh = front.view(bool) & (count == 0)
        if not fresh.any():
            break
        count[fresh] = n
    return count


def _moved(mask: Bytes, step: tuple[int, int]) -> Bytes:
    """The mask moved by (rows, columns), with nothing coming in."""
    out = np.zeros_like(mask)
    (h, w), (dy, dx) = mask.shape, step
    out[max(0, dy) : h + min(0, dy), max(0, dx) : w + min(0, dx)] = mask[
        max(0, -dy) : h + min(0, -dy), max(0, -dx) : w + min(0, -dx)
    ]
    return out
