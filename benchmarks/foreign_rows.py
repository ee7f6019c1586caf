"""Rows of `./run bench formats` for recordings, 3D maps and drawings: the grid as those programs would hand it on.

Bags hold the grid as a message. Point clouds hold its walls upright, seven points over each occupied cell, and its
floor, one point for each free cell, at most ten million in all. Drawings hold each run of occupied cells in a row as a
line along its middle. What is slow to write takes part with a smaller map in the table of times.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.bag_files import GRID, ROS1, ROS2, Written, mcap_bytes, write_bag1, write_bag2, write_rtabmap
from benchmarks.cloud_files import Points, write_las, write_octree, write_pcd, write_ply
from benchmarks.drawing_files import write_dxf, write_geojson, write_svg
from benchmarks.rows import Row
from fidmap.grid import cells_to_metres, trinarize
from fidmap.model import FloatArray, Grid, Label, Pose2

MOST_POINTS = 10_000_000
HEIGHTS = np.linspace(0.2, 0.9, 7) + 0.005
SLOW = 10  # times fewer cells a side


def _values(grid: Grid) -> npt.NDArray[np.int8]:
    """(H, W) of a message: 0, 100 and -1."""
    return np.array([0, -1, 100], np.int8)[trinarize(grid).labels]


def _recorded(write: Callable[[Path, Written], Path], name: str) -> Callable[[Path, Grid], Path]:
    return lambda folder, grid: write(folder / name, [("/map", 0.0, _values(grid))])


def _mcap(compression: str) -> Callable[[Path, Written], Path]:
    def write(path: Path, written: Written) -> Path:
        path.write_bytes(mcap_bytes(written, compression))
        return path

    return write


def rosbags(path: Path) -> int:
    """Bytes of the message as rosbags decodes it."""
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2

    ros1 = path.suffix == ".bag"
    with (Reader1 if ros1 else Reader2)(path) as reader:
        data = next(raw for _, _, raw in reader.messages(reader.connections))
    message: Any = ROS1.deserialize_ros1(data, GRID) if ros1 else ROS2.deserialize_cdr(data, GRID)
    return int(message.data.nbytes)


def _rtabmap(folder: Path, grid: Grid) -> Path:
    return write_rtabmap(folder / "rtabmap.db", _values(grid))


def unpacked(path: Path) -> int:
    """Bytes of the map that SQLite and zlib give."""
    import sqlite3
    import zlib

    connection = sqlite3.connect(path)
    ((blob,),) = connection.execute("SELECT opt_map FROM Admin")
    connection.close()
    return len(zlib.decompress(blob[:-12]))


def _centres(grid: Grid, label: Label) -> FloatArray:
    """(N, 2) in a frame that begins at the grid's corner."""
    cells = np.argwhere(trinarize(grid).labels == label).astype(float) + 0.5
    return cells_to_metres(cells, grid.resolution_m, Pose2())


def cloud(grid: Grid) -> Points:
    """Points (N, 3) of walls and floor."""
    walls, floor = _centres(grid, Label.OCCUPIED), _centres(grid, Label.FREE)
    upright = np.column_stack([np.repeat(walls, len(HEIGHTS), axis=0), np.tile(HEIGHTS, len(walls))])
    room = max(1, MOST_POINTS - len(upright))
    floor = floor[:: -(-len(floor) // room)]
    return np.concatenate([upright, np.column_stack([floor, np.zeros(len(floor))])])[:MOST_POINTS]


def _scanned(write: Callable[[Path, Points], Path], name: str) -> Callable[[Path, Grid], Path]:
    return lambda folder, grid: write(folder / name, cloud(grid))


def bytes_read(path: Path) -> int:
    """Bytes of the file: there is no library to compare with."""
    return int(np.fromfile(path, np.uint8).nbytes)


def pypcd4(path: Path) -> int:
    """Bytes of the points that pypcd4 decodes."""
    from pypcd4.pypcd4 import PointCloud

    return int(PointCloud.from_path(path).pc_data.nbytes)


def laspy(path: Path) -> int:
    """Bytes of the points that laspy decodes, as coordinates in float64."""
    import laspy as library

    return int(library.read(path).xyz.nbytes)


def octomap(path: Path) -> int:
    """Bytes of the tree that OctoMap decodes."""
    import pyoctomap

    tree = pyoctomap.OcTree(0.05)
    tree = tree if path.suffix == ".bt" and tree.readBinary(str(path)) else tree.read(str(path))
    return int(tree.memoryUsage())


def _octree(suffix: str) -> Callable[[Path, Grid], Path]:
    def write(folder: Path, grid: Grid) -> Path:
        walls, air = _centres(grid, Label.OCCUPIED), _centres(grid, Label.FREE)
        high = np.arange(0.025, 1, grid.resolution_m)
        ground = np.column_stack([air, np.full(len(air), -0.025)])
        parts = (np.column_stack([np.repeat(xy, len(high), axis=0), np.tile(high, len(xy))]) for xy in (walls, air))
        upright, above = parts
        return write_octree(folder / f"tree{suffix}", np.concatenate([upright, ground]), above, grid.resolution_m)

    return write


def runs(grid: Grid) -> list[tuple[str, FloatArray]]:
    """Each run of occupied cells in a row as a line from the middle of its first to that of its last cell."""
    occupied = (trinarize(grid).labels == Label.OCCUPIED).astype(np.int8)
    change = np.diff(np.pad(occupied, ((0, 0), (1, 1))), axis=1)
    (rows, first), (_, last) = np.nonzero(change == 1), np.nonzero(change == -1)
    r = grid.resolution_m
    return [
        ("line", np.array([(a + 0.5) * r, (row + 0.5) * r, (b - 0.5) * r, (row + 0.5) * r]))
        for row, a, b in zip(rows, first, last, strict=True)
    ]


def _drawn(write: Callable[..., Path], name: str) -> Callable[[Path, Grid], Path]:
    return lambda folder, grid: write(folder / name, runs(grid))


def ezdxf(path: Path) -> int:
    """Bytes of the document that ezdxf parses."""
    from ezdxf.filemanagement import readfile

    return len(readfile(path).modelspace()) and path.stat().st_size


def json_of(path: Path) -> int:
    """Bytes of the document that Python's json parses."""
    import json

    return len(json.loads(path.read_bytes())) and path.stat().st_size


def svgelements(path: Path) -> int:
    """Bytes of the document that svgelements parses."""
    from svgelements import SVG

    return len(list(SVG.parse(str(path)).elements())) and path.stat().st_size


def _same_cells(name: str, write: Callable[..., Path], file: str, decode: Callable[[Path], int]) -> Row:
    return Row(name, _drawn(write, file), decode, {"resolution_m": 0.05}, points=2.0, across=SLOW)


def _packed(encoding: str) -> Callable[[Path, Points], Path]:
    return lambda path, points: write_pcd(path, points, encoding)


FOREIGN_ROWS = (
    Row("ROS 1 bag", _recorded(write_bag1, "a.bag"), rosbags),
    Row("ROS 1 bag, lz4", _recorded(lambda path, maps: write_bag1(path, maps, "LZ4"), "b.bag"), rosbags),
    Row("ROS 2 bag, SQLite", _recorded(write_bag2, "bag2"), rosbags),
    Row("MCAP", _recorded(_mcap("NONE"), "a.mcap"), rosbags),
    Row("MCAP, zstd", _recorded(_mcap("ZSTD"), "b.mcap"), rosbags),
    Row("RTAB-Map", _rtabmap, unpacked),
    Row("PLY, binary", _scanned(write_ply, "a.ply"), bytes_read, points=2.0),
    Row("PCD, binary", _scanned(write_pcd, "a.pcd"), pypcd4, points=2.0),
    Row("PCD, compressed", _scanned(_packed("binary_compressed"), "b.pcd"), pypcd4, points=2.0),
    Row("LAS", _scanned(write_las, "a.las"), laspy, points=2.0),
    Row("LAZ", _scanned(write_las, "a.laz"), laspy, points=2.0),
    Row("OctoMap .bt, a tenth a side", _octree(".bt"), octomap, points=2.0, across=SLOW),
    Row("OctoMap .ot, a tenth a side", _octree(".ot"), octomap, points=2.0, across=SLOW),
    _same_cells("DXF, a tenth a side", write_dxf, "a.dxf", ezdxf),
    _same_cells("SVG, a tenth a side", write_svg, "a.svg", svgelements),
    _same_cells("GeoJSON, a tenth a side", write_geojson, "a.geojson", json_of),
)
