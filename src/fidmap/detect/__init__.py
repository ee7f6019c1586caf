"""TrinaryGrid + radius -> barrel parts: all arcs of the known radius, convex towards free space (SSRR 2011, II-A-3).

On cells coarse enough for the radius, those that touch an obstacle vote for centres behind it; small networks, trained
on artificial maps and run A2 of the real ones, look at polar windows around these centres and say where half circles
and whole ones stand and how sure that is; what remains is measured in the map's own cells, and faces as the walls
around tell as well. The detector knows no arena.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import numpy.typing as npt

from fidmap.detect.arcs import Arcs, hypotheses, suppress
from fidmap.detect.coarse import coarser, factor
from fidmap.detect.measure import Measured, measure
from fidmap.detect.polar import Windower
from fidmap.detect.spread import with_spreads
from fidmap.detect.votes import boundary, centre_candidates
from fidmap.detect.walls import Walls, towards_walls, walls_around
from fidmap.grid import cells_to_metres
from fidmap.model import BarrelPart, FloatArray, SettingsError, TrinaryGrid

__all__ = ["find_barrel_parts", "with_spreads"]

Labels = npt.NDArray[np.uint8]
LEAST_CONFIDENCE = 0.02
LEAST_DRAWN = math.pi / 2
WHOLE = math.radians(300)
KEPT_BYTES = 31 * 2**20


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
    _keep_freed_memory()
    arcs, walls = half_circles(grid.labels, radius)
    if len(arcs.sure) == 0:
        return ()
    found = measure(grid.labels, arcs, radius, grid.resolution_m)
    found = replace(found, facings=towards_walls(found.facings, walls))
    return with_spreads(grid, _barrel_parts(grid, found, arcs.sure), radius_m)


@cache
def _keep_freed_memory() -> None:
    """Let the C library use freed memory again, once for the process; without it a quarter of the time is page faults.

    glibc returns freed chunks to the system at once when they are larger than any freed before, up to 32 MiB; this one
    is never touched.
    """
    np.empty(KEPT_BYTES, np.uint8)


def half_circles(labels: Labels, radius: float) -> tuple[Arcs, Walls]:
    """Half circles and more of a radius (cells), each once, most probable first, and the walls around each of them.

    Centres are in the map's own cells.
    """
    times = factor(radius)
    small = coarser(labels, times)
    windower = Windower(small, radius / times)
    edge = boundary(small, windower.radius)
    arcs = hypotheses(windower, centre_candidates(edge, windower.radius))
    arcs = arcs.take(arcs.sure >= LEAST_CONFIDENCE)
    arcs = arcs.take(suppress(arcs, windower.radius))
    return replace(arcs, centres=arcs.centres * times), walls_around(arcs, edge, windower.radius)


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
