"""The part of a map that a drawing shows, as a small picture, and the way from metres to drawing units.

The drawing keeps the image's own orientation: cells stay upright squares, points are turned by the origin's
yaw.
"""

from __future__ import annotations

import base64
import io
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.grid import metres_to_cells
from fidmap.model import FloatArray, Label, Pose2, TrinaryGrid

GREYS = {Label.FREE: 255, Label.UNKNOWN: 216, Label.OCCUPIED: 62}
LONG_SIDE = 1160.0  # of the map in drawing units; labels are chosen to be read at this size
ASPECT = 3.0  # a longer map is padded: labels need room
PICTURE_CELLS = 2400  # on the long side; beyond, several cells share a pixel


@dataclass(frozen=True)
class View:
    """A window of continuous cell coordinates and its place in the drawing (units, y down)."""

    resolution_m: float
    origin: Pose2
    bottom_row: float
    left_column: float
    top_row: float
    right_column: float
    left: float = 0.0
    top: float = 0.0

    @property
    def scale(self) -> float:
        """Drawing units per cell."""
        long_side = max(self.right_column - self.left_column, self.top_row - self.bottom_row)
        return LONG_SIDE / long_side

    @property
    def units_per_metre(self) -> float:
        """Drawing units per metre."""
        return self.scale / self.resolution_m

    @property
    def width(self) -> float:
        """Width in drawing units."""
        return (self.right_column - self.left_column) * self.scale

    @property
    def height(self) -> float:
        """Height in drawing units."""
        return (self.top_row - self.bottom_row) * self.scale

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Left, top, right and bottom in drawing units."""
        return self.left, self.top, self.left + self.width, self.top + self.height

    def to_drawing(self, points_xy: FloatArray) -> FloatArray:
        """Map metres (N, 2) to drawing units (N, 2)."""
        rc = metres_to_cells(points_xy, self.resolution_m, self.origin)
        x = self.left + (rc[..., 1] - self.left_column) * self.scale
        y = self.top + (self.top_row - rc[..., 0]) * self.scale
        return np.stack([x, y], axis=-1)

    def direction(self, angle: float) -> float:
        """A direction of the map's frame as the drawing shows it, counter-clockwise with y up."""
        return angle - self.origin.yaw


def make_view(grid: TrinaryGrid | None, points_xy: FloatArray, radius_m: float) -> View:
    """Crop to what is known, and to all points (N, 2) in metres with room for their arcs."""
    resolution_m, origin = (grid.resolution_m, grid.origin) if grid is not None else (1.0, Pose2())
    boxes = [] if grid is None else [_used_cells(grid.labels)]
    finite = points_xy[np.isfinite(points_xy).all(axis=1)]
    if len(finite):
        rc = metres_to_cells(finite, resolution_m, origin)
        room = 2 * radius_m / resolution_m
        boxes.append(np.array([*(rc.min(axis=0) - room), *(rc.max(axis=0) + room)]))
    if not boxes:
        boxes.append(np.array([0.0, 0.0, 10.0, 10.0]))
    all_boxes = np.stack(boxes)
    low, high = all_boxes[:, :2].min(axis=0), all_boxes[:, 2:].max(axis=0)
    margin = max(2 * radius_m / resolution_m, 0.03 * float((high - low).max()))
    low, high = _less_slender(low - margin, high + margin)
    low, high = np.floor(low), np.ceil(high)  # whole cells: the picture then needs no clipping, which is slow
    return View(resolution_m, origin, float(low[0]), float(low[1]), float(high[0]), float(high[1]))


def _used_cells(labels: npt.NDArray[np.uint8]) -> FloatArray:
    """Bounding box (4,) as (row, column, row, column) of the known cells; of the walls where all is known."""
    used = labels != Label.UNKNOWN
    if used.all():
        used = labels == Label.OCCUPIED
    rows, columns = np.flatnonzero(used.any(axis=1)), np.flatnonzero(used.any(axis=0))
    if not len(rows):
        return np.array([0.0, 0.0, *map(float, labels.shape)])
    return np.array([rows[0], columns[0], rows[-1] + 1, columns[-1] + 1], float)


def _less_slender(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    size = high - low
    wanted = np.maximum(size, size.max() / ASPECT)
    return low - (wanted - size) / 2, high + (wanted - size) / 2


@dataclass(frozen=True)
class Picture:
    """A PNG of the shown cells and its place in continuous cell coordinates."""

    png: bytes
    bottom_row: float
    left_column: float
    top_row: float
    right_column: float
    cells_per_pixel: float

    @property
    def data_uri(self) -> str:
        """The PNG as part of the document itself."""
        return "data:image/png;base64," + base64.b64encode(self.png).decode("ascii")


def picture(grid: TrinaryGrid, view: View, pixels_per_unit: float = math.inf) -> Picture | None:
    """The shown cells of a grid in three greys, None where the window shows no cell.

    Args:
        grid: the trinarized map.
        view: what the drawing shows of it.
        pixels_per_unit: of a drawing that will be pixels; finer cells are averaged to them here, because that
            is ten times as fast as letting the renderer do it.
    """
    height, width = grid.labels.shape
    bottom, top = max(0, math.floor(view.bottom_row)), min(height, math.ceil(view.top_row))
    left, right = max(0, math.floor(view.left_column)), min(width, math.ceil(view.right_column))
    if bottom >= top or left >= right:
        return None
    share = math.ceil(max(top - bottom, right - left) / PICTURE_CELLS)
    cells = _shared(grid.labels[bottom:top, left:right], share)[::-1]
    rows, columns = (size * share for size in cells.shape)
    pixels_per_cell = pixels_per_unit * view.scale * share
    png = _png(cells) if pixels_per_cell >= 1 else _averaged_png(cells, pixels_per_cell)
    return Picture(png, bottom, left, bottom + rows, left + columns, share / min(1.0, pixels_per_cell))


def _shared(labels: npt.NDArray[np.uint8], share: int) -> npt.NDArray[np.uint8]:
    """Let share x share cells become one; walls win over free over unknown, so that nothing thin is lost."""
    if share == 1:
        return labels
    strength = np.array([Label.UNKNOWN, Label.FREE, Label.OCCUPIED], np.uint8)
    rank = np.argsort(strength).astype(np.uint8)[labels]
    padding = [(0, -size % share) for size in labels.shape]
    padded = np.pad(rank, padding)  # 0 is the weakest: unknown
    rows, columns = padded.shape[0] // share, padded.shape[1] // share
    strongest = padded.reshape(rows, share, columns, share).max(axis=(1, 3))
    return np.asarray(strength[strongest], np.uint8)


def _png(labels: npt.NDArray[np.uint8]) -> bytes:
    """A palette PNG of two bits per cell; row 0 is the top row here."""
    from PIL import Image

    image = Image.fromarray(np.ascontiguousarray(labels), mode="P")
    image.putpalette([GREYS[label] for label in sorted(GREYS) for _ in range(3)])
    target = io.BytesIO()
    image.save(target, "PNG", bits=2)
    return target.getvalue()


def _averaged_png(labels: npt.NDArray[np.uint8], pixels_per_cell: float) -> bytes:
    """A grey PNG with fewer pixels than cells; a thin wall becomes lighter but stays."""
    import cv2

    greys = np.array([GREYS[label] for label in sorted(GREYS)], np.uint8)
    rows, columns = (max(1, round(size * pixels_per_cell)) for size in labels.shape)
    image = cv2.resize(greys[labels], (columns, rows), interpolation=cv2.INTER_AREA)
    return cv2.imencode(".png", image, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes()
