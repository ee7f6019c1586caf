"""What a found arc measures: centre to a fraction of a cell, drawn angle and uncertainty.

Lengths are cells unless a name says metres, centres continuous (row, column), angles as in `ring`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.detect.arcs import HALF, Arcs, difference
from fidmap.detect.fits import BandCells, band_cells, estimates
from fidmap.detect.network import correct
from fidmap.model import FloatArray

Labels = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Measured:
    """K arcs: centres (K, 2), facings, drawn angles, and sigma per axis in metres (K,)."""

    centres: FloatArray
    facings: FloatArray
    drawn: FloatArray
    sigma_m: FloatArray


def measure(labels: Labels, arcs: Arcs, radius: float, resolution_m: float) -> Measured:
    """Measure arcs (K) that are known roughly; radius in cells.

    The centre is that of a fit at the fixed radius, corrected by a network that compares it with other fits of the
    same cells and with what the map's other arcs show: mappers draw walls thicker or thinner than they are.
    """
    seen = estimates(labels, arcs, radius, resolution_m)
    along, across, log_sigma = correct(seen.even, seen.odd).T
    s, c = np.sin(arcs.facings), np.cos(arcs.facings)
    centres = seen.centres + np.stack([along * s + across * c, along * c - across * s], axis=1)
    cells = band_cells(labels, centres, radius, 1.0)
    facings = np.where(arcs.reach > HALF, middles(cells, centres, arcs.facings, radius), arcs.facings)
    return Measured(
        centres=centres,
        facings=facings,
        drawn=drawn_angles(cells, centres, facings, arcs.reach, radius),
        sigma_m=np.exp(log_sigma) * resolution_m,
    )


def middles(cells: BandCells, centres: FloatArray, facings: FloatArray, radius: float) -> FloatArray:
    """The middle (K,) of what is drawn of each circle: opposite to its widest gap; the facing where nothing is."""
    r, angle = cells.polar(centres)
    near = cells.valid & (np.abs(r - radius) <= 1.0)
    found = facings.copy()
    for k in np.flatnonzero(near.any(axis=1)):
        drawn = np.sort(angle[k, near[k]])
        gaps = np.diff(np.append(drawn, drawn[0] + 2 * np.pi))
        widest = int(np.argmax(gaps))
        found[k] = drawn[widest] + gaps[widest] / 2 + np.pi
    return found


def drawn_angles(
    cells: BandCells, centres: FloatArray, facings: FloatArray, reach: FloatArray, radius: float
) -> FloatArray:
    """Visible angle (K,): the union of what each occupied cell within one cell of the circle covers.

    A cell covers cell/R; gaps up to 1.5 cells are closed; no fixed bins.
    """
    r, angle = cells.polar(centres)
    relative = difference(angle, facings[:, None])
    near = cells.valid & (np.abs(r - radius) <= 1.0) & (np.abs(relative) <= reach[:, None])
    return np.array([_union(np.sort(a[n]), 1 / radius, w) for a, n, w in zip(relative, near, reach, strict=True)])


def _union(angles: FloatArray, side: float, reach: float) -> float:
    """Measure of the union of intervals of width `side` about sorted angles, gaps up to 1.5 sides closed."""
    if len(angles) == 0:
        return 0.0
    around = np.append(angles, angles[0] + 2 * np.pi) if reach >= np.pi else angles
    gaps = np.diff(around) - side
    open_gaps = float(gaps[gaps > 1.5 * side].sum())
    ends = 0.0 if reach >= np.pi else side
    return float(min(around[-1] - around[0] + ends - open_gaps, 2 * reach))
