"""Walls that are drawn twice beside each other, or many cells thick."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.inspect.frame import known_box
from fidmap.model import Finding, Grid, Label

Bytes = npt.NDArray[np.uint8]
NARROW_M, LONG_M = 0.3, 0.6
"""A free strip narrower and longer than this between two walls is no way, but a wall that was drawn twice."""
DOUBLED_SHARE, LEAST_STRIPS = 0.1, 4
"""Area of such strips over that of the walls: up to 0.07 on sound maps, whose furniture leaves a few."""
SOLID_SHARE = 0.3
"""Share of occupied cells two and more cells deep in a wall: up to 0.16 on clean maps, with thickened walls too."""


def wall_findings(grid: Grid, labels: Bytes) -> tuple[Finding, ...]:
    """`doubled-walls` and `thick-walls`, where they apply."""
    top, bottom, left, right = known_box(labels)
    labels = np.ascontiguousarray(labels[top:bottom, left:right])
    walls = (labels == Label.OCCUPIED).view(np.uint8)
    found = []
    share, strips = doubled(labels, walls, grid.resolution_m)
    if share > DOUBLED_SHARE and strips >= LEAST_STRIPS:
        text = (
            f"{strips} long free strips of less than {NARROW_M:g} m run between two walls: walls look drawn twice, "
            "so a barrel may stand there twice or be torn; relative accuracy and resolution quality suffer"
        )
        found.append(Finding("warning", "doubled-walls", text))
    inner = cv2.erode(walls, np.ones((5, 5), np.uint8))
    solid = int(np.count_nonzero(inner)) / max(1, int(np.count_nonzero(walls)))
    if solid > SOLID_SHARE and not walls.all():  # of a map of nothing else the depth is endless
        thick = 4 * float(np.median(_depth(walls))) * grid.resolution_m
        text = (
            f"walls are drawn solid, about {thick:.2f} m thick: either they are so, or they were blurred or thickened, "
            "which moves the edges of barrels outwards"
        )
        found.append(Finding("note", "thick-walls", text))
    return tuple(found)


def doubled(labels: Bytes, walls: Bytes, resolution_m: float) -> tuple[float, int]:
    """Area of long narrow free strips over that of the walls, and their number."""
    reach = max(3, int(NARROW_M / resolution_m) // 2 * 2 + 1)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    between = cv2.morphologyEx(walls, cv2.MORPH_CLOSE, disc)
    between[cv2.morphologyEx(walls, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)) > 0] = 0
    between[labels != Label.FREE] = 0
    _, _, strips, _ = cv2.connectedComponentsWithStats(between, connectivity=8)
    width, height, cells = (strips[1:, k] for k in (cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT, cv2.CC_STAT_AREA))
    long = np.hypot(width, height) * resolution_m >= LONG_M
    return float(cells[long].sum() / max(1, np.count_nonzero(walls))), int(long.sum())


def _depth(walls: Bytes) -> npt.NDArray[np.float32]:
    """Distance of wall cells to the nearest other cell, in cells."""
    depth = cv2.distanceTransform(walls, cv2.DIST_L2, 3)
    return np.asarray(depth[walls > 0], np.float32)
