"""How sharply arcs are drawn: what resolution quality is computed from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fidmap.detect.cells import band_cells
from fidmap.grid import metres_to_cells
from fidmap.model import BarrelPart, FloatArray, TrinaryGrid

# tuned on artificial maps (tune split): what the raster alone spreads, in cells; what turns the median of |r - R| into
# the deviation of the poses, and how much more of it where a radius has few cells (times their side over it, squared):
# beams that see free space outvote the few hits far from the ring, the larger the cells the more
RASTER_SPREAD = 0.6
TO_DEVIATION = 1.12
COARSE = 1.6
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
    count the same: the weighted median of |r - R|, scaled to a deviation, less the raster's own in squares.
    """
    cells = band_cells(grid.labels, centres, radius, BAND * radius)
    seen = cells.seen(centres, facings)
    away = np.abs(seen.r - radius)
    near = (away <= BAND * radius) & (seen.ahead >= cells.each(np.cos(reach)))
    cells, away, weight = cells.take(near), away[near], 1 / np.maximum(seen.r[near], 1)
    order = np.argsort(cells.ring * (2 * radius) + away)
    count, total = cells.counts, np.cumsum(weight[order])
    ends = np.cumsum(count)
    before = np.append(0.0, total)[ends - count]
    # the first cell at which half of its ring's weight is reached
    middle = np.searchsorted(total, (before + np.append(0.0, total)[ends]) / 2)
    spread = np.full(len(centres), BAND * radius)
    some = count > 0
    spread[some] = TO_DEVIATION * (1 + COARSE / radius**2) * away[order][np.minimum(middle, ends - 1)[some]]
    return np.sqrt(np.maximum(0.0, spread**2 - RASTER_SPREAD**2))
