"""How sharply arcs are drawn: what resolution quality is computed from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fidmap.detect.arcs import difference
from fidmap.detect.fits import band_cells
from fidmap.grid import metres_to_cells
from fidmap.model import BarrelPart, FloatArray, TrinaryGrid

# tuned on artificial maps (tune split): what the raster alone spreads, in cells; and what turns the median of |r - R|
# into the deviation of the poses, which hit-counting mappers widen
RASTER_SPREAD = 0.46
TO_DEVIATION = 1.15
BAND = 0.9


def with_spreads(grid: TrinaryGrid, parts: Sequence[BarrelPart], radius_m: float) -> tuple[BarrelPart, ...]:
    """The barrel parts with their radial spread as this map draws them, wherever the parts came from.

    It depends on what a points file holds alone, so that reading one back gives the same resolution quality.
    """
    if not parts:
        return ()
    places = metres_to_cells(np.array([(p.x_m, p.y_m) for p in parts]), grid.resolution_m, grid.origin)
    facings = np.array([0.0 if p.facing is None else p.facing - grid.origin.yaw for p in parts])
    reach = np.array([math.pi if p.facing is None else math.radians(70) for p in parts])
    spreads = radial_spreads(grid, places, facings, reach, radius_m / grid.resolution_m) * grid.resolution_m
    return tuple(replace(p, spread_m=float(s)) for p, s in zip(parts, spreads, strict=True))


def radial_spreads(
    grid: TrinaryGrid, centres: FloatArray, facings: FloatArray, reach: FloatArray, radius: float
) -> FloatArray:
    """Robust radial spread (K,) in cells of the occupied cells about circles (K, 2), beyond what the raster causes.

    Of the cells within 0.9 R of the ring and `reach` of the facing, each weighed by 1/r so that rings of all radii
    count the same: 1.15 times the weighted median of |r - R|, less the raster's own in squares.
    """
    cells = band_cells(grid.labels, centres, radius, BAND * radius)
    r, angle = cells.polar(centres)
    near = cells.valid & (np.abs(r - radius) <= BAND * radius)
    near &= np.abs(difference(angle, facings[:, None])) <= reach[:, None]
    away = np.where(near, np.abs(r - radius), np.inf)
    weight = np.where(near, 1 / np.maximum(r, 1), 0.0)
    order = np.argsort(away, axis=1, kind="stable")
    total = np.cumsum(np.take_along_axis(weight, order, axis=1), axis=1)
    middle = np.minimum((total < total[:, -1:] / 2).sum(axis=1), away.shape[1] - 1)
    median = np.take_along_axis(away, np.take_along_axis(order, middle[:, None], axis=1), axis=1)[:, 0]
    spread = np.where(np.isfinite(median), TO_DEVIATION * median, BAND * radius)
    return np.sqrt(np.maximum(0.0, spread**2 - RASTER_SPREAD**2))
