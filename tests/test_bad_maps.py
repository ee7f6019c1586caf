"""Map files that cannot be used: each ends in one exact sentence, before memory is taken."""

from __future__ import annotations

import os
import struct
import tracemalloc
import zlib
from pathlib import Path

import pytest

from fidmap.maps import read_map
from fidmap.model import Pose2
from map_files import sentence, write_map, write_pgm, write_yaml

READABLE = (
    "a map_server YAML, an image (PGM, PNG, BMP, JPEG, TIFF), a bag or MCAP file, a 3D map (PLY, PCD, LAS, LAZ, "
    "OctoMap), a drawing (SVG, DXF, GeoJSON) or an RTAB-Map database"
)
IMAGE = "a PGM, PNG, BMP, JPEG or TIFF image"
TOO_LARGE = "announces 100000 x 100000 cells; at most 400 million are read, so crop it or save it with larger cells"
KEYS = "image, resolution, origin, negate, occupied_thresh, free_thresh"


@pytest.fixture(autouse=True)
def _in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files are named as a user in their folder names them."""
    monkeypatch.chdir(tmp_path)


def png_header(width: int, height: int) -> bytes:
    """A PNG that announces dimensions and holds nothing."""
    data = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    idat = b"IDAT" + zlib.compress(b"")
    chunks = [struct.pack(">I", len(c) - 4) + c + struct.pack(">I", zlib.crc32(c)) for c in (data, idat, b"IEND")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


@pytest.mark.parametrize(
    ("name", "content", "text"),
    [
        ("m.yaml", b"", f"m.yaml is empty (0 bytes); expected {READABLE}, so save the map again"),
        (
            "m.tif",
            b"II*\0\x08\0\0\0\xff\xfe",
            "m.tif is a broken or truncated TIFF image; expected a whole one, so copy or save the map again",
        ),
        ("m.txt", b"hello", f"m.txt is no map of a known format; expected {READABLE}"),
        (
            "m.json",
            b'{"a": 1}',
            f"m.json is YAML but no map: it has none of the keys {KEYS}; expected {READABLE}",
        ),
        (
            "a.yaml",
            b"fidmap_arena: 1\n",
            "a.yaml is an arena file, not a map; give it with --arena and name a map here",
        ),
        (
            "p.yaml",
            b"fidmap_profile: 1\n",
            "p.yaml is a profile file, not a map; give it with --profile and name a map here",
        ),
        (
            "m.yaml",
            b"image: a.pgm\nfree_thresh: 0.1 # cut\nn package\nnegate: 0\n",
            "m.yaml is not valid YAML in line 4 (could not find expected ':'); correct that line",
        ),
        (
            "m.dat",
            b"\xff" * 70_000,
            f"m.dat is not a map of a known format, nor a YAML of at most 65,536 bytes; expected {READABLE}",
        ),
        (
            "m.bag",
            b"#ROSBAG V2.0\n" + b"\xff" * 70_000,
            "m.bag is a ROS 1 bag that cannot be used: the record at byte 13 announces a header of 4294967295 bytes; "
            "copy or save it again",
        ),
        (
            "m.yaml",
            b"[" * 30_000,
            "m.yaml holds over 20 levels of YAML; a map file needs none, so write its values out plainly",
        ),
        (
            "m.yaml",
            b"a: &a [1]\nimage: [" + b"*a, " * 40 + b"1]\n",
            "m.yaml holds more than 16 aliases of YAML; a map file needs none, so write its values out plainly",
        ),
        (
            "m.yaml",
            b"!!python/object/apply:os.system [true]",
            "m.yaml is not valid YAML in line 1 (could not determine a constructor for the tag "
            "'tag:yaml.org,2002:python/object/apply:os.system'); correct that line",
        ),
    ],
)
def test_not_a_map(tmp_path: Path, name: str, content: bytes, text: str) -> None:
    """What is no map is called what it is."""
    (tmp_path / name).write_bytes(content)

    assert sentence(name) == text


@pytest.mark.parametrize("named", ["map.png", "../elsewhere/map.png", "/nowhere/on/earth/map.png"])
def test_missing_image(tmp_path: Path, named: str) -> None:
    """A YAML whose image does not exist says where it was looked for."""
    write_yaml(tmp_path, image=named)

    assert sentence("map.yaml") == (
        f"map.yaml names the image {named}, which does not exist; expected it at that path (seen from the "
        "YAML's folder), so put it there or correct `image:`"
    )


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"", f"is empty (0 bytes); expected {IMAGE}, so save the map again"),
        (b"GIF89a", "is not a PGM, PNG, BMP, JPEG or TIFF image; save the map in one of these formats"),
        (
            b"version https://git-lfs.github.com/spec/v1\n",
            "is a Git LFS pointer, not the image itself; fetch it with `git lfs pull`",
        ),
        (
            b"P5\n30 20\n255\nabc",
            "is truncated: 30 x 20 cells need 600 values or bytes, 3 are there; copy or save the map again",
        ),
        (
            b"P2 2 2 255 1 2 3",
            "is truncated: 2 x 2 cells need 4 values or bytes, 3 are there; copy or save the map again",
        ),
        (
            b"P2 2 2 255 1 2 3 x",
            "is a P2 file with text among its numbers; expected numbers, so save it again",
        ),
        (b"P5\n30 high", "has a broken P5 header; expected width, height and maximum as numbers"),
        (b"P5 2 2 70000\n", "announces a maximum grey of 70000; expected 1 to 65535, so save it again"),
        (b"P5 0 2 255\n", "has 0 x 2 cells; expected at least 1 x 1, so save the map again"),
        (
            b"P5 100000 100000 255\n",
            TOO_LARGE,
        ),
        (
            png_header(100_000, 100_000),
            TOO_LARGE,
        ),
        (
            png_header(40, 30)[:60],
            "is a broken or truncated PNG image; expected a whole one, so copy or save the map again",
        ),
    ],
)
def test_bad_image(tmp_path: Path, content: bytes, text: str) -> None:
    """A bad image is told the same way beside its YAML and alone, before memory is taken."""
    (tmp_path / "map.png").write_bytes(content)
    write_yaml(tmp_path)
    tracemalloc.start()
    beside = sentence("map.yaml")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()

    assert beside == f"map.yaml: its image map.png {text}"
    assert peak < 5_000_000
    if content[:2] in {b"P5", b"P2", b"\x89P"}:
        assert sentence("map.png", resolution_m=0.05) == f"map.png {text}"


@pytest.mark.slow
def test_large_map_is_no_bomb(tmp_path: Path) -> None:
    """More cells than Pillow's own warning allows are read without a warning, up to the bound here."""
    rows = zlib.compress(bytes((10_000 + 1) * 10_000), 1)
    head = png_header(10_000, 10_000)
    idat = b"IDAT" + rows
    chunk = struct.pack(">I", len(rows)) + idat + struct.pack(">I", zlib.crc32(idat))
    (tmp_path / "m.png").write_bytes(head[:33] + chunk + head[-12:])

    assert read_map("m.png", resolution_m=0.05).occupancy.shape == (10_000, 10_000)


def test_no_regular_file(tmp_path: Path) -> None:
    """A missing file, a directory and a pipe are told apart; a pipe is not waited for."""
    os.mkfifo("pipe")
    (tmp_path / "folder").mkdir()
    write_yaml(tmp_path, image="folder")

    assert sentence("none.yaml") == f"none.yaml does not exist; expected {READABLE}, so check the path"
    assert sentence("map.yaml/x") == f"map.yaml/x does not exist; expected {READABLE}, so check the path"
    assert sentence("folder") == f"folder is a directory; expected {READABLE}, so name the file inside it"
    (tmp_path / "folder" / "a.yaml").touch()
    assert sentence("folder") == f"folder is a directory; expected {READABLE}, so name a file inside it, such as a.yaml"
    (tmp_path / "folder" / "a.yaml").unlink()
    (tmp_path / "link").symlink_to("nowhere")
    assert sentence("link") == "link is a link to a file that does not exist; put that back or name the file"
    assert sentence("pipe") == f"pipe is a device or a pipe; expected {READABLE}, so save it to a file first"
    assert sentence("map.yaml") == (
        f"map.yaml: its image folder is a directory; expected {IMAGE}, so name the file inside it"
    )


def test_permission_denied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that may not be read is told with its remedy (forced here: root may read everything)."""
    write_yaml(tmp_path)

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    assert sentence("map.yaml") == "map.yaml cannot be read: permission denied; make it readable (chmod +r)"


def test_names_with_line_breaks_and_nul(tmp_path: Path) -> None:
    """Line breaks, terminal codes and NUL in names neither break the line nor the program."""
    write_yaml(tmp_path, image='"a\\nb\\0.png"')

    assert sentence("no\n\x1b[31mfile").startswith("no??[31mfile does not exist")
    assert sentence("map.yaml").startswith("map.yaml names the image a?b?.png, which does not exist")
    assert sentence("a\0b") == "a?b cannot be read (embedded null byte); check the path"


def test_plain_image_needs_a_resolution(tmp_path: Path) -> None:
    """A plain image without a scale names the option that gives it."""
    write_pgm(tmp_path, [[0, 254]], "m.pgm")

    assert sentence("m.pgm") == (
        "m.pgm is an image without a YAML beside it that names it; give its scale with --resolution M_PER_CELL"
    )


def test_image_of_several_yamls(tmp_path: Path) -> None:
    """An image that two YAML files name is not guessed about."""
    write_map(tmp_path, [[0, 205, 254]])
    (tmp_path / "map.yaml").rename(tmp_path / "a.yaml")
    write_yaml(tmp_path, "b.yaml")

    assert sentence("map.png") == (
        "map.png is named by a.yaml and b.yaml; expected one: give the YAML that is meant, or --resolution"
    )


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (
            {"resolution_m": float("nan")},
            "--resolution nan; expected the side of a cell in metres, 1e-05 to 1000, such as --resolution 0.05",
        ),
        (
            {"resolution_m": -0.05},
            "--resolution -0.05; expected the side of a cell in metres, 1e-05 to 1000, such as --resolution 0.05",
        ),
        (
            {"origin": Pose2(0, float("inf"), 0)},
            "an --origin that is not finite; give --origin X_M,Y_M,YAW_DEG",
        ),
        ({"free_thresh": float("nan")}, "--free-thresh nan; expected a number from 0 to 1"),
    ],
)
def test_impossible_options(tmp_path: Path, options: dict[str, object], text: str) -> None:
    """Values that no map can have are refused with their option's name."""
    write_map(tmp_path, [[0, 205, 254]])

    assert sentence("map.yaml", **options) == f"map.yaml cannot be read with {text}"
