"""Rescue maps: as hector and crosbot write them, as screenshots, with marks drawn over them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from benchmarks.robocup_picture import clean_picture, marked_picture
from PIL import Image

from fidmap.detect import find_barrel_parts
from fidmap.grid import cells_to_metres, metres_to_cells, trinarize
from fidmap.maps import read_map
from fidmap.maps.robocup.write import write_geotiff
from fidmap.model import BarrelPart, Grid, Label, Pose2
from fidmap.synth.suite import CaseSpec, SynthCase, case_rng, make_case
from map_files import sentence, write_pgm

F, U, X = Label.FREE, Label.UNKNOWN, Label.OCCUPIED
TILES, WALL, GREY = ((226, 226, 227), (237, 237, 238)), (0, 40, 120), (128, 128, 128)


@pytest.fixture(scope="module")
def case() -> SynthCase:
    """One mapped arena, seen from a frame that is turned, so that walls do not stand on the raster of cells."""
    spec = CaseSpec(resolution_m=0.05, frame=Pose2(1.3, -2.1, 0.3))
    return make_case(case_rng("tune", 5, "clean", 0), spec)


PLACE = Pose2(-1.25, 2.5, 0.0)


def small(origin: Pose2 = PLACE, resolution_m: float = 0.05) -> Grid:
    """A lopsided grid of 60 x 90 cells with all three labels."""
    labels = np.full((60, 90), U, np.uint8)
    labels[5:50, 10:80] = F
    labels[5:50, [10, 11, 40, 79]] = X
    labels[[5, 20, 49], 10:80] = X
    labels[30:34, 60:63] = X
    return Grid(np.array([0, np.nan, 1], np.float32)[labels], resolution_m, origin)


def labels_at(grid: Grid, places: np.ndarray) -> np.ndarray:
    """Labels at places in the world, so that grids of another size or orientation can be compared."""
    rc = np.floor(metres_to_cells(places, grid.resolution_m, grid.origin)).astype(int)
    return trinarize(grid).labels[rc[:, 0], rc[:, 1]]


def same_in_the_world(a: Grid, b: Grid) -> bool:
    """Every cell of `a` has the same label in `b` at the same place; unknown beyond the rim of `b` is not asked for."""
    cells = np.argwhere(trinarize(a).labels != U)
    places = cells_to_metres(cells + 0.5, a.resolution_m, a.origin)
    return bool((labels_at(a, places) == labels_at(b, places)).all())


@pytest.mark.parametrize("yaw", [0.0, 0.3, -2.0])
def test_what_was_written_reads_back(tmp_path: Path, yaw: float) -> None:
    """Labels, resolution and origin, whatever the frame."""
    grid = small(Pose2(-1.25, 2.5, yaw))
    write_geotiff(tmp_path / "map.tif", grid)
    back = read_map(tmp_path / "map.tif")

    assert (trinarize(back).labels == trinarize(grid).labels).all()
    assert back.resolution_m == pytest.approx(grid.resolution_m, rel=1e-12)
    assert (back.origin.x_m, back.origin.y_m, back.origin.yaw) == pytest.approx((-1.25, 2.5, yaw), abs=1e-9)


def test_the_world_file_says_the_same_as_the_tags(tmp_path: Path) -> None:
    """Without its tags, as hector writes it, the picture is placed by the `.tfw` in its turned frame."""
    write_geotiff(tmp_path / "map.tif", small())
    Image.open(tmp_path / "map.tif").convert("RGB").save(tmp_path / "bare.tif", compression="tiff_lzw")
    (tmp_path / "map.tfw").rename(tmp_path / "bare.tfw")
    back = read_map(tmp_path / "bare.tif")

    assert (trinarize(back).labels == trinarize(small()).labels).all()
    assert (back.origin.x_m, back.origin.y_m, back.origin.yaw) == pytest.approx((-1.25, 2.5, 0), abs=1e-9)


def as_hector(grid: Grid, path: Path) -> None:
    """hector_geotiff's drawing, from its description: (x, y) in pixels from the margin's corner to (column, row)."""
    px = 3 / grid.resolution_m
    h, w = grid.occupancy.shape
    size_x = int(math.ceil(1 + w * grid.resolution_m + 3) * px)
    size_y = int(math.ceil(1 + h * grid.resolution_m + 3) * px)
    rows, columns = np.mgrid[:size_x, :size_y]
    x, y = size_x - rows - 0.5, size_y - columns - 0.5
    picture = np.array(TILES, np.uint8)[((x // px + y // px) % 2).astype(int)]
    i, j = ((x - px) // 3).astype(int), ((y - px) // 3).astype(int)
    inside = (i >= 0) & (i < w) & (j >= 0) & (j < h)
    shown = np.full(inside.shape, U)
    shown[inside] = trinarize(grid).labels[j[inside], i[inside]]
    picture[shown == F], picture[shown == X] = (255, 255, 255), WALL
    lines = (shown == F) & (((x - px) % (px / 2) < 1) | ((y - px) % (px / 2) < 1))
    picture[lines] = (190, 190, 191)
    Image.fromarray(picture).save(path, compression="tiff_lzw")
    beyond_x = grid.origin.x_m + (size_x + 1 - px) / px
    beyond_y = grid.origin.y_m + (size_y + 1 - px) / px
    numbers = (1 / px, 0, 0, -1 / px, -beyond_y, beyond_x)
    path.with_suffix(".tfw").write_text("".join(f"{n:.10f}\n" for n in numbers))


@pytest.mark.parametrize("resolution_m", [0.05, 0.04, 0.07])
def test_as_hector_writes_it(tmp_path: Path, resolution_m: float) -> None:
    """Margins, tiles, grid lines, enlargement, +x up, and a world file in the turned frame: every cell in its place."""
    grid = small(Pose2(-3.7, 1.9, 0), resolution_m)
    as_hector(grid, tmp_path / "map.tif")
    back = read_map(tmp_path / "map.tif")

    assert back.resolution_m == pytest.approx(resolution_m, abs=1e-8)
    assert back.origin.yaw == 0
    assert same_in_the_world(grid, back)
    assert np.isin(trinarize(back).labels, [F, X]).sum() == np.isin(trinarize(grid).labels, [F, X]).sum()


def test_as_crosbot_writes_it(tmp_path: Path) -> None:
    """One pixel per cell, not turned, free space from grey 128 on, and a fourth line with the wrong sign."""
    grid = small()
    labels = trinarize(grid).labels[::-1]
    rows, columns = np.mgrid[: labels.shape[0], : labels.shape[1]]
    picture = np.array(TILES, np.uint8)[(rows // 20 + columns // 20) % 2]
    free = np.where((rows + columns) % 7 == 0, 128, 128 + rows)
    picture[labels == F] = np.repeat(free[labels == F][:, None], 3, axis=1)
    picture[labels == X] = WALL
    Image.fromarray(picture).save(tmp_path / "map.tiff")
    top = grid.origin.y_m + len(labels) * 0.05
    (tmp_path / "map.tfw").write_text(f"0.05\n0.0\n0.0\n0.05\n{grid.origin.x_m}\n{top}\n\n")
    back = read_map(tmp_path / "map.tiff")

    assert (trinarize(back).labels == trinarize(grid).labels).all()
    assert (back.origin.x_m, back.origin.y_m, back.origin.yaw) == pytest.approx((-1.25, 2.5, 0))
    assert [f.code for f in back.source.findings] == ["robocup-colours", "world-file-upwards"]


def test_grey_at_the_rim_is_margin(tmp_path: Path) -> None:
    """(128, 128, 128) that touches the rim is unknown; enclosed by the map it is free."""
    picture = clean_picture(small())
    picture[(picture == 255).all(axis=2)] = GREY
    wide = np.pad(picture, ((30, 30), (60, 60), (0, 0)), constant_values=128)
    Image.fromarray(wide).save(tmp_path / "map.png")
    labels = trinarize(read_map(tmp_path / "map.png", resolution_m=0.05)).labels

    turned = trinarize(small()).labels.T[:, ::-1]
    assert (labels[10:-10, 20:-20] == turned).all()
    assert (labels[:10] == U).all()
    assert (labels[:, :20] == U).all()


def turned_places(parts: tuple[BarrelPart, ...], rows: int) -> np.ndarray:
    """Where parts of a grid lie in the picture that shows it with +x up, read without any frame."""
    return np.array([[rows * 0.05 - (p.y_m), p.x_m] for p in parts])


@pytest.mark.parametrize(("name", "options"), [("m.png", {}), ("m.jpg", {"quality": 90}), ("m.jpg", {"quality": 75})])
@pytest.mark.parametrize("seed", [0, 1])
def test_marks_are_no_parts_and_hide_none(
    tmp_path: Path, case: SynthCase, name: str, options: dict[str, int], seed: int
) -> None:
    """12 discs, 3 diamonds, a path across walls, arrow, text, scale bar: the parts are those of the bare map.

    The scale comes from the picture itself, the cells from its enlargement.
    """
    bare = Grid(case.grid.occupancy, 0.05)
    Image.fromarray(marked_picture(bare, victims=12, seed=seed)).save(tmp_path / name, **options)
    grid = read_map(tmp_path / name)
    expected = turned_places(find_barrel_parts(trinarize(bare), case.arena.arena.radius_m), len(bare.occupancy))
    sure = [p for p in find_barrel_parts(trinarize(grid), case.arena.arena.radius_m) if p.confidence >= 0.5]
    found = np.array([[p.x_m, p.y_m] for p in sure])
    distance = np.hypot(*(expected[:, None] - found[None]).transpose(2, 0, 1))

    assert grid.resolution_m == pytest.approx(0.05, rel=1e-3)
    assert grid.occupancy.shape == case.grid.occupancy.shape[::-1]
    assert len(sure) >= 10
    assert (distance.min(axis=0) < 0.1).all(), "a mark became a part"
    confident = [p.confidence >= 0.8 for p in find_barrel_parts(trinarize(bare), case.arena.arena.radius_m)]
    assert (distance.min(axis=1) < 0.1)[confident].all(), "a mark hid a part"


def test_a_scaled_screenshot_keeps_its_scale(tmp_path: Path, case: SynthCase) -> None:
    """Scaled by 1.37 and blurred by that, the tiles still say how long a metre is, and walls stay walls."""
    bare = Grid(case.grid.occupancy, 0.05)
    image = Image.fromarray(marked_picture(bare))
    size = (round(image.width * 1.37), round(image.height * 1.37))
    image.resize(size, Image.Resampling.BILINEAR).save(tmp_path / "shot.png")
    grid = read_map(tmp_path / "shot.png")

    assert grid.resolution_m == pytest.approx(1 / (60 * 1.37), rel=3e-3)
    walls = (trinarize(grid).labels == X).mean()
    assert walls == pytest.approx((trinarize(bare).labels == X).mean(), rel=0.1)


def test_the_scale_bar_alone_gives_the_scale(tmp_path: Path) -> None:
    """Where nothing is unexplored there are no tiles: a bar of 61 pixels is 60 pixels long."""
    picture = clean_picture(small())
    picture[np.isin(picture[..., 0], (226, 237))] = 255
    picture[10, 20:81] = (0, 50, 140)
    Image.fromarray(picture).save(tmp_path / "map.png")

    assert read_map(tmp_path / "map.png").resolution_m == pytest.approx(0.05)


def test_a_wall_under_a_disc_goes_on(tmp_path: Path) -> None:
    """A victim's disc on a straight wall: the wall below it is restored, the rest of the disc is free."""
    picture = clean_picture(small())
    clean = Image.fromarray(picture)
    clean.save(tmp_path / "clean.png")
    rows, columns = np.mgrid[: picture.shape[0], : picture.shape[1]]
    picture[np.hypot(rows - 3 * (90 - 41), columns - 3 * (60 - 12)) < 10] = (240, 10, 10)
    Image.fromarray(picture).save(tmp_path / "map.png")
    before, after = (trinarize(read_map(tmp_path / n, resolution_m=0.05)).labels for n in ("clean.png", "map.png"))

    assert (before == after).all()


def test_neither_scale_nor_tiles(tmp_path: Path) -> None:
    """The sentence says what was looked for."""
    picture = clean_picture(small())
    picture[np.isin(picture[..., 0], (226, 237))] = 255
    Image.fromarray(picture).save(tmp_path / "map.png")

    assert sentence(tmp_path / "map.png").endswith(
        "is in the colours of a rescue map, but has neither GeoTIFF tags nor a world file nor a scale bar; give the "
        "side of a cell with --resolution M_PER_CELL"
    )


def test_other_pictures_are_not_taken_for_rescue_maps(tmp_path: Path) -> None:
    """Greys, a colour-coded costmap and noise are plain images."""
    rng = np.random.default_rng(3)
    grey = np.repeat(rng.choice([0, 205, 254], (50, 50))[..., None], 3, axis=2)
    costmap = np.array([[200, 0, 200], [0, 255, 255], [255, 255, 255], [112, 137, 134]])[rng.integers(0, 4, (50, 50))]
    for pixels in (grey, costmap, rng.integers(0, 256, (50, 50, 3))):
        Image.fromarray(pixels.astype(np.uint8)).save(tmp_path / "map.png")
        assert read_map(tmp_path / "map.png", resolution_m=0.05).source.format == "image"
    assert read_map(write_pgm(tmp_path, grey[..., 0]), resolution_m=0.05).source.format == "image"
