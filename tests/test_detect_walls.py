"""Facings and the walls around: what an arc alone cannot tell where a wall hides one of its ends."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fidmap.detect import find_barrel_parts, half_circles
from fidmap.detect.arcs import HALF, Arcs
from fidmap.detect.votes import boundary
from fidmap.detect.walls import DOUBT, MOST, towards_walls, walls_around
from fidmap.geometry import angle_between
from fidmap.model import FloatArray, Label, TrinaryGrid

SIDE, RADIUS = 240, 12.0


def test_the_more_the_walls_agree_and_the_farther_off_an_arc_is_the_more_it_is_turned() -> None:
    """Half of the way where the difference is `DOUBT` over how much they agree, to the nearest of four normals."""
    off = np.array([DOUBT / 0.5, -DOUBT / 0.5, DOUBT / 0.5, 2 * DOUBT / 0.5])
    walls = 0.5 * np.exp(4j * (1.0 + np.array([0, 0, np.pi / 2, 0])))

    assert towards_walls(1.0 + off, walls) - 1.0 == pytest.approx(off * [0.5, 0.5, 0.5, 0.2])


def test_arcs_far_from_the_walls_axis_and_arcs_without_walls_keep_their_facing() -> None:
    facings = 1.0 + np.array([MOST + 0.01, 0.2])

    assert towards_walls(facings, np.array([np.exp(4j), 0])) == pytest.approx(facings)


def filled(labels: np.ndarray, angle: float, box: tuple[float, float, float, float], label: Label) -> None:
    """A box of cells out of the wall (from, to) and along it (from, to), in a map turned about its middle."""
    u, v = out_and_along(angle)
    labels[(u >= box[0]) & (u < box[1]) & (v >= box[2]) & (v < box[3])] = label


def out_and_along(angle: float) -> tuple[FloatArray, FloatArray]:
    y, x = np.mgrid[0:SIDE, 0:SIDE] + 0.5 - SIDE / 2
    return np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x


def half_beside_a_step(angle: float) -> TrinaryGrid:
    """A half barrel on a wall that stands 9 cells farther out on one side, so that one end of the arc is hidden."""
    labels = np.full((SIDE, SIDE), Label.FREE, np.uint8)
    u, v = out_and_along(angle)
    ring = np.hypot(u, v)
    labels[(ring < RADIUS - 0.7) & (u > 0)] = Label.UNKNOWN
    labels[(np.abs(ring - RADIUS) < 0.7) & (u > 0)] = Label.OCCUPIED
    filled(labels, angle, (-3, 0, -100, 100), Label.OCCUPIED)
    filled(labels, angle, (0, 9, RADIUS - 3, 100), Label.UNKNOWN)
    filled(labels, angle, (7, 9, RADIUS - 3, 100), Label.OCCUPIED)
    filled(labels, angle, (0, 9, RADIUS - 3, RADIUS - 1), Label.OCCUPIED)
    return TrinaryGrid(labels, 0.025)


@pytest.mark.parametrize("angle", [0.0, 0.4, 2.5])
def test_the_walls_tell_the_facing_of_an_arc_with_a_hidden_end(angle: float) -> None:
    grid = half_beside_a_step(angle)
    arc = float(half_circles(grid.labels, RADIUS)[0].facings[0])

    part = find_barrel_parts(grid, 0.3)[0]

    assert part.facing is not None
    assert angle_between(part.facing, angle) < min(angle_between(arc, angle), math.radians(5))


@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_the_walls_around_are_the_mean_of_their_normals_four_times_turned(angle: float) -> None:
    """The arc beside them adds little."""
    _, (walls,) = half_circles(half_beside_a_step(angle).labels, RADIUS)

    assert np.angle(walls * np.exp(-4j * angle)) / 4 == pytest.approx(0, abs=np.radians(5))
    assert 0.5 < abs(walls) < 0.9


def test_whole_barrels_stand_against_no_wall() -> None:
    labels = half_beside_a_step(0.0).labels
    arcs = Arcs(np.full((2, 2), SIDE / 2), np.zeros(2), np.ones(2), np.array([HALF, np.pi]))

    half, whole = walls_around(arcs, boundary(labels, RADIUS), RADIUS)

    assert abs(half) > 0.5
    assert whole == 0
