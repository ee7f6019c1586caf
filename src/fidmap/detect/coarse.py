"""Maps with larger cells: arcs are looked for with a radius of 5 to 11 cells, whatever the map's resolution."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fidmap.model import Label

Labels = npt.NDArray[np.uint8]
LEAST_RADIUS = 5.5
# what this turns labels into, and back again, is in the order in which they win in a block of cells, unknown, free,
# occupied: a thin or ragged arc must not drown in the free space around it
FLIP = Label.UNKNOWN


def factor(radius: float) -> int:
    """How many cells make one in which a radius (cells) is at least 5.5 and less than 11."""
    return max(1, int(radius / LEAST_RADIUS))


def coarser(labels: Labels, factor: int) -> Labels:
    """Blocks of factor x factor cells as one: occupied if any is, else free if any is; two passes over the map."""
    if factor == 1:
        return labels
    rows = _highest(labels ^ FLIP, factor)
    return _highest(rows.T, factor).T ^ FLIP


def _highest(values: Labels, times: int) -> Labels:
    """The highest of every so many rows; the last of them may be fewer."""
    found = values[::times].copy(order="K")
    for k in range(1, times):
        more = values[k::times]
        np.maximum(found[: len(more)], more, out=found[: len(more)])
    return found
