"""A point cloud to a grid: the slab at the height of barrels, seen from above.

Two passes over the points: one for their extent and a sample in which the floor is looked for, one that counts
the points over each cell. Points are never all in memory unless their format has to be decoded slowly.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.maps.cursor import BrokenRecordError
from fidmap.maps.files import fault
from fidmap.maps.floor import Floor, find_floor
from fidmap.maps.overrides import Overrides
from fidmap.maps.slab import MAX_SLAB_CELLS, slab_grid, slab_of
from fidmap.maps.tables import look_up
from fidmap.model import FloatArray, Grid, Label

MAX_POINTS = 500_000_000
CHUNK_POINTS = 200_000
SAMPLE_POINTS = 100_000
FINEST_M = 0.025
OFF_LATTICE = 0.75  # cells: points of voxel grids, centred or not, must not lie on the borders of cells
FACTORS = (1, 2, 4)
FINE_CELLS = 16_500_000
FLOOR_BLOCK_M = 0.1
FLOOR_BELOW_M, FLOOR_ABOVE_M = 0.15, 0.1
KEPT_TILT = math.radians(2)
_OCCUPANCY = np.array([0, np.nan, 1], np.float32)
Points = npt.NDArray[np.float32] | npt.NDArray[np.float64]
Counts = npt.NDArray[np.int32]
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Cloud:
    """A file's points: how many it announces, and blocks of them (n, 3) in metres, as often as asked for."""

    count: int
    blocks: Callable[[], Iterator[Points]]


@dataclass(frozen=True, eq=False)
class Extent:
    """low, high (3,): the corners of the box around all finite points; sample (N, 3) of them."""

    low: FloatArray
    high: FloatArray
    sample: FloatArray


# points that are not finite, and absurd ones, stay so and fall out: numpy has nothing to tell about them
@np.errstate(invalid="ignore", over="ignore")
def read_cloud(cloud: Cloud, path: Path, name: str, kind: str, overrides: Overrides) -> Grid:
    """Find the floor, cut the slab, and look at it from above.

    Args:
        cloud: the points.
        path: their file, for its hash.
        name: the file as the user named it.
        kind: the format's name.
        overrides: `slab_m` is above the floor; `up` says which axis is up; a resolution replaces the fitting one.

    Raises:
        MapFileError: no points, or a map beyond the bound on cells.
        BrokenRecordError: as the format's blocks raise it.
    """
    if cloud.count > MAX_POINTS:
        raise BrokenRecordError(f"it announces {cloud.count:,} points, at most {MAX_POINTS:,} are read")
    extent = _survey(cloud, name)
    floor = find_floor(extent.sample, overrides.up)
    view = View(floor, *slab_of(overrides))
    resolution, origin, shape = _frame(extent, view, overrides.resolution_m, name)
    occupied, seen = _count(cloud, view, resolution, origin, shape)
    if overrides.resolution_m is None:
        factor = _fitting(occupied, resolution)
        occupied, seen, resolution = _summed(occupied, factor), _any(seen, factor), resolution * factor
    labels = _labels(occupied, seen, resolution)
    del occupied, seen  # the map needs their memory
    occupancy = look_up(_OCCUPANCY, labels)
    corner = float(origin[0]), float(origin[1])
    return slab_grid(occupancy, resolution, corner, floor, (path, name, kind), overrides)


@dataclass(frozen=True, eq=False)
class View:
    """How points are looked at: x and y of the map, and the height above the floor."""

    floor: Floor
    low: float
    high: float

    @property
    def axes(self) -> FloatArray:
        """(3, 3): rows that give map x, map y and up of a point.

        Where up is the file's z but for two degrees, x and y are the file's own; else the cloud is turned by the
        least rotation that makes up the z axis.
        """
        up = self.floor.up
        if self.floor.tilt < KEPT_TILT:
            return np.array([[1, 0, 0], [0, 1, 0], up])
        if up[2] < -1 + 1e-9:
            return np.diag([1.0, -1.0, -1.0])
        # Rodrigues' formula for the rotation that takes `up` to z, with v = up x z and cosine up_z
        v = np.cross(up, [0.0, 0.0, 1.0])
        K = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
        return np.asarray(np.eye(3) + K + K @ K / (1 + up[2]))

    def look(self, points: Points) -> tuple[Points, Points, Points]:
        """Map x, map y and height above the floor, each (n,)."""
        x, y, up = self.axes
        if self.floor.tilt < KEPT_TILT:
            return points[:, 0], points[:, 1], _along(points, up) - self.floor.height_m
        return _along(points, x), _along(points, y), _along(points, up) - self.floor.height_m


def _along(points: Points, axis: FloatArray) -> Points:
    a, b, c = (float(value) for value in axis)
    if (a, b, c) == (0, 0, 1):
        return points[:, 2]
    return a * points[:, 0] + b * points[:, 1] + c * points[:, 2]


def _survey(cloud: Cloud, name: str) -> Extent:
    """Extent and sample of the finite points."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    step = max(1, cloud.count // SAMPLE_POINTS)
    sample = []
    for block in filter(len, cloud.blocks()):
        for axis in range(3):
            column = block[:, axis]
            least, most = float(column.min()), float(column.max())
            if not (math.isfinite(least) and math.isfinite(most)):
                column = column[np.isfinite(column)]
                least, most = float(column.min(initial=np.inf)), float(column.max(initial=-np.inf))
            low[axis], high[axis] = min(low[axis], least), max(high[axis], most)
        thin = block[::step].astype(float)
        sample.append(thin[np.isfinite(thin).all(axis=1)])
    points = np.concatenate(sample) if sample else np.empty((0, 3))
    if not len(points):
        raise fault(name, "holds no points; expected those of a map, so save it again")
    if max(np.abs(low).max(), np.abs(high).max()) > 1e8:
        raise fault(name, "holds points over 100,000 km away; expected metres, so remove them")
    return Extent(low, high, points)


def _frame(
    extent: Extent, view: View, resolution_m: float | None, name: str
) -> tuple[float, FloatArray, tuple[int, int]]:
    """Resolution to count with, lower-left corner and (rows, columns).

    Larger maps begin with coarser cells; the far tails are cut off where that does not help.
    """
    corners = np.array(np.meshgrid(*zip(extent.low, extent.high, strict=True))).reshape(3, -1).T
    whole, core = (corners, 0.0), (_within_tails(extent.sample), 1.0)
    if resolution_m is not None:
        tries = [(resolution_m, box, MAX_SLAB_CELLS) for box in (whole, core)]
    else:
        fine, coarse = (FINEST_M, 2 * FINEST_M), 4 * FINEST_M
        tries = [(step, box, FINE_CELLS) for box in (whole, core) for step in fine]
        tries += [(coarse, whole, MAX_SLAB_CELLS), *((coarse * 2**k, core, MAX_SLAB_CELLS) for k in range(8))]
    for step, (points, margin), most in tries:
        x, y, _ = view.look(points)
        low = (np.floor(np.array([x.min() - margin, y.min() - margin]) / step) - OFF_LATTICE) * step
        columns, rows = (int(n) for n in np.ceil((np.array([x.max(), y.max()]) + margin - low) / step) + 1)
        shape = -(-rows // 4) * 4, -(-columns // 4) * 4
        if shape[0] * shape[1] <= most:
            return step, low, shape
    raise fault(
        name,
        f"covers {columns:,} x {rows:,} cells of {step:g} m; at most {MAX_SLAB_CELLS // 1_000_000} million are "
        "read, so crop it or give a larger --resolution",
    )


def _within_tails(points: FloatArray) -> FloatArray:
    """Points but for the thousandth part at either end of each axis: stray points must not make the map."""
    low, high = np.percentile(points, [0.1, 99.9], axis=0)
    kept = points[((points >= low) & (points <= high)).all(axis=1)]
    return kept if len(kept) else points


def _count(cloud: Cloud, view: View, step: float, low: FloatArray, shape: tuple[int, int]) -> tuple[Counts, Mask]:
    """How many points of the slab lie over each cell, and where the floor was seen."""
    size = shape[0] * shape[1]
    slab, floor = np.zeros(size, np.int32), np.zeros(size, bool)
    left, bottom = map(float, low)  # numpy's own float64 would make float32 points wide
    for block in cloud.blocks():
        x, y, height = view.look(block)
        column, row = (x - left) / step, (y - bottom) / step
        inside = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
        # places in the flattened map, which has fewer than 2^31 cells; those of points outside mean nothing
        cells = row.astype(np.int32) * np.int32(shape[1]) + column.astype(np.int32)
        walls = inside & (height >= view.low) & (height <= view.high)
        np.add.at(slab, cells[walls], np.int32(1))  # a Python 1 would be cast for every point
        floor[cells[inside & (height >= -FLOOR_BELOW_M) & (height <= FLOOR_ABOVE_M)]] = True
    return slab.reshape(shape), floor.reshape(shape)


def _summed(counts: Counts, factor: int) -> Counts:
    """Sums over blocks of cells; the shape is a multiple of 4."""
    if factor == 1:
        return counts
    parts = [counts[a::factor, b::factor] for a in range(factor) for b in range(factor)]
    return np.asarray(functools.reduce(np.add, parts))


def _any(cells: Mask, side: int) -> Mask:
    """Whether any cell of a block is set; incomplete blocks at the upper and right rim count too."""
    result = np.zeros((-(-cells.shape[0] // side), -(-cells.shape[1] // side)), bool)
    for a in range(side):
        for b in range(side):
            part = cells[a::side, b::side]
            result[: part.shape[0], : part.shape[1]] |= part
    return result


def _fitting(occupied: Counts, step: float) -> int:
    """The finest of the resolutions at which walls are closed: 9 of 10 occupied cells have two occupied neighbours."""
    factors = [factor for factor in FACTORS if factor == 1 or factor * step <= FACTORS[-1] * FINEST_M + 1e-9]
    occupied_at_all = occupied > 0
    for factor in factors:
        walls = (_any(occupied_at_all, factor) if factor > 1 else occupied_at_all).view(np.uint8)
        around = cv2.boxFilter(walls, -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
        count = np.count_nonzero(walls)
        if count and np.count_nonzero((around >= 3) & walls) >= 0.9 * count:
            return factor
    return factors[-1]


def _labels(occupied: Counts, seen: Mask, resolution_m: float) -> npt.NDArray[np.uint8]:
    """(H, W) occupied where the slab has points, free where the floor was seen, unknown elsewhere.

    A cell with less than a twentieth of the points that an occupied cell usually has holds stray points. Floor is
    taken in blocks of a decimetre and gaps of one block are closed: scanners see it thinly. Where hardly any floor
    was recorded, every other cell is free, as in a drawing of walls.
    """
    usual = float(np.median(occupied[occupied > 0])) if occupied.any() else 1.0
    walls = occupied >= max(1, math.ceil(0.05 * usual))  # an integer, or all counts would become floats
    block = max(1, round(FLOOR_BLOCK_M / resolution_m))
    blocks, wall_blocks = _any(seen, block), _any(walls, block)
    recorded = np.count_nonzero(blocks & ~wall_blocks) >= np.count_nonzero(wall_blocks)
    closed = cv2.morphologyEx(blocks.view(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)).view(bool)
    if not recorded:
        return np.where(walls, Label.OCCUPIED, Label.FREE)
    rows, columns = occupied.shape
    ground = closed.view(np.uint8).repeat(block, axis=0)[:rows].repeat(block, axis=1)[:, :columns]
    labels = np.where(ground, Label.FREE, Label.UNKNOWN)
    np.copyto(labels, Label.OCCUPIED, where=walls)
    return labels
