"""Maps and arenas written and read back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fidmap.arena import read_arena
from fidmap.arena.write import write_arena
from fidmap.grid import trinarize
from fidmap.maps import read_map
from fidmap.maps.write import write_map
from fidmap.model import Arena, FiducialPart, Grid, Group, OutputError, Pose2


@pytest.mark.parametrize("thresholds", [(0.196, 0.65), (0.25, 0.65), (0.1, 0.9)])
def test_a_written_map_has_the_same_labels_and_nearly_the_same_p(tmp_path, thresholds):
    """Whatever the thresholds were; p to half a grey where the label's band of greys holds it."""
    p = np.linspace(0, 1, 1200, dtype=np.float32).reshape(30, 40)
    p[3:5] = np.nan
    grid = Grid(p, 0.05, Pose2(-1.5, 2.25, 0.1), *thresholds)

    again = read_map(write_map(tmp_path, "m", grid))

    assert np.array_equal(trinarize(again).labels, trinarize(grid).labels)
    assert (again.resolution_m, again.origin) == (grid.resolution_m, grid.origin)
    if thresholds == (0.196, 0.65):
        assert np.nanmax(np.abs(again.occupancy - grid.occupancy)[np.isfinite(grid.occupancy)]) <= 1.01 / 255


def test_only_the_two_files_are_left(tmp_path):
    """What is written beside its place is moved there."""
    write_map(tmp_path / "new", "m", Grid(np.zeros((3, 4), np.float32), 0.05))

    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == ["m.pgm", "m.yaml"]


def test_a_place_that_cannot_be_written(tmp_path):
    """One sentence that names it."""
    (tmp_path / "taken").write_text("")

    with pytest.raises(OutputError, match=r"taken/m\.pgm: cannot be written \(.*\); choose another place"):
        write_map(tmp_path / "taken", "m", Grid(np.zeros((3, 4), np.float32), 0.05))


def test_a_written_arena_is_the_same_arena(tmp_path):
    """Every field, with names that YAML would take for something else."""
    parts = (
        FiducialPart("1A", 1.0, 2.0, math.pi / 2, math.pi, 0.005),
        FiducialPart("no", 1.5, 2.0, -math.pi / 2, math.radians(170), z_m=0.4),
        FiducialPart("7", 3.0, 4.0),
    )
    groups = (Group("1", ("1A", "no"), None, 7.25, 0.1), Group("room: a", ("1A", "no", "7"), "room"))
    arena = Arena("on: #1", 0.3, parts, groups, "map", 1.2)
    write_arena(tmp_path / "arena.yaml", arena)

    again = read_arena(tmp_path / "arena.yaml")

    assert (again.name, again.radius_m, again.frame, again.pallet_m) == ("on: #1", 0.3, "map", 1.2)
    for old, new in zip(parts, again.parts, strict=True):
        assert (new.id, new.x_m, new.y_m, new.sigma_m, new.z_m) == (old.id, old.x_m, old.y_m, old.sigma_m, old.z_m)
        assert (new.facing, new.opening) == pytest.approx((old.facing, old.opening), abs=1e-6)
    assert again.groups == groups


def test_a_distance_that_follows_from_the_positions_is_left_out(tmp_path):
    """And a way that nobody can walk is long."""
    parts = (FiducialPart("1A", 0.0, 0.0, 0.0, math.pi), FiducialPart("1B", 0.3, 0.4, math.pi, math.pi))
    write_arena(tmp_path / "a.yaml", Arena("a", 0.3, parts, (Group("1", ("1A", "1B"), None, math.inf, 0.5),)))

    (group,) = read_arena(tmp_path / "a.yaml").groups

    assert (group.distance_m, group.named_class) == (None, "long")
