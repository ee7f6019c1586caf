"""What somebody did to the picture of a map: enlarged it, or smoothed it."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.model import Finding, Grid, Label

Bytes = npt.NDArray[np.uint8]
LEAST_LINES = 20
"""Rows, and columns, with edges that an enlargement must explain: drawn mazes have edges on few lines."""
SMOOTH_SHARE = 0.8
"""Sharp maps have up to 0.07 of their edges smooth, mappers that keep probabilities up to 0.68; smoothing by 0.8 cells,
or enlarging with interpolation, makes it 0.85 and more."""
MOST_CELLS = 4_000_000


def picture_findings(grid: Grid, labels: Bytes) -> tuple[Finding, ...]:
    """`upscaled` and `smoothed`, where they apply."""
    found = []
    if (factor := enlarged(labels)) > 1:
        text = (
            f"all edges lie on every {factor}th row and column: the map was enlarged {factor} times, its true cells "
            f"are {grid.resolution_m * factor:g} m and so is the exactness of all positions"
        )
        found.append(Finding("warning", "upscaled", text, "fidmap inspect --fix"))
    elif (share := smooth_share(grid)) > SMOOTH_SHARE:
        text = (
            f"{share:.0%} of the edges are smooth: the image was smoothed or scaled with interpolation, so thin walls "
            "fade and the thresholds move all edges; save the map anew from the mapping program"
        )
        found.append(Finding("warning", "smoothed", text))
    return tuple(found)


def enlarged(labels: Bytes) -> int:
    """How often each cell was repeated; 1 for an ordinary map."""
    edges = []
    for axis in (0, 1):
        walls = (labels if axis == 0 else labels.T) == Label.OCCUPIED
        counts = np.concatenate([[0], (walls[1:] != walls[:-1]).sum(axis=1)])
        if (counts > 0).sum() < LEAST_LINES:
            return 1
        edges.append(counts)
    return max((k for k in range(2, 9) if all(_on_raster(counts, k) for counts in edges)), default=1)


def _on_raster(counts: npt.NDArray[np.int64], k: int) -> bool:
    by_offset = np.bincount(np.arange(len(counts)) % k, counts, minlength=k)
    return bool(by_offset.max() > 0.99 * counts.sum())


def smooth_share(grid: Grid) -> float:
    """Of the places where p changes by 0.4 and more within 5 x 5 cells the share without any step of 70 % of that.

    Of a large map the middle is looked at.
    """
    p = _middle(grid.occupancy)
    if min(p.shape) < 5:
        return 0.0
    grey = np.where(np.isnan(p), np.float32(51), 255 * p).astype(np.uint8)  # unknown as map savers write it: 0.2
    window = np.ones((5, 5), np.uint8)
    change = cv2.dilate(grey, window) - cv2.erode(grey, window)
    step = np.zeros_like(grey)
    step[:, 1:] = cv2.absdiff(grey[:, 1:], grey[:, :-1])
    step[1:] = np.maximum(step[1:], cv2.absdiff(grey[1:], grey[:-1]))
    edge = change >= 102
    if np.count_nonzero(edge) < 100:
        return 0.0
    steepest = cv2.dilate(step, window)[edge]
    return float((steepest < 0.7 * change[edge]).mean())


def _middle(occupancy: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    if occupancy.size <= MOST_CELLS:
        return occupancy
    keep = (MOST_CELLS / occupancy.size) ** 0.5
    cut = [round(n * (1 - keep) / 2) for n in occupancy.shape]
    return occupancy[cut[0] : occupancy.shape[0] - cut[0], cut[1] : occupancy.shape[1] - cut[1]]
