from __future__ import annotations

import math

import numpy as np
import pytest

from fidmap.model import Arena, FiducialPart
from fidmap.synth.arena import SynthArena, box_segments
from fidmap.synth.laser import Laser, cast, scan
from fidmap.synth.maze import PalletMaze

NO_ARCS = np.zeros((0, 5))
NO_WALLS = np.zeros((0, 4))
EXACT = Laser(noise_m=0, mixed=0, dropout=0)


def room(side_m: float = 4.0) -> SynthArena:
    """A square room with half a barrel of radius 0.3 on the middle of its east wall."""
    part = FiducialPart("1", side_m, side_m / 2, math.pi, math.pi)
    walls = box_segments(np.array([[0.0, 0.0, side_m, side_m]]))
    maze = PalletMaze(np.zeros((1, 0), bool), np.zeros((0, 1), bool), np.zeros((1, 1), bool), side_m)
    arcs = np.array([[side_m, side_m / 2, 0.3, math.pi, math.pi]])
    return SynthArena(Arena("room", 0.3, (part,)), maze, walls, arcs, np.array([0]), 0.02)


def test_range_to_a_wall():
    """The wall x = 2 is 2 / cos(angle) away, and out of sight above its end at 45 degrees."""
    wall = np.array([[2.0, -2.0, 2.0, 2.0]])
    fan = np.array([[0.0, 0.0, math.radians(-60), math.radians(30)]])

    ranges, hits = cast(wall, NO_ARCS, fan, 5)

    slant = 2 / math.cos(math.radians(30))
    assert ranges[0] == pytest.approx([math.inf, slant, 2.0, slant, math.inf])
    assert hits[0].tolist() == [-1, 0, 0, 0, -1]


def test_range_to_a_circle():
    """A circle of 1 m at 3 m: 2 m straight on, by Pythagoras where a beam passes its centre at 0.6 m."""
    fan = np.array([[0.0, 0.0, 0.0, math.asin(0.2)]])

    ranges, hits = cast(NO_WALLS, np.array([[3.0, 0.0, 1.0, 0.0, 2 * math.pi]]), fan, 3)

    assert ranges[0] == pytest.approx([2.0, 3 * math.cos(math.asin(0.2)) - 0.8, math.inf])
    assert hits[0].tolist() == [0, 0, -1]


def test_a_half_circle_is_hit_on_its_own_side_only():
    """From the open side the beam passes the missing half and meets the other one from inside."""
    half = np.array([[3.0, 0.0, 1.0, math.pi, math.pi]])  # shows its bulge to the origin
    fans = np.array([[0.0, 0.0, 0.0, 0.1], [6.0, 0.0, math.pi, 0.1]])

    ranges, _ = cast(NO_WALLS, half, fans, 1)

    assert ranges[:, 0] == pytest.approx([2.0, 4.0])


def test_a_circle_around_the_sensor_is_seen_everywhere():
    """A curved wall of 2 m about the robot is 2 m away in each of 360 directions."""
    fan = np.array([[1.0, 1.0, 2.5, math.radians(1)]])

    ranges, _ = cast(NO_WALLS, np.array([[1.0, 1.0, 2.0, 0.0, 2 * math.pi]]), fan, 359)

    assert ranges == pytest.approx(np.full((1, 359), 2.0))


def test_the_nearest_surface_wins_and_far_ones_are_out_of_reach():
    """Two walls one behind the other, then none within the laser's reach."""
    walls = np.array([[3.0, -1.0, 3.0, 1.0], [2.0, -1.0, 2.0, 1.0]])
    fan = np.array([[0.0, 0.0, 0.0, 0.1]])

    assert cast(walls, NO_ARCS, fan, 1)[1].tolist() == [[1]]
    assert cast(walls, NO_ARCS, fan, 1, max_range_m=1.9)[0].tolist() == [[math.inf]]


def test_ranges_agree_with_brute_force():
    """Random segments from random places, checked beam by beam against the intersection formula."""
    rng = np.random.default_rng(4)
    walls, fans = rng.uniform(-3, 3, (30, 4)), rng.uniform(-3, 3, (8, 4))
    fans[:, 3] = 0.05

    ranges, _ = cast(walls, NO_ARCS, fans, 100)

    angle = fans[:, 2:3] + 0.05 * np.arange(100)
    ray = np.stack([np.cos(angle), np.sin(angle)], -1)[:, :, None]
    a, along = walls[:, :2] - fans[:, None, None, :2], walls[:, 2:] - walls[:, :2]
    cross = ray[..., 0] * along[:, 1] - ray[..., 1] * along[:, 0]
    t = (a[..., 0] * along[:, 1] - a[..., 1] * along[:, 0]) / cross
    u = (a[..., 0] * ray[..., 1] - a[..., 1] * ray[..., 0]) / cross
    expected = np.where((t > 0) & (u >= 0) & (u <= 1), t, math.inf).min(-1)
    assert ranges == pytest.approx(expected)


def test_a_scan_knows_what_it_hit():
    """From the middle of the room the barrel is 1.7 m ahead and fills 2 asin(0.3 / 2)."""
    scans = scan(room(), np.array([[2.0, 2.0, 0.0]]), EXACT, np.random.default_rng(0))

    ahead = len(scans.bearings) // 2
    assert scans.ranges[0, ahead] == pytest.approx(1.7)
    assert scans.ranges[0, ahead + 360] == pytest.approx(2.0)  # 90 degrees to the left
    assert (scans.parts[0] == 0).sum() == 1 + 2 * int(math.degrees(math.asin(0.15)) / 0.25)


def test_noise_mixed_beams_and_dropouts():
    """Deviation as asked for, missing beams as many as asked for, mixed ones between the two surfaces."""
    laser = Laser(noise_m=0.02, mixed=1.0, dropout=0.1)
    poses = np.tile([2.0, 1.0, 0.3], (60, 1))

    noisy = scan(room(), poses, laser, np.random.default_rng(1)).ranges
    exact = scan(room(), poses, EXACT, np.random.default_rng(1)).ranges

    error = noisy - exact
    assert np.isnan(noisy).mean() == pytest.approx(0.1, abs=0.01)
    assert np.nanstd(error[np.abs(error) < 0.1]) == pytest.approx(0.02, rel=0.05)
    assert (np.abs(error) > 0.15).any()


def test_a_tilted_sensor_sees_the_floor():
    """Far surfaces are replaced by the floor in front of them, and the floor is no barrel."""
    poses = np.tile([1.0, 10.0, 0.0], (50, 1))
    tilted = Laser(noise_m=0, mixed=0, dropout=0, tilt=math.radians(5))

    flat, swaying = (scan(room(20.0), poses, laser, np.random.default_rng(2)) for laser in (EXACT, tilted))

    assert (swaying.ranges < flat.ranges - 1).any()
    assert (swaying.parts == 0).sum() < (flat.parts == 0).sum()


def test_skew_turns_the_sweep_with_the_robot():
    """A robot that turns left has its first beams from headings farther right; the middle one stays."""
    poses = np.array([[2.0, 2.0, yaw] for yaw in (0.0, 0.2, 0.4)])
    skewed = Laser(noise_m=0, mixed=0, dropout=0, skew=0.5)

    straight, turned = (scan(room(), poses, laser, np.random.default_rng(3)) for laser in (EXACT, skewed))

    early = cast(room().walls, room().arcs, np.array([[2.0, 2.0, 0.2 - math.radians(135) - 4 / 9 * 0.1, 0.1]]), 1)
    assert turned.ranges[1, 0] == pytest.approx(early[0][0, 0])
    assert turned.ranges[1, 0] != pytest.approx(straight.ranges[1, 0])
    assert turned.ranges[1, 540] == pytest.approx(straight.ranges[1, 540])
