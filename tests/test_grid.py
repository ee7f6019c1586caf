"""Cells and metres, and the three labels."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fidmap.grid import cells_to_metres, metres_to_cells, trinarize
from fidmap.model import Grid, Label, Pose2, Source

FREE, UNKNOWN, OCCUPIED = Label.FREE, Label.UNKNOWN, Label.OCCUPIED


def grid_of(*values: float, **more: object) -> Grid:
    return Grid(np.array([values], np.float32), 0.05, **more)


def test_thresholds_belong_to_their_labels() -> None:
    """P <= free is free, p >= occupied is occupied, what lies between or is NaN is unknown."""
    grid = grid_of(0.0, 0.196, 0.197, 0.649, 0.65, 1.0, math.nan)

    assert trinarize(grid).labels.tolist() == [[FREE, FREE, UNKNOWN, UNKNOWN, OCCUPIED, OCCUPIED, UNKNOWN]]


def test_thresholds_are_compared_in_single_precision() -> None:
    """A cell of exactly float32(0.65) is occupied although 0.65 as a double is a little greater."""
    assert float(np.float32(0.65)) < 0.65
    assert trinarize(grid_of(0.65)).labels.tolist() == [[OCCUPIED]]


def test_free_wins_where_thresholds_overlap() -> None:
    """As in map_server."""
    grid = grid_of(0.4, 0.5, 0.6, free_thresh=0.55, occupied_thresh=0.45)

    assert trinarize(grid).labels.tolist() == [[FREE, FREE, OCCUPIED]]


def test_thresholds_can_be_overridden() -> None:
    """Each alone."""
    grid = grid_of(0.1, 0.3, 0.6)

    assert trinarize(grid, free_thresh=0.3).labels.tolist() == [[FREE, FREE, UNKNOWN]]
    assert trinarize(grid, occupied_thresh=0.6).labels.tolist() == [[FREE, UNKNOWN, OCCUPIED]]


def test_labels_of_the_format_stand_unless_thresholds_are_overridden() -> None:
    """A palette knows its labels."""
    labels = np.array([[OCCUPIED, FREE]], np.uint8)
    grid = grid_of(0.0, 1.0, labels=labels)

    assert trinarize(grid).labels.tolist() == [[OCCUPIED, FREE]]
    assert trinarize(grid, free_thresh=0.196).labels.tolist() == [[FREE, OCCUPIED]]


def test_what_belongs_to_the_map_rides_along() -> None:
    """Origin, resolution, source and occupancy."""
    grid = grid_of(0.5, origin=Pose2(1, 2, 3), source=Source("m.yaml"))

    found = trinarize(grid)

    assert (found.origin, found.resolution_m, found.source) == (Pose2(1, 2, 3), 0.05, Source("m.yaml"))
    assert np.array_equal(found.occupancy, grid.occupancy)


def test_arrays_cannot_be_written_through() -> None:
    """Frozen values hold frozen arrays; the caller's own array stays writable."""
    own = np.zeros((2, 2), np.float32)
    grid = Grid(own, 0.05)

    with pytest.raises(ValueError, match="read-only"):
        grid.occupancy[0, 0] = 1
    with pytest.raises(ValueError, match="read-only"):
        trinarize(grid).labels[0, 0] = 1
    own[0, 0] = 1


def test_the_middle_of_the_lowest_left_cell() -> None:
    """Row 0 is lowest: half a cell to the right of and above the origin."""
    assert cells_to_metres(np.array([[0.5, 0.5]]), 0.1, Pose2(2.0, -1.0)) == pytest.approx(np.array([[2.05, -0.95]]))


def test_rows_go_up_and_columns_right_and_yaw_turns_about_the_corner() -> None:
    """Ten rows up are one metre in y; with a yaw of 90 degrees they are one metre to the left."""
    cells = np.array([[10.0, 0.0], [0.0, 20.0]])

    assert cells_to_metres(cells, 0.1, Pose2()) == pytest.approx(np.array([[0, 1], [2, 0]]))
    turned = cells_to_metres(cells, 0.1, Pose2(5, 5, math.pi / 2))
    assert turned == pytest.approx(np.array([[4, 5], [5, 7]]))


def test_there_and_back() -> None:
    """metres_to_cells is the inverse, yaw and all."""
    cells = np.array([[3.25, 4.5], [-7.0, 120.125]])
    pose = Pose2(-12.2, 4.1, 2.2)

    assert metres_to_cells(cells_to_metres(cells, 0.05, pose), 0.05, pose) == pytest.approx(cells)


def test_labels_are_of_their_maps_type():
    """What numpy makes of them are maps of bytes, not of integers eight times as wide."""
    walls = np.array([True, False])

    assert np.where(walls, Label.OCCUPIED, Label.FREE).dtype == np.uint8
    assert np.full(2, Label.UNKNOWN).dtype == np.uint8
    assert Label(np.uint8(2)) is Label.OCCUPIED
