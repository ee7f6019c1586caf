"""RTAB-Map's database, files that are no maps, and maps behind URLs."""

from __future__ import annotations

import io
import sqlite3
import sys
import zipfile
import zlib
from pathlib import Path

import fsspec
import numpy as np
import pytest
from benchmarks.bag_files import write_rtabmap

from fidmap.maps import read_map
from fidmap.maps.refused import ADVICE
from map_files import sentence, write_map, write_pgm, write_yaml

CELLS = np.array([[0, 100, -1], [50, 0, 0]], np.int8)


def test_the_map_of_rtabmap(tmp_path: Path) -> None:
    """Row 0 is the lowest; place and resolution are those of the database."""
    grid = read_map(write_rtabmap(tmp_path / "rtabmap.db", CELLS))
    assert (grid.resolution_m, grid.origin.x_m, grid.origin.y_m) == (0.05, -1.5, 2.5)
    assert np.array_equal(grid.occupancy, np.float32([[0, 1, np.nan], [0.5, 0, 0]]), equal_nan=True)
    assert grid.source.format == "rtabmap"


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"shape": (2, 4)}, "its map has 6 of 8 cells"),
        ({"shape": (2**20, 2**20)}, "its map has 1048576 x 1048576 cells"),
        ({"kind": 5}, "cells of the kind 5, expected signed bytes"),
        ({"resolution": -1.0}, "the resolution -1 m"),
        ({"resolution": "fine"}, "its map has no place or no resolution"),
        ({"packed": zlib.compress(bytes(10**8))}, None),
    ],
)
def test_databases_that_lie(tmp_path: Path, changes: dict[str, object], says: str | None) -> None:
    """More or fewer cells than announced; a blob that explodes is unpacked as far as announced."""
    path = write_rtabmap(tmp_path / "a.db", CELLS, **changes)  # type: ignore[arg-type]
    if says is None:
        assert read_map(path).occupancy.shape == (2, 3)
    else:
        assert says in sentence(path)


def test_a_database_without_a_map(tmp_path: Path) -> None:
    """What to do is said."""
    with sqlite3.connect(tmp_path / "old.db") as connection:
        connection.execute("CREATE TABLE Admin (version TEXT)")
    connection.close()
    assert "is an RTAB-Map database without an assembled 2D map" in sentence(tmp_path / "old.db")


@pytest.mark.parametrize("begin", ADVICE)
def test_files_of_other_programs(tmp_path: Path, begin: bytes) -> None:
    """Each gets its sentence with what to do; the name of the file does not matter."""
    (tmp_path / "map").write_bytes(begin + bytes(100))
    assert sentence(tmp_path / "map") == f"{tmp_path / 'map'} {ADVICE[begin]}"


def zipped(path: Path, *files: Path) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in files:
            archive.write(file, f"team/{file.name}")
    return path


def test_members_of_an_archive(tmp_path: Path) -> None:
    """A YAML brings its image along; the report names the URL."""
    path = write_map(tmp_path, [[0, 205, 254]])
    name = f"zip://team/map.yaml::{zipped(tmp_path / 'maps.zip', path, tmp_path / 'map.png')}"
    grid = read_map(name)
    assert np.array_equal(grid.occupancy, read_map(path).occupancy, equal_nan=True)
    assert grid.source.name == name
    assert grid.source.sha256 == read_map(path).source.sha256


def test_other_places(tmp_path: Path) -> None:
    """Whatever fsspec opens; sentences name the URL, not where it was fetched to."""
    memory = fsspec.filesystem("memory")
    memory.pipe("/maps/m.pgm", write_pgm(tmp_path, [[0, 205, 254]]).read_bytes())
    assert read_map("memory://maps/m.pgm", resolution_m=0.05).occupancy.shape == (1, 3)
    assert sentence("memory://maps/m.pgm").startswith("memory://maps/m.pgm is an image without a YAML")
    memory.pipe("/maps/bad.yaml", b"image: none.png\n")
    assert sentence("memory://maps/bad.yaml").startswith("memory://maps/bad.yaml")
    assert "cannot be fetched" in sentence("memory://maps/nothing.pgm")
    assert "cannot be fetched" in sentence("nonsense://maps/m.pgm")


def test_a_missing_library_for_a_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fsspec says which one, and the extra brings it."""
    monkeypatch.setitem(sys.modules, "s3fs", None)
    text = sentence("s3://maps/m.yaml")
    assert text.startswith("s3://maps/m.yaml needs a library (")
    assert "pip install 'fidmap[remote]'" in text


@pytest.mark.parametrize("image", ["/etc/passwd", "../secret.pgm", "a/../../secret.pgm", "C:\\maps\\m.pgm"])
def test_images_elsewhere_are_not_fetched(tmp_path: Path, image: str) -> None:
    """A YAML from elsewhere reads neither this machine's files nor those above it there."""
    memory = fsspec.filesystem("memory")
    memory.pipe("/secret.pgm", b"P5 1 1 255\n\0")
    memory.pipe("/maps/m.yaml", write_yaml(tmp_path, image=image).read_bytes())
    assert "of a URL only images beside the YAML are fetched" in sentence("memory://maps/m.yaml")


def test_an_archive_that_explodes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What comes out is counted, not what is announced."""
    monkeypatch.setattr("fidmap.maps.remote.MAX_BYTES", 1_000_000)
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("m.pgm", bytes(10_000_000))
    (tmp_path / "bomb.zip").write_bytes(file.getvalue())
    assert "has more than 1,000,000 bytes" in sentence(f"zip://m.pgm::{tmp_path / 'bomb.zip'}")
