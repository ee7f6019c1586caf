"""The detector on drawings whose truth is known: half and whole circles on thin walls."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import pytest

from fidmap.detect import find_barrel_parts
from fidmap.detect.cells import BandCells
from fidmap.detect.measure import drawn_angles
from fidmap.detect.network import JUDGE_ANGLES, JUDGE_STEPS, MIRRORED, judge
from fidmap.geometry import angle_between
from fidmap.grid import cells_to_metres
from fidmap.model import BarrelPart, Label, Pose2, SettingsError, TrinaryGrid

R = 0.3
SIDE = 140
WALL = 1.0  # distance of the two centres, cells
Labels = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Canvas:
    """A drawing in cells: x right, y up; `angle` is the direction of side A of the wall through (x, y)."""

    labels: Labels
    x: float
    y: float
    angle: float = 0.0

    def place(self, u: float, v: float) -> tuple[float, float]:
        """Where a point u cells out of the wall and v along it is drawn."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        return self.x + c * u - s * v, self.y + s * u + c * v


def canvas(angle: float = 0.0, at: tuple[float, float] = (70.3, 69.8)) -> Canvas:
    return Canvas(np.full((SIDE, SIDE), Label.FREE, np.uint8), *at, angle)


def local(paper: Canvas) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Every cell's centre, out of and along the wall."""
    y, x = np.mgrid[0:SIDE, 0:SIDE] + 0.5
    c, s = math.cos(paper.angle), math.sin(paper.angle)
    return c * (x - paper.x) + s * (y - paper.y), -s * (x - paper.x) + c * (y - paper.y)


def ink(paper: Canvas, points: npt.NDArray[np.float64]) -> None:
    """Occupy the cells that hold points (N, 2), out of and along the wall: what a perfect laser would hit."""
    x, y = paper.place(points[:, 0], points[:, 1])
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    inside = (column >= 0) & (row >= 0) & (column < SIDE) & (row < SIDE)
    paper.labels[row[inside], column[inside]] = Label.OCCUPIED


def draw_wall(paper: Canvas) -> None:
    along = np.linspace(-SIDE, SIDE, 8 * SIDE)
    for side in (-WALL / 2, WALL / 2):
        ink(paper, np.stack([np.full_like(along, side), along], axis=1))


def draw_half(paper: Canvas, radius: float, v: float = 0.0, side: float = 1.0) -> None:
    """A half circle on side A (1) or B (-1) of the wall."""
    u_all, v_all = local(paper)
    middle = side * WALL / 2
    behind = (side * u_all > WALL / 2) & (np.hypot(u_all - middle, v_all - v) < radius)
    paper.labels[behind] = Label.UNKNOWN
    t = np.linspace(-math.pi / 2, math.pi / 2, 3000)
    ink(paper, np.stack([middle + side * radius * np.cos(t), v + radius * np.sin(t)], axis=1))


def draw_circle(paper: Canvas, radius: float, u: float = 0.0, v: float = 0.0) -> None:
    u_all, v_all = local(paper)
    paper.labels[np.hypot(u_all - u, v_all - v) < radius] = Label.UNKNOWN
    t = np.linspace(0, 2 * math.pi, 6000)
    ink(paper, np.stack([u + radius * np.cos(t), v + radius * np.sin(t)], axis=1))


def pair(radius: float, angle: float, at: tuple[float, float] = (70.3, 69.8)) -> Canvas:
    paper = canvas(angle, at)
    draw_half(paper, radius)
    draw_half(paper, radius, side=-1.0)
    draw_wall(paper)
    return paper


def sure(labels: Labels, radius: float, origin: Pose2 | None = None) -> list[BarrelPart]:
    """Parts at the operating point, for barrels of 0.3 m drawn with so many cells."""
    found = find_barrel_parts(TrinaryGrid(labels, R / radius, origin or Pose2()), R)
    return [p for p in found if p.confidence >= 0.5]


def off(part: BarrelPart, paper: Canvas, radius: float, u: float, v: float = 0.0) -> float:
    """Distance of a centre from its truth, cells."""
    x, y = paper.place(u, v)
    return math.hypot(part.x_m * radius / R - x, part.y_m * radius / R - y)


# what must be found


def test_of_pairs_three_cells_large_seven_of_eight_halves_are_found() -> None:
    """The limit: a half is then nine cells or so, and one in eight may be too ragged to be sure of."""
    found = [sure(pair(3, angle).labels, 3) for angle in (0.0, 0.3, math.pi / 2, 2.0)]

    assert sum(map(len, found)) >= 7
    assert max(map(len, found)) == 2


@pytest.mark.parametrize("angle", [0.0, 0.3, math.pi / 2, 2.0])
@pytest.mark.parametrize("radius", [6, 12, 15])
def test_both_halves_on_a_wall(radius: float, angle: float) -> None:
    """Two parts, each with its own centre and facing, each drawn all around its half."""
    paper = pair(radius, angle)

    found = sure(paper.labels, radius)

    assert len(found) == 2
    for side in (1, -1):
        facing = angle if side == 1 else angle + math.pi
        part = min(found, key=lambda p: float(angle_between(p.facing or 0.0, facing)))
        assert part.facing is not None
        assert math.degrees(float(angle_between(part.facing, facing))) < 12
        assert off(part, paper, radius, side * WALL / 2) < 0.55
        assert 150 <= math.degrees(part.drawn) <= 180.1


@pytest.mark.parametrize("angle", [0.0, 0.3, math.pi / 2, 2.0])
@pytest.mark.parametrize("radius", [3, 6, 12, 15])
def test_one_half_on_a_wall(radius: float, angle: float) -> None:
    """The other side is plain."""
    paper = canvas(angle)
    draw_half(paper, radius)
    draw_wall(paper)

    (part,) = sure(paper.labels, radius)

    assert math.degrees(float(angle_between(part.facing or 0.0, angle))) < 12
    assert off(part, paper, radius, WALL / 2) < 0.55


@pytest.mark.parametrize("at", [(70.0, 70.0), (70.3, 69.8), (70.5, 70.1)])
@pytest.mark.parametrize("radius", [3, 6, 12, 15])
def test_a_whole_circle_has_no_facing(radius: float, at: tuple[float, float]) -> None:
    """One part, drawn all around, its centre within a third of a cell."""
    paper = canvas(at=at)
    draw_circle(paper, radius)

    (part,) = sure(paper.labels, radius)

    assert part.facing is None
    assert math.degrees(part.drawn) > 345
    assert off(part, paper, radius, 0) < 0.35


def test_several_parts_are_numbered_from_one() -> None:
    """Four parts on one wall, numbered as they come, most confident first."""
    paper = canvas(0.2)
    for v in (-30, 25):
        draw_half(paper, 6, v)
        draw_half(paper, 6, v, -1)
    draw_wall(paper)

    found = sure(paper.labels, 6)

    assert [p.n for p in found] == [1, 2, 3, 4]
    assert [p.confidence for p in found] == sorted((p.confidence for p in found), reverse=True)
    assert sorted(round(min(off(p, paper, 6, s / 2, v) for s in (1, -1) for v in (-30, 25))) for p in found) == [0] * 4


# what must not be found


@pytest.mark.parametrize("factor", [0.5, 0.6, 1.6, 2.0])
@pytest.mark.parametrize("radius", [6, 12])
def test_other_round_objects_are_not_taken(radius: float, factor: float) -> None:
    """Circles that are much smaller or larger than the barrels."""
    paper = canvas()
    draw_circle(paper, radius * factor)

    assert sure(paper.labels, radius) == []


def test_walls_and_corners_are_not_taken() -> None:
    """A wall, a room."""
    paper = canvas()
    draw_wall(paper)
    paper.labels[20:121, 20] = paper.labels[20:121, 120] = Label.OCCUPIED
    paper.labels[20, 20:121] = paper.labels[120, 20:121] = Label.OCCUPIED

    assert sure(paper.labels, 6) == []


@pytest.mark.parametrize("label", list(Label))
def test_maps_of_one_label_have_no_parts(label: Label) -> None:
    """Empty, unknown, full."""
    assert sure(np.full((60, 80), label, np.uint8), 6) == []


@pytest.mark.parametrize("shape", [(1, 1), (1, 50), (3, 2), (5, 5)])
def test_maps_smaller_than_a_barrel(shape: tuple[int, int]) -> None:
    """Nothing to find, nothing to fall over."""
    labels = np.full(shape, Label.FREE, np.uint8)
    labels[shape[0] // 2, shape[1] // 2] = Label.OCCUPIED

    assert sure(labels, 6) == []


@pytest.mark.parametrize("radius_m", [0.09, 0.0, -0.3, math.nan, math.inf])
def test_a_radius_that_cannot_be(radius_m: float) -> None:
    """Less than two cells, or no number at all."""
    grid = TrinaryGrid(np.zeros((20, 20), np.uint8), 0.05)

    with pytest.raises(SettingsError, match="arcs need at least 2 cells; give the radius in metres, or a finer map"):
        find_barrel_parts(grid, radius_m)


# where things are


def test_rows_go_up() -> None:
    """Row 0 is the lowest: a barrel in row 30, column 100 stands at x = 5 m, y = 1.5 m."""
    paper = canvas(at=(100.0, 30.0))
    draw_circle(paper, 6)

    (part,) = sure(paper.labels, 6)

    assert (part.x_m, part.y_m) == pytest.approx((5.0, 1.5), abs=0.02)


def test_origin_and_yaw_move_parts_and_turn_facings() -> None:
    """The same cells under another origin: positions follow the transform of cells, facings turn by the yaw."""
    paper = pair(6, 0.3)
    origin = Pose2(-4.0, 7.0, 2.5)

    plain, moved = sure(paper.labels, 6), sure(paper.labels, 6, origin)

    assert len(plain) == len(moved) == 2
    for one, other in zip(plain, moved, strict=True):
        cells = np.array([[one.y_m, one.x_m]]) / (R / 6)
        assert (other.x_m, other.y_m) == pytest.approx(tuple(cells_to_metres(cells, R / 6, origin)[0]))
        assert float(angle_between(other.facing or 0, (one.facing or 0) + 2.5)) < 1e-9
        assert -math.pi < (other.facing or 0) <= math.pi
        assert (one.drawn, one.sigma_m, one.confidence) == (other.drawn, other.sigma_m, other.confidence)


def turned(part: BarrelPart) -> BarrelPart:
    """Under a quarter turn counter-clockwise of the whole map: (x, y) to (height - y, x)."""
    return replace(part, x_m=SIDE * R / 12 - part.y_m, y_m=part.x_m, facing=(part.facing or 0) + math.pi / 2)


def mirrored(part: BarrelPart) -> BarrelPart:
    """Left and right exchanged."""
    return replace(part, x_m=SIDE * R / 12 - part.x_m, facing=math.pi - (part.facing or 0))


def test_the_judge_says_of_a_mirror_image_what_it_says_of_the_window() -> None:
    """With across and turn the other way; angles of the mirror image run backwards from the same facing."""
    windows = np.random.default_rng(0).integers(0, 3, (40, JUDGE_ANGLES, JUDGE_STEPS)).astype(np.uint8)

    plain, mirror = judge(windows, 8.0), judge(np.roll(windows[:, ::-1], 1, axis=1), 8.0)

    assert mirror == pytest.approx(MIRRORED * plain, abs=1e-4)
    assert np.abs(plain[:, 2]).max() > 0.01


@pytest.mark.parametrize("angle", [0.0, 0.4])
def test_turning_or_mirroring_the_map_does_the_same_to_its_parts(angle: float) -> None:
    """Nothing in the detector knows up from right."""
    labels = pair(12, angle).labels
    before = sure(labels, 12)
    # row 0 is lowest: a counter-clockwise turn of the map is a clockwise one of the array as numpy prints it
    for after, moved in ((np.rot90(labels, -1), turned), (labels[:, ::-1], mirrored)):
        found = sure(np.ascontiguousarray(after), 12)
        assert len(found) == len(before)
        for part in map(moved, before):
            twin = min(found, key=lambda p: math.hypot(p.x_m - part.x_m, p.y_m - part.y_m))
            assert math.hypot(twin.x_m - part.x_m, twin.y_m - part.y_m) < 0.25 * R / 12
            assert math.degrees(float(angle_between(twin.facing or 0, part.facing or 0))) < 6
            assert math.degrees(abs(twin.drawn - part.drawn)) < 10


# the drawn angle: each cell covers cell/R, gaps up to 1.5 cells are closed


def drawn_cells(*angles: float, radius: float = 6.0, away: float = 0.0, reach: float = math.pi / 2) -> float:
    """The drawn angle, in cells, of cells at these angles (in cells too) about the facing 0."""
    turn = np.array(angles) / radius
    cells = BandCells((radius + away) * np.sin(turn), (radius + away) * np.cos(turn), np.array([len(angles)]))
    return float(drawn_angles(cells, np.zeros((1, 2)), np.zeros(1), np.array([reach]), np.array([radius]))[0]) * radius


@pytest.mark.parametrize(
    ("angles", "expected"),
    [
        ((0.0,), 1.0),
        ((0.0, 1.0), 2.0),
        ((0.0, 0.4), 1.4),
        ((0.0, 0.2, 0.4, 0.4), 1.4),
        ((0.0, 2.49), 3.49),  # a gap of 1.49 cells is closed
        ((0.0, 2.51), 2.0),  # one of 1.51 is not
        ((-3.0, -2.0, 2.0, 3.0), 4.0),
        ((-8.0, -6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0, 8.0), 17.0),
    ],
)
def test_drawn_angle_is_the_measure_of_the_union(angles: tuple[float, ...], expected: float) -> None:
    """Computed by hand, in cells along the circle; the order of cells does not matter."""
    assert drawn_cells(*angles) == pytest.approx(expected)
    assert drawn_cells(*reversed(angles)) == pytest.approx(expected)


def test_cells_farther_than_one_cell_from_the_circle_do_not_count() -> None:
    """On both sides."""
    assert drawn_cells(0.0, away=0.99) == pytest.approx(1)
    assert drawn_cells(0.0, away=-0.99) == pytest.approx(1)
    assert drawn_cells(0.0, away=1.01) == 0
    assert drawn_cells(0.0, away=-1.01) == 0


def test_a_half_is_never_drawn_over_more_than_its_half() -> None:
    """Cells behind the wall do not count, and a cell at the end does not reach round the corner."""
    around = tuple(np.arange(-18.0, 18.0, 0.5))

    assert drawn_cells(*around) == pytest.approx(math.pi * 6)


def test_a_whole_circle_closes_over_its_seam() -> None:
    """38 cells around a circle of six cells: all of it; without four in a row 33 and the gap's ends."""
    around = 2 * math.pi * 6 * (np.arange(38) / 38 - 0.5)

    assert drawn_cells(*around, reach=math.pi) == pytest.approx(2 * math.pi * 6)
    gap = 5 * 2 * math.pi * 6 / 38 - 1
    assert drawn_cells(*around[:-4], reach=math.pi) == pytest.approx(2 * math.pi * 6 - gap)
    assert drawn_cells(*around[10:14], reach=math.pi) == pytest.approx(3 * 2 * math.pi * 6 / 38 + 1)
