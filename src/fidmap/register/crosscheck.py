"""The other side of a sweep: what the fiducial parts can be worth at most in boxes that it left open."""

from __future__ import annotations

import math

import numpy as np

from fidmap.geometry import ComplexArray
from fidmap.model import FloatArray
from fidmap.register.landscape import IntArray, Landscape


def fiducial_sums(
    land: Landscape, rotation: float, scale: float, half: tuple[float, float, float], places: ComplexArray
) -> FloatArray:
    """(B,) sums over fiducial parts of the best admissible pair, upper bounds of boxes about `places` (B,) x + iy.

    half: half widths of the boxes: rotation (radians), scale, x and y (metres). The distance from every place that a
    fiducial part can have, seen from the pivot, to the nearest moved barrel part is kept in an image.
    """
    half_turn, half_scale, half_side = half
    cell = 2 * half_side
    arms = scale * np.exp(1j * rotation) * land.barrels[land.used]
    swing = 2 * math.sin(min(half_turn, math.pi) / 2) * (scale + half_scale) + half_scale
    reach = land.arms[land.used] * swing + math.sqrt(2) * cell
    far = land.problem.d_max + float(reach.max())
    size = math.ceil(far / cell)
    low = complex(float((-arms).real.min()), float((-arms).imag.min())) - (1 + 1j) * (size + 1) * cell
    shape = tuple(math.ceil(float(np.ptp(part)) / cell) + 2 * size + 4 for part in (arms.imag, arms.real))
    at = np.floor((-arms - low).real / cell).astype(int), np.floor((-arms - low).imag / cell).astype(int)
    step = np.arange(-size, size + 1)
    column, row = at[0][:, None] + step, at[1][:, None] + step
    dx = low.real + column * cell + arms.real[:, None]
    dy = low.imag + row * cell + arms.imag[:, None]
    near = np.hypot(dx[:, None, :], dy[:, :, None]) - reach[:, None, None]
    cells = row[:, :, None] * shape[1] + column[:, None, :]
    total = np.zeros(len(places))
    for fiducials, barrels in _groups(land, rotation, half_turn):
        field = np.full(shape[0] * shape[1], 1e6)
        np.minimum.at(field, cells[barrels].ravel(), near[barrels].ravel())
        worth = land.worth(np.maximum(field, 0.0))
        spots = places[:, None] - land.fiducials[fiducials] - low
        right, up = np.rint(spots.real / cell).astype(int), np.rint(spots.imag / cell).astype(int)
        inside = (right >= 0) & (up >= 0) & (right < shape[1]) & (up < shape[0])
        total += np.where(inside, worth[np.where(inside, up * shape[1] + right, 0)], 0.0).sum(axis=1)
    return total


def _groups(land: Landscape, rotation: float, spread: float) -> list[tuple[IntArray, IntArray]]:
    """Fiducial parts that are open to the same barrel parts (positions among the used), with those barrel parts."""
    open_to = land.possible[:, land.used]
    if land.faced:
        rows = np.arange(len(land.fiducials))
        open_to = open_to & ~land.clash(rows[:, None], land.used[None], rotation, spread)
    sets: dict[bytes, list[int]] = {}
    for i, one in enumerate(np.packbits(open_to, axis=1)):
        sets.setdefault(one.tobytes(), []).append(i)
    return [(np.array(rows), np.flatnonzero(open_to[rows[0]])) for rows in sets.values() if open_to[rows[0]].any()]
