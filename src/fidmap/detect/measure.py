"""What a found arc measures: centre to a fraction of a cell, drawn angle and uncertainty.

Lengths are cells unless a name says metres, centres continuous (row, column), angles as in `ring`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.detect.arcs import difference
from fidmap.model import FloatArray, Label

Mask = npt.NDArray[np.bool_]
Labels = npt.NDArray[np.uint8]

# Mappers draw arcs a little inside of the surface. Tuned on artificial maps (tune split) and on run A2 of real ones:
# the mean offset, and how much of the offset seen in a map's own arcs (a noisy estimate) to believe.
OFFSET_M = -0.0065
BELIEVED = 0.5
MOST_OFFSET = 0.6
# radial noise of one cell of a clean arc, and what correlated noise adds; tuned the same way
CELL_SIGMA = 0.4
INFLATION = 2.0
POSE_SIGMA_M = 0.004


@dataclass(frozen=True)
class Measured:
    """K arcs: centres (K, 2), facings, drawn angles, and sigma per axis in metres (K,)."""

    centres: FloatArray
    facings: FloatArray
    drawn: FloatArray
    sigma_m: FloatArray


@dataclass(frozen=True)
class BandCells:
    """Occupied cells near K rings, padded to L per ring: centres of cells (K, L, 2), valid (K, L)."""

    points: FloatArray
    valid: Mask

    def polar(self, centres: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Radius and angle (K, L) of the cells about centres (K, 2)."""
        away = self.points - centres[:, None]
        return np.hypot(away[..., 0], away[..., 1]), np.arctan2(away[..., 0], away[..., 1])


def measure(
    labels: Labels,
    centres: FloatArray,
    facings: FloatArray,
    reach: FloatArray,
    radius: float,
    resolution_m: float,
) -> Measured:
    """Measure arcs whose centres (K, 2), facings and reach to each side (K,) are known roughly.

    First the radius that this map draws is estimated from all its arcs, then each centre is fitted at that radius,
    robustly, to the occupied cells of its band.
    """
    width = max(1.6, 0.15 * radius)
    cells = band_cells(labels, centres, radius, width + 1.5)
    inside = np.maximum(reach - np.radians(2), np.radians(60))
    _, offsets, variances = _fit(cells, centres, facings, inside, radius, width, free_radius=True)
    drawn_radius = radius + map_offset(offsets, variances[:, 2, 2], resolution_m)
    centres, _, variances = _fit(cells, centres, facings, inside, drawn_radius, width, free_radius=False)
    sigma = CELL_SIGMA * resolution_m * np.sqrt(INFLATION * np.trace(variances[:, :2, :2], axis1=1, axis2=2) / 2)
    return Measured(
        centres=centres,
        facings=facings,
        drawn=drawn_angles(cells, centres, facings, reach, radius),
        sigma_m=np.hypot(sigma, POSE_SIGMA_M),
    )


def map_offset(offsets: FloatArray, variances: FloatArray, resolution_m: float) -> float:
    """How far outside of the true radius this map draws its arcs, in cells, from free fits (K,) of all of them."""
    usual = OFFSET_M / resolution_m
    if len(offsets) == 0:
        return usual
    weight = 1 / (variances * CELL_SIGMA**2 + 0.02)
    seen = float((weight * offsets).sum() / weight.sum())
    trust = BELIEVED * min(1.0, len(offsets) / 4)
    return usual + trust * float(np.clip(seen, -MOST_OFFSET, MOST_OFFSET))


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
    return BandCells(index + 0.5, inside & (labels[index[..., 0], index[..., 1]] == Label.OCCUPIED))


def _fit(
    cells: BandCells,
    centres: FloatArray,
    facings: FloatArray,
    reach: FloatArray,
    radius: float,
    width: float,
    free_radius: bool,
    rounds: int = 6,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Robust circle fits (Tukey's biweight, Gauss-Newton), the radius fixed or free within two cells.

    Returns centres (K, 2), radius offsets (K,) and covariances (K, 3, 3) of (row, column, radius) for cells of unit
    variance.
    """
    offset = np.zeros(len(centres))
    prior = np.array([0.05, 0.05, 0.04 if free_radius else 1e9])
    information = np.tile(np.diag(prior), (len(centres), 1, 1))
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
    return centres, offset, np.linalg.inv(information)


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
