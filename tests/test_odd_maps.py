"""Every YAML of the odd maps, met in 46 repositories: what each one reads as, or the sentence it ends in."""

from __future__ import annotations

import numpy as np
import pytest

from fidmap.grid import trinarize
from fidmap.maps import read_map
from fidmap.model import MapFileError
from real_data import real_data

EMPTY, UNKNOWN_FREE = ["nothing-occupied", "no-unknown"], ["unknown-loads-as-free"]
READ = {
    # folder / YAML: rows, columns, cells free, unknown, occupied, findings
    "2sungryul+turtlebot3_navigation2/map/map.yaml": (162, 188, 28323, 0, 2133, UNKNOWN_FREE),
    "CIFASIS+weed_robot_navigation/maps/empty.yaml": (1200, 1200, 1440000, 0, 0, EMPTY),
    "CNURobotics+chris_world_models/maps/creech_map.yaml": (240, 240, 54986, 0, 2614, UNKNOWN_FREE),
    "FedericoCalzoni+AMR-tiago/maps/map.yaml": (119, 118, 12745, 0, 1297, UNKNOWN_FREE),
    "ros-navigation+navigation2/nav2_bringup/maps/depot_speed.yaml": (307, 604, 123746, 57947, 3735, []),
    "ros-navigation+navigation2/nav2_map_server/test/testmap.yaml": (
        10, 10, 71, 0, 29, ["no-unknown", "yaw-ignored-by-ros"],
    ),
    "ros-planning+navigation/map_server/test/testmap.yaml": (
        10, 10, 71, 0, 29, ["no-unknown", "yaw-ignored-by-ros"],
    ),
    "ros-planning+navigation/map_server/test/testmap2.yaml": (
        12, 12, 88, 0, 56, ["no-unknown", "yaw-ignored-by-ros"],
    ),
    "turtlebot+turtlebot_simulator/turtlebot_stdr/maps/frieburg.yaml": (898, 1000, 271585, 609834, 16581, []),
    "tuw-robotics+tuw_multi_robot/tuw_multi_robot_demo/cfg/maps/test04/map.yaml": (
        500, 500, 20090, 218050, 11860, [],
    ),
}  # fmt: skip
IMAGE_MISSING = {
    "CNURobotics+chris_world_models/maps/jackal_race.yaml": "jackal_race.pgm",
    "FedericoCalzoni+AMR-tiago/tiago_ws/eut_kitchen_map 1.yaml": "eut_kitchen_map.pgm",
    "JonNatanael+rins/map/NewMap Backup/newmap.yaml": "/home/team_beta/ROS/src/rins/map/newmap_extreme.pgm",
    "Xiangyu-Fu+slam_bot/maps/jackal_race.yaml": "jackal_race.pgm",
    "nukoon+ATPBOT2/turtlebot3_navigation2/map/map.yaml": "/home/ubuntu/realsense/map.pgm",
    "ros-navigation+navigation2/nav2_map_server/test/invalid_image.yaml": "invalid.png",
    "ros-navigation+navigation2/tools/planner_benchmarking/100by100_10.yaml": "100by100_10.pgm",
}
UNPARSABLE = "UbiquityRobotics+magni_robot/magni_nav/maps/blank_map.yaml"


@pytest.mark.parametrize("name", READ)
def test_odd_map_reads(name: str) -> None:
    """The map has its size, exactly these cells of each label, and these findings."""
    grid = read_map(real_data("odd_maps", name))
    counts = np.bincount(trinarize(grid).labels.ravel(), minlength=3).tolist()
    codes = [finding.code for finding in grid.source.findings]

    assert (*grid.occupancy.shape, *counts, codes) == READ[name]


@pytest.mark.parametrize("name", IMAGE_MISSING)
def test_odd_map_without_its_image(name: str) -> None:
    """A YAML whose image was not kept names the image and where it was looked for."""
    path = real_data("odd_maps", name)
    with pytest.raises(MapFileError) as caught:
        read_map(path)

    assert str(caught.value) == (
        f"{path} names the image {IMAGE_MISSING[name]}, which does not exist; expected it at that path "
        "(seen from the YAML's folder), so put it there or correct `image:`"
    )


def test_odd_map_of_broken_yaml() -> None:
    """A YAML with a torn comment names the line that cannot be parsed."""
    path = real_data("odd_maps", UNPARSABLE)
    with pytest.raises(MapFileError) as caught:
        read_map(path)

    assert str(caught.value) == (f"{path} is not valid YAML in line 7 (could not find expected ':'); correct that line")


def test_every_odd_map_is_listed() -> None:
    """No YAML of the folder is left without an expected result."""
    folder = real_data("odd_maps")

    assert {str(path.relative_to(folder)) for path in folder.rglob("*.yaml")} == {
        *READ,
        *IMAGE_MISSING,
        UNPARSABLE,
    }


@pytest.mark.parametrize("folder", ["playpen", "tb3_world", "slam_challenge/maps"])
def test_ordinary_maps_are_silent(folder: str) -> None:
    """No ordinary map of a SLAM program raises a finding."""
    paths = [path for path in real_data(folder).glob("*.yaml") if not path.name.endswith("arena.yaml")]
    found = {path.name: [f.code for f in read_map(path).source.findings] for path in paths}

    assert paths
    assert not any(found.values()), found


def test_black_and_white_map() -> None:
    """The RoboCup map of 2010 has black and white only; it reads with a note once its scale is given."""
    grid = read_map(real_data("robocup2010", "singa.png"), resolution_m=0.05)

    assert grid.occupancy.shape == (367, 459)
    assert [(finding.level, finding.code) for finding in grid.source.findings] == [("note", "no-unknown")]
