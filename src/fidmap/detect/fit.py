"""The last fit: centres to a fraction of a cell, drawn angle, uncertainty and radial spread of found arcs.

Cells, continuous (row, column) coordinates; angles as in `ring`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.detect.arcs import difference
from fidmap.model import FloatArray, Label

Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class BandCells:
    """Occupied cells near K rings, padded to L per ring: offsets (K, L, 2) from the centre's cell, valid (K, L)."""

    points: FloatArray
    valid: Mask


def band_cells(labels: npt.NDArray[np.uint8], centres: FloatArray, radius: float, width: float) -> BandCells:
    """Centres of the occupied cells within `width` of each ring (labels unpadded, centres (K, 2))."""
    reach = int(np.ceil(radius + width)) + 1
    grid = np.arange(-reach, reach + 1)
    offsets = np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1).reshape(-1, 2)
    r = np.hypot(offsets[:, 0], offsets[:, 1])
    offsets = offsets[(r <= radius + width + 1) & (r >= radius - width - 1)]
    index = np.floor(centres).astype(np.intp)[:, None] + offsets[None]
    inside = ((index >= 0) & (index < labels.shape)).all(axis=2)
    clipped = np.clip(index, 0, np.array(labels.shape) - 1)
    occupied = inside & (labels[clipped[..., 0], clipped[..., 1]] == Label.OCCUPIED)
    return BandCells(index + 0.5, occupied)


def polar(cells: BandCells, centres: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Radius and angle (K, L) of the cells about the centres."""
    away = cells.points - centres[:, None]
    return np.hypot(away[..., 0], away[..., 1]), np.arctan2(away[..., 0], away[..., 1])


def fit_centres(
    cells: BandCells,
    centres: FloatArray,
    facings: FloatArray,
    reach: FloatArray,
    radius: float,
    width: float,
    bias_prior: float | None,
    rounds: int = 6,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Robust fixed-radius fits (K, 2), each to the cells within `reach` of its facing.

    With `bias_prior` (one sigma, cells) the radius is free around the given one by so much; without it is fixed.
    Returns centres, radius offsets (K,) and covariances (K, 3, 3) of (row, column, radius) in units of the
    residual variance.
    """
    offset = np.zeros(len(centres))
    information = np.tile(np.eye(3), (len(centres), 1, 1))
    for _ in range(rounds):
        r, angle = polar(cells, centres)
        residual = r - radius - offset[:, None]
        near = cells.valid & (np.abs(difference(angle, facings[:, None])) <= reach[:, None])
        ratio = residual / width
        weight = np.where(near & (np.abs(ratio) < 1), (1 - ratio**2) ** 2, 0.0)
        design = np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)], axis=-1)
        normal = np.einsum("kl,kli,klj->kij", weight, design, design)
        prior = np.array([0.05, 0.05, 1e9 if bias_prior is None else (0.4 / bias_prior) ** 2])
        information = normal + np.diag(prior)
        right = np.einsum("kl,kli->ki", weight * residual, design)
        right[:, 2] -= prior[2] * offset if bias_prior is not None else 0.0
        move = np.linalg.solve(information, right[..., None])[..., 0]
        centres = centres + move[:, :2]
        if bias_prior is not None:
            offset = offset + move[:, 2]
    return centres, offset, np.linalg.inv(information)


def drawn_angles(
    cells: BandCells, centres: FloatArray, facings: FloatArray, reach: FloatArray, radius: float
) -> FloatArray:
    """Visible angle (K,): the union of what each occupied cell within one cell of the circle covers.

    A cell covers cell/R; gaps up to 1.5 cells are closed; no fixed bins.
    """
    r, angle = polar(cells, centres)
    relative = difference(angle, facings[:, None])
    near = cells.valid & (np.abs(r - radius) <= 1.0) & (np.abs(relative) <= reach[:, None])
    return np.array(
        [_union(np.sort(a[n]), 1 / radius, w) for a, n, w in zip(relative, near, reach, strict=True)]
    )


def _union(angles: FloatArray, side: float, reach: float) -> float:
    """Measure of the union of intervals of width `side` about sorted angles, gaps up to 1.5 sides closed."""
    if len(angles) == 0:
        return 0.0
    whole = reach >= np.pi
    gaps = np.diff(angles, append=angles[0] + 2 * np.pi if whole else np.inf) - side
    open_gaps = gaps[gaps > 1.5 * side]
    if whole:
        return float(2 * np.pi - open_gaps.sum())
    return float(min(angles[-1] - angles[0] + side - open_gaps[np.isfinite(open_gaps)].sum(), 2 * reach))
