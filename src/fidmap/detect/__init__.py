"""TrinaryGrid + radius -> barrel parts: all arcs of the known radius, convex towards free space (SSRR 2011, II-A-3).

On cells coarse enough for the radius, those that touch an obstacle vote for centres behind it; around each candidate
half circles are fitted at the fixed radius, the two halves on one wall each by itself; a small network trained on
artificial maps and run A2 of the real ones says how sure each is; what remains is measured in the map's own cells. The
detector knows no arena.
"""

from __future__ import annotations

import math

import numpy as np

from fidmap.detect.coarse import propose
from fidmap.detect.confidence import confidence
from fidmap.detect.extent import extents, suppress
from fidmap.detect.measure import Measured, measure
from fidmap.detect.spread import with_spreads
from fidmap.grid import cells_to_metres
from fidmap.model import BarrelPart, FloatArray, SettingsError, TrinaryGrid

__all__ = ["find_barrel_parts", "with_spreads"]

LEAST_CONFIDENCE = 0.02
LEAST_DRAWN = math.pi / 2
WHOLE = math.radians(300)


def find_barrel_parts(grid: TrinaryGrid, radius_m: float) -> tuple[BarrelPart, ...]:
    """All arcs of a radius that are drawn over at least 90 degrees, most confident first, numbered from 1.

    Args:
        grid: the trinarized map.
        radius_m: radius of the barrels, metres; at least two cells.

    Returns:
        Barrel parts in the map's frame: centre to a fraction of a cell, facing (none for arcs of 300 degrees and
        more), drawn angle, sigma, confidence and radial spread.

    Raises:
        SettingsError: the radius is not positive, or smaller than two cells.
    """
    radius = radius_m / grid.resolution_m
    if not math.isfinite(radius) or radius < 2:
        raise SettingsError(
            f"a radius of {radius_m:g} m is {radius:.2g} cells of {grid.resolution_m:g} m: arcs need at least 2 cells; "
            "give the radius in metres, or a finer map"
        )
    sampler, arcs, factor = propose(grid.labels, radius)
    if len(arcs.facings) == 0:
        return ()
    sure = confidence(sampler, arcs)
    order = np.argsort(-sure, kind="stable")
    order = order[sure[order] >= LEAST_CONFIDENCE]
    arcs, sure = arcs.take(order), sure[order]
    seen = extents(sampler, arcs)
    kept = suppress(seen, sampler.radius)
    centres, facings, reach = seen.centres[kept] * factor, seen.facings[kept], seen.reach[kept]
    found = measure(grid.labels, centres, facings, reach, radius, grid.resolution_m)
    return with_spreads(grid, _barrel_parts(grid, found, sure[kept]), radius_m)


def _barrel_parts(grid: TrinaryGrid, found: Measured, sure: FloatArray) -> tuple[BarrelPart, ...]:
    """Arcs in cells to numbered barrel parts in the map's frame."""
    places = cells_to_metres(found.centres, grid.resolution_m, grid.origin)
    enough = [k for k in range(len(sure)) if found.drawn[k] >= LEAST_DRAWN]
    return tuple(
        BarrelPart(
            n=n,
            x_m=float(places[k, 0]),
            y_m=float(places[k, 1]),
            facing=None if found.drawn[k] >= WHOLE else _wrapped(float(found.facings[k]) + grid.origin.yaw),
            drawn=float(found.drawn[k]),
            sigma_m=float(found.sigma_m[k]),
            confidence=float(sure[k]),
        )
        for n, k in enumerate(enough, start=1)
    )


def _wrapped(angle: float) -> float:
    """The same direction in (-pi, pi]."""
    return math.atan2(math.sin(angle), math.cos(angle))
