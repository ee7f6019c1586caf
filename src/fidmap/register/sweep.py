"""All placements in one sweep: for every rotation, images of what a barrel part would be worth, added up shifted.

For one rotation (and scale) the sum over barrel parts of what the nearest admissible fiducial part gives, seen as a
function of the translation, is a sum of shifted copies of one image. Adding copies costs a nanosecond per cell, so
the whole of the plane is looked at, and nothing is left out: inflated images give upper bounds of whole boxes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.geometry import ComplexArray
from fidmap.model import FloatArray
from fidmap.register.landscape import IntArray, Landscape

Counts = npt.NDArray[np.uint16]
FULL = 65535
# cells of all layers together; larger searches start from one box
MOST_CELLS = 600_000_000


@dataclass(frozen=True)
class Raster:
    """The mesh of a sweep: cell size (metres), rotations (T,) and scales (S,) with their half widths."""

    cell: float
    rotations: FloatArray
    half_turn: float
    scales: FloatArray
    half_scale: float


@dataclass(frozen=True, eq=False)
class Layer:
    """Sums (H, W) of one rotation and scale; cell (0, 0) is the placement with x, y of the pivot at `corner`."""

    rotation: float
    scale: float
    corner: tuple[float, float]
    cell: float
    sums: Counts

    def placements(self, rows: IntArray, columns: IntArray) -> FloatArray:
        """Placements (K, 4) in the middle of cells."""
        return np.stack(
            [
                np.full(len(rows), self.rotation),
                self.corner[0] + columns * self.cell,
                self.corner[1] + rows * self.cell,
                np.full(len(rows), self.scale),
            ],
            axis=1,
        )


def raster(land: Landscape, cell: float, turn_share: float) -> Raster | None:
    """A mesh whose half turns move the parts by `turn_share` cells (rms), its scales by as much; None if too large."""
    start = land.start
    low, high = land.problem.scale_range
    reach = math.pi if start is None else min(math.pi, 3 * start.sigma_yaw)
    middle = 0.0 if start is None else start.pose.yaw
    step = turn_share * cell / max(land.arm, cell)
    if land.faced:
        step = min(step, land.problem.settings.facing_tolerance / 6)
    count = max(1, math.ceil(reach / step))
    if land.cells(cell) * count * max(1, (high - low) / 2 / step) > MOST_CELLS:
        return None
    half = reach / count
    slabs = max(1, math.ceil((high - low) / 2 / step))
    half_scale = (high - low) / 2 / slabs
    return Raster(
        cell,
        np.linspace(middle - reach + half, middle + reach - half, count),
        half,
        np.linspace(low + half_scale, high - half_scale, slabs),
        half_scale,
    )


class Sweep:
    """Adds up the layers of a raster; `inflated` sums bound every placement of the cell's box from above."""

    def __init__(self, land: Landscape, mesh: Raster, inflated: bool) -> None:
        self.land, self.mesh = land, mesh
        self.unit = min(1000, FULL // max(1, len(land.used)))
        self.columns = land.used
        self.reach = self._reach(inflated)
        margin = land.problem.d_max + float(self.reach.max(initial=0.0)) + mesh.cell
        near = land.fiducials[land.possible.any(axis=1)]
        self.low = (float(near.real.min()) - margin, float(near.imag.min()) - margin)
        self.high = (float(near.real.max()) + margin, float(near.imag.max()) + margin)
        self.shape = tuple(math.ceil((b - a) / mesh.cell) + 1 for a, b in zip(self.low, self.high, strict=True))[::-1]
        self._distances: dict[bytes, npt.NDArray[np.float32]] = {}
        self._images: dict[tuple[bytes, int], Counts] = {}
        self._patches = self._all_patches(margin)

    def _reach(self, inflated: bool) -> FloatArray:
        """(used,) how far a part can be from where the middle of its box puts it, rounded up to quarter cells."""
        mesh, arms = self.mesh, self.land.arms[self.columns]
        if not inflated:
            return np.zeros(len(arms))
        turn = 2 * math.sin(mesh.half_turn / 2)
        moved = arms * (turn * (self.land.problem.scale_range[1]) + mesh.half_scale)
        return np.asarray(np.ceil((moved + math.sqrt(2) * mesh.cell) / (mesh.cell / 4)) * (mesh.cell / 4))

    def _all_patches(self, reach: float) -> list[tuple[int, int, npt.NDArray[np.float32]]]:
        """Per fiducial part its distances to the cells around it, with the patch's first row and column."""
        cell, size = self.mesh.cell, math.ceil(reach / self.mesh.cell)
        steps = np.arange(2 * size + 1) * cell
        patches = []
        for point in self.land.fiducials:
            column = math.floor((point.real - self.low[0]) / cell) - size
            row = math.floor((point.imag - self.low[1]) / cell) - size
            dx = self.low[0] + column * cell + steps - point.real
            dy = self.low[1] + row * cell + steps - point.imag
            patches.append((row, column, np.hypot(dx[None], dy[:, None]).astype(np.float32)))
        return patches

    def _distance(self, key: bytes) -> npt.NDArray[np.float32]:
        """Distance of every cell's middle to the nearest fiducial part of a set (a packed mask)."""
        if key not in self._distances:
            chosen = np.unpackbits(np.frombuffer(key, np.uint8), count=len(self.land.fiducials))
            field = np.full(self.shape, 1e6, np.float32)
            for i in np.flatnonzero(chosen):
                row, column, patch = self._patches[i]
                rows = slice(max(row, 0), max(0, min(row + len(patch), self.shape[0])))
                columns = slice(max(column, 0), max(0, min(column + len(patch), self.shape[1])))
                inner = patch[rows.start - row : rows.stop - row, columns.start - column : columns.stop - column]
                np.minimum(field[rows, columns], inner, out=field[rows, columns])
            self._distances[key] = field
        return self._distances[key]

    def _image(self, key: bytes, reach: float) -> Counts:
        """What a part in a cell is worth at most, in units, when the set `key` is open to it."""
        index = (key, round(reach / self.mesh.cell * 4))
        if index not in self._images:
            near = self._distance(key).astype(float) - reach
            worth = self.land.worth(np.maximum(near, 0.0))
            self._images[index] = np.ceil(worth * self.unit).astype(np.uint16)
        return self._images[index]

    def _open(self, spread: float) -> list[list[bytes]]:
        """Per rotation and used barrel part the packed set of fiducial parts that are open to it."""
        land, turns = self.land, self.mesh.rotations
        rows = np.arange(len(land.fiducials))
        possible = land.possible[:, self.columns].T
        if not land.faced:
            packed = np.packbits(possible, axis=1)
            return [[one.tobytes() for one in packed]] * len(turns)
        sets = []
        for turn in turns:
            clash = land.clash(rows[None], self.columns[:, None], turn, spread)
            sets.append([one.tobytes() for one in np.packbits(possible & ~clash, axis=1)])
        return sets

    def layers(self, least: float) -> Iterator[Layer]:
        """All layers, their range of x and y cut to where a sum of `least` is possible at all."""
        inflated = bool(self.reach.max(initial=0.0) > 0)
        open_to = self._open(self.mesh.half_turn if inflated else 0.0)
        for k, rotation in enumerate(self.mesh.rotations):
            images = [self._image(key, r) for key, r in zip(open_to[k], self.reach.tolist(), strict=True)]
            for scale in self.mesh.scales:
                arms = scale * np.exp(1j * rotation) * self.land.barrels[self.columns]
                yield self._layer(float(rotation), float(scale), arms, images, least)

    def _layer(self, rotation: float, scale: float, arms: ComplexArray, images: list[Counts], least: float) -> Layer:
        """Add up one layer."""
        cell = self.mesh.cell
        (x0, columns), (y0, rows) = (self._range(part, k, least) for k, part in enumerate((arms.real, arms.imag)))
        sums = np.zeros((rows, columns), np.uint16)
        right = np.rint((x0 + arms.real - self.low[0]) / cell).astype(int).tolist()
        up = np.rint((y0 + arms.imag - self.low[1]) / cell).astype(int).tolist()
        height, width = self.shape
        for image, a, b in zip(images, up, right, strict=True):
            top, left = min(rows, height - a), min(columns, width - b)
            low, first = max(0, -a), max(0, -b)
            if top > low and left > first:
                sums[low:top, first:left] += image[low + a : top + a, first + b : left + b]
        return Layer(rotation, scale, (x0, y0), cell, sums)

    def _range(self, offsets: FloatArray, axis: int, least: float) -> tuple[float, int]:
        """First cell and number of cells along an axis: at least `least` parts must lie near fiducial parts."""
        start, cell = self.land.start, self.mesh.cell
        needed = min(len(offsets), max(1, math.ceil(least)))
        ordered = np.sort(offsets)
        low, high = self.low[axis] - ordered[-needed], self.high[axis] - ordered[needed - 1]
        if start is not None:
            middle = (start.pose.x_m, start.pose.y_m)[axis]
            low, high = max(low, middle - 3 * start.sigma_m), min(high, middle + 3 * start.sigma_m)
        return low, max(1, math.ceil((high - low) / cell + 0.5)) if high >= low else 0
