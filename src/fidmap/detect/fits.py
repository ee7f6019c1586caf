"""Circle fits of found arcs by the occupied cells near them, with the radius fixed and with it free.

Lengths are cells, centres continuous (row, column), angles as in `polar`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.detect.arcs import Arcs
from fidmap.detect.cells import BandCells, band_cells
from fidmap.model import FloatArray

Labels = npt.NDArray[np.uint8]
BANDS, ROUNDS = 2, 3  # how often the band's cells are seen anew from the centre found, and weighed anew
LOOSE = 0.1
PRIOR = 0.05, 0.04  # what holds a shift and a radius where nothing else does, in cells of evidence


@dataclass(frozen=True)
class Circles:
    """K arcs: centres (K, 2) of the fit at the fixed radius, and what may be counted on.

    free_centres, free_radii: the fit with a free radius, which is within a tenth of the fixed one. cells: the occupied
    cells near the rings.
    """

    centres: FloatArray
    free_centres: FloatArray
    free_radii: FloatArray
    cells: BandCells


@dataclass(frozen=True)
class Band:
    """The cells of K arcs from their centres, each (N,): distance from the ring, sine and cosine of the direction."""

    cells: BandCells
    residual: FloatArray
    sine: FloatArray
    cosine: FloatArray


def circles(labels: Labels, arcs: Arcs, radius: float) -> Circles:
    """Fit every arc by the cells of a narrow band around it; radius in cells."""
    narrow = max(1.6, 0.15 * radius)
    near = band_cells(labels, arcs.centres, radius, 2 * narrow)  # centres may move by as much
    reach = np.maximum(arcs.reach - np.radians(2), np.radians(60))
    centres = arcs.centres
    for _ in range(BANDS):
        centres = centres + fit(band(near, centres, arcs.facings, reach, radius), narrow)[0]
    free, offset = fit(band(near, centres, arcs.facings, reach, radius), narrow, free_radius=True)
    return Circles(centres, centres + free, radius + np.clip(offset, -LOOSE * radius, LOOSE * radius), near)


def band(cells: BandCells, centres: FloatArray, facings: FloatArray, reach: FloatArray, radius: float) -> Band:
    """The cells within reach (K,) of the facings, from there."""
    seen = cells.seen(centres, facings)
    half = seen.ahead >= cells.each(np.cos(reach))
    return Band(cells.take(half), seen.r[half] - radius, seen.sine[half], seen.cosine[half])


def fit(band: Band, width: float, free_radius: bool = False) -> tuple[FloatArray, FloatArray]:
    """Robust circle fits (Tukey's biweight, Gauss-Newton): shifts (K, 2) and radius offsets (K,), 0 if it is fixed.

    Directions are those seen from the given centres: shifts are small beside the radius.
    """
    a, b, each, total = band.sine, band.cosine, band.cells.each, band.cells.sum
    moved, offset = np.zeros((len(band.cells.counts), 2)), np.zeros(len(band.cells.counts))
    for _ in range(ROUNDS):
        residual = band.residual - a * each(moved[:, 0]) - b * each(moved[:, 1]) - each(offset)
        weight = np.maximum(0, 1 - (residual / width) ** 2)
        weight *= weight
        wa, wb = weight * a, weight * b
        normal = [total(v) for v in (wa * a, wa * b, wb * b, wa * residual, wb * residual)]
        if free_radius:  # eliminated: what is left are shifts
            to_a, to_b, whole = total(wa), total(wb), total(weight) + PRIOR[1]
            pull = total(weight * residual) - PRIOR[1] * offset
            taken = (to_a**2, to_a * to_b, to_b**2, to_a * pull, to_b * pull)
            normal = [n - v / whole for n, v in zip(normal, taken, strict=True)]
        move = _solved(normal, PRIOR[0])
        if free_radius:
            offset = offset + (pull - to_a * move[:, 0] - to_b * move[:, 1]) / whole
        moved = moved + move
    return moved, offset


def _solved(normal: Sequence[FloatArray], ridge: float) -> FloatArray:
    """Shifts (K, 2) that solve the normal equations [[aa, ab], [ab, bb]] x = [a, b], given in this order, ridged."""
    aa, ab, bb, a, b = normal
    aa, bb = aa + ridge, bb + ridge
    return np.asarray(np.stack([bb * a - ab * b, aa * b - ab * a], axis=1) / (aa * bb - ab * ab)[:, None])
