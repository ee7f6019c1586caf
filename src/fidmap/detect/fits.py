"""Circle fits of a found arc at a known radius, several ways, and how they differ: what its centre is computed from.

Lengths are cells, centres continuous (row, column), angles as in `polar`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.detect.arcs import Arcs
from fidmap.detect.cells import BandCells, band_cells
from fidmap.detect.ring import Edges, edges
from fidmap.model import FloatArray

Labels = npt.NDArray[np.uint8]
SURE = 0.5  # whose fits tell how a map draws
ROUNDS = 3
LOOSE = 0.1
PRIOR = 0.05, 0.04  # what holds a shift and a radius where nothing else does, in cells of evidence


@dataclass(frozen=True)
class Estimates:
    """K arcs: centres (K, 2) of the fit at the fixed radius; numbers about it that a mirror leaves and turns round.

    free_centres, free_radii: the fit with a free radius, which is within a tenth of the fixed one. cells: the occupied
    cells near the rings.
    """

    centres: FloatArray
    free_centres: FloatArray
    free_radii: FloatArray
    even: FloatArray
    odd: FloatArray
    cells: BandCells


@dataclass(frozen=True)
class Band:
    """The cells of K arcs as the arcs' centres see them, each (N,).

    residual: distance from the ring; sine, cosine: of the direction; aside: its sine relative to the facing.
    """

    cells: BandCells
    residual: FloatArray
    sine: FloatArray
    cosine: FloatArray
    aside: FloatArray


def estimates(labels: Labels, arcs: Arcs, radius: float, resolution_m: float) -> Estimates:
    """Fit every arc by its band's cells, narrow and wide, with a free radius, and by its outer edge.

    even, odd: how these fits and the arc's own rough centre differ from the first along and across the facing; radius
    offset, spreads, edge, thickness; what the map's arcs show on average; sizes.
    """
    narrow, wide = max(1.6, 0.15 * radius), max(2.5, 0.35 * radius)
    near = band_cells(labels, arcs.centres, radius, wide + 1.5)
    reach = np.maximum(arcs.reach - np.radians(2), np.radians(60))
    base = arcs.centres
    for _ in range(ROUNDS):
        base = base + fit(band(near, base, arcs.facings, reach, radius), narrow)[0]
    cells = band(near, base, arcs.facings, reach, radius)
    free, offset = fit(cells, narrow, free_radius=True)
    broad, _ = fit(cells, wide)
    edge = edges(labels, base, arcs.facings, reach, radius)
    outer, rim = _outer(edge, radius)
    shape, lean = _shape(cells, reach, radius, narrow, wide)
    others = [_turned(shift, arcs.facings) for shift in (free, broad, outer, arcs.centres - base)]
    even = np.column_stack([offset, shape, rim, *(along for along, _ in others)])
    some = arcs.sure > SURE if (arcs.sure > SURE).any() else arcs.sure >= 0
    usual = np.median(even[some], axis=0) if len(even) else np.zeros(even.shape[1])
    sizes = [np.log(some.sum() + 1.0), np.log(radius), np.log(resolution_m / 0.05)]
    sure = np.log((arcs.sure + 1e-4) / (1 - arcs.sure + 1e-4))
    shared = np.tile([*usual, *sizes], (len(even), 1))
    return Estimates(
        centres=base,
        free_centres=base + free,
        free_radii=radius + np.clip(offset, -LOOSE * radius, LOOSE * radius),
        even=np.column_stack([even, shared, sure, arcs.reach]),
        odd=np.column_stack([*(across for _, across in others), lean]),
        cells=near,
    )


def band(cells: BandCells, centres: FloatArray, facings: FloatArray, reach: FloatArray, radius: float) -> Band:
    """The cells within reach (K,) of the facings, from there."""
    seen = cells.seen(centres, facings)
    half = seen.ahead >= cells.each(np.cos(reach))
    some = cells.take(half)
    sine, cosine = seen.sine[half], seen.cosine[half]
    aside = sine * some.each(np.cos(facings)) - cosine * some.each(np.sin(facings))
    return Band(some, seen.r[half] - radius, sine, cosine, aside)


def _turned(shift: FloatArray, facings: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Parts (K,) of (K, 2) shifts along the facing and across it."""
    s, c = np.sin(facings), np.cos(facings)
    return shift[:, 0] * s + shift[:, 1] * c, shift[:, 0] * c - shift[:, 1] * s


def _outer(edge: Edges, radius: float) -> tuple[FloatArray, FloatArray]:
    """Shift (K, 2) to the fit to the outer edge; the edge's mean place and spread before it, and thickness (K, 3).

    The weight of an edge is 1 on the ring and 0 a quarter of the radius away from it.
    """
    tolerance, moved = max(2.5, 0.25 * radius), np.zeros((len(edge.place), 2))
    weight = np.where(edge.there, np.maximum(0, 1 - (edge.place / tolerance) ** 2), 0.0)
    total = weight.sum(axis=1) + 1e-9
    mean = (weight * edge.place).sum(axis=1) / total
    spread = np.sqrt((weight * (edge.place - mean[:, None]) ** 2).sum(axis=1) / total)
    for _ in range(2):
        left = edge.place - edge.sine * moved[:, :1] - edge.cosine * moved[:, 1:]
        weight = np.where(edge.there, np.maximum(0, 1 - (left / tolerance) ** 2), 0.0)
        sine, cosine = weight * edge.sine, weight * edge.cosine
        products = (sine * edge.sine, sine * edge.cosine, cosine * edge.cosine, sine * left, cosine * left)
        moved = moved + _solved([p.sum(axis=1) for p in products], 10 * PRIOR[0])
    return moved, np.column_stack([mean, spread, edge.thick.mean(axis=1)])


def _shape(band: Band, reach: FloatArray, radius: float, narrow: float, wide: float) -> tuple[FloatArray, FloatArray]:
    """How the cells of the narrow and the wide band lie.

    (K, 7) mean and spread of the residuals and share of cells in both bands, share drawn; (K, 3) how they lean aside.
    """
    residual, total = band.residual, band.cells.sum
    length = 2 * reach * radius
    even, odd = [], []
    for width in (narrow, wide):
        near = (np.abs(residual) <= width).astype(np.float64)
        count = total(near) + 1e-9
        mean = total(residual * near) / count
        square = total(near * residual**2) / count - mean**2
        even += [mean, np.sqrt(np.maximum(square, 0)), count / length]
        odd.append(total(near * band.aside) / count)
    near = (np.abs(residual) <= 1.0).astype(np.float64)
    even.append(total(near) / length)
    odd.append(total(near * residual * band.aside) / (total(near) + 1e-9))
    return np.column_stack(even), np.column_stack(odd)


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
