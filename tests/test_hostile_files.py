"""Files made to exhaust their reader or to lead it astray: one sentence, little memory, little time."""

from __future__ import annotations

import io
import struct
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from command_line import fault, fidmap
from fidmap.grid import trinarize
from fidmap.maps import read_map
from fidmap.model import Label
from map_files import sentence, write_map, write_pgm, write_yaml

MEGABYTE = 1 << 20


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_jpeg_header_is_no_map(tmp_path: Path) -> None:
    """335 bytes that announce 400 million pixels: libjpeg would fill them all with grey, in 11 s and 2 GB."""
    file = io.BytesIO()
    Image.new("L", (16, 16)).save(file, "JPEG")
    data = bytearray(file.getvalue())
    at = data.index(b"\xff\xc0")
    data[at + 5 : at + 9] = struct.pack(">HH", 20_000, 20_000)
    (tmp_path / "bomb.jpg").write_bytes(data)

    tracemalloc.start()
    text = sentence("bomb.jpg", resolution_m=0.05)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert text == ("bomb.jpg is a broken or truncated JPEG image; expected a whole one, so copy or save the map again")
    assert peak < MEGABYTE


def test_a_tiff_of_which_most_is_missing(tmp_path: Path) -> None:
    """One strip of 20 rows in an image of millions: 1 GB of black that nobody drew (found by fuzzing)."""
    file = io.BytesIO()
    Image.new("L", (30, 20), 254).save(file, "TIFF")
    data = bytearray(file.getvalue())
    entry = data.index(struct.pack("<HHI", 257, 4, 1))
    data[entry : entry + 12] = struct.pack("<HHII", 257, 4, 1, 5_963_796)
    (tmp_path / "m.tif").write_bytes(data)
    tracemalloc.start()
    assert "m.tif is a broken or truncated TIFF image" in sentence("m.tif", resolution_m=0.05)
    assert tracemalloc.get_traced_memory()[1] < MEGABYTE
    tracemalloc.stop()


def test_pillow_says_nothing_of_its_own(tmp_path: Path) -> None:
    """A TIFF with a thousand samples per pixel: Pillow logs an error, which Python prints where nobody handles it."""
    file = io.BytesIO()
    Image.new("RGB", (30, 20)).save(file, "TIFF")
    data = bytearray(file.getvalue())
    entry = data.index(struct.pack("<HHIH", 277, 3, 1, 3))
    data[entry : entry + 12] = struct.pack("<HHII", 277, 3, 1, 1000)
    (tmp_path / "m.tif").write_bytes(data)
    command = [sys.executable, "-m", "fidmap", "detect", "m.tif", "--radius", "0.3", "--resolution", "0.05"]
    told = subprocess.run(command, capture_output=True, text=True, check=False)
    assert told.returncode == 1
    assert told.stderr.count("\n") == 1
    assert told.stderr.startswith("fidmap: m.tif")


@pytest.mark.parametrize(("mode", "compression"), [("L", "tiff_lzw"), ("1", "group4")])
def test_libtiff_says_nothing_of_its_own(tmp_path: Path, mode: str, compression: str) -> None:
    """It writes past Python to stderr, and what comes behind a broken word of a fax code used to be made up."""
    grey = np.random.default_rng(0).choice(np.array([0, 254], np.uint8), (40, 60))
    path = tmp_path / "m.tif"
    Image.fromarray(grey).convert(mode).save(path, compression=compression)
    assert read_map(path, resolution_m=0.05).occupancy.shape == (40, 60)
    data = bytearray(path.read_bytes())
    data[100:120] = b"\x5a" * 20
    path.write_bytes(data)
    command = [sys.executable, "-m", "fidmap", "detect", "m.tif", "--radius", "0.3", "--resolution", "0.05"]
    told = subprocess.run(command, capture_output=True, text=True, check=False)
    assert told.returncode == 1
    assert told.stderr.count("\n") == 1
    assert told.stderr.startswith("fidmap: m.tif is a broken or truncated TIFF image")


def test_an_absurd_threshold_is_infinite(tmp_path: Path) -> None:
    """Greater than any float32: nothing is occupied, and numpy does not warn (found by fuzzing)."""
    path = write_map(tmp_path, [[0, 254, 254]], occupied_thresh="1e300")
    labels = trinarize(read_map(path)).labels
    assert labels.tolist() == [[Label.UNKNOWN, Label.FREE, Label.FREE]]


def test_links_that_lead_in_a_circle(tmp_path: Path) -> None:
    """Also where only names are compared: `--resolution` used to end in a traceback."""
    (tmp_path / "a.png").symlink_to("b.png")
    (tmp_path / "b.png").symlink_to("a.png")
    assert "cannot be read (Too many levels of symbolic links)" in sentence("a.png")
    assert "cannot be read" in fault("detect", "a.png", "--radius", 0.3, "--resolution", 0.05)
    assert fidmap("detect", "a.png", "b.png", "--radius", 0.3, "--resolution", 0.05).exit_code == 1
    write_yaml(tmp_path, image="a.png")
    assert "a.png" in sentence("map.yaml")


def test_a_yaml_cannot_make_a_secret_visible(tmp_path: Path) -> None:
    """`image:` may name any path, but only what decodes as an image is used, and nothing of it is quoted."""
    secret = tmp_path / "secret"
    secret.write_text("password: hunter2\n")
    (tmp_path / "maps").mkdir()
    path = write_yaml(tmp_path / "maps", image="../secret")
    text = sentence(path)
    assert "hunter2" not in text
    assert "is not a" in text


@pytest.mark.parametrize("number", [".nan", "-.inf", "1e400", "0", "-0.05"])
def test_headers_that_are_no_numbers(tmp_path: Path, number: str) -> None:
    """No resolution, origin or threshold that no map can have reaches the grid."""
    write_pgm(tmp_path, [[0, 205, 254]])
    assert "resolution" in sentence(write_yaml(tmp_path, image="map.pgm", resolution=number))
    if number not in {"0", "-0.05"}:
        assert "origin" in sentence(write_yaml(tmp_path, image="map.pgm", origin=f"[0, 0, {number}]"))


@pytest.mark.parametrize("size", [(20_000, -20_000), (-20_000, 20_000), (2**31 - 1, 1), (0, 5)])
def test_bitmaps_with_negative_sizes(tmp_path: Path, size: tuple[int, int]) -> None:
    """A BMP may count its rows from the top; no size takes memory that its bytes do not fill."""
    file = io.BytesIO()
    Image.new("L", (16, 16)).save(file, "BMP")
    data = bytearray(file.getvalue())
    data[18:26] = struct.pack("<ii", *size)
    (tmp_path / "m.bmp").write_bytes(data)
    tracemalloc.start()
    assert sentence("m.bmp", resolution_m=0.05)
    assert tracemalloc.get_traced_memory()[1] < MEGABYTE
    tracemalloc.stop()
