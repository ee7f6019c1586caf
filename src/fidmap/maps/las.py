"""LAS point clouds, and LAZ, whose points are decoded by laspy and lazrs in a process of their own.

Format: ASPRS, "LAS Specification 1.4 - R15", section 2. lazrs ends its whole process when a file announces absurd
sizes; a child takes that blow, under a bound on its memory and its time.
"""

from __future__ import annotations

import functools
import struct
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fidmap.maps.cloud import CHUNK_POINTS, MAX_POINTS, Cloud, Points, read_cloud
from fidmap.maps.cursor import BrokenRecordError
from fidmap.maps.extras import need
from fidmap.maps.overrides import Overrides
from fidmap.maps.point_table import kept
from fidmap.model import Grid

HEADER_BYTES = 375
MOST_POINTS_PER_BYTE = 2500  # the first of each 50,000 points is not compressed, and has 20 bytes and more
POINT_BYTES = 12  # X, Y and Z as 32-bit integers come first in every point format


@dataclass(frozen=True)
class Header:
    """What the header says: where points begin, bytes per point, how many, and how integers become metres."""

    start: int
    width: int
    count: int
    compressed: bool
    scale: tuple[float, ...]
    offset: tuple[float, ...]


def read(path: Path, name: str, overrides: Overrides) -> Grid:
    """Read the points of a LAS or LAZ file as a map.

    Raises:
        MapFileError: as `read_cloud`.
        MissingLibraryError: compressed, and the library for it is not installed.
        BrokenRecordError: a header or points that are not what they announce.
    """
    with path.open("rb") as file:
        header = _header(file.read(HEADER_BYTES))
    if header.compressed:
        need("laspy", "pointcloud", "a LAZ file")
        need("lazrs", "pointcloud", "a LAZ file")
        blocks = kept(functools.partial(_unpacked, path, header), header.count)
    else:
        blocks = functools.partial(_plain, path, header)
    return read_cloud(Cloud(header.count, blocks), path, name, "las", overrides)


def _header(head: bytes) -> Header:
    if len(head) < 227:
        raise BrokenRecordError("its header is cut off")
    (start,) = struct.unpack_from("<I", head, 96)
    kind, width, count = struct.unpack_from("<BHI", head, 104)
    if head[25] >= 4 and len(head) >= 255:
        count = struct.unpack_from("<Q", head, 247)[0] or count
    scale, offset = struct.unpack_from("<3d", head, 131), struct.unpack_from("<3d", head, 155)
    if width < POINT_BYTES or not np.isfinite([*scale, *offset]).all() or 0 in scale:
        raise BrokenRecordError(f"its points have {width} bytes, the scale {scale} and the offset {offset}")
    return Header(start, width, count, kind >= 64, scale, offset)


def _metres(rows: npt.NDArray[np.int32], header: Header) -> Points:
    """X, Y and Z (n, 3) to metres."""
    points = np.empty(rows.shape, np.float64, order="F")
    for k, (scale, offset) in enumerate(zip(header.scale, header.offset, strict=True)):
        np.multiply(rows[:, k], scale, out=points[:, k])
        points[:, k] += offset
    return points


def _plain(path: Path, header: Header) -> Iterator[Points]:
    """Blocks of an uncompressed file."""
    if (held := (path.stat().st_size - header.start) // header.width) < header.count:
        raise BrokenRecordError(f"it announces {header.count:,} points where bytes for {max(0, held):,} are left")
    layout = np.dtype({"names": ["xyz"], "formats": [("<i4", (3,))], "itemsize": header.width})
    with path.open("rb") as file:
        file.seek(header.start)
        for done in range(0, header.count, CHUNK_POINTS):
            yield _metres(np.fromfile(file, layout, min(CHUNK_POINTS, header.count - done))["xyz"], header)


def _unpacked(path: Path, header: Header) -> Iterator[Points]:
    """Blocks of a compressed file, from the child that decodes it."""
    if header.count > min(MAX_POINTS, MOST_POINTS_PER_BYTE * path.stat().st_size):
        raise BrokenRecordError(
            f"it announces {header.count:,} points, at most {MAX_POINTS:,} are read, and "
            f"{MOST_POINTS_PER_BYTE:,} per byte"
        )
    command = [sys.executable, "-m", "fidmap.maps.laz_points", str(path.absolute())]
    done = 0
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as child:
        assert child.stdout is not None
        try:
            while done < header.count and (data := child.stdout.read(POINT_BYTES * CHUNK_POINTS)):
                rows = np.frombuffer(data, "<i4", len(data) // 4 - len(data) // 4 % 3).reshape(-1, 3)
                rows = rows[: header.count - done]
                done += len(rows)
                yield _metres(rows, header)
        finally:
            child.kill()
    if done < header.count:
        raise BrokenRecordError(f"it announces {header.count:,} points, {done:,} could be decoded")
