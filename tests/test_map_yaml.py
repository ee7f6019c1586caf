"""The YAML of a map_server map: its faults, and the traps between YAML 1.1 and ROS."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fidmap.maps import read_map
from fidmap.maps.description import parse
from fidmap.maps.overrides import Overrides
from fidmap.model import MapFileError, Pose2
from map_files import YAML, sentence, write_map, write_yaml


@pytest.fixture(autouse=True)
def _in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files are named as a user in their folder names them."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("changed", "faults"),
    [
        ({"resolution": None, "negate": None, "free_thresh": None}, "lacks resolution, negate, free_thresh"),
        ({"resolution": ".nan"}, "resolution is nan, expected metres per cell from 1e-05 to 1000"),
        ({"resolution": "-0.05"}, "resolution is -0.05, expected metres per cell from 1e-05 to 1000"),
        ({"resolution": "0"}, "resolution is 0, expected metres per cell from 1e-05 to 1000"),
        ({"resolution": "fine"}, "resolution is 'fine', expected metres per cell from 1e-05 to 1000"),
        ({"origin": "[0, 0]"}, "origin is a list of 2, expected exactly three numbers [x_m, y_m, yaw_rad]"),
        ({"origin": "[0, 0, -nan]"}, "origin has a yaw that is '-nan', expected a finite number"),
        ({"origin": "[0, x, 0]"}, "origin has a y that is 'x', expected a number"),
        ({"origin": "0 0 0"}, "origin is '0 0 0', expected exactly three numbers [x_m, y_m, yaw_rad]"),
        ({"negate": "2.5"}, "negate is 2.5, expected 0 or 1"),
        ({"free_thresh": ".inf"}, "free_thresh is inf, expected a finite number"),
        ({"occupied_thresh": "[1]"}, "occupied_thresh is a list, expected a number"),
        ({"mode": "ternary"}, "mode is 'ternary', expected trinary, scale or raw"),
        ({"mode": ""}, "mode is None, expected trinary, scale or raw"),
        ({"image": '""'}, "image is '', expected the name of an image file"),
        (
            {"resolution": "-1", "origin": "[]", "mode": "x", "negate": None},
            "lacks negate; resolution is -1, expected metres per cell from 1e-05 to 1000; origin is a "
            "list of 0, expected exactly three numbers [x_m, y_m, yaw_rad]; "
            "mode is 'x', expected trinary, scale or raw",
        ),
    ],
)
def test_faulty_yaml(tmp_path: Path, changed: dict[str, str | None], faults: str) -> None:
    """Every fault of a YAML is told at once, each with its key, its value and what was expected."""
    write_map(tmp_path, [[0, 205, 254]])
    write_yaml(tmp_path, **changed)

    assert sentence("map.yaml") == f"map.yaml is not a valid map_server YAML: {faults}; correct the file"


def test_faults_and_a_missing_image_are_told_together(tmp_path: Path) -> None:
    """Who corrects the YAML should not learn only then that its image is missing too."""
    write_yaml(tmp_path, negate=None, mode="ternary", image="/home/team/a.pgm")

    assert sentence("map.yaml") == (
        "map.yaml is not a valid map_server YAML: lacks negate; mode is 'ternary', expected trinary, scale or raw; "
        "its image /home/team/a.pgm does not exist; correct the file"
    )


@pytest.mark.parametrize(
    ("changed", "codes"),
    [
        ({}, []),
        ({"free_thresh": "0.25"}, ["unknown-loads-as-free"]),
        ({"free_thresh": "0.25", "mode": "raw"}, []),
        ({"negate": "1"}, ["inverted"]),
        ({"free_thresh": "0.7"}, ["thresholds", "unknown-loads-as-free"]),
        ({"origin": "[0, 0, 0.1]", "image": "C:\\maps\\a.pgm"}, ["foreign-image-path", "yaw-ignored-by-ros"]),
        (
            {"free_thresh": "0.25", "origin": "[1, 2, -1.6]", "image": "/home/team/a.pgm", "resolution": "-1"},
            ["unknown-loads-as-free", "foreign-image-path", "yaw-ignored-by-ros"],
        ),
    ],
)
@pytest.mark.parametrize("broken", [False, True])
def test_findings_without_the_image(tmp_path: Path, changed: dict[str, str], codes: list[str], broken: bool) -> None:
    """What the YAML alone shows is told beside the image that is missing or broken, or the key at fault."""
    write_yaml(tmp_path, **{"free_thresh": "0.196", **changed})
    if broken:
        (tmp_path / "map.png").write_bytes(b"P5 3 2 255\n")
    with pytest.raises(MapFileError) as error:
        read_map("map.yaml")

    assert [finding.code for finding in error.value.findings] == codes


@pytest.mark.parametrize(
    "changed",
    [
        {"resolution": "25e-3"},
        {"resolution": '"0.025"'},
        {"origin": "[-4e-17, 1e1, 0] # comment"},
        {"negate": "no"},
        {"negate": '"0"'},
        {"image": "map.png # 3 x 1 pixels"},
        {"unheard_of": "{a: [1]}"},
    ],
)
def test_yaml_as_ros_reads_it(tmp_path: Path, changed: dict[str, str]) -> None:
    """Numbers that YAML 1.1 takes for text, quotes, comments and unknown keys are no faults."""
    grid = read_map(write_map(tmp_path, [[0, 205, 254]]))
    write_yaml(tmp_path, **changed)
    other = read_map("map.yaml")

    assert other.occupancy.tobytes() == grid.occupancy.tobytes()
    assert other.resolution_m == (0.025 if "resolution" in changed else 0.05)
    assert other.origin == (Pose2(-4e-17, 10, 0) if "origin" in changed else Pose2())


SCALARS = st.one_of(
    st.sampled_from(["1", "0x", ".nan", "~", "[1, 2, 3]", "{a: b}", "!!int x", "2001-99-99", "*a", "&a 1", "9" * 5000]),
    st.text(max_size=12),
)


@settings(max_examples=120, derandomize=True, deadline=None)
@given(st.dictionaries(st.sampled_from([*YAML, "mode"]), SCALARS, max_size=4), st.binary(max_size=20))
def test_hostile_yaml_ends_in_one_sentence(changed: dict[str, str], tail: bytes) -> None:
    """Whatever stands in the keys and after them, a YAML is understood or told off in one line."""
    lines = [f"{key}: {value}\n" for key, value in {**YAML, **changed}.items()]
    data = "".join(lines).encode("utf-8", "surrogatepass") + tail
    try:
        text = f"m.yaml {parse(data, 'm.yaml', Overrides()).meaning.resolution_m}"
    except MapFileError as error:
        text = str(error)

    assert text.startswith("m.yaml ")
    assert "\n" not in text
