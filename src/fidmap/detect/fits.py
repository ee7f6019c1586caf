"""Circle fits of a found arc at a known radius, several ways, and how they differ: what its centre is computed from.

Lengths are cells, centres continuous (row, column), angles as in `polar`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.detect.arcs import Arcs, difference
from fidmap.detect.ring import RingSampler, shift, support
from fidmap.model import FloatArray, Label

Mask = npt.NDArray[np.bool_]
Labels = npt.NDArray[np.uint8]
SURE = 0.5  # whose fits tell how a map draws


@dataclass(frozen=True)
class BandCells:
    """Occupied cells near K rings, padded to L per ring: centres of cells (K, L, 2), valid (K, L)."""

    points: FloatArray
    valid: Mask

    def polar(self, centres: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Radius and angle (K, L) of the cells about centres (K, 2)."""
        away = self.points - centres[:, None]
        return np.hypot(away[..., 0], away[..., 1]), np.arctan2(away[..., 0], away[..., 1])


@dataclass(frozen=True)
class Estimates:
    """K arcs: centres (K, 2) of the fit at the fixed radius; numbers about it that a mirror leaves and turns round."""

    centres: FloatArray
    even: FloatArray
    odd: FloatArray


def estimates(labels: Labels, arcs: Arcs, radius: float, resolution_m: float) -> Estimates:
    """Fit every arc by its band's cells, narrow and wide, with a free radius, and by its outer edge.

    even, odd: how these fits and the arc's own rough centre differ from the first along and across the facing; radius
    offset, spreads, edge, thickness; what the map's arcs show on average; sizes.
    """
    narrow, wide = max(1.6, 0.15 * radius), max(2.5, 0.35 * radius)
    cells = band_cells(labels, arcs.centres, radius, wide + 1.5)
    reach = np.maximum(arcs.reach - np.radians(2), np.radians(60))
    base, _ = fit(cells, arcs.centres, arcs.facings, reach, radius, narrow)
    free, offset = fit(cells, base, arcs.facings, reach, radius, narrow, free_radius=True)
    broad, _ = fit(cells, base, arcs.facings, reach, radius, wide)
    outer, edge, edge_spread, thick = _edges(labels, base, arcs.facings, reach, radius)
    shape, lean = _shape(cells, base, arcs.facings, reach, radius, narrow, wide)
    others = [_turned(other - base, arcs.facings) for other in (free, broad, outer, arcs.centres)]
    even = np.column_stack([offset, edge, thick, shape, edge_spread, *(along for along, _ in others)])
    some = arcs.sure > SURE if (arcs.sure > SURE).any() else arcs.sure >= 0
    usual = np.median(even[some], axis=0) if len(even) else np.zeros(even.shape[1])
    sizes = [np.log(some.sum() + 1.0), np.log(radius), np.log(resolution_m / 0.05)]
    sure = np.log((arcs.sure + 1e-4) / (1 - arcs.sure + 1e-4))
    return Estimates(
        centres=base,
        even=np.column_stack([even, np.tile([*usual, *sizes], (len(even), 1)), sure, arcs.reach]),
        odd=np.column_stack([*(across for _, across in others), lean]),
    )


def _turned(shift: FloatArray, facings: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Parts (K,) of (K, 2) shifts along the facing and across it."""
    s, c = np.sin(facings), np.cos(facings)
    return shift[:, 0] * s + shift[:, 1] * c, shift[:, 0] * c - shift[:, 1] * s


def _edges(
    labels: Labels, centres: FloatArray, facings: FloatArray, reach: FloatArray, radius: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """The fit to the outer edge (K, 2); from the given centres the edge's mean place and spread, and thickness."""
    sampler = RingSampler(labels, radius)
    ring = first = sampler.look(centres)
    within = np.abs(difference(sampler.theta[None, :], facings[:, None])) <= reach[:, None]
    outer = centres
    for _ in range(2):
        weight = support(ring, max(2.5, 0.25 * radius)) * within
        outer = outer + shift(sampler.directions, weight, np.nan_to_num(ring.edge))
        ring = sampler.look(outer)
    weight = support(first, max(2.5, 0.25 * radius)) * within + 1e-9
    total, edge = weight.sum(axis=1), np.nan_to_num(first.edge)
    mean = (weight * edge).sum(axis=1) / total
    spread = np.sqrt((weight * (edge - mean[:, None]) ** 2).sum(axis=1) / total)
    return outer, mean, spread, (first.thick * within).sum(axis=1) / within.sum(axis=1)


def _shape(
    cells: BandCells,
    centres: FloatArray,
    facings: FloatArray,
    reach: FloatArray,
    radius: float,
    narrow: float,
    wide: float,
) -> tuple[FloatArray, FloatArray]:
    """How the cells of the narrow and the wide band lie.

    (K, 7) mean and spread of the residuals and share of cells in both bands, share drawn; (K, 3) how they lean aside.
    """
    r, angle = cells.polar(centres)
    residual, relative = r - radius, difference(angle, facings[:, None])
    half = cells.valid & (np.abs(relative) <= reach[:, None])
    even, odd = [], []
    for width in (narrow, wide):
        near = half & (np.abs(residual) <= width)
        count = near.sum(axis=1) + 1e-9
        mean = (residual * near).sum(axis=1) / count
        even += [
            mean,
            np.sqrt((near * (residual - mean[:, None]) ** 2).sum(axis=1) / count),
            count / (2 * reach * radius),
        ]
        odd.append((near * np.sin(relative)).sum(axis=1) / count)
    near = half & (np.abs(residual) <= 1.0)
    odd.append((near * residual * np.sin(relative)).sum(axis=1) / (near.sum(axis=1) + 1e-9))
    even.append(near.sum(axis=1) / (2 * reach * radius))
    return np.column_stack(even), np.column_stack(odd)


def band_cells(labels: Labels, centres: FloatArray, radius: float, width: float) -> BandCells:
    """The occupied cells within about `width` of each ring."""
    reach = int(np.ceil(radius + width)) + 1
    grid = np.arange(-reach, reach + 1)
    offsets = np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1).reshape(-1, 2)
    away = np.hypot(offsets[:, 0], offsets[:, 1])
    offsets = offsets[(away <= radius + width + 1) & (away >= radius - width - 1)]
    index = np.floor(centres).astype(np.intp)[:, None] + offsets[None]
    inside = ((index >= 0) & (index < labels.shape)).all(axis=2)
    index = np.clip(index, 0, np.array(labels.shape) - 1)
    return _packed(index, inside & (labels[index[..., 0], index[..., 1]] == Label.OCCUPIED))


def _packed(index: npt.NDArray[np.intp], valid: Mask) -> BandCells:
    """The valid ones of (K, L) cells side by side, in their order: most cells of a band are not occupied."""
    rows, columns = np.nonzero(valid)
    count = np.bincount(rows, minlength=len(valid))
    places = np.arange(len(rows)) - np.repeat(np.cumsum(count) - count, count)
    points = np.zeros((len(valid), int(count.max(initial=1)), 2))
    kept = np.zeros(points.shape[:2], bool)
    points[rows, places], kept[rows, places] = index[rows, columns] + 0.5, True
    return BandCells(points, kept)


def fit(
    cells: BandCells,
    centres: FloatArray,
    facings: FloatArray,
    reach: FloatArray,
    radius: float,
    width: float,
    free_radius: bool = False,
    rounds: int = 6,
) -> tuple[FloatArray, FloatArray]:
    """Robust circle fits (Tukey's biweight, Gauss-Newton): centres (K, 2) and radius offsets (K,), 0 if it is fixed."""
    offset = np.zeros(len(centres))
    prior = np.array([0.05, 0.05, 0.04 if free_radius else 1e9])
    for _ in range(rounds):
        r, angle = cells.polar(centres)
        residual = r - radius - offset[:, None]
        near = cells.valid & (np.abs(difference(angle, facings[:, None])) <= reach[:, None])
        weight = np.where(near, np.maximum(0, 1 - (residual / width) ** 2) ** 2, 0.0)
        design = np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)], axis=-1)
        information = np.swapaxes(design * weight[..., None], 1, 2) @ design + np.diag(prior)
        right = np.einsum("kl,kli->ki", weight * residual, design)
        right[:, 2] -= prior[2] * offset
        move = np.linalg.solve(information, right[..., None])[..., 0]
        centres, offset = centres + move[:, :2], offset + move[:, 2]
    return centres, offset
