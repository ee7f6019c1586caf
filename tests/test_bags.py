"""Maps from ROS 1 bags, ROS 2 bags and MCAP files."""

from __future__ import annotations

import bz2
import math
import sqlite3
import struct
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from benchmarks.bag_files import (
    BEGIN,
    GRID,
    ROS1,
    ROS2,
    SECOND,
    Cells,
    as_cdr,
    cells,
    mcap_bytes,
    message,
    write_bag1,
    write_bag2,
)

from command_line import fidmap
from fidmap.grid import trinarize
from fidmap.maps import read_map
from fidmap.maps.cursor import BrokenRecordError, Budget
from fidmap.maps.occupancy_message import decode_cdr, decode_ros1
from fidmap.maps.recording import unpacked
from fidmap.model import Label
from map_files import sentence

THREE = [("/map", 0.0, cells(0)), ("/map", 1.0, cells(1)), ("/map", 2.5, cells(2))]


def as_values(path: Path, **options: object) -> Cells:
    """The map as the message's values, -1 for whatever is unknown."""
    occupancy = read_map(path, **options).occupancy
    return np.where(np.isnan(occupancy), -1, np.rint(100 * np.nan_to_num(occupancy))).astype(np.int8)


def known(data: Cells) -> Cells:
    """What the map savers make of a message: all but 0 to 100 is unknown."""
    return np.where((data < 0) | (data > 100), -1, data).astype(np.int8)


def mcap(**options: object) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (folder / "a.mcap").write_bytes(mcap_bytes(THREE, **options))
        return folder / "a.mcap"

    return write


def file_of(plugin: str, suffix: str, mode: str | None = None) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        path = write_bag2(folder / "bag", THREE, plugin, mode)
        (path / "metadata.yaml").unlink()  # a single file, as people hand it on
        return path / f"bag{suffix}"

    return write


KINDS: dict[str, Callable[[Path], Path]] = {
    "ROS 1": lambda folder: write_bag1(folder / "a.bag", THREE),
    "ROS 1, bz2": lambda folder: write_bag1(folder / "a.bag", THREE, "BZ2"),
    "ROS 1, lz4": lambda folder: write_bag1(folder / "a.bag", THREE, "LZ4"),
    "ROS 2 folder": lambda folder: write_bag2(folder / "bag", THREE),
    "ROS 2 folder of MCAP": lambda folder: write_bag2(folder / "bag", THREE, "MCAP"),
    "db3 alone": file_of("SQLITE3", ".db3"),
    "db3, zstd messages": file_of("SQLITE3", ".db3", "MESSAGE"),
    "MCAP alone": file_of("MCAP", ".mcap"),
    "MCAP, zstd messages": file_of("MCAP", ".mcap", "MESSAGE"),
    "MCAP, zstd chunks": file_of("MCAP", ".mcap", "STORAGE"),
    "MCAP by mcap, lz4": mcap(),
    "MCAP by mcap, zstd": mcap(compression="ZSTD"),
    "MCAP without chunks": mcap(use_chunking=False),
    "MCAP without summary": mcap(
        use_summary_offsets=False, use_statistics=False, repeat_channels=False, repeat_schemas=False
    ),
}


@pytest.mark.parametrize("kind", KINDS)
def test_the_map_of_a_moment(tmp_path: Path, kind: str) -> None:
    """The last map without --time, else the last until then; values, resolution and pose as recorded."""
    path = KINDS[kind](tmp_path)
    assert (as_values(path) == known(cells(2))).all()
    assert (as_values(path, time_s=2.4) == known(cells(1))).all()
    assert (as_values(path, time_s=0) == known(cells(0))).all()

    grid = read_map(path)
    assert (grid.resolution_m, grid.origin.x_m, grid.origin.y_m) == (0.05, 1.0, -2.0)
    assert grid.origin.yaw == pytest.approx(0.2)
    assert grid.source.format == "bag:/map"


def test_labels_are_those_of_the_map_savers(tmp_path: Path) -> None:
    """At most 25 is free, at least 65 occupied, all else and whatever is not 0 to 100 unknown."""
    data = np.array([[0, 25, 26, 64, 65, 100, -1, 101, -128, 127]], np.int8)
    labels = trinarize(read_map(write_bag1(tmp_path / "a.bag", [("/map", 0, data)]))).labels[0]
    free, unknown, occupied = Label.FREE, Label.UNKNOWN, Label.OCCUPIED
    assert labels.tolist() == [free, free, unknown, unknown, occupied, occupied, *[unknown] * 4]


def test_row_0_is_the_lowest(tmp_path: Path) -> None:
    """The message's first value is the cell at the origin, unlike an image's."""
    data = np.full((3, 4), -1, np.int8)
    data[0, 0] = 100
    grid = read_map(write_bag1(tmp_path / "a.bag", [("/m", 0, data)]))
    assert grid.occupancy[0, 0] == 1
    assert np.isnan(grid.occupancy).sum() == 11


def test_choosing_a_topic(tmp_path: Path) -> None:
    """The only one, or /map with a note; else one sentence that lists them; --topic decides."""
    path = write_bag1(tmp_path / "a.bag", [("/map", 0, cells(0)), ("/local/map", 1, cells(1))])
    grid = read_map(path)
    assert (as_values(path) == known(cells(0))).all()
    assert [(f.code, f.option) for f in grid.source.findings if f.code == "several-topics"] == [
        ("several-topics", "--topic NAME")
    ]
    assert (as_values(path, topic="local/map") == known(cells(1))).all()

    other = write_bag1(tmp_path / "b.bag", [("/a", 0, cells(0)), ("/b", 1, cells(1))])
    assert sentence(other) == f"{other} holds maps on 2 topics: /a, /b; choose one with --topic"
    assert sentence(other, topic="/c") == (
        f"{other} cannot be read with --topic /c, which is not in it; its maps are on /a, /b"
    )
    assert sentence(other, topic="/b", time_s=0.5) == (
        f"{other} holds no map on /b in its first 0.5 s; give a later --time, or none for the last one"
    )


def test_files_of_one_recording_are_one(tmp_path: Path) -> None:
    """A split recording: the last map may lie in any of its files."""
    folder = write_bag2(tmp_path / "bag", THREE[:1])
    late = write_bag2(tmp_path / "late", THREE[1:])
    (late / "late.db3").rename(folder / "bag_1.db3")
    assert (as_values(folder) == known(cells(2))).all()
    assert (as_values(folder, time_s=1) == known(cells(1))).all()


def test_a_killed_recording_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    """Without its index, or cut in the middle, a bag gives the maps that are whole."""
    whole = write_bag1(tmp_path / "a.bag", THREE).read_bytes()
    index = struct.unpack("<Q", whole[whole.index(b"index_pos=") + 10 :][:8])[0]
    (tmp_path / "cut.bag").write_bytes(whole[:index])
    (tmp_path / "no_index.bag").write_bytes(whole[:index].replace(struct.pack("<Q", index), bytes(8)))
    for name in ("cut.bag", "no_index.bag"):
        assert (as_values(tmp_path / name) == known(cells(2))).all()

    data = mcap_bytes(THREE)
    third = data.index(struct.pack("<Q", BEGIN + round(2.5 * SECOND)))  # a chunk begins with its first stamp
    (tmp_path / "cut.mcap").write_bytes(data[: third + 30])
    assert (as_values(tmp_path / "cut.mcap") == known(cells(1))).all()


def test_a_summary_that_begins_in_the_footer(tmp_path: Path) -> None:
    """Read as if there were none (found by fuzzing)."""
    data = bytearray(mcap_bytes(THREE))
    data[-28:-20] = struct.pack("<Q", len(data) - 20)
    (tmp_path / "a.mcap").write_bytes(data)
    assert (as_values(tmp_path / "a.mcap") == known(cells(2))).all()


def test_the_command_line_reads_bags(tmp_path: Path) -> None:
    """`--topic` and `--time` reach the reader, and the report says what they were."""
    path = write_bag1(tmp_path / "a.bag", [("/a", 0, cells(0)), ("/b", 1, cells(1))])
    assert fidmap("detect", path, "--radius", 0.3).exit_code == 1
    assert fidmap("detect", path, "--radius", 0.3, "--topic", "/a", "--time", 0.5).exit_code == 0
    assert "--time" in fidmap("detect", path, "--radius", 0.3, "--topic", "/b", "--time", 0.5).stderr
    assert "--time -1" in fidmap("detect", path, "--radius", 0.3, "--time=-1").stderr


@pytest.mark.parametrize(
    ("quaternion", "yaw"),
    [((0, 0, 0, 0), 0), ((0, 0, 2, 2), math.pi / 2), ((0, 0, 0, -1), 0), ((0, 0, 1, 0), math.pi)],
)
def test_yaw_of_careless_quaternions(quaternion: tuple[float, ...], yaw: float) -> None:
    """Of any length and sign; all zeros means not turned."""
    decoded = decode_cdr(memoryview(as_cdr(cells(0), quaternion=tuple(map(float, quaternion)))))
    assert abs(decoded.origin.yaw) == pytest.approx(yaw)


def test_big_endian_messages() -> None:
    """CDR says its order of bytes."""
    little = as_cdr(cells(3))
    big = bytes(ROS2.serialize_cdr(message(ROS2, cells(3)), GRID, little_endian=False))
    assert big != little
    assert (decode_cdr(memoryview(big)).data == cells(3)).all()


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"width": 10**9}, "1000000000 x 7 cells"),
        ({"width": 8}, "63 values for 8 x 7 cells"),
        ({"height": 0}, "9 x 0 cells"),
        ({"resolution": math.nan}, "resolution is nan m"),
        ({"resolution": -0.05}, "resolution is -0.05 m"),
    ],
)
def test_messages_that_lie(changed: dict[str, float], says: str) -> None:
    """Sizes and numbers no map can have are told, in both encodings."""
    with pytest.raises(BrokenRecordError, match=says):
        decode_cdr(memoryview(as_cdr(cells(0), **changed)))
    raw = bytes(ROS1.serialize_ros1(message(ROS1, cells(0), **changed), GRID))
    with pytest.raises(BrokenRecordError, match=says):
        decode_ros1(memoryview(raw))


@pytest.mark.parametrize("compression", ["lz4", "zstd", "bz2"])
def test_chunks_that_explode(compression: str) -> None:
    """A chunk of zeros that unpacks to a hundred times what it announces takes no more than it announces."""
    pack = {"lz4": lz4.frame.compress, "zstd": zstandard.ZstdCompressor().compress, "bz2": bz2.compress}
    bomb = pack[compression](bytes(100_000_000))
    tracemalloc.start()
    with pytest.raises(BrokenRecordError, match="does not hold the 1000000 bytes that it announces"):
        unpacked(memoryview(bomb), compression, 1_000_000)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20_000_000
    with pytest.raises(BrokenRecordError, match="at most 536,870,912 are read"):
        unpacked(memoryview(bomb), compression, 2**40)
    with pytest.raises(BrokenRecordError):
        unpacked(memoryview(bomb[:50]), compression, 1000)


def test_an_endless_index(tmp_path: Path) -> None:
    """A bag whose index points at itself, and records without end, come to an end."""
    whole = bytearray(write_bag1(tmp_path / "a.bag", THREE).read_bytes())
    place = whole.index(b"chunk_pos=") + 10
    index = struct.unpack("<Q", whole[whole.index(b"index_pos=") + 10 :][:8])[0]
    whole[place : place + 8] = struct.pack("<Q", index)
    (tmp_path / "loop.bag").write_bytes(whole)
    assert "the index names a chunk where none is" in sentence(tmp_path / "loop.bag")

    budget = Budget(1)
    budget.spend()
    with pytest.raises(BrokenRecordError, match="records would have to be looked at"):
        budget.spend()


def database(path: Path, *statements: str) -> Path:
    with sqlite3.connect(path) as connection:
        for statement in statements:
            connection.execute(statement)
    connection.close()
    return path


def test_databases_that_are_no_bags(tmp_path: Path) -> None:
    """Other tables, views that would never end, text in place of bytes: one sentence each."""
    other = database(tmp_path / "other.db3", "CREATE TABLE films (title TEXT)")
    assert "its tables are not those of a ROS 2 bag" in sentence(other)
    endless = "CREATE VIEW topics AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i id FROM n"
    view = database(tmp_path / "view.db3", "CREATE TABLE messages (id, topic_id, timestamp, data)", endless)
    assert "its tables are not those of a ROS 2 bag" in sentence(view)
    text = database(
        tmp_path / "text.db3",
        "CREATE TABLE topics (id, name, type, serialization_format)",
        "CREATE TABLE messages (id, topic_id, timestamp, data)",
        "INSERT INTO topics VALUES (1, '/map', 'nav_msgs/msg/OccupancyGrid', 'cdr')",
        "INSERT INTO messages VALUES (1, 1, 0, 'no bytes')",
    )
    assert "a message has no bytes or no time" in sentence(text)
    (tmp_path / "short.db3").write_bytes(text.read_bytes()[:3000])
    assert "SQLite says" in sentence(tmp_path / "short.db3")


def test_bags_without_maps(tmp_path: Path) -> None:
    """What to record is said; a bag folder without recordings is a folder like any other."""
    path = tmp_path / "empty.mcap"
    path.write_bytes(mcap_bytes([]))
    assert sentence(path) == (
        f"{path} holds no nav_msgs/OccupancyGrid; record the topic of the map, such as /map, as well"
    )
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "metadata.yaml").write_text("{}")
    assert "is a directory" in sentence(tmp_path / "folder")


def test_a_missing_library_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A core installation reads plain bags, and says how to get the library that others need."""
    monkeypatch.setitem(sys.modules, "lz4.frame", None)
    plain = write_bag1(tmp_path / "a.bag", THREE)
    packed = write_bag1(tmp_path / "b.bag", THREE, "LZ4")
    assert (as_values(plain) == known(cells(2))).all()
    assert sentence(packed) == (
        f"{packed} is a bag with lz4 compression, which needs the library lz4; install it with pip install "
        "'fidmap[bags]'"
    )
