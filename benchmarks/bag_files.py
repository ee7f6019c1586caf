"""Bags for tests, fuzzing and benchmarks, written by rosbags and by the mcap library, never by the program itself."""

from __future__ import annotations

import io
import sqlite3
import struct
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Bag1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Bag2
from rosbags.typesys import Stores, get_typestore

ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
GRID = "nav_msgs/msg/OccupancyGrid"
BEGIN = 1_700_000_000 * 10**9
SECOND = 10**9
Cells = npt.NDArray[np.int8]
Written = Sequence[tuple[str, float, Cells]]  # topic, seconds after the beginning, map


def cells(seed: int, height: int = 7, width: int = 9) -> Cells:
    """A map of every value that a message may carry, and some that it may not."""
    return np.random.default_rng(seed).integers(-5, 110, (height, width), dtype=np.int8)


def message(store: Any, data: Cells, **changed: Any) -> Any:
    """An OccupancyGrid turned by 0.2 rad; `changed` are fields of its info, or `quaternion`."""
    types = store.types
    x, y, z, w = changed.pop("quaternion", (0.0, 0.0, np.sin(0.1), np.cos(0.1)))
    stamp = types["builtin_interfaces/msg/Time"](sec=5, nanosec=6)
    sequence = {"seq": 3} if store is ROS1 else {}
    pose = types["geometry_msgs/msg/Pose"](
        position=types["geometry_msgs/msg/Point"](x=1.0, y=-2.0, z=0.0),
        orientation=types["geometry_msgs/msg/Quaternion"](x=x, y=y, z=z, w=w),
    )
    info = {"resolution": 0.05, "width": data.shape[1], "height": data.shape[0], "origin": pose} | changed
    return types[GRID](
        header=types["std_msgs/msg/Header"](stamp=stamp, frame_id="map1", **sequence),
        info=types["nav_msgs/msg/MapMetaData"](map_load_time=stamp, **info),
        data=data.ravel(),
    )


def as_cdr(data: Cells, **changed: Any) -> bytes:
    """The message in CDR."""
    return bytes(ROS2.serialize_cdr(message(ROS2, data, **changed), GRID))


def write_bag1(path: Path, written: Written, compression: str | None = None, **changed: Any) -> Path:
    """A ROS 1 bag."""
    writer = Bag1(path)
    if compression:
        writer.set_compression(Bag1.CompressionFormat[compression])
    with writer:
        topics = dict.fromkeys(topic for topic, _, _ in written)
        connections = {topic: writer.add_connection(topic, GRID, typestore=ROS1) for topic in topics}
        for topic, when, data in written:
            raw = ROS1.serialize_ros1(message(ROS1, data, **changed), GRID)
            writer.write(connections[topic], BEGIN + round(when * SECOND), raw)
    return path


def write_bag2(path: Path, written: Written, plugin: str = "SQLITE3", mode: str | None = None) -> Path:
    """A folder of a ROS 2 bag."""
    writer = Bag2(path, version=9, storage_plugin=StoragePlugin[plugin])
    if mode:
        writer.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
    with writer:
        topics = dict.fromkeys(topic for topic, _, _ in written)
        connections = {topic: writer.add_connection(topic, GRID, typestore=ROS2) for topic in topics}
        for topic, when, data in written:
            writer.write(connections[topic], BEGIN + round(when * SECOND), as_cdr(data))
    return path


def mcap_bytes(written: Written, compression: str = "LZ4", **options: Any) -> bytes:
    """An MCAP file by the mcap library."""
    file = io.BytesIO()
    writer = McapWriter(file, compression=CompressionType[compression], chunk_size=1, **options)
    writer.start(profile="ros2")
    schema = writer.register_schema("nav_msgs/msg/OccupancyGrid", "ros2msg", b"")
    channels = {t: writer.register_channel(t, "cdr", schema) for t in dict.fromkeys(topic for topic, _, _ in written)}
    for topic, when, data in written:
        stamp = BEGIN + round(when * SECOND)
        writer.add_message(channels[topic], stamp, as_cdr(data), stamp)
    writer.finish()  # type: ignore[no-untyped-call]  # as the library has it
    return file.getvalue()


def write_rtabmap(
    path: Path,
    data: Cells,
    shape: tuple[int, int] | None = None,
    kind: int = 1,
    resolution: object = 0.05,
    packed: bytes | None = None,
) -> Path:
    """A database with the table and the blob of RTAB-Map's Compression.cpp: zlib, then three integers."""
    with sqlite3.connect(path) as connection:
        connection.execute(
            "CREATE TABLE Admin (version TEXT, opt_map BLOB, opt_map_x_min FLOAT, opt_map_y_min FLOAT, "
            "opt_map_resolution FLOAT)"
        )
        blob = zlib.compress(data.tobytes()) if packed is None else packed
        blob += struct.pack("<3i", *(shape or data.shape), kind)
        connection.execute("INSERT INTO Admin VALUES ('0.21', ?, -1.5, 2.5, ?)", (blob, resolution))
    connection.close()
    return path
