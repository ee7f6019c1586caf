"""What a found arc measures: centre to a fraction of a cell, drawn angle and uncertainty.

Lengths are cells unless a name says metres, centres continuous (row, column), angles as in `strips`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.detect.arcs import HALF, Arcs
from fidmap.detect.ballot import vote
from fidmap.detect.cells import BandCells
from fidmap.detect.centres import centres
from fidmap.detect.fits import circles
from fidmap.detect.network import USUAL_RADIUS
from fidmap.detect.strips import strips
from fidmap.model import FloatArray

Labels = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Measured:
    """K arcs: centres (K, 2), facings, drawn angles, and sigma per axis in metres (K,)."""

    centres: FloatArray
    facings: FloatArray
    drawn: FloatArray
    sigma_m: FloatArray


@dataclass(frozen=True)
class Gaps:
    """From each of N cells near its circle to the next one around it: angle of the cell, gap, ring, whether it is last.

    The next one after a ring's last cell is its first.
    """

    angle: FloatArray
    gap: FloatArray
    ring: npt.NDArray[np.intp]
    last: npt.NDArray[np.bool_]


def measure(labels: Labels, arcs: Arcs, radius: float, resolution_m: float) -> Measured:
    """Measure arcs (K) that are known roughly; radius in cells.

    The centre is that of a fit at the fixed radius, shifted by what each direction around it votes for: mappers draw
    walls thicker or thinner than they are. What is drawn is counted on the fitted circles, which lie on the cells where
    the shifted one need not: that of the radius, or the one that fits best, whichever shows more.
    """
    seen = circles(labels, arcs, radius)
    along_it = strips(labels, seen.centres, arcs.facings, arcs.reach, radius)
    found = centres(vote(along_it, sizes(arcs, radius, resolution_m), arcs.sure), arcs.sure)
    s, c = np.sin(arcs.facings), np.cos(arcs.facings)
    along, across = found.shifts.T
    facings = middles(seen.cells, seen.centres, arcs.facings, arcs.reach > HALF, np.full(len(s), radius))
    rings = (seen.centres, np.full(len(s), radius)), (seen.free_centres, seen.free_radii)
    drawn = [drawn_angles(seen.cells, middle, facings, arcs.reach, radii) for middle, radii in rings]
    return Measured(
        centres=seen.centres + np.stack([along * s + across * c, along * c - across * s], axis=1),
        facings=facings,
        drawn=np.maximum(*drawn),
        sigma_m=found.sigma * resolution_m,
    )


def sizes(arcs: Arcs, radius: float, resolution_m: float) -> FloatArray:
    """(K, 4) what the votes depend on beside the cells: radius in cells, cells in metres, confidence, half or whole."""
    sure = np.clip(arcs.sure, 1e-3, 1 - 1e-3)
    same = np.tile([np.log(radius / USUAL_RADIUS), np.log(resolution_m / 0.05)], (len(sure), 1))
    return np.column_stack([same, np.log(sure / (1 - sure)) / 3, arcs.reach > HALF])


def middles(
    cells: BandCells, centres: FloatArray, facings: FloatArray, whole: npt.NDArray[np.bool_], radii: FloatArray
) -> FloatArray:
    """The middle (K,) of what is drawn of whole circles: opposite to the widest gap; of others, the facing."""
    gaps = _gaps(cells.take(cells.each(whole)), centres, facings, np.full(len(centres), np.pi), radii)
    order = np.lexsort((gaps.gap, gaps.ring))
    widest = order[np.diff(gaps.ring[order], append=-1) != 0]
    found = facings.copy()
    found[gaps.ring[widest]] += gaps.angle[widest] + gaps.gap[widest] / 2 + np.pi
    return found


def drawn_angles(
    cells: BandCells, centres: FloatArray, facings: FloatArray, reach: FloatArray, radii: FloatArray
) -> FloatArray:
    """Visible angle (K,): the union of what each occupied cell within one cell of the circle (K radii) covers.

    A cell covers cell/R; gaps up to 1.5 cells are closed; no fixed bins.
    """
    whole = reach >= np.pi
    gaps = _gaps(cells, centres, facings, reach, radii)
    side = 1 / radii[gaps.ring]
    # around a whole circle all gaps count, on a half the one behind it is where the arc ends
    end = gaps.last & ~whole[gaps.ring]
    covered = np.where(end, side, np.where(gaps.gap - side > 1.5 * side, side, gaps.gap))
    return np.minimum(np.bincount(gaps.ring, covered, len(centres)), 2 * reach)


def _gaps(cells: BandCells, centres: FloatArray, facings: FloatArray, reach: FloatArray, radii: FloatArray) -> Gaps:
    """Between cells within one cell of the circles and reach (K,) of the facings, around each ring."""
    down, right = cells.rows - cells.each(centres[:, 0]), cells.columns - cells.each(centres[:, 1])
    near = np.flatnonzero(np.abs(np.sqrt(down * down + right * right) - cells.each(radii)) <= 1.0)
    down, right, ring = down[near], right[near], cells.ring[near]
    s, c = np.sin(facings)[ring], np.cos(facings)[ring]
    relative = np.arctan2(down * c - right * s, down * s + right * c)
    near = np.flatnonzero(np.abs(relative) <= reach[ring])
    ring = ring[near]
    apart = 3 * np.pi * ring  # the rings are in order already
    angle = np.sort(apart + relative[near]) - apart
    last = np.diff(ring, append=-1) != 0
    first = np.roll(last, 1)
    after = np.roll(angle, -1)
    after[last] = angle[first] + 2 * np.pi
    return Gaps(angle, after - angle, ring, last)
