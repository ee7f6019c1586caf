"""A grid as a RoboCup Rescue GeoTIFF: the league's colours, +x up the picture, 3 x 3 pixels per cell.

Nothing is drawn over the map, so that reading it back gives every cell. The tags say where it lies with x as east and
y as north; the world file beside it says the same in hector's turned frame, for programs that know that one alone.
"""

from __future__ import annotations

import io
import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, TiffImagePlugin

from fidmap.grid import cells_to_metres, trinarize
from fidmap.maps.georeference import GEO_KEYS, MODEL_TYPE, RASTER_TYPE, TRANSFORMATION
from fidmap.maps.robocup.palette import DESCRIPTION_TAG, FACTOR, OURS, TILES, WALL, WHITE
from fidmap.model import Grid, Label, Pose2
from fidmap.output_file import write_whole

PALETTE = np.array([WHITE, TILES[0], WALL, TILES[1]], np.uint8)
_DOUBLE, _SHORT = 12, 3  # types of TIFF tags


def write_geotiff(path: Path, grid: Grid) -> None:
    """Write a GeoTIFF (LZW, palette) and the `.tfw` beside it; only the three labels are kept.

    Raises:
        OutputError: the place cannot be written.
    """
    indices = picture(trinarize(grid).labels, grid.resolution_m)
    corner = _upper_left(grid)
    image = Image.fromarray(indices, "P")
    image.putpalette(PALETTE.tobytes())
    buffer = io.BytesIO()
    image.save(buffer, "TIFF", compression="tiff_lzw", tiffinfo=_tags(grid, corner))
    write_whole(path.with_suffix(".tfw"), _world_file(grid, corner).encode())
    write_whole(path, buffer.getvalue())


def picture(labels: npt.NDArray[np.uint8], resolution_m: float) -> npt.NDArray[np.uint8]:
    """(3 W, 3 H) indices into the palette of labels (H, W) with row 0 lowest: +x up, +y left, tiles of one metre."""
    turned = labels.T[::-1, ::-1]
    tile = max(1, round(1 / resolution_m))
    row, column = np.ogrid[: turned.shape[0], : turned.shape[1]]
    odd = ((row // tile + column // tile) % 2).astype(bool)
    cells = np.where((turned == Label.UNKNOWN) & odd, np.uint8(3), turned)
    return np.repeat(np.repeat(cells, FACTOR, axis=0), FACTOR, axis=1)


def _upper_left(grid: Grid) -> Pose2:
    """Where the picture's upper left corner lies: the far end of both of the grid's axes."""
    far = cells_to_metres(np.array([grid.occupancy.shape], float), grid.resolution_m, grid.origin)[0]
    return Pose2(float(far[0]), float(far[1]), grid.origin.yaw)


def _tags(grid: Grid, corner: Pose2) -> TiffImagePlugin.ImageFileDirectory_v2:
    """ModelTransformation of pixel corners (the picture's right is -y of the grid, its down is -x), in metres."""
    size = grid.resolution_m / FACTOR
    c, s = size * math.cos(corner.yaw), size * math.sin(corner.yaw)
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    tags[TRANSFORMATION] = (s, -c, 0.0, corner.x_m, -c, -s, 0.0, corner.y_m, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    tags.tagtype[TRANSFORMATION] = _DOUBLE
    user_defined, area = 32767, 1
    tags[DESCRIPTION_TAG] = OURS
    tags[GEO_KEYS] = (1, 1, 0, 2, MODEL_TYPE, 0, 1, user_defined, RASTER_TYPE, 0, 1, area)
    tags.tagtype[GEO_KEYS] = _SHORT
    return tags


def _world_file(grid: Grid, corner: Pose2) -> str:
    """Hector's frame: east = -y, north = x, the last two lines one pixel beyond the corner."""
    size = grid.resolution_m / FACTOR
    c, s = size * math.cos(corner.yaw), size * math.sin(corner.yaw)
    east, north = -corner.y_m, corner.x_m
    # one pixel to the left and one up
    beyond = east - c - s, north - s + c
    return "".join(f"{value!r}\n" for value in (c, s, s, -c, *beyond))
