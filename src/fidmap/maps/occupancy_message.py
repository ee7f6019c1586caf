"""nav_msgs/OccupancyGrid as ROS 1 and ROS 2 (CDR) put it on the wire."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.maps.cursor import BrokenRecordError, Cursor
from fidmap.maps.files import MAX_CELLS
from fidmap.maps.overrides import is_resolution
from fidmap.maps.tables import histogram, look_up
from fidmap.model import Pose2

TYPES = frozenset({"nav_msgs/OccupancyGrid", "nav_msgs/msg/OccupancyGrid"})
FREE_THRESH, OCCUPIED_THRESH = 0.25, 0.65
"""What the map savers of ROS take: at most 25 is free, at least 65 occupied (nav2_map_server, map_saver.cpp)."""


@dataclass(frozen=True, eq=False)
class OccupancyMessage:
    """data (H, W) int8, row 0 lowest: 0 to 100, anything else is unknown."""

    resolution_m: float
    origin: Pose2
    data: npt.NDArray[np.int8]

    def labels(self, free_thresh: float, occupied_thresh: float) -> tuple[int, int, int]:
        """How many cells are free, unknown and occupied."""
        counts = histogram(self.data.view(np.uint8), None)
        p = np.arange(101, dtype=np.float32) / np.float32(100)
        free = p <= np.float32(free_thresh)
        occupied = (p >= np.float32(occupied_thresh)) & ~free
        known = int(counts[:101][free].sum()), int(counts[:101][occupied].sum())
        return known[0], self.data.size - sum(known), known[1]

    def occupancy(self) -> npt.NDArray[np.float32]:
        """(H, W) p = value / 100, NaN where unknown; the map savers take all but 0 to 100 for unknown."""
        table = np.full(256, np.nan, np.float32)
        table[:101] = np.arange(101, dtype=np.float32) / np.float32(100)
        return look_up(table, self.data.view(np.uint8))


def decode_ros1(data: memoryview) -> OccupancyMessage:
    """The message as ROS 1 packs it: no padding, little endian.

    Raises:
        BrokenRecordError: shorter than announced, or values no map can have.
    """
    cursor = Cursor(data)
    cursor.numbers("III")  # sequence number and stamp
    cursor.block()  # frame
    cursor.numbers("II")  # time of loading
    resolution, width, height = cursor.numbers("fII")
    return _message(cursor, resolution, width, height, cursor.numbers("7d"))


def decode_cdr(data: memoryview) -> OccupancyMessage:
    """The message in plain CDR: aligned values behind four bytes that tell the order of bytes.

    Raises:
        BrokenRecordError: another encoding, shorter than announced, or values no map can have.
    """
    encoding = bytes(data[:4])
    if encoding[:2] not in {b"\0\0", b"\0\1"}:
        raise BrokenRecordError("the message is not in plain CDR")
    cursor = Cursor(data, "<" if encoding[1] else ">", 4)
    cursor.numbers("iI")  # stamp
    cursor.block()  # frame
    cursor.align(4, 4)
    cursor.numbers("iI")  # time of loading
    resolution, width, height = cursor.numbers("fII")
    cursor.align(8, 4)
    return _message(cursor, resolution, width, height, cursor.numbers("7d"))


def _message(cursor: Cursor, resolution_m: float, width: int, height: int, pose: tuple[float, ...]) -> OccupancyMessage:
    """Check what was read; resolutions are float32 on the wire, so 0.05 comes back to 7 digits."""
    if not (1 <= width * height <= MAX_CELLS):
        raise BrokenRecordError(f"the map has {width} x {height} cells, expected 1 to {MAX_CELLS:,}")
    if not is_resolution(resolution_m):
        raise BrokenRecordError(f"the map's resolution is {resolution_m:g} m")
    if not all(map(math.isfinite, pose)) or max(map(abs, pose[:2])) > 1e8:
        raise BrokenRecordError("the map's origin is not finite")
    cells = cursor.block()
    if len(cells) != width * height:
        raise BrokenRecordError(f"the map has {len(cells)} values for {width} x {height} cells")
    data = np.frombuffer(cells, np.int8).reshape(height, width)
    shortest = float(np.format_float_positional(np.float32(resolution_m), unique=True))
    return OccupancyMessage(shortest, Pose2(pose[0], pose[1], _yaw(*pose[3:])), data)


def _yaw(x: float, y: float, z: float, w: float) -> float:
    """Turn about the vertical axis of a quaternion of any length; 0 for the zero quaternion of careless writers."""
    size = math.hypot(x, y, z, w)
    if not 1e-9 < size < math.inf:
        return 0.0
    x, y, z, w = x / size, y / size, z / size, w / size
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
