"""Maps from point clouds and octrees: the floor, the slab, and every file format."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmarks.arena_shapes import arena, surface_points
from benchmarks.cloud_files import Points, write_las, write_octree, write_pcd, write_ply
from scipy.spatial.transform import Rotation

from command_line import fidmap
from fidmap.evaluate import evaluate
from fidmap.grid import metres_to_cells, trinarize
from fidmap.maps import read_map
from fidmap.maps.floor import find_floor
from fidmap.maps.octree_file import binary_leaves, full_leaves
from fidmap.model import Grid, Label
from map_files import sentence

FORMS = ("ascii", "binary_little_endian", "binary_big_endian")


def room(spacing: float = 0.04) -> Points:
    """A room of 4 x 3 m with its floor at z = 0.5, a table top at 0.7 m above it and a beam at 2 m."""
    steps = np.arange(0, 1.2, spacing)
    x, y = np.arange(0, 4, spacing), np.arange(0, 3, spacing)
    sides = [
        *(np.array([(a, b, h) for a in x for h in steps]) for b in (0.0, 3.0)),
        *(np.array([(a, b, h) for b in y for h in steps]) for a in (0.0, 4.0)),
    ]
    floor = np.array([(a, b, 0) for a in x for b in y])
    table = np.array([(a, b, 0.7) for a in np.arange(1, 1.5, spacing) for b in np.arange(1, 1.5, spacing)])
    beam = np.array([(a, 2.0, 2.0) for a in x])
    return np.concatenate([*sides, floor, table, beam]) + np.array([0, 0, 0.5])


def label_at(grid: Grid, x: float, y: float) -> Label:
    row, column = metres_to_cells(np.array([[x, y]]), grid.resolution_m, grid.origin)[0].astype(int)
    return Label(trinarize(grid).labels[row, column])


def ply(folder: Path, points: Points, **options: str) -> Path:
    return write_ply(folder / "cloud.ply", points, **options)


WRITERS: dict[str, Callable[[Path, Points], Path]] = {
    **{f"PLY {form}": lambda folder, p, form=form: ply(folder, p, form=form) for form in FORMS},
    "PLY double": lambda folder, p: ply(folder, p, kind="double"),
    "PCD ascii": lambda folder, p: write_pcd(folder / "a.pcd", p, "ascii"),
    "PCD binary": lambda folder, p: write_pcd(folder / "a.pcd", p, "binary"),
    "PCD compressed": lambda folder, p: write_pcd(folder / "a.pcd", p, "binary_compressed"),
    "LAS": lambda folder, p: write_las(folder / "a.las", p),
    "LAZ": lambda folder, p: write_las(folder / "a.laz", p),
}


@pytest.mark.parametrize("kind", WRITERS)
def test_every_format_gives_the_same_map(tmp_path: Path, kind: str) -> None:
    """Walls and what stands in the slab are occupied, seen floor is free, the beam above is nothing."""
    path = WRITERS[kind](tmp_path, room())
    grid = read_map(path.rename(tmp_path / "no_suffix"))
    assert label_at(grid, 2, 0) == label_at(grid, 4, 1.5) == label_at(grid, 1.2, 1.2) == Label.OCCUPIED
    assert label_at(grid, 3, 2) == label_at(grid, 3, 1) == Label.FREE
    assert grid.resolution_m in {0.025, 0.05}
    assert [finding.code for finding in grid.source.findings if finding.level == "warning"] == []
    assert "which is at 0.50 m" in grid.source.findings[0].text


def test_the_slab_is_the_users(tmp_path: Path) -> None:
    """Above the table only the walls are left; a slab at the beam shows the beam."""
    path = ply(tmp_path, room())
    assert label_at(read_map(path, slab_m=(0.8, 1.1)), 1.2, 1.2) == Label.FREE
    beam = read_map(path, slab_m=(1.9, 2.1))
    assert label_at(beam, 2, 2) == Label.OCCUPIED
    assert label_at(beam, 2, 1) == Label.FREE
    assert read_map(path, resolution_m=0.1).resolution_m == 0.1


FAR = np.array([400_000, 5_000_000, 30])  # coordinates as surveyors have them
UPS = {"z": [0, 0, 0], "y": [-90, 0, 0], "-y": [90, 0, 0], "x": [0, 90, 0], "-z": [180, 0, 0]}


@pytest.mark.parametrize("up", UPS)
@pytest.mark.parametrize("tilt", [0, 9])
def test_up_is_found(up: str, tilt: int) -> None:
    """Along any axis and between them, to a degree; the floor's height to a centimetre."""
    turn = Rotation.from_euler("xyz", UPS[up], degrees=True) * Rotation.from_euler("xy", [tilt, -tilt], degrees=True)
    points = turn.apply(room() + np.random.default_rng(0).normal(0, 0.005, room().shape)) + FAR
    floor = find_floor(points)
    wanted = turn.apply([0, 0, 1.0])
    assert floor.found
    assert math.degrees(math.acos(min(1, floor.up @ wanted))) < 1
    on_floor = turn.apply([2, 1.5, 0.5]) + FAR
    assert floor.up @ on_floor == pytest.approx(floor.height_m, abs=0.01)


def test_a_ceiling_is_no_floor() -> None:
    """Of two equal planes the one beneath is the floor; stray points below it do no harm."""
    rng = np.random.default_rng(1)
    ceiling = room()[np.isclose(room()[:, 2], 0.5)] + [0, 0, 2.5]
    stray = np.column_stack([rng.uniform(0, 4, (50, 2)), rng.uniform(-2, 3, 50)])
    assert find_floor(np.concatenate([room(), ceiling, stray])).height_m == pytest.approx(0.5, abs=0.01)
    upside_down = find_floor(np.concatenate([room(), ceiling]), "-z")
    assert upside_down.height_m == pytest.approx(-3.0, abs=0.01)
    assert upside_down.up[2] == pytest.approx(-1)


def test_a_cloud_without_floor_is_a_drawing_of_walls(tmp_path: Path) -> None:
    """Where no floor was recorded, all but the walls is free, and the findings say what heights are from."""
    walls = room()[room()[:, 2] > 0.6]
    grid = read_map(ply(tmp_path, walls))
    assert label_at(grid, 2, 0) == Label.OCCUPIED
    assert label_at(grid, 3, 2) == Label.FREE
    blob = np.random.default_rng(0).uniform(-3, 3, (20_000, 3))
    codes = [finding.code for finding in read_map(ply(tmp_path, blob)).source.findings]
    assert "no-floor" in codes


def test_the_resolution_fits_the_spacing(tmp_path: Path) -> None:
    """Dense clouds get 2.5 cm; the points of a voxel grid of 5 cm one cell each, wherever the lattice lies."""
    assert read_map(ply(tmp_path, room(0.015))).resolution_m == 0.025
    for shift in (0, 0.025, 0.0125):
        lattice = np.unique(np.round(room(0.02) / 0.05), axis=0) * 0.05 + shift
        assert read_map(ply(tmp_path, lattice)).resolution_m == 0.05


def test_points_that_are_none(tmp_path: Path) -> None:
    """NaN and infinity mean nothing was seen; a stray point far away does not make the map huge."""
    points = np.concatenate([room(), np.full((5, 3), np.nan), np.full((5, 3), np.inf), [[9e4, 9e4, 1]]])
    grid = read_map(ply(tmp_path, points))
    assert label_at(grid, 2, 0) == Label.OCCUPIED
    assert grid.occupancy.size < 1_000_000
    assert sentence(ply(tmp_path, np.full((5, 3), np.nan))) == (
        f"{tmp_path / 'cloud.ply'} holds no points; expected those of a map, so save it again"
    )


@pytest.mark.parametrize("turn", [(0, 0, 0), (90, 0, 0), (11, -7, 40)])
def test_a_scanned_arena_scores_like_its_plan(tmp_path: Path, turn: tuple[float, ...]) -> None:
    """All parts are found and lie where they are, also in a tilted cloud with y up."""
    made = arena()
    points = Rotation.from_euler("xyz", turn, degrees=True).apply(surface_points(made)) + np.array([3, -2, 7])
    report = evaluate(read_map(ply(tmp_path, points)), made.arena, fast=True)
    values = report.attributes.by_name
    assert values["coverage"].value == 1
    assert values["relative_accuracy"].value > 0.98
    assert values["consistency"].value > 0.98
    assert len(report.detections) == len(made.arena.parts)


def octree_parts() -> tuple[Points, Points]:
    """Cells of 5 cm: a wall of 0.1 m at x = 1 and its floor, and the air before the wall."""
    y, z = np.meshgrid(np.arange(0.025, 2, 0.05), np.arange(0.025, 1.2, 0.05))
    wall = np.concatenate([np.column_stack([np.full(y.size, x), y.ravel(), z.ravel()]) for x in (1.025, 1.075)])
    x, y = np.meshgrid(np.arange(-1.975, 1, 0.05), np.arange(0.025, 2, 0.05))
    floor = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, -0.025)])
    air = np.concatenate([floor + np.array([0, 0, h]) for h in np.arange(0.05, 1.2, 0.05)])
    return np.concatenate([wall, floor]), air


@pytest.mark.parametrize("suffix", [".bt", ".ot"])
def test_octrees_know_free_and_unknown(tmp_path: Path, suffix: str) -> None:
    """Cell by cell: the air is free, the wall occupied, what lies behind it and outside unknown."""
    occupied, free = octree_parts()
    grid = read_map(write_octree(tmp_path / f"tree{suffix}", occupied, free))
    assert grid.resolution_m == 0.05
    labels = trinarize(grid).labels
    counts = [int((labels == label).sum()) for label in Label]
    assert counts == [60 * 40, labels.size - 62 * 40, 2 * 40]
    assert label_at(grid, 1.05, 1) == Label.OCCUPIED
    assert label_at(grid, -1.95, 1.95) == Label.FREE


@pytest.mark.parametrize("suffix", [".bt", ".ot"])
def test_leaves_are_those_of_octomap(tmp_path: Path, suffix: str) -> None:
    """Every leaf at random places, also pruned ones, is where OctoMap's own iterator has it."""
    import pyoctomap

    rng = np.random.default_rng(5)
    points = np.concatenate([rng.uniform(-3, 3, (400, 3)), octree_parts()[0]])
    path = write_octree(tmp_path / f"tree{suffix}", points, octree_parts()[1] + [0, 3, 0])
    tree = pyoctomap.OcTree(0.05)
    tree = tree if suffix == ".bt" and tree.readBinary(str(path)) else tree.read(str(path))
    wanted = {
        (*np.round(np.array(it.getCoordinate()) / 0.05 - it.getSize() / 0.1).astype(int), round(it.getSize() / 0.05),
         bool(tree.isNodeOccupied(it)))
        for it in tree.begin_leafs()
    }  # fmt: skip
    body = path.read_bytes().split(b"\ndata\n", 1)[1]
    found = {
        (*map(int, corner), leaves.side, bool(hit))
        for leaves in (binary_leaves(body) if suffix == ".bt" else full_leaves(body, "OcTree"))
        for corner, hit in zip(leaves.corner, leaves.occupied, strict=True)
    }
    assert found == wanted
    assert max(side for *_, side, _ in found) > 1


def test_the_command_line_reads_clouds(tmp_path: Path) -> None:
    """`--slab` and `--up` reach the reader; nonsense is told."""
    path = ply(tmp_path, room())
    words = ("detect", path, "--radius", 0.3)
    assert "0.1 to 1 m above the floor" in fidmap(*words, "--slab", "0.1,1", "--up", "z").stderr
    assert fidmap(*words, "--slab", "0.1").exit_code == 2
    assert "--slab 1,0.1; expected the lowest" in fidmap(*words, "--slab", "1,0.1").stderr
    assert "--up w; expected one of x, -x" in fidmap(*words, "--up", "w").stderr


PLY_HEAD = (
    "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
)
PCD_HEAD = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 9\nHEIGHT 1\nPOINTS {}\nDATA {}\n"
BROKEN = {
    "more points than bytes": (
        PLY_HEAD.replace("ascii", "binary_little_endian").format(10**11),
        "at most 500,000,000 are read",
    ),
    "cut off": (
        PLY_HEAD.replace("ascii", "binary_little_endian").format(9) + "123",
        "it announces 9 points where bytes for 0 are left",
    ),
    "cut off text": (PLY_HEAD.format(3) + "1 2 3\n", "it announces 3 points where 1 are"),
    "words": (PLY_HEAD.format(1) + "1 2 three\n", "there are words among the numbers"),
    "columns": (PLY_HEAD.format(1) + "1 2 3 4\n", "its points do not have 3 numbers each"),
    "no end": (PLY_HEAD.format(1)[:-12], "its header does not end"),
    "no z": (PLY_HEAD.format(1).replace("float z", "float w"), "do not have one x, y and z each"),
    "list": (PLY_HEAD.format(1).replace("float z", "float z\nproperty list uchar int a").replace(
        "ascii", "binary_big_endian"), "a list stands in its element 'vertex'"),
    "no vertices": ("ply\nformat ascii 1.0\nend_header\n", "it has no vertices"),
    "negative": (PLY_HEAD.format(-5), "its header has the line 'element vertex -5'"),
    "PCD type": (PCD_HEAD.format(1, "ascii").replace("F F F", "F F Q"), "has the type Q4"),
    "PCD count": (PCD_HEAD.format(1, "ascii").replace("COUNT 1 1", "COUNT 1 1000000"), "'y' has 1000000 numbers"),
    "PCD data": (PCD_HEAD.format(1, "secret"), "its DATA is 'secret'"),
    "PCD size": (PCD_HEAD.format(9, "binary_compressed") + "abcdefgh", "its points unpack to"),
    "PCD bomb": (PCD_HEAD.format(9 * 10**7, "binary_compressed") + "\5\0\0\0\0\x7e\x5f\x40 7777", "are damaged"),
    "octree": ("# Octomap OcTree binary file\nid OcTree\nsize 3\nres 0.1\ndata\n\x03\0\x03\0", "its tree is cut off"),
    "octree res": ("# Octomap OcTree binary file\nid OcTree\nres nan\ndata\n", "its resolution `res` is 'nan'"),
    "octree id": ("# Octomap OcTree file\nid MyTree\nres 0.1\ndata\n", "it holds the tree 'MyTree'"),
    "octree depth": (
        "# Octomap OcTree binary file\nid OcTree\nres 0.1\ndata\n" + "\x03\0" * 16 + "\0\0",
        "its tree is deeper than 16 levels",
    ),
    "LAS": ("LASF" + "\0" * 40, "its header is cut off"),
    "LAS scale": ("LASF" + "\0" * 400, "its points have 0 bytes, the scale (0.0, 0.0, 0.0)"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_files_that_lie(tmp_path: Path, case: str) -> None:
    """Headers that announce what is not there end in one sentence, before memory is taken."""
    content, says = BROKEN[case]
    (tmp_path / "broken").write_bytes(content.encode("latin-1"))
    text = sentence(tmp_path / "broken")
    assert says in text
    assert text.endswith("copy or save it again")


def test_a_laz_file_that_kills_its_decoder(tmp_path: Path) -> None:
    """A table of 2^32 chunks makes lazrs end its process (found by fuzzing); the program lives and says so."""
    data = bytearray(write_las(tmp_path / "a.laz", room(0.2)).read_bytes())
    start = int.from_bytes(data[96:100], "little")
    table = int.from_bytes(data[start : start + 8], "little")
    data[table + 4 : table + 8] = b"\xff" * 4
    (tmp_path / "a.laz").write_bytes(data)
    assert "points, 0 could be decoded; copy or save it again" in sentence(tmp_path / "a.laz")


def test_a_small_laz_file_of_many_points(tmp_path: Path) -> None:
    """A kilobyte that announced 86 million points kept its decoder busy for 40 s (found by fuzzing)."""
    data = bytearray(write_las(tmp_path / "a.laz", room(0.2)).read_bytes())
    data[247:255] = (86_704_128).to_bytes(8, "little")
    (tmp_path / "a.laz").write_bytes(data)
    assert "it announces 86,704,128 points, at most 500,000,000 are read, and 2,500 per byte" in sentence(
        tmp_path / "a.laz"
    )


def test_a_las_file_of_absurd_scale(tmp_path: Path) -> None:
    """Points beyond all numbers are left out without a warning of numpy (found by fuzzing)."""
    data = bytearray(write_las(tmp_path / "a.las", room(0.2)).read_bytes())
    data[131:155] = struct.pack("<3d", 1e308, 1e308, 1e308)
    (tmp_path / "a.las").write_bytes(data)
    assert np.isfinite([read_map(tmp_path / "a.las").origin.x_m, read_map(tmp_path / "a.las").origin.y_m]).all()


SIGNALLING = np.frombuffer(b"\x01\0\xa0\x7f", "<f4")  # a NaN that numpy warns of when it computes with it


@pytest.mark.parametrize("turn", [0, 30])
@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_numpy_does_not_warn_of_points_that_are_none(tmp_path: Path, turn: int, encoding: str) -> None:
    """Signalling NaNs, and infinities that cancel out where the cloud is turned: warnings are errors in these tests."""
    points = Rotation.from_euler("x", turn, degrees=True).apply(room())
    strange = np.array([[np.inf, np.inf, -np.inf], [-np.inf, np.inf, np.inf], [1, np.inf, np.inf], [2, 2, 2]])
    path = write_pcd(tmp_path / "a.pcd", np.concatenate([points, np.repeat(strange, 50, axis=0)]), encoding)
    two = np.array([2, 2, 2], "<f4").tobytes()
    path.write_bytes(path.read_bytes().replace(two, SIGNALLING.tobytes() * 3))
    assert label_at(read_map(path), 2, 0) == Label.OCCUPIED


def test_numpy_does_not_warn_of_points_beyond_float32(tmp_path: Path) -> None:
    """Text is remembered as float32; what does not fit is told in our own sentence, and nothing before it."""
    path = ply(tmp_path, np.array([[0, 0, 0], [1e300, 0, 0]]), form="ascii")
    assert "holds points over 100,000 km away" in sentence(path)


def test_compressed_points_that_are_damaged(tmp_path: Path) -> None:
    """LZF refuses what cannot be its own (found by fuzzing)."""
    data = bytearray(write_pcd(tmp_path / "a.pcd", room(0.2), "binary_compressed").read_bytes())
    data[-300:] = b"\xff" * 300
    (tmp_path / "a.pcd").write_bytes(data)
    assert "its compressed points are damaged or cut off" in sentence(tmp_path / "a.pcd")


def test_blank_lines_before_points(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A block of text without any point is skipped (found by fuzzing)."""
    monkeypatch.setattr("fidmap.maps.point_table.TEXT_BYTES", 100)
    path = ply(tmp_path, room(0.2), form="ascii")
    path.write_bytes(path.read_bytes().replace(b"\n1.5 3\n", b"\n1.5 3\n" + b" \n" * 200))
    assert label_at(read_map(path), 2, 0) == Label.OCCUPIED


def test_maps_too_large(tmp_path: Path) -> None:
    """Two heaps of points 90 km apart are no map at 2 cm; the remedy is named."""
    far = np.concatenate([room(), room() + np.array([9e4, 9e4, 0])])
    assert "so crop it or give a larger --resolution" in sentence(ply(tmp_path, far, kind="double"), resolution_m=0.02)
    assert read_map(ply(tmp_path, far, kind="double"), resolution_m=30).occupancy.size < 10**8


def test_octree_with_another_up(tmp_path: Path) -> None:
    """OctoMap's z is up."""
    path = write_octree(tmp_path / "a.bt", *octree_parts())
    assert sentence(path, up="y") == f"{path} is an octree, whose z is up; it cannot be read with --up y"
    assert "holds nothing at the height of the slab" in sentence(path, slab_m=(50, 60))


def test_the_origin_is_the_users(tmp_path: Path) -> None:
    """`--origin` replaces where the cloud has its lower-left corner."""
    path = ply(tmp_path, room())
    origin = replace(read_map(path).origin, x_m=7.0)
    assert read_map(path, origin=origin).origin.x_m == 7
