"""SQLite files: a ROS 2 bag or a database of RTAB-Map, told apart by their tables."""

from __future__ import annotations

import hashlib
import struct
import zlib
from pathlib import Path

import numpy as np

from fidmap.maps import bag
from fidmap.maps.cursor import BrokenRecordError
from fidmap.maps.files import MAX_CELLS, fault
from fidmap.maps.occupancy_message import OccupancyMessage
from fidmap.maps.overrides import Overrides, is_resolution
from fidmap.maps.sqlite_file import opened
from fidmap.model import Grid, Pose2

QUESTION = "SELECT opt_map, opt_map_x_min, opt_map_y_min, opt_map_resolution FROM Admin"
CV_8S = 1


def read(path: Path, name: str, overrides: Overrides) -> Grid:
    """Read the map of a bag, or the assembled 2D map that RTAB-Map keeps.

    Raises:
        MapFileError: no map in it.
        BrokenRecordError: what it holds is not what it announces.
    """
    with opened(path) as database:
        if "Admin" not in database.tables:
            return bag.read(path, name, overrides)
        columns = {row[1] for row in database.rows("PRAGMA table_info(Admin)")}
        rows = database.rows(QUESTION) if "opt_map" in columns else []
    row = next((row for row in rows if isinstance(row[0], bytes)), None)
    if row is None:
        raise fault(
            name,
            "is an RTAB-Map database without an assembled 2D map; open it with `rtabmap-databaseViewer`, and export "
            "the map or save the optimized map into it",
        )
    message = _message(*row)
    return bag.message_grid(message, hashlib.sha256(row[0]).hexdigest(), name, "rtabmap", overrides)


def _message(packed: bytes, x_m: object, y_m: object, resolution_m: object) -> OccupancyMessage:
    """A matrix as RTAB-Map's Compression.cpp packs it: zlib, then rows, columns and type in 32 bit each."""
    if not all(isinstance(value, int | float) and abs(value) < 1e8 for value in (x_m, y_m, resolution_m)):
        raise BrokenRecordError("its map has no place or no resolution")
    x, y, resolution = float(x_m), float(y_m), float(resolution_m)  # type: ignore[arg-type]  # just checked
    if len(packed) < 12 or not is_resolution(resolution):
        raise BrokenRecordError(f"its map has {len(packed)} bytes and the resolution {resolution:g} m")
    rows, columns, kind = struct.unpack("<3i", packed[-12:])
    if kind != CV_8S or rows < 1 or columns < 1 or rows * columns > MAX_CELLS:
        raise BrokenRecordError(f"its map has {rows} x {columns} cells of the kind {kind}, expected signed bytes")
    try:
        cells = zlib.decompressobj().decompress(packed[:-12], rows * columns)
    except zlib.error as error:
        raise BrokenRecordError(f"its map cannot be unpacked ({error})") from None
    if len(cells) != rows * columns:
        raise BrokenRecordError(f"its map has {len(cells)} of {rows * columns} cells")
    shortest = float(np.format_float_positional(np.float32(resolution), unique=True))
    return OccupancyMessage(shortest, Pose2(x, y), np.frombuffer(cells, np.int8).reshape(rows, columns))
