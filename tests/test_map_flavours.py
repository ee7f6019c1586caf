"""ROS 1, older nav2 and nav2 of today read the same file differently; and where a map's origin lies."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from fidmap.grid import cells_to_metres, trinarize
from fidmap.maps import read_map
from fidmap.maps.cells import FLAVOURS, Flavour, Meaning, code_table
from fidmap.model import Label, Pose2
from map_files import sentence, write_map, write_yaml

F, U, X = Label.FREE, Label.UNKNOWN, Label.OCCUPIED


def ros1(channels: list[int], mode: str, negate: bool, free: float, occupied: float) -> int:
    """One pixel by the rules of ROS 1, with alpha last where there is one; written apart from the code under test."""
    average = sum(channels) / len(channels)
    if negate:
        average = 255 - average
    if mode == "raw":
        return int(average) if average < 101 else -1
    p = (255 - average) / 255.0
    if p > occupied:
        return 100
    if p < free:
        return 0
    return -1 if mode == "trinary" else int(1 + 98 * (p - free) / (occupied - free))


def old_nav2(channels: list[int], mode: str, negate: bool, free: float, occupied: float) -> int:
    """One pixel by the rules of older nav2."""
    shade = sum(channels) / len(channels) / 255.0
    if mode == "raw":
        return round(shade * 255) if round(shade * 255) <= 100 else -1
    p = shade if negate else 1.0 - shade
    if occupied < p:
        return 100
    if p < free:
        return 0
    return -1 if mode == "trinary" else round((p - free) / (occupied - free) * 100.0)


@pytest.mark.parametrize("negate", [False, True])
@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
@pytest.mark.parametrize(("flavour", "rule"), [("ros1", ros1), ("nav2-old", old_nav2)])
def test_agrees_with_a_second_implementation(
    tmp_path: Path, flavour: Flavour, rule: object, mode: str, negate: bool
) -> None:
    """Grey and coloured pictures, at thresholds that greys hit exactly and at others."""
    rng = np.random.default_rng(5)
    grey, colour = np.arange(256).reshape(8, 32), rng.integers(0, 256, (8, 32, 3))
    for pixels in (grey, colour):
        for free, occupied in ((0.196, 0.65), (0.2, 0.8), (0.4, 0.6), (0.0, 1.0)):
            path = write_map(
                tmp_path, pixels, mode=mode, negate=str(int(negate)),
                free_thresh=str(free), occupied_thresh=str(occupied),
            )  # fmt: skip
            labels = trinarize(read_map(path, flavour=flavour)).labels[::-1]
            for at in np.ndindex(8, 32):
                channels = np.atleast_1d(pixels[at]).tolist()
                value = rule(channels, mode, negate, free, occupied)  # type: ignore[operator]
                if mode == "raw" and value >= 0:
                    value = 100 if value / 100 > occupied else 0 if value / 100 < free else 50
                assert labels[at] == {0: F, 100: X}.get(value, U), (at, channels)


@pytest.mark.parametrize(
    ("flavour", "expected"), [("nav2-old", {0.0, 0.4, 0.6, 0.8, 1.0}), ("ros1", {0.0, 0.2, 0.4, 0.6, 0.8, 1.0})]
)
def test_thresholds_at_which_greys_differ(flavour: Flavour, expected: set[float]) -> None:
    """Of all multiples of 0.001 only these set a flavour apart from nav2 on grey maps: those that a grey hits.

    0.2 only in ROS 1, whose (255 - 204) / 255 is exactly 0.2 where 1 - 204 / 255 is a little less.
    """
    apart = set()
    for k in range(1001):
        for free, occupied in ((k / 1000, 2.0), (-1.0, k / 1000)):
            old, new = (
                code_table(Meaning(0.05, free_thresh=free, occupied_thresh=occupied, flavour=word))
                for word in (flavour, FLAVOURS[0])
            )
            if (old.labels != new.labels).any():
                apart.add(k / 1000)

    assert apart == expected


def test_alpha_is_averaged_in_trinary_and_hides_in_scale(tmp_path: Path) -> None:
    """White, clear: (3 x 255 + 0) / 4 = 191.25, p = 0.25; ROS 1 and older nav2 average it, nav2 of today hides it."""
    pixels = np.array([[[255, 255, 255, 0], [255, 255, 255, 255], [0, 0, 0, 0]]], np.uint8)
    path = write_map(tmp_path, pixels, free_thresh="0.3")
    labels = {flavour: trinarize(read_map(path, flavour=flavour)).labels[0].tolist() for flavour in FLAVOURS}

    assert labels == {"nav2": [U, F, U], "nav2-old": [F, F, X], "ros1": [F, F, X]}

    path = write_map(tmp_path, pixels, mode="scale", free_thresh="0.3")
    labels = {flavour: trinarize(read_map(path, flavour=flavour)).labels[0].tolist() for flavour in FLAVOURS}
    assert labels == {"nav2": [U, F, U], "nav2-old": [U, F, U], "ros1": [F, F, X]}


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_palette_one_bit_and_sixteen_bit(tmp_path: Path, flavour: Flavour) -> None:
    """However a picture of pure greys is stored, each flavour reads the same map."""
    grey = np.array([[0, 255, 255], [255, 0, 0]], np.uint8)
    image = Image.fromarray(grey)
    expected = trinarize(read_map(write_map(tmp_path, grey), flavour=flavour)).labels
    for mode in ("1", "P", "RGB", "LA", "RGBA"):
        image.convert(mode).save(tmp_path / "map.png")
        # an opaque alpha channel of 255 is averaged in by the older flavours: black becomes 63.75
        if flavour == "nav2" or mode not in {"LA", "RGBA"}:
            assert (trinarize(read_map(tmp_path / "map.yaml", flavour=flavour)).labels == expected).all(), mode
    Image.fromarray(grey.astype(np.uint16) * 257).save(tmp_path / "map.png")
    assert (trinarize(read_map(tmp_path / "map.yaml", flavour=flavour)).labels == expected).all()


def test_mode_in_any_case(tmp_path: Path) -> None:
    """`Scale`, `SCALE` and `scale` are one mode."""
    labels = [trinarize(read_map(write_map(tmp_path, [[0, 150, 254]], mode=m))).labels for m in ("Scale", "SCALE")]
    lower = trinarize(read_map(write_map(tmp_path, [[0, 150, 254]], mode="scale"))).labels

    assert all((other == lower).all() for other in labels)


def test_origin_at_the_centre_of_a_turned_cell(tmp_path: Path) -> None:
    """AMCL's reading: the origin is the centre of cell (0, 0), whatever the yaw; also for --origin and plain images."""
    path = write_map(tmp_path, [[0, 254]], origin="[2, 3, 0.5]")
    for grid in (
        read_map(path, origin_at="centre"),
        read_map(path, origin=Pose2(2, 3, 0.5), origin_at="centre"),
        read_map(tmp_path / "map.png", resolution_m=0.1, origin=Pose2(2, 3, 0.5), origin_at="centre"),
    ):
        centre = cells_to_metres(np.array([[0.5, 0.5]]), grid.resolution_m, grid.origin)
        np.testing.assert_allclose(centre, [[2, 3]], atol=1e-12)
        assert grid.origin.yaw == 0.5
    assert read_map(path, origin_at="corner").origin == read_map(path).origin == Pose2(2, 3, 0.5)
    assert math.dist((2, 3), (read_map(path, origin_at="centre").origin.x_m, 3)) > 0


def test_unknown_words(tmp_path: Path) -> None:
    """A flavour that does not exist is told with those that do."""
    path = write_yaml(tmp_path)

    assert sentence(path, flavour="ros3").endswith("--flavour ros3; expected nav2 or nav2-old or ros1")
    assert sentence(path, origin_at="middle").endswith("--origin-at middle; expected corner or centre")
