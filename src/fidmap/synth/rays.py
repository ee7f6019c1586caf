"""Which cells the beams of a scan cross: a DDA over many beams at once, in windows of the grid."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.model import FloatArray

IntArray = npt.NDArray[np.int64]
BITS = 16  # of the fraction in the DDA's fixed point; 15 more hold any allowed grid
MAX_CELLS = 16_000


@dataclass(frozen=True, eq=False)
class Rays:
    """Beams scan by scan, x and y apart since numpy is slow along axes of two.

    start: (2, M) x, y of the sensor. end: (2, M, B) where the beam ends, NaN for beams to be ignored.
    hit: (M, B) whether something was hit there; else the beam only clears cells.
    """

    start: FloatArray
    end: FloatArray
    hit: npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Frame:
    """The grid to draw on: its lower-left corner, resolution and (rows, columns)."""

    x_m: float
    y_m: float
    resolution_m: float
    shape: tuple[int, int]


@dataclass(frozen=True)
class Window:
    """A block of the grid with its first row and column; indices of cells are flat within it."""

    frame: Frame
    row: int
    column: int
    rows: int
    columns: int

    @property
    def cells(self) -> tuple[slice, slice]:
        """The block's slices of the whole grid."""
        return slice(self.row, self.row + self.rows), slice(self.column, self.column + self.columns)

    def count(self, flat: IntArray, weights: FloatArray | None = None) -> npt.NDArray[np.float32]:
        """How often each cell is listed (or the sum of its weights), (rows, columns)."""
        total = np.bincount(flat, weights, self.rows * self.columns)
        return total.astype(np.float32).reshape(self.rows, self.columns)

    def touched(self, flat: IntArray) -> npt.NDArray[np.bool_]:
        """Which cells are listed, (rows, columns)."""
        found = np.zeros(self.rows * self.columns, bool)
        found[flat] = True
        return found.reshape(self.rows, self.columns)


@dataclass(frozen=True, eq=False)
class Samples:
    """Cells crossed by beams, as flat indices into a window.

    passed: crossed without a hit. end: hit. all: every cell of every beam, with along_m, its distance from
    the sensor, and range_m, that of the beam's end (inf without hit); filled only where cells beyond the end
    are asked for.
    """

    passed: IntArray
    end: IntArray
    all: IntArray
    along_m: FloatArray
    range_m: FloatArray


Batch = Callable[[int, float], Iterator[tuple[Window, Rays]]]


def ray_ends(ranges: npt.NDArray[np.float32], bearings: FloatArray, poses: FloatArray, usable_m: float) -> Rays:
    """Beams in the map's frame; those without return within `usable_m` are cut there and hit nothing.

    Args:
        ranges: (M, B) metres, NaN for no measurement (ignored), inf beyond reach.
        bearings: (B,) radians.
        poses: (M, 3) x, y, yaw.
        usable_m: longest range that is believed.
    """
    length = np.minimum(ranges, usable_m)
    angle = poses[:, 2:3] + bearings
    start = poses[:, :2].T
    end = start[:, :, None] + length * np.stack([np.cos(angle), np.sin(angle)])
    return Rays(start, end, ranges < usable_m)


def frame_of(rays: Rays, resolution_m: float, margin_m: float, min_cells: int) -> Frame:
    """The smallest grid with its rim around all beams, its corner on a multiple of the resolution.

    Raises:
        ValueError: no beam measured anything, or the grid would be wider than 16,000 cells.
    """
    if not np.isfinite(rays.end).any():
        raise ValueError("no beam measured anything, so there is nothing to map")
    least, most = _extent(rays.start, rays.end)
    low = np.floor((least - margin_m) / resolution_m)
    size = np.ceil((most + margin_m) / resolution_m) - low
    low -= np.floor(np.maximum(min_cells - size, 0) / 2)
    columns, rows = (int(n) for n in np.maximum(size, min_cells))
    if max(rows, columns) > MAX_CELLS:
        raise ValueError(f"a map of {rows} x {columns} cells is too large; use a coarser resolution")
    return Frame(float(low[0]) * resolution_m, float(low[1]) * resolution_m, resolution_m, (rows, columns))


def _extent(start: FloatArray, end: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least and greatest x, y of starts (2, M) and ends (2, M, B), without the NaN among them."""
    low, high = np.fmin.reduce(end, axis=(1, 2)), np.fmax.reduce(end, axis=(1, 2))
    return np.fmin(low, start.min(1)), np.fmax(high, start.max(1))


def batches(rays: Rays, frame: Frame) -> Batch:
    """A function (scans, rim in metres) that yields so many scans at a time in cells, with their window."""
    corner = np.array([[frame.x_m], [frame.y_m]])

    def each(scans: int, rim_m: float) -> Iterator[tuple[Window, Rays]]:
        for begin in range(0, rays.start.shape[1], scans):
            part = slice(begin, begin + scans)
            start = (rays.start[:, part] - corner) / frame.resolution_m
            end = (rays.end[:, part] - corner[..., None]) / frame.resolution_m
            least, most = _extent(start, end)
            rim = rim_m / frame.resolution_m
            yield _window(frame, least - rim, most + rim), Rays(start, end, rays.hit[part])

    return each


def _window(frame: Frame, least: FloatArray, most: FloatArray) -> Window:
    """The block between two corners in cells, with two cells of slack for rounding."""
    low = np.maximum(np.floor(least).astype(int) - 2, 0)
    high = np.minimum(np.floor(most).astype(int) + 3, frame.shape[::-1])
    return Window(frame, int(low[1]), int(low[0]), int(high[1] - low[1]), int(high[0] - low[0]))


def samples(rays: Rays, window: Window, beyond_m: float | None = None) -> Samples:
    """The cells that beams cross, one per row or column crossed.

    Args:
        rays: beams in cells of the whole grid.
        window: the block they lie in.
        beyond_m: how far to go on behind a hit (cut at the window's rim); None: up to the hit.
    """
    good = np.isfinite(rays.end[0])
    offset = np.array([[window.column], [window.row]], float)
    start = np.broadcast_to(rays.start[:, :, None], rays.end.shape)[:, good] - offset
    end = rays.end[:, good] - offset
    hit = rays.hit[good]
    if beyond_m is not None:
        return _samples_beyond(start, end, hit, window, beyond_m)
    # Steps of one cell or a little more along the longer axis: none but the end itself lies in the end's
    # cell.
    count = np.maximum(_longer(end - start), 1).astype(np.int64)
    passed = _dda(start, (end - start) / count, count, window)
    x, y = end[:, hit].astype(np.int64)
    empty = np.zeros(0)
    return Samples(passed, y * window.columns + x, passed[:0], empty, empty)


def _longer(way: FloatArray) -> FloatArray:
    """The longer of the two components of (2, N) ways."""
    longer: FloatArray = np.maximum(np.abs(way[0]), np.abs(way[1]))
    return longer


def _samples_beyond(
    start: FloatArray, end: FloatArray, hit: npt.NDArray[np.bool_], window: Window, beyond_m: float
) -> Samples:
    """Cells with their distances, up to `beyond_m` behind the hits."""
    resolution_m = window.frame.resolution_m
    length = np.maximum(np.hypot(*(end - start)), 1e-6)
    stop = start + (1 + np.where(hit, beyond_m / resolution_m, 0) / length) * (end - start)
    stop = np.clip(stop, 0.01, [[window.columns - 0.01], [window.rows - 0.01]])
    count = np.maximum(np.ceil(_longer(stop - start)), 1).astype(np.int64)
    flat = _dda(start, (stop - start) / count, count, window)
    step_m = np.hypot(*(stop - start)) / count * resolution_m
    within = np.arange(len(flat)) - np.repeat(np.cumsum(count) - count, count)
    ranges = np.repeat(np.where(hit, length * resolution_m, math.inf), count)
    return Samples(flat[:0], flat[:0], flat, within * np.repeat(step_m, count), ranges)


def _dda(start: FloatArray, step: FloatArray, count: IntArray, window: Window) -> IntArray:
    """Flat cells at start, start + step, ... (2, N) for each beam, `count` of them.

    Row and column share one integer (row in the upper half, both in fixed point), so that one multiplication
    and one addition move both; sums wrap around harmlessly, since every result fits.
    """
    scale = float(1 << BITS)
    x, y = (start * scale).astype(np.int64)
    stride_x, stride_y = np.rint(step * scale).astype(np.int64)
    packed = (y << 32) + x
    motion = (stride_y << 32) + stride_x
    packed -= motion * (np.cumsum(count) - count)
    place = np.repeat(motion, count)
    place *= np.arange(len(place))
    place += np.repeat(packed, count)
    row = place >> (32 + BITS)
    row *= window.columns
    place &= 0xFFFFFFFF
    place >>= BITS
    row += place
    return row
