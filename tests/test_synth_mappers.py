from __future__ import annotations

import math

import numpy as np
import pytest

from fidmap.grid import cells_to_metres, trinarize
from fidmap.model import Label
from fidmap.synth.laser import Laser, Scans, scan
from fidmap.synth.mappers import MAPPERS, Mapper, count_probability, draw_map, hole_profile
from test_synth_laser import EXACT, room


def beams(*ranges: float, bearings: tuple[float, ...] = (0.0,)) -> Scans:
    """Scans from (0.05, 0.05) towards +x, one per range."""
    count = len(ranges)
    return Scans(
        np.tile([0.05, 0.05, 0.0], (count, 1)),
        np.array(bearings),
        np.array(ranges, np.float32).reshape(count, -1),
        np.full((count, 1), -1, np.int16),
        30.0,
    )


def row_of(grid, y_m: float = 0.05):
    """The row of cells at a height, from x = 0."""
    row = math.floor((y_m - grid.origin.y_m) / grid.resolution_m)
    return grid.occupancy[row, round(-grid.origin.x_m / grid.resolution_m) :]


def test_one_beam_clears_its_cells_and_fills_the_last():
    """Cells of 0.1 m: a beam from the middle of cell 0 to that of cell 4 passes 0 to 3 and hits 4."""
    scans = beams(0.4)

    grid = draw_map(scans, scans.poses, Mapper("hits", min_visits=1), 0.1, margin_m=0.2)

    assert row_of(grid).tolist()[:5] == [0, 0, 0, 0, 1]
    assert np.isnan(row_of(grid)[5:]).all()
    assert np.nansum(grid.occupancy == 0) == 4


def test_beams_without_return_and_beyond_reach():
    """NaN is ignored; inf clears cells up to the usable range and hits nothing."""
    scans = beams(math.nan, math.inf)

    grid = draw_map(scans, scans.poses, Mapper("hits", min_visits=1, usable_m=0.3), 0.1, margin_m=0.2)

    assert np.nansum(grid.occupancy == 0) == 3
    assert not np.nansum(grid.occupancy == 1)


def test_hit_counting():
    """One hit of ten visits is Karto's limit; nine passes more put it below; too few visits are unknown."""
    mapper = Mapper("hits", share=0.1, min_visits=2)

    p = count_probability(np.float32([1, 1, 5, 1]), np.float32([10, 20, 5, 1]), mapper)

    assert p[:3].tolist() == pytest.approx([0.5, 0.25, 1.0])
    assert np.isnan(p[3])


def test_hits_against_misses_in_a_map():
    """Nine beams through a cell and one that ends in it: occupied at a share of 0.1, free at 0.2."""
    scans = beams(*[0.4] * 9, 0.2)

    labels = [row_of(draw_map(scans, scans.poses, Mapper("hits", share=s), 0.1))[2] for s in (0.1, 0.2)]

    assert labels == [1.0, 0.0]


def test_log_odds_add_up_and_are_clamped():
    """Three hits of 0.85 are p = 1 / (1 + exp(-2.55)); nine are clamped at 3.5; one miss is -0.4."""
    raw = Mapper("log_odds", output="raw")

    three, nine = (row_of(draw_map(beams(*[0.4] * n), beams(*[0.4] * n).poses, raw, 0.1)) for n in (3, 9))

    assert three[4] == pytest.approx(1 / (1 + math.exp(-2.55)))
    assert nine[4] == pytest.approx(1 / (1 + math.exp(-3.5)))
    assert three[1] == pytest.approx(1 / (1 + math.exp(1.2)))


def test_the_hole_profile_rises_to_the_hit_and_falls_behind_it():
    """Free 0.15 m before the hit, half-way at 0.075 m, and symmetric."""
    along = np.array([0.8, 0.85, 0.925, 1.0, 1.075, 1.15])

    assert hole_profile(along, np.ones(6), 0.3) == pytest.approx(np.array([0, 0, 0.5, 1, 0.5, 0]))


def test_coreslam_erases_behind_a_wall():
    """Its beams write 'free' behind the hit: that is how it erases the other half of a thin pair."""
    scans = beams(*[1.0] * 30)

    grid = draw_map(scans, scans.poses, Mapper("coreslam", hole_m=0.3, output="raw"), 0.05)

    wall = round(1.05 / 0.05)
    assert row_of(grid)[wall - 1 : wall + 1].max() > 0.65
    assert row_of(grid)[wall + 2] < 0.4
    assert row_of(grid)[wall + 6] == 0.5


def test_exact_poses_put_walls_where_they_belong():
    """Each occupied cell of a room has a surface within its own half diagonal, through `cells_to_metres`."""
    poses = np.array([[x, y, yaw] for x in (1.0, 2.0, 3.0) for y in (1.0, 3.0) for yaw in (0.0, 2.0, 4.0)])
    scans = scan(room(), poses, EXACT, np.random.default_rng(0))

    grid = draw_map(scans, poses, MAPPERS["hits"], 0.05)

    cells = np.argwhere(trinarize(grid).labels == Label.OCCUPIED) + 0.5
    x, y = cells_to_metres(cells, 0.05, grid.origin).T
    to_wall = np.minimum.reduce([np.abs(x), np.abs(x - 4), np.abs(y), np.abs(y - 4)])
    to_barrel = np.abs(np.hypot(x - 4, y - 2) - 0.3)
    assert len(cells) > 4 * 70
    assert np.minimum(to_wall, to_barrel).max() <= 0.05 / math.sqrt(2) + 1e-6


@pytest.mark.parametrize("name", sorted(MAPPERS))
def test_every_manner_draws_the_room(name):
    """Free inside, something occupied, and the three values or probabilities that its output promises."""
    poses = np.array([[2.0, 2.0, yaw] for yaw in np.linspace(0, 6, 24)])
    scans = scan(room(), poses, Laser(), np.random.default_rng(0))

    grid = draw_map(scans, poses, MAPPERS[name], 0.05)

    labels = trinarize(grid).labels
    values = grid.occupancy[~np.isnan(grid.occupancy)]
    middle = math.floor((2.5 - grid.origin.y_m) / 0.05), math.floor((2.0 - grid.origin.x_m) / 0.05)
    assert labels[middle] == Label.FREE
    assert 200 < (labels == Label.OCCUPIED).sum() < 2000
    assert ((values >= 0) & (values <= 1)).all()
    assert (len(np.unique(values)) == 2) == (MAPPERS[name].output != "raw")
    assert (labels == Label.UNKNOWN).any() == (MAPPERS[name].output != "binary")


def test_a_small_map_gets_the_rim_asked_for():
    """At least `min_cells` either way, the origin moved along so that nothing shifts."""
    scans = beams(0.4)

    grid = draw_map(scans, scans.poses, Mapper("hits", min_visits=1), 0.1, min_cells=101)

    assert grid.occupancy.shape == (101, 101)
    assert row_of(grid).tolist()[:5] == [0, 0, 0, 0, 1]


def test_maps_that_cannot_be_drawn():
    """Poses of another run, nothing measured, a map too large."""
    scans = beams(0.4)
    with pytest.raises(ValueError, match="1 scans need as many poses, not 2"):
        draw_map(scans, np.zeros((2, 3)), Mapper(), 0.1)
    with pytest.raises(ValueError, match="nothing to map"):
        draw_map(beams(math.nan), scans.poses, Mapper(), 0.1)
    with pytest.raises(ValueError, match="too large; use a coarser resolution"):
        draw_map(scans, scans.poses, Mapper(), 1e-5)
