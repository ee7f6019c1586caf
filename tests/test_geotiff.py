"""TIFF files in greys: every compression, real GeoTIFF tags, world files; written by tifffile and Pillow."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

from fidmap.grid import trinarize
from fidmap.maps import read_map
from fidmap.maps.robocup.write import write_geotiff
from fidmap.model import Grid, Pose2
from map_files import sentence

GREYS = np.array([[0, 254, 205], [254, 254, 0]], np.uint8)
SCALE, TIEPOINT, MATRIX, KEYS = 33550, 33922, 34264, 34735


def write(path: Path, *tags: tuple[int, str, tuple[float, ...]]) -> Path:
    """A TIFF by tifffile with these tags: (code, type, values)."""
    tifffile.imwrite(path, GREYS, photometric="minisblack", extratags=[(c, t, len(v), v, True) for c, t, v in tags])
    return path


def raster_type(value: int, model: int = 1) -> tuple[int, str, tuple[float, ...]]:
    """The directory of geo keys with a raster type: 1 area, 2 point."""
    return KEYS, "H", (1, 1, 0, 2, 1024, 0, 1, model, 1025, 0, 1, value)


def pose(path: Path) -> tuple[float, float, float, float]:
    """Resolution and origin as read."""
    grid = read_map(path)
    return grid.resolution_m, grid.origin.x_m, grid.origin.y_m, grid.origin.yaw


@pytest.mark.parametrize(
    "options",
    [{}, {"compression": "tiff_lzw"}, {"compression": "tiff_adobe_deflate"}, {"compression": "packbits"}],
)
@pytest.mark.parametrize("mode", ["L", "RGB", "P", "RGBA", "1", "I;16"])
def test_every_compression_and_kind_of_sample(tmp_path: Path, options: dict[str, str], mode: str) -> None:
    """The same greys, however they are stored."""
    greys = np.where(GREYS < 128, 0, 255).astype(np.uint8) if mode == "1" else GREYS
    image = Image.fromarray(greys.astype(np.uint16) * 257) if mode == "I;16" else Image.fromarray(greys).convert(mode)
    image.save(tmp_path / "map.tif", **options)
    grid = read_map(tmp_path / "map.tif", resolution_m=0.05)

    np.testing.assert_array_equal(grid.occupancy[::-1], np.float32(1) - greys.astype(np.float32) / np.float32(255))


def test_fax_and_jpeg_compression(tmp_path: Path) -> None:
    """Group 4 of a bitmap is exact, JPEG nearly."""
    Image.fromarray(np.where(GREYS < 128, 0, 255).astype(np.uint8)).convert("1").save(
        tmp_path / "fax.tif", compression="group4"
    )
    Image.fromarray(np.repeat(np.repeat(GREYS, 16, 0), 16, 1)).save(tmp_path / "jpeg.tif", compression="jpeg")

    assert read_map(tmp_path / "fax.tif", resolution_m=1).occupancy.tolist() == [[0, 0, 1], [1, 0, 0]]
    blurred = trinarize(read_map(tmp_path / "jpeg.tif", resolution_m=1)).labels[8::16, 8::16]
    assert blurred.tolist() == [[0, 0, 2], [2, 0, 1]]


def test_pixel_scale_and_tiepoint(tmp_path: Path) -> None:
    """A pixel's area: the tie point is a corner. A point: its centre. Any pixel may be tied."""
    scale = (SCALE, "d", (0.05, 0.05, 0.0))
    area = write(tmp_path / "area.tif", scale, (TIEPOINT, "d", (0, 0, 0, 10, 20, 0)), raster_type(1))
    point = write(tmp_path / "point.tif", scale, (TIEPOINT, "d", (0, 0, 0, 10, 20, 0)), raster_type(2))
    other = write(tmp_path / "other.tif", scale, (TIEPOINT, "d", (3, 2, 0, 10.15, 19.9, 0)))

    assert pose(area) == pytest.approx((0.05, 10, 19.9, 0))
    assert pose(point) == pytest.approx((0.05, 9.975, 19.925, 0))
    assert pose(other) == pytest.approx((0.05, 10, 19.9, 0))
    assert read_map(area).source.format == "geotiff"


def test_transformation(tmp_path: Path) -> None:
    """A turned picture: yaw is the direction of its rows, the origin its lower left corner."""
    c, s = 0.1 * math.cos(0.4), 0.1 * math.sin(0.4)
    matrix = (c, s, 0, 5, s, -c, 0, 7, 0, 0, 0, 0, 0, 0, 0, 1)

    assert pose(write(tmp_path / "m.tif", (MATRIX, "d", matrix))) == pytest.approx((0.1, 5 + 2 * s, 7 - 2 * c, 0.4))


def test_options_win(tmp_path: Path) -> None:
    """--origin replaces the place, --resolution everything that a tag says."""
    path = write(tmp_path / "m.tif", (SCALE, "d", (0.05, 0.05, 0.0)), (TIEPOINT, "d", (0, 0, 0, 10, 20, 0)))

    assert read_map(path, origin=Pose2(1, 2, 3)).origin == Pose2(1, 2, 3)
    assert read_map(path, resolution_m=0.1).resolution_m == 0.1
    assert read_map(path, resolution_m=0.1).origin == Pose2()


@pytest.mark.parametrize("name", ["map.tfw", "map.tifw", "map.wld", "map.TFW"])
def test_world_file_of_a_grey_tiff(tmp_path: Path, name: str) -> None:
    """Its last lines are the centre of the upper left pixel."""
    Image.fromarray(GREYS).save(tmp_path / "map.tif")
    (tmp_path / name).write_text("0.05\n0\n0\n-0.05\n10.025\n19.975\n")

    assert pose(tmp_path / "map.tif") == pytest.approx((0.05, 10, 19.9, 0))


def test_world_file_of_a_png(tmp_path: Path) -> None:
    """PNG and JPEG have world files too."""
    Image.fromarray(GREYS).save(tmp_path / "map.png")
    (tmp_path / "map.pgw").write_text("0.05 0 0 -0.05 10.025 19.975")

    assert pose(tmp_path / "map.png") == pytest.approx((0.05, 10, 19.9, 0))


@pytest.mark.parametrize(
    ("text", "end"),
    [
        ("0.05\n0\n0\n", "is broken; expected six numbers, so correct it or give --resolution M_PER_CELL"),
        ("0.05 0 0 -0.05 east north", "is broken; expected six numbers, so correct it or give --resolution M_PER_CELL"),
        (
            "0.05 0 0 -0.1 0 0",
            "is georeferenced by 0.05, 0, 0, 0, -0.1, 0; expected square pixels of 1e-05 to 1000 m that are not "
            "mirrored, so give its scale with --resolution M_PER_CELL",
        ),
        (
            "nan 0 0 nan 0 0",
            "is georeferenced by nan, 0, 0, 0, nan, 0; expected square pixels of 1e-05 to 1000 m that are not "
            "mirrored, so give its scale with --resolution M_PER_CELL",
        ),
    ],
)
def test_broken_world_file(tmp_path: Path, text: str, end: str) -> None:
    """Told with the file's name and what to do; --resolution reads the image alone."""
    Image.fromarray(GREYS).save(tmp_path / "map.tif")
    (tmp_path / "map.tfw").write_text(text)

    assert sentence(tmp_path / "map.tif") == f"{tmp_path / 'map.tif'}: its world file map.tfw {end}"
    assert read_map(tmp_path / "map.tif", resolution_m=0.05).resolution_m == 0.05


def test_degrees(tmp_path: Path) -> None:
    """A geographic GeoTIFF has no metres."""
    tags = (SCALE, "d", (1e-4, 1e-4, 0.0)), (TIEPOINT, "d", (0, 0, 0, 10, 20, 0)), raster_type(1, model=2)

    assert "is a GeoTIFF in degrees, expected metres" in sentence(write(tmp_path / "m.tif", *tags))


def test_floats_are_no_map(tmp_path: Path) -> None:
    """Samples that are no greys end in a sentence."""
    tifffile.imwrite(tmp_path / "m.tif", GREYS.astype(np.float32))

    assert sentence(tmp_path / "m.tif", resolution_m=1).endswith(
        "holds samples of kind F; save the map with 8 or 16 bits per pixel"
    )


def test_tifffile_reads_what_was_written(tmp_path: Path) -> None:
    """Tags as another library sees them: the far corner of the grid, at a third of a cell per pixel."""
    write_geotiff(tmp_path / "m.tif", Grid(np.zeros((4, 6), np.float32), 0.06, Pose2(1, 2, 0)))
    with tifffile.TiffFile(tmp_path / "m.tif") as file:
        page = file.pages.first
        matrix = page.tags[MATRIX].value

    assert (page.imagelength, page.imagewidth) == (18, 12)
    assert matrix[:8] == pytest.approx((0, -0.02, 0, 1.36, -0.02, 0, 0, 2.24))
