"""Facings by the walls around: half barrels stand against walls, and what hides an arc's end turns what is drawn of it.

Walls mostly stand at right angles, so each cell of their boundary tells an axis modulo 90 degrees: the walls around an
arc are the mean of exp(4 i angle) of the normals there. Arcs hardly add to it: their normals point everywhere.
"""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.detect.arcs import HALF, Arcs
from fidmap.detect.votes import Boundary
from fidmap.model import FloatArray

Walls = npt.NDArray[np.complex128]
# tuned on artificial maps (tune split) and run A2: how many radii away walls count half; and how far from walls that
# all agree an arc may face before half of the difference is put down to the arc
AROUND = 7
DOUBT = np.radians(4.5)
MOST = np.pi / 8  # who faces farther from the walls' axis does not stand against them


def towards_walls(facings: FloatArray, walls: Walls) -> FloatArray:
    """Facings (K,) turned towards a normal of the walls around each: the more, the farther off, the more these agree.

    Arcs face some 2 degrees wrong as a rule, but a few by 20, and walls tell a normal to 3 degrees: of a difference d
    the share d^2 / (d^2 + t^2) is turned, where t is `DOUBT` over how much the walls agree, 0 to 1. The formula is our
    own: docs/decisions/0038-facings-and-walls.md.
    """
    off = np.angle(walls * np.exp(-4j * facings)) / 4
    share = off**2 / (off**2 + (DOUBT / np.maximum(np.abs(walls), 1e-9)) ** 2)
    return np.asarray(facings + np.where(np.abs(off) < MOST, share * off, 0))


def walls_around(arcs: Arcs, edge: Boundary, radius: float) -> Walls:
    """(K,) the walls about each half circle, the nearer the more; 0 where there are none, and for whole ones.

    One pass over the boundary, few over the map in blocks of a radius.
    """
    side = np.int32(radius)
    height, width = -(-np.array(edge.padded.shape) // side)
    block = edge.rows // side * np.int32(width) + edge.columns // side
    fourfold = np.square(np.square(edge.right + 1j * edge.down))
    row, column = np.clip((arcs.centres + edge.margin) // side, 0, (height - 1, width - 1)).astype(np.intp).T
    cosine, sine, count = (
        _around(np.bincount(block, values, height * width).reshape(height, width))[row, column]
        for values in (fourfold.real, fourfold.imag, None)
    )
    return np.where(arcs.reach > HALF, 0, (cosine + 1j * sine) / np.maximum(count, 1))


def _around(blocks: npt.NDArray[np.number]) -> FloatArray:
    """Sums over the blocks around each, the near ones counting more: two boxes make a pyramid."""
    box, summed = (2 * AROUND + 1, 2 * AROUND + 1), blocks.astype(np.float64)
    for _ in range(2):
        summed = np.asarray(cv2.boxFilter(summed, -1, box, normalize=False, borderType=cv2.BORDER_CONSTANT))
    return summed
