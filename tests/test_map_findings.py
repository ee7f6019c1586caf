"""What a reader finds odd about a map, and what it stays silent about."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fidmap.maps import read_map
from fidmap.model import Finding, Grid
from map_files import write_map


def codes(grid: Grid) -> list[str]:
    """The codes of a map's findings."""
    return [finding.code for finding in grid.source.findings]


def rooms(free: int = 254, unknown: int = 205, wall: int = 0) -> np.ndarray:
    """An ordinary map: a walled room with a thin inner wall in unknown surroundings."""
    pixels = np.full((60, 80), unknown)
    pixels[10:50, 10:70] = wall
    pixels[11:49, 11:69] = free
    pixels[30, 11:40] = wall
    return pixels


def test_ordinary_map_is_silent(tmp_path: Path) -> None:
    """A map as the ROS savers write it has no findings."""
    assert codes(read_map(write_map(tmp_path, rooms()))) == []


def test_probability_map_is_silent(tmp_path: Path) -> None:
    """A smooth histogram that passes through grey 205 is no unknown-becomes-free."""
    pixels = np.tile(np.arange(256), (40, 1))

    assert codes(read_map(write_map(tmp_path, pixels, free_thresh="0.25"))) == []


def test_unknown_loads_as_free(tmp_path: Path) -> None:
    """Grey 205 with free_thresh 0.25 loads as free: said with its share and the option that mends it."""
    path = write_map(tmp_path, rooms(), free_thresh="0.25")
    expected = Finding(
        "warning",
        "unknown-loads-as-free",
        "50% of the cells are grey 205, which map savers write for unknown, but free_thresh 0.25 loads them "
        "as free: arcs are then also looked for where nothing was mapped",
        "--free-thresh 0.196",
    )

    assert read_map(path).source.findings == (expected,)
    assert codes(read_map(path, free_thresh=0.196)) == []


def test_unknown_of_another_saver_loads_as_free(tmp_path: Path) -> None:
    """The middle one of just three greys is unknown too; its option lies just below its own occupancy."""
    path = write_map(tmp_path, rooms(255, 208))
    (finding,) = read_map(path).source.findings

    assert (finding.code, finding.option) == ("unknown-loads-as-free", "--free-thresh 0.184")
    assert codes(read_map(path, free_thresh=0.184)) == []
    assert codes(read_map(write_map(tmp_path, rooms(255, 250)))) == ["no-unknown"]


def test_yaw(tmp_path: Path) -> None:
    """A turned origin is applied, and said to be ignored by ROS."""
    (finding,) = read_map(write_map(tmp_path, rooms(), origin="[0, 0, 1.5707963]")).source.findings

    assert finding == Finding(
        "warning",
        "yaw-ignored-by-ros",
        "the origin's yaw is 90 degrees and is applied here, while ROS costmaps and AMCL ignore it: global "
        "accuracy may differ from what the robot saw",
        "--origin X_M,Y_M,0",
    )


def test_no_unknown_is_a_note(tmp_path: Path) -> None:
    """A black-and-white map is valid and noted."""
    (finding,) = read_map(write_map(tmp_path, rooms(255, 255))).source.findings

    assert (finding.level, finding.code, finding.option) == ("note", "no-unknown", None)


@pytest.mark.parametrize("greys", [(254, 205, 0), (254, 254, 0)])
def test_negate_gone_wrong(tmp_path: Path, greys: tuple[int, int, int]) -> None:
    """The map of a map saver read with negate 1 looks swapped, with and without unknown cells."""
    assert "inverted" in codes(read_map(write_map(tmp_path, rooms(*greys), negate="1")))


def test_negate_put_right(tmp_path: Path) -> None:
    """White walls on black with negate 1 are in order, and so is a floor plan in a solid block."""
    plan = np.zeros((60, 80))
    plan[25:35, 20:40] = 254

    assert codes(read_map(write_map(tmp_path, 255 - rooms(255, 128, 0), negate="1"))) == []
    assert codes(read_map(write_map(tmp_path, plan))) == ["no-unknown"]


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        (
            {"free_thresh": "0.65", "occupied_thresh": "0.65"},
            "free_thresh 0.65 is not below occupied_thresh 0.65: no grey is unknown and free wins, so walls "
            "may be lost to the score",
        ),
        (
            {"occupied_thresh": "65"},
            "free_thresh 0.196 and occupied_thresh 65 reach beyond 0 to 1, the range of occupancy: no cell "
            "can be occupied, which the score misses",
        ),
    ],
)
def test_odd_thresholds(tmp_path: Path, changed: dict[str, str], text: str) -> None:
    """Thresholds that overlap or leave 0 to 1 are told first, with the usual ones as the remedy."""
    finding = read_map(write_map(tmp_path, rooms(), **changed)).source.findings[0]

    assert finding == Finding("warning", "thresholds", text, "--free-thresh 0.196 --occupied-thresh 0.65")


def test_nothing_occupied(tmp_path: Path) -> None:
    """A map without a single occupied cell is told, because its coverage can only be 0."""
    (finding,) = read_map(write_map(tmp_path, rooms(wall=205))).source.findings

    assert (finding.level, finding.code, finding.option) == ("warning", "nothing-occupied", None)


@pytest.mark.parametrize("folder", ["/home/nobody-here/maps/", "C:\\\\maps\\\\"])
def test_foreign_image_path(tmp_path: Path, folder: str) -> None:
    """An absolute path of another machine gives way to the base name beside the YAML, with a warning."""
    path = write_map(tmp_path, rooms())
    path.write_text(path.read_text().replace("map.png", f'"{folder}map.png"'))
    (finding,) = read_map(path).source.findings

    assert (finding.level, finding.code) == ("warning", "foreign-image-path")
    assert finding.text.endswith(
        "which is not on this machine: map.png beside the YAML was scored in its place; is it the same map?"
    )
