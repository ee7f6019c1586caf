"""Maps with larger cells: arcs are looked for with a radius of 5 to 11 cells, whatever the map's resolution."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.model import Label

Labels = npt.NDArray[np.uint8]
LEAST_RADIUS = 5.5
# what wins in a block of cells, least first: a thin or ragged arc must not drown in the free space around it
ORDER = np.array([Label.UNKNOWN, Label.FREE, Label.OCCUPIED], np.uint8)


def factor(radius: float) -> int:
    """How many cells make one in which a radius (cells) is at least 5.5 and less than 11."""
    return max(1, int(radius / LEAST_RADIUS))


def coarser(labels: Labels, factor: int) -> Labels:
    """Blocks of factor x factor cells as one: occupied if any is, else free if any is; three passes over the map."""
    if factor == 1:
        return labels
    rank = np.argsort(ORDER).astype(np.uint8)
    ranked = cv2.LUT(labels, np.resize(rank, 256))
    highest = cv2.dilate(ranked, np.ones((factor, factor), np.uint8), anchor=(0, 0), borderType=cv2.BORDER_REPLICATE)
    return np.asarray(ORDER[highest[::factor, ::factor]], np.uint8)
