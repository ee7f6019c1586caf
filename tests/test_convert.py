"""`fidmap convert`: what was written reads back the same, by us and by others."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from command_line import fault, fidmap
from fidmap.grid import trinarize
from fidmap.maps import convert, read_map
from fidmap.model import Grid, Label, Pose2
from map_files import write_map


def nav2(path: Path) -> tuple[np.ndarray, float, list[float]]:
    """Cells as nav2's trinary mode loads them (-1, 0, 100; row 0 lowest), with Pillow, apart from our code."""
    keys = yaml.safe_load(path.read_text())
    pixels = np.asarray(Image.open(path.parent / keys["image"]).convert("L"))[::-1].astype(np.float32)
    p = np.float32(1) - pixels / np.float32(255)
    cells = np.full(p.shape, -1)
    cells[p >= np.float32(keys["occupied_thresh"])] = 100
    cells[p <= np.float32(keys["free_thresh"])] = 0
    assert (keys["negate"], keys.get("mode", "trinary")) == (0, "trinary")
    return cells, keys["resolution"], keys["origin"]


def as_cells(grid: Grid) -> np.ndarray:
    """The labels in nav2's numbers."""
    return np.array([0, -1, 100])[trinarize(grid).labels]


@settings(max_examples=40, derandomize=True, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), free=st.sampled_from([0.0, 0.1, 0.196, 0.25, 0.4]), unknown=st.booleans())
def test_map_server_reads_back(tmp_path_factory: pytest.TempPathFactory, seed: int, free: float, unknown: bool) -> None:
    """Labels, resolution and origin to the last digit, for us and for nav2; p to half a grey where labels allow it."""
    rng = np.random.default_rng(seed)
    p = rng.random((7, 9), np.float32)
    if unknown:
        p[rng.random(p.shape) < 0.3] = np.nan
    numbers = rng.normal(size=3)
    grid = Grid(p, float(rng.uniform(0.01, 0.2)), Pose2(*numbers), free, 0.65)
    path, image = convert.write(tmp_path_factory.mktemp("c") / "map.yaml", grid)
    again = read_map(path)
    cells, resolution_m, origin = nav2(path)

    assert image.suffix == ".pgm"
    assert (trinarize(again).labels == trinarize(grid).labels).all()
    assert (again.resolution_m, again.origin) == (grid.resolution_m, grid.origin)
    assert (cells == as_cells(grid)).all()
    assert (resolution_m, origin) == (grid.resolution_m, list(numbers))


def test_a_map_server_map_comes_back_as_it_was(tmp_path: Path) -> None:
    """Every grey, the thresholds, and the origin of a file: nothing moves by converting it."""
    grid = read_map(write_map(tmp_path, np.arange(256).reshape(16, 16), origin="[0.1, -7.123456789, 1e-3]"))
    (tmp_path / "new").mkdir()
    again = read_map(convert.write(tmp_path / "new" / "map.yaml", grid)[0])

    np.testing.assert_array_equal(again.occupancy, grid.occupancy)
    assert (again.free_thresh, again.occupied_thresh) == (grid.free_thresh, grid.occupied_thresh)
    assert (again.resolution_m, again.origin) == (grid.resolution_m, grid.origin)


def test_geotiff_reads_back(tmp_path: Path) -> None:
    """The three labels, resolution and origin; another reader sees the league's colours, +x up."""
    labels = np.random.default_rng(1).integers(0, 3, (40, 60))
    grid = Grid(np.array([0, np.nan, 1], np.float32)[labels], 0.04, Pose2(-2, 3, 0))
    path, world = convert.write(tmp_path / "map.tif", grid)
    again = read_map(path)
    pixels = np.asarray(Image.open(path).convert("RGB"))

    assert world.name == "map.tfw"
    assert (trinarize(again).labels == labels).all()
    assert again.resolution_m == pytest.approx(0.04)
    assert (again.origin.x_m, again.origin.y_m, again.origin.yaw) == pytest.approx((-2, 3, 0))
    walls = (pixels == (0, 40, 120)).all(axis=2)[1::3, 1::3]
    assert (walls == (labels == Label.OCCUPIED).T[::-1, ::-1]).all()
    assert ((pixels == 255).all(axis=2)[1::3, 1::3] == (labels == Label.FREE).T[::-1, ::-1]).all()


@pytest.mark.parametrize("values", [[[1]], [[0]], [[np.nan]], [[np.nan, 0]], [[0, np.nan, 1]] * 30, [[1] * 9] * 5])
def test_geotiffs_of_few_walls_read_back(tmp_path: Path, values: list[list[float]]) -> None:
    """Too little is drawn to tell colours, scale or enlargement: the file itself says that it is such a map."""
    grid = Grid(np.array(values, np.float32), 0.05, Pose2(1, -2, 0.3))
    again = read_map(convert.write(tmp_path / "map.tif", grid)[0])

    assert (trinarize(again).labels == trinarize(grid).labels).all()
    assert (again.resolution_m, again.source.format) == (pytest.approx(0.05), "robocup")
    assert (again.origin.x_m, again.origin.y_m, again.origin.yaw) == pytest.approx((1, -2, 0.3))


def test_a_geotiff_saved_in_greys_is_an_image(tmp_path: Path) -> None:
    """Another program may keep the description and not the colours."""
    path = convert.write(tmp_path / "map.tif", Grid(np.ones((4, 5), np.float32), 0.05))[0]
    with Image.open(path) as picture:
        tags = {tag: picture.tag_v2[tag] for tag in (270, 34264)}
    Image.fromarray(np.full((15, 12), 52685, np.uint16)).save(path, tiffinfo=tags)

    assert read_map(path).source.format == "geotiff"


def test_there_and_back_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the command line: YAML to GeoTIFF to YAML keeps every label and the place."""
    monkeypatch.chdir(tmp_path)
    pixels = np.random.default_rng(2).choice([0, 205, 254], (50, 70))
    grid = read_map(write_map(tmp_path, pixels, origin=f"[1, 2, {math.radians(30)}]"))
    first = fidmap("convert", "map.yaml", "there.tif")
    second = fidmap("convert", "there.tif", "back.yaml")
    again = read_map("back.yaml")

    assert (first.stdout, second.stdout) == ("there.tif\nthere.tfw\n", "back.yaml\nback.pgm\n")
    assert (trinarize(again).labels == trinarize(grid).labels).all()
    assert (again.origin.x_m, again.origin.y_m, again.origin.yaw) == pytest.approx((1, 2, math.radians(30)))


def test_refusals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Existing files stay, and an unknown suffix is told with those that are known."""
    monkeypatch.chdir(tmp_path)
    write_map(tmp_path, [[0, 254]])

    again = fidmap("convert", "map.yaml", "map.yaml")
    assert (again.exit_code, again.stdout) == (1, "")
    assert again.stderr.endswith("map.yaml: is there already; choose another name, or move it away\n")
    assert fault("convert", "map.yaml", "map.dxf") == (
        "map.dxf: no format of that name is written; end it in .yaml (map_server) or .tif (RoboCup GeoTIFF)"
    )
    assert "does not exist" in fault("convert", "none.yaml", "new.tif")
    assert "cannot be written" in fidmap("convert", "map.yaml", "map.png/new.yaml").stderr
