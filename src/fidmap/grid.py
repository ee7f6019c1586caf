"""Cells and metres: the only place that turns one into the other, and where grids are trinarized.

Indices are (row, column) with row 0 lowest; the centre of cell (i, j) is at (i + 0.5, j + 0.5) in continuous
cell coordinates.
"""

from __future__ import annotations

import math

import numpy as np

from fidmap.model import FloatArray, Grid, Label, Pose2, TrinaryGrid


def trinarize(grid: Grid, free_thresh: float | None = None, occupied_thresh: float | None = None) -> TrinaryGrid:
    """Reduce a grid to free / unknown / occupied (SSRR 2011, II-A-2); three passes over the map.

    Thresholds given here override the file's. Comparison is in float32, as nav2 does it, with free winning.
    """
    free = np.float32(grid.free_thresh if free_thresh is None else free_thresh)
    occupied = np.float32(grid.occupied_thresh if occupied_thresh is None else occupied_thresh)
    overridden = free_thresh is not None or occupied_thresh is not None
    labels = grid.labels
    if labels is None or overridden:
        labels = np.full(grid.occupancy.shape, Label.UNKNOWN, np.uint8)
        labels[grid.occupancy >= occupied] = Label.OCCUPIED
        labels[grid.occupancy <= free] = Label.FREE
    return TrinaryGrid(labels, grid.resolution_m, grid.origin, grid.occupancy, grid.source)


def cells_to_metres(cells_rc: FloatArray, resolution_m: float, origin: Pose2) -> FloatArray:
    """Continuous cell coordinates (N, 2) as (row, column) to world metres (N, 2) as (x, y)."""
    rc = np.asarray(cells_rc, float) * resolution_m
    c, s = math.cos(origin.yaw), math.sin(origin.yaw)
    return np.stack(
        [origin.x_m + c * rc[..., 1] - s * rc[..., 0], origin.y_m + s * rc[..., 1] + c * rc[..., 0]], axis=-1
    )


def metres_to_cells(points_xy: FloatArray, resolution_m: float, origin: Pose2) -> FloatArray:
    """World metres (N, 2) as (x, y) to continuous cell coordinates (N, 2) as (row, column)."""
    xy = np.asarray(points_xy, float) - [origin.x_m, origin.y_m]
    c, s = math.cos(origin.yaw), math.sin(origin.yaw)
    return np.stack([-s * xy[..., 0] + c * xy[..., 1], c * xy[..., 0] + s * xy[..., 1]], axis=-1) / resolution_m
