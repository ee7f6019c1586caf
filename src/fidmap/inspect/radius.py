"""The radius of a map's arcs, fitted with the radius left free."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fidmap.detect import find_barrel_parts
from fidmap.geometry import circle_through
from fidmap.grid import metres_to_cells
from fidmap.model import BarrelPart, FloatArray, Label, TrinaryGrid

# arcs of half to twice the radius are seen by a detector for one of these times the radius
NEAR, FAR = (0.8, 1.25), (0.64, 1.56)
BONUS = 1.25  # for the radius that was stated
LEAST_ARCS, MOST_ARCS = 3, 10
LEAST_CONFIDENCE = 0.5
# thick walls and sparse scans draw sound arcs up to 0.15 off with 6 cells per radius, 0.2 with 3
OFF, OFF_CELLS = 0.1, 0.3
FINE_CELLS = 5  # of 49 sound maps (tune split) with so many cells per radius one is drawn a tenth off
SUSPICIOUS_CELLS = 0.15  # other radii are tried from here on
# no sound map shows so many times more with another radius than with its own
MANIFOLD, MANY = 2.0, 5
ENOUGH_CELLS = 6


@dataclass(frozen=True)
class SeenArcs:
    """The sure arcs of a map and their common radius.

    factor: of the stated radius, which a detector needs to see them; gain: how many times more it shows. ratio: median
    of the fitted radii to the stated one, None where fewer than three could be fitted; error: its standard error, of
    fewer than five half their range.
    """

    parts: tuple[BarrelPart, ...]
    factor: float
    ratio: float | None
    error: float
    gain: float = 1.0

    def is_off(self, radius_cells: float) -> bool:
        """Whether the radius differs from the stated one (in cells) by more than sound maps draw it wrong."""
        if self.ratio is None:
            return False
        if self.gain >= MANIFOLD and len(self.parts) >= MANY:
            return abs(self.ratio - 1) > OFF and (self.ratio > 1) == (self.factor > 1)
        return abs(self.ratio - 1) > OFF + OFF_CELLS / radius_cells + 2 * self.error

    def may_be_off(self, radius_cells: float) -> bool:
        """Whether the radius differs by a tenth and more, where cells are fine enough for that to be rare."""
        return self.ratio is not None and abs(self.ratio - 1) > OFF and radius_cells >= FINE_CELLS


def seen_arcs(trinary: TrinaryGrid, radius_m: float, parts: Sequence[BarrelPart], enough: float = math.inf) -> SeenArcs:
    """The radius of what was found with the stated one, or with others where those show clearly more.

    Args:
        trinary: the map.
        radius_m: as stated.
        parts: what the detector found with it.
        enough: with so many sure ones of about that radius no other radius is tried.
    """
    stated = _fitted(trinary, radius_m, 1.0, _sure(parts))
    near = OFF + SUSPICIOUS_CELLS * trinary.resolution_m / radius_m
    if len(stated.parts) >= enough and stated.ratio is not None and abs(stated.ratio - 1) + 2 * stated.error < near:
        return stated
    best, most = stated, BONUS * _worth(stated.parts)
    for factors in (NEAR, FAR):
        for factor in factors:
            found = _found_with(trinary, factor * radius_m)
            if _worth(found) > most:
                best, most = SeenArcs(found, factor, None, 0.0), _worth(found)
        if best is stated or best.factor not in factors:
            break
    if best is stated:
        return stated
    gain = most / max(_worth(stated.parts), LEAST_CONFIDENCE)
    return replace(_fitted(trinary, radius_m, best.factor, best.parts), gain=gain)


def _sure(parts: Sequence[BarrelPart]) -> tuple[BarrelPart, ...]:
    return tuple(part for part in parts if part.confidence >= LEAST_CONFIDENCE)


def _worth(parts: Sequence[BarrelPart]) -> float:
    return sum(part.confidence for part in parts)


def _found_with(trinary: TrinaryGrid, radius_m: float) -> tuple[BarrelPart, ...]:
    return _sure(find_barrel_parts(trinary, radius_m)) if radius_m >= 2 * trinary.resolution_m else ()


def _fitted(trinary: TrinaryGrid, radius_m: float, factor: float, parts: tuple[BarrelPart, ...]) -> SeenArcs:
    """The median of the surest arcs' radii, and its standard error from their absolute deviations.

    Those of a few arcs say little: two may agree by chance.
    """
    surest = sorted(parts, key=lambda part: -part.confidence)[:MOST_ARCS]
    radii = [r / radius_m for part in surest if (r := _radius_m(trinary, part, factor * radius_m)) is not None]
    if len(radii) < LEAST_ARCS:
        return SeenArcs(parts, factor, None, 0.0)
    ratio = float(np.median(radii))
    if len(radii) < MANY:
        return SeenArcs(parts, factor, ratio, (max(radii) - min(radii)) / 2)
    deviation = 1.4826 * float(np.median(np.abs(np.array(radii) - ratio)))
    return SeenArcs(parts, factor, ratio, 1.2533 * deviation / math.sqrt(len(radii)))


def _radius_m(trinary: TrinaryGrid, part: BarrelPart, radius_m: float) -> float | None:
    """Radius of a circle through the walls near an arc, centre and radius free, twice trimmed; metres."""
    radius = radius_m / trinary.resolution_m
    centre = metres_to_cells(np.array([[part.x_m, part.y_m]]), trinary.resolution_m, trinary.origin)[0]
    cells = _walls_near(trinary, centre, 1.4 * radius) - centre
    if part.facing is not None:
        facing = part.facing - trinary.origin.yaw
        ahead = cells @ np.array([np.sin(facing), np.cos(facing)])
        cells = cells[ahead > 0.2 * radius]
    middle, fitted = np.zeros(2), radius
    for tolerance in (0.3, 0.15, 0.1):
        near = cells[np.abs(np.hypot(*(cells - middle).T) - fitted) < max(1.5, tolerance * radius)]
        if len(near) < ENOUGH_CELLS:
            return None
        middle, fitted = circle_through(near)
    return fitted * trinary.resolution_m if 0.5 < fitted / radius < 2 else None


def _walls_near(trinary: TrinaryGrid, centre: FloatArray, reach: float) -> FloatArray:
    """Centres (N, 2) of occupied cells within a square around a place, in cells."""
    low = np.maximum(0, np.floor(centre - reach)).astype(int)
    high = np.ceil(centre + reach).astype(int) + 1
    cut = trinary.labels[low[0] : high[0], low[1] : high[1]]
    return np.asarray(np.argwhere(cut == Label.OCCUPIED) + low + 0.5, np.float64)
