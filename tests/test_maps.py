"""Reading map_server maps: every formula by hand, and against a slow second implementation."""

from __future__ import annotations

import hashlib
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from fidmap.grid import cells_to_metres, trinarize
from fidmap.maps import read_map
from fidmap.maps.cells import Meaning, code_table, to_grid
from fidmap.maps.images import Raster
from fidmap.model import Grid, Label, Pose2
from map_files import write_map, write_pgm, write_yaml

F, U, X = Label.FREE, Label.UNKNOWN, Label.OCCUPIED


def labels_of(grid: Grid) -> list[int]:
    """The labels of a map of one row."""
    return [int(label) for label in trinarize(grid).labels[0]]


@pytest.mark.parametrize(
    ("changed", "greys", "expected"),
    [
        # 254: p = 1/255 = .004; 205: 50/255 = .19608 > .196; 89: 166/255 = .651; 90: 165/255 = .647
        ({}, [254, 206, 205, 128, 90, 89, 0], [F, F, U, U, U, X, X]),
        ({"free_thresh": "0.25"}, [205, 192, 191, 0], [F, F, U, X]),
        ({"negate": "1"}, [0, 49, 50, 165, 166, 255], [F, F, U, U, X, X]),
        ({"negate": "true"}, [0, 255], [F, X]),
        ({"mode": "Trinary"}, [255, 0], [F, X]),
        # free wins where both hold: p(128) = .498
        ({"free_thresh": "0.6", "occupied_thresh": "0.4"}, [255, 128, 0], [F, F, X]),
        # 100 (p - .1) / .8 rounds to 0 below p = .104, to 100 from p = .896
        (
            {"mode": "SCALE", "free_thresh": "0.1", "occupied_thresh": "0.9"},
            [255, 230, 229, 228, 128, 27, 26, 0],
            [F, F, F, U, U, U, X, X],
        ),
        (
            {"mode": "scale", "free_thresh": "0.0", "occupied_thresh": "1.0"},
            [255, 254, 253, 2, 1, 0],
            [F, F, U, U, X, X],
        ),
        # raw: the value is the percentage, over 100 is unknown, negate is ignored
        (
            {"mode": "Raw", "negate": "1"},
            [0, 19, 20, 64, 65, 100, 101, 205, 255],
            [F, F, U, U, X, X, U, U, U],
        ),
    ],
)
def test_labels_by_hand(tmp_path: Path, changed: dict[str, str], greys: list[int], expected: list[Label]) -> None:
    """Each mode, negate and threshold gives the labels computed by hand."""
    grid = read_map(write_map(tmp_path, [greys], **changed))

    assert expected == labels_of(grid)


def test_scale_keeps_occupancy_beside_labels(tmp_path: Path) -> None:
    """In scale mode p rides along while the labels carry what the loaded value decides."""
    path = write_map(tmp_path, [[254, 127]], mode="scale", free_thresh="0.0", occupied_thresh="1.0")
    grid = read_map(path)

    assert np.float32(1) - np.float32(254) / np.float32(255) == grid.occupancy[0, 0]
    assert grid.labels[0].tolist() == [F, U]


def test_thresholds_given_recompute_scale_labels(tmp_path: Path) -> None:
    """Thresholds of the user's own go into the scale formula before it decides."""
    path = write_map(tmp_path, [[254, 205, 100, 0]], mode="scale", free_thresh="0.0", occupied_thresh="1.0")
    grid = read_map(path, free_thresh=0.2, occupied_thresh=0.6)

    assert grid.labels[0].tolist() == [F, F, X, X]
    assert (grid.free_thresh, grid.occupied_thresh) == (0.2, 0.6)


def test_transparent_cells_are_unknown(tmp_path: Path) -> None:
    """Alpha below 255 makes a cell unknown in trinary and scale mode; raw mode ignores alpha."""
    pixels = [[[255, 255, 255, 255], [255, 255, 255, 254], [0, 0, 0, 0], [0, 0, 0, 255]]]

    assert labels_of(read_map(write_map(tmp_path, pixels))) == [F, U, U, X]
    assert labels_of(read_map(write_map(tmp_path, pixels, mode="scale"))) == [F, U, U, X]
    assert labels_of(read_map(write_map(tmp_path, pixels, mode="raw"))) == [U, U, F, F]
    assert np.isnan(read_map(write_map(tmp_path, pixels)).occupancy[0]).tolist() == [False, True, True, False]


def test_lowest_row_first_and_yaw_about_the_corner(tmp_path: Path) -> None:
    """The image's bottom row is row 0, and a yaw of 90 degrees turns the map about its lower-left corner."""
    path = write_map(tmp_path, [[0, 254], [254, 254], [254, 254]], resolution="0.5", origin=f"[1, 2, {math.pi / 2}]")
    grid = read_map(path)
    row, column = np.argwhere(trinarize(grid).labels == X)[0]
    centre = cells_to_metres(np.array([[row + 0.5, column + 0.5]]), grid.resolution_m, grid.origin)

    assert (row, column) == (2, 0)
    # i = 0, j = 2: x = 1 - 2.5 * 0.5, y = 2 + 0.5 * 0.5
    np.testing.assert_allclose([[-0.25, 2.25]], centre, atol=1e-12)


def test_source_carries_name_and_hash_of_both_files(tmp_path: Path) -> None:
    """The source is the path as given, and the hash covers the YAML's bytes and then the image's."""
    path = write_map(tmp_path, [[0, 205, 254]])
    grid = read_map(str(path))

    expected = hashlib.sha256(path.read_bytes() + (tmp_path / "map.png").read_bytes()).hexdigest()
    assert (str(path), expected, "map_server") == (grid.source.name, grid.source.sha256, grid.source.format)


def test_grid_is_read_only_float32(tmp_path: Path) -> None:
    """Occupancy is float32, one contiguous block that nobody can write to."""
    occupancy = read_map(write_map(tmp_path, [[0, 205], [254, 254]])).occupancy

    assert (np.float32, True, False) == (
        occupancy.dtype,
        occupancy.flags.c_contiguous,
        occupancy.flags.writeable,
    )


def test_options_override_the_yaml(tmp_path: Path) -> None:
    """The user's resolution, origin and thresholds replace the file's; its yaw is no longer worth a word."""
    path = write_map(tmp_path, [[0, 205, 254]], origin="[1, 2, 0.3]")
    grid = read_map(path, resolution_m=0.1, origin=Pose2(5, 6, 0.1), free_thresh=0.3, occupied_thresh=0.7)

    assert (0.1, Pose2(5, 6, 0.1), 0.3, 0.7) == (
        grid.resolution_m, grid.origin, grid.free_thresh, grid.occupied_thresh,
    )  # fmt: skip
    assert [finding.code for finding in grid.source.findings] == ["unknown-loads-as-free"]


def test_options_stand_for_missing_keys(tmp_path: Path) -> None:
    """A YAML without a resolution is readable when the user gives one."""
    path = write_map(tmp_path, [[0, 205, 254]], resolution=None)

    assert read_map(path, resolution_m=0.1).resolution_m == 0.1


def test_plain_image(tmp_path: Path) -> None:
    """A plain image has its lower-left corner at the world's origin and the thresholds 0.65 and 0.196."""
    path = write_pgm(tmp_path, [[0, 205, 254]])
    grid = read_map(path, resolution_m=0.05)

    assert labels_of(grid) == [X, U, F]
    assert (0.05, Pose2(), 0.196, 0.65) == (
        grid.resolution_m, grid.origin, grid.free_thresh, grid.occupied_thresh,
    )  # fmt: skip
    assert ("image", hashlib.sha256(path.read_bytes()).hexdigest()) == (
        grid.source.format,
        grid.source.sha256,
    )


def test_image_beside_its_yaml_is_the_same_map(tmp_path: Path) -> None:
    """An image is read through the YAML of its stem that names it, with the same hash as that YAML."""
    path = write_map(tmp_path, [[0, 205, 254]], resolution="0.25")
    grid = read_map(tmp_path / "map.png")

    assert (0.25, str(tmp_path / "map.png")) == (grid.resolution_m, grid.source.name)
    assert read_map(path).source.sha256 == grid.source.sha256
    assert [finding.code for finding in grid.source.findings] == ["image-uses-yaml"]
    assert read_map(tmp_path / "map.png", resolution_m=0.1).source.format == "image"


def test_image_finds_a_yaml_of_another_name(tmp_path: Path) -> None:
    """Without a YAML of its stem, an image uses the only other one that names it, never one that does not."""
    write_map(tmp_path, [[0, 205, 254]])
    (tmp_path / "map.yaml").rename(tmp_path / "other.yaml")
    write_yaml(tmp_path, image="foreign.png", resolution="0.9")
    (tmp_path / "broken.yaml").write_text("image: map.png\n  : [")

    assert read_map(tmp_path / "map.png").resolution_m == 0.05


def slow_load(grey: int, alpha: int, *, mode: str, negate: bool, free: float, occupied: float) -> int:
    """One cell as nav2_map_server loads it: -1, or 0 to 100; written apart from the code under test."""
    free32, occupied32 = np.float32(free), np.float32(occupied)
    if mode == "raw":
        return grey if grey <= 100 else -1
    if alpha < 255:
        return -1
    s = np.float32(grey) / np.float32(255)
    p = s if negate else np.float32(1) - s
    if p <= free32:
        return 0
    if p >= occupied32:
        return 100
    if mode == "trinary":
        return -1
    ratio = (p - free32) / np.float32(occupied - free) * np.float32(100)
    return math.floor(float(ratio) + 0.5)


THRESHOLDS = st.one_of(
    st.sampled_from([0.0, 0.196, 0.2, 0.25, 0.4, 0.6, 0.65, 0.8, 1.0]), st.floats(-0.2, 1.2, allow_nan=False)
)


@settings(max_examples=150, derandomize=True, deadline=None)
@given(
    mode=st.sampled_from(["trinary", "scale", "raw"]),
    negate=st.booleans(),
    free=THRESHOLDS,
    occupied=THRESHOLDS,
    alpha=st.one_of(st.none(), st.integers(0, 2**32 - 1)),
)
def test_agrees_with_a_slow_second_implementation(
    mode: str, negate: bool, free: float, occupied: float, alpha: int | None
) -> None:
    """All 256 greys, with random transparency, load as in the map server's formulas taken cell by cell."""
    grey = np.arange(256, dtype=np.uint8).reshape(16, 16)
    clear = None if alpha is None else np.random.default_rng(alpha).random((16, 16)) < 0.3
    meaning = Meaning(0.05, negate=negate, free_thresh=free, occupied_thresh=occupied, mode=mode)
    got = trinarize(to_grid(Raster(grey, clear), meaning, code_table(meaning), Grid(np.zeros((1, 1)), 1).source))

    for row in range(16):
        for column in range(16):
            opacity = 0 if clear is not None and clear[15 - row, column] else 255
            value = slow_load(
                int(grey[15 - row, column]), opacity, mode=mode, negate=negate, free=free, occupied=occupied
            )
            if mode == "raw" and value >= 0:
                p = np.float32(value) / np.float32(100)
                value = 0 if p <= np.float32(free) else 100 if p >= np.float32(occupied) else 50
            assert {0: F, 100: X}.get(value, U) == got.labels[row, column]


def test_image_modes_agree(tmp_path: Path) -> None:
    """The same grey picture saved in any mode and format gives the same map."""
    grey = np.array([[0, 205, 254], [254, 0, 205]], np.uint8)
    image = Image.fromarray(grey)
    expected = read_map(write_map(tmp_path, grey)).occupancy
    for name, other in [
        ("rgb.png", image.convert("RGB")), ("rgba.png", image.convert("RGBA")),
        ("la.png", image.convert("LA")),
        ("p.png", image.convert("P")), ("l.bmp", image), ("rgb.bmp", image.convert("RGB")), ("l.pgm", image),
        ("rgb.ppm", image.convert("RGB")),
        ("wide.png", Image.fromarray(grey.astype(np.uint16) * 257)),
    ]:  # fmt: skip
        other.save(tmp_path / name)
        np.testing.assert_array_equal(expected, read_map(tmp_path / name, resolution_m=1).occupancy, name)
