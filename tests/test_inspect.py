"""The map doctor: each finding on a map that deserves it, none on clean ones, and the mended copy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from command_line import documents, fault, fidmap
from fidmap.arena.write import write_arena
from fidmap.grid import trinarize
from fidmap.inspect import with_findings
from fidmap.inspect.against import radius_findings
from fidmap.inspect.mend import mended
from fidmap.maps import read_map
from fidmap.maps.write import greys
from fidmap.maps.write import write_map as write_grid
from fidmap.model import Grid, Label, MapFileError, Pose2
from fidmap.synth.suite import CaseSpec, SynthCase, case_rng, make_case, suite
from map_files import write_map
from real_data import real_data

X = Label.OCCUPIED


def codes(grid: Grid) -> list[str]:
    """The codes of all findings about a map."""
    return [finding.code for finding in with_findings(grid).source.findings]


@pytest.fixture(scope="module")
def case() -> SynthCase:
    """A clean map of a maze with barrels, in a turned frame, with cells of 0.05 m."""
    spec = CaseSpec(resolution_m=0.05, frame=Pose2(2, 1, 0.3))
    return make_case(case_rng("tune", 5, "clean", 0), spec)


def as_file(grid: Grid) -> Grid:
    """The grid as a map_server file gives it: unknown is p = 0.196, not a missing value."""
    return replace(grid, occupancy=(1 - greys(grid).astype(np.float32) / 255))


@pytest.mark.parametrize("tier", ["clean", "office", "field"])
def test_clean_maps_are_silent(tier: str) -> None:
    """Every kind of place and mapper, as the program has it and as a file gives it."""
    for made in suite("tune", 8, 2, tier):  # type: ignore[arg-type]
        assert codes(made.grid) == [], made.name
        assert codes(as_file(made.grid)) == [], made.name


def test_enlarged(case: SynthCase) -> None:
    """Each cell repeated three times: found with its factor, and put together again."""
    big = np.repeat(np.repeat(case.grid.occupancy, 3, axis=0), 3, axis=1)[1:, 2:]
    grid = Grid(big, 0.05 / 3, Pose2(1, 2, 0.5))
    (finding,) = with_findings(grid).source.findings
    again, done = mended(grid, (finding,))

    assert (finding.code, finding.level) == ("upscaled", "warning")
    assert "enlarged 3 times, its true cells are 0.05 m" in finding.text
    assert done == ("upscaled",)
    assert again.resolution_m == pytest.approx(0.05)
    assert (trinarize(again).labels == trinarize(case.grid).labels[1:, 1:]).all()


@pytest.mark.parametrize("sigma", [0.8, 1.2])
def test_smoothed(case: SynthCase, sigma: float) -> None:
    """A blurred image, as a photo editor makes it."""
    blurred = cv2.GaussianBlur(as_file(case.grid).occupancy, (0, 0), sigma)

    assert "smoothed" in codes(Grid(blurred, 0.05))


def test_enlarged_with_interpolation(case: SynthCase) -> None:
    """Scaled by two with linear interpolation, as an image viewer does it."""
    scaled = cv2.resize(as_file(case.grid).occupancy, None, fx=2, fy=2, interpolation=cv2.INTER_LINEAR)

    assert "smoothed" in codes(Grid(scaled, 0.025))


def test_doubled_walls() -> None:
    """The same map once more, 0.15 and 0.1 m beside itself: every wall has a twin."""
    made = make_case(case_rng("tune", 5, "clean", 0), CaseSpec(resolution_m=0.025, frame=Pose2(0, 0, 0.3)))
    labels = trinarize(made.grid).labels.copy()
    labels[np.roll(labels, (6, 4), (0, 1)) == X] = X
    doubled = np.array([0, np.nan, 1], np.float32)[labels]

    assert codes(made.grid) == []
    assert "doubled-walls" in codes(Grid(doubled, 0.025))


def test_thick_walls(case: SynthCase) -> None:
    """Walls widened by three cells to each side are told with their thickness."""
    walls = cv2.dilate((trinarize(case.grid).labels == X).view(np.uint8), np.ones((7, 7), np.uint8)) > 0
    (finding,) = with_findings(Grid(np.where(walls, np.float32(1), case.grid.occupancy), 0.05)).source.findings

    assert (finding.code, finding.level) == ("thick-walls", "note")


def test_stray_rays_and_margins(case: SynthCase) -> None:
    """A ray that went far out, and a frame of nothing: told, and cut off at the same place in the world."""
    p = np.full((1200, 1500), np.nan, np.float32)
    h, w = case.grid.occupancy.shape
    p[300 : 300 + h, 400 : 400 + w] = case.grid.occupancy
    margins = Grid(p.copy(), 0.05, Pose2(-3, 4, 0))
    p[300 + h // 2, 400 : 400 + 5 * w // 2] = 0
    p[300 : 300 + 2 * h, 400 + w // 2] = 0
    stray = Grid(p, 0.05, Pose2(-3, 4, 0))

    assert codes(margins) == ["empty-margins"]
    assert codes(stray) == ["stray-rays"]
    for grid in (margins, stray):
        again, done = mended(grid, with_findings(grid).source.findings)
        rows, columns = np.array(np.nonzero(trinarize(again).labels == X))[:, 0]
        x = again.origin.x_m + (columns + 0.5) * 0.05, again.origin.y_m + (rows + 0.5) * 0.05
        rows, columns = np.array(np.nonzero(trinarize(grid).labels == X))[:, 0]
        assert x == pytest.approx((-3 + (columns + 0.5) * 0.05, 4 + (rows + 0.5) * 0.05))
        assert done == (with_findings(grid).source.findings[0].code,)
        assert again.occupancy.size < 0.2 * grid.occupancy.size
        assert (trinarize(again).labels == X).sum() == (trinarize(grid).labels == X).sum()


@pytest.mark.parametrize(
    ("resolution_m", "rounded"),
    [(0.05, False), (0.025, False), (0.0254, False), (0.04, False), (1 / 30, False), (0.033, True), (0.032, True),
     (0.017, True), (0.1, False), (0.01, False), (0.015, False)],
)  # fmt: skip
def test_rounded_resolution(case: SynthCase, resolution_m: float, rounded: bool) -> None:
    """Three decimals that nobody chooses: 0.033 may be 1/30. A side with more decimals was not rounded to three."""
    assert codes(Grid(case.grid.occupancy, resolution_m)) == ["resolution-rounded"] * rounded


def test_radius(case: SynthCase) -> None:
    """The map's arcs are 0.30 m: silent for that, and for what mappers make of it; told for 0.24."""
    assert radius_findings(case.grid, 0.30) == ()
    assert radius_findings(case.grid, 0.285) == ()
    (finding,) = radius_findings(case.grid, 0.24)
    assert finding.code == "radius-off"
    assert float(finding.text.split("about ")[1].split()[0]) == pytest.approx(0.30, abs=0.012)


def test_jpeg_shared_image_and_colours(tmp_path: Path, case: SynthCase) -> None:
    """What only the files show: a lossy image, two YAMLs for one image, rescue colours read as greys."""
    pixels = greys(case.grid)[::-1]
    path = write_map(tmp_path, pixels, image="map.jpg")

    assert "lossy-jpeg" in codes(read_map(path))
    path = write_map(tmp_path, pixels, image="map.png")
    (tmp_path / "other.yaml").write_text(path.read_text())
    assert "shared-image" in codes(read_map(path))
    (tmp_path / "other.yaml").unlink()
    assert codes(read_map(path)) == []

    from benchmarks.robocup_picture import clean_picture

    Image.fromarray(clean_picture(case.grid)).save(tmp_path / "map.png")
    assert "rescue-colours" in codes(read_map(path))


ODD = {
    "2sungryul+turtlebot3_navigation2/map/map.yaml": ["unknown-loads-as-free"],
    "CIFASIS+weed_robot_navigation/maps/empty.yaml": ["nothing-occupied", "no-unknown"],
    "CNURobotics+chris_world_models/maps/creech_map.yaml": ["unknown-loads-as-free", "thick-walls"],
    "FedericoCalzoni+AMR-tiago/maps/map.yaml": ["unknown-loads-as-free"],
    "ros-navigation+navigation2/nav2_bringup/maps/depot_speed.yaml": [],
    "ros-navigation+navigation2/nav2_map_server/test/testmap.yaml": ["no-unknown", "yaw-ignored-by-ros"],
    "ros-planning+navigation/map_server/test/testmap.yaml": ["no-unknown", "yaw-ignored-by-ros"],
    "ros-planning+navigation/map_server/test/testmap2.yaml": ["no-unknown", "yaw-ignored-by-ros"],
    "turtlebot+turtlebot_simulator/turtlebot_stdr/maps/frieburg.yaml": [],
    "tuw-robotics+tuw_multi_robot/tuw_multi_robot_demo/cfg/maps/test04/map.yaml": ["thick-walls", "resolution-rounded"],
}


@pytest.mark.parametrize("name", ODD)
def test_odd_maps(name: str) -> None:
    """Each odd map has the findings that docs/formats.md lists beside what it is."""
    assert codes(read_map(real_data("odd_maps", name))) == ODD[name]


WITHOUT_IMAGE = {
    "Xiangyu-Fu+slam_bot/maps/jackal_race.yaml": [],
    "nukoon+ATPBOT2/turtlebot3_navigation2/map/map.yaml": ["unknown-loads-as-free", "foreign-image-path"],
    "ros-navigation+navigation2/nav2_map_server/test/invalid_image.yaml": ["yaw-ignored-by-ros"],
    "ros-navigation+navigation2/tools/planner_benchmarking/100by100_10.yaml": ["inverted"],
}


@pytest.mark.parametrize("name", WITHOUT_IMAGE)
def test_odd_maps_without_their_image(name: str) -> None:
    """The image is named, and what the YAML shows is told beside it."""
    with pytest.raises(MapFileError, match=r"names the image .* which does not exist") as error:
        read_map(real_data("odd_maps", name))
    assert [finding.code for finding in error.value.findings] == WITHOUT_IMAGE[name]


def test_ordinary_real_maps() -> None:
    """SLAM maps: huge margins where they are, one map that is doubled to the eye too, nothing else."""
    found = {}
    for folder in ("playpen", "tb3_world", "slam_challenge/maps"):
        for path in real_data(folder).glob("*.yaml"):
            if not path.name.endswith("arena.yaml"):
                found[path.stem] = codes(read_map(path))

    assert {name: what for name, what in found.items() if what} == {
        "playpen_map": ["empty-margins"],
        "ros_navigation_tb3_sandbox": ["empty-margins"],
        "tiryoh_turtlebot3_world": ["empty-margins"],
        "m55": ["doubled-walls"],
    }


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, case: SynthCase) -> Path:
    """A folder to work in, with a map whose unknown cells load as free, and its arena."""
    monkeypatch.chdir(tmp_path)
    path = write_grid(tmp_path, "map", case.grid)
    path.write_text(path.read_text().replace("free_thresh: 0.196", "free_thresh: 0.25"))
    write_arena(tmp_path / "arena.yaml", case.arena.arena)
    return tmp_path


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (500, 1), (1, 500), (3, 4), (5, 5)])
@pytest.mark.parametrize("p", [0.0, 1.0, np.nan])
def test_tiny_maps(shape: tuple[int, int], p: float) -> None:
    """A map of one cell, or one cell wide, free, occupied or unknown, is inspected like any other."""
    assert set(codes(Grid(np.full(shape, p, np.float32), 0.05))) <= {"empty-margins"}


@pytest.mark.usefixtures("folder")
def test_inspect_json() -> None:
    """One valid line per map, in order, also for one that cannot be used."""
    result = fidmap("inspect", "map.yaml", "none.yaml", "--json")
    good, bad = documents(result.stdout, "inspect")

    assert result.exit_code == 1
    assert (good["format"], good["resolution_m"], sum(good["share"].values())) == ("map_server", 0.05, pytest.approx(1))
    assert sum(good["histogram"]["percent"]) + good["histogram"]["no_value"] == good["width"] * good["height"]
    assert [f["code"] for f in good["findings"]] == ["unknown-loads-as-free"]
    assert bad["error"]["code"] == "map-file"


def test_findings_beside_an_error(folder: Path) -> None:
    """A map whose image is missing: one sentence, then what its YAML shows; both in the line of JSON."""
    (folder / "map.pgm").unlink()
    told = fidmap("inspect", "map.yaml").stderr.splitlines()
    (document,) = documents(fidmap("inspect", "map.yaml", "--json").stdout, "inspect")

    assert told[0].startswith("fidmap: map.yaml names the image map.pgm, which does not exist; ")
    assert told[1].startswith("fidmap: warning: unknown-loads-as-free: free_thresh 0.25 would load grey 205, ")
    assert told[1].endswith(" (--free-thresh 0.196)")
    assert [f["code"] for f in document["findings"]] == ["unknown-loads-as-free"]


@pytest.mark.usefixtures("folder")
def test_inspect_text_and_picture() -> None:
    """Facts, a picture in characters, findings with their option; and a picture file where one is asked for."""
    result = fidmap("inspect", "map.yaml", "--out", "seen", "--radius", "0.30")

    assert result.exit_code == 0
    assert "  resolution  0.05 m per cell\n" in result.stdout
    assert result.stdout.count("█") > 50
    assert "warning: unknown-loads-as-free: " in result.stdout
    assert "(--free-thresh 0.196)" in result.stdout
    with Image.open("seen/map/thumbnail.png") as picture:
        assert picture.mode == "L"


def test_fix_writes_a_copy_and_never_the_original(folder: Path) -> None:
    """The copy has no finding left; a second run refuses to overwrite it."""
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    result = fidmap("inspect", "map.yaml", "--fix")

    assert result.stderr.endswith("map-fixed.yaml without unknown-loads-as-free\n")
    assert codes(read_map("map-fixed.yaml")) == []
    assert {name: (folder / name).read_bytes() for name in before} == before
    again = fidmap("inspect", "map.yaml", "--fix")
    assert again.exit_code == 1
    assert "map-fixed.yaml: is there already; choose another name, or move it away" in again.stderr
    assert "nothing that a program could mend" in fidmap("inspect", "map-fixed.yaml", "--fix").stderr


def test_fix_mends_what_another_finding_hid(folder: Path, case: SynthCase) -> None:
    """While unknown loads as free, nothing tells margins: enlarged, with margins and such thresholds, all is mended."""
    big = np.repeat(np.repeat(case.grid.occupancy, 2, axis=0), 2, axis=1)
    path = write_grid(folder, "big", Grid(np.pad(big, 1500, constant_values=np.nan), 0.025))
    path.write_text(path.read_text().replace("free_thresh: 0.196", "free_thresh: 0.25"))
    result = fidmap("inspect", "big.yaml", "--fix")

    assert result.stderr.endswith("big-fixed.yaml without unknown-loads-as-free, upscaled, empty-margins\n")
    assert codes(read_map("big-fixed.yaml")) == []


@pytest.mark.usefixtures("folder")
def test_score_tells_the_same() -> None:
    """The findings of the doctor stand in the report."""
    p = np.pad(read_map("map.yaml").occupancy, 300, constant_values=np.nan)
    write_grid(Path(), "wide", Grid(p, 0.05))
    result = fidmap("score", "wide.yaml", "--arena", "arena.yaml", "--json", "--workers", "1")
    (document,) = documents(result.stdout)

    assert "empty-margins" in [finding["code"] for finding in document["findings"]]


def test_usage() -> None:
    """No map, or a radius that is none."""
    assert fidmap("inspect").exit_code == 2
    assert fidmap("inspect", "map.yaml", "--radius", "-1").exit_code == 2
    assert "does not exist" in fault("inspect", "nowhere.yaml")
