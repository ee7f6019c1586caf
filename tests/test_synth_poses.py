from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from fidmap.model import Pose2
from fidmap.synth.maze import random_maze
from fidmap.synth.poses import PoseNoise, estimated_poses, moved_points, tier_noise
from fidmap.synth.trajectory import TURN_PER_SCAN, tour, trajectory

LINE = np.column_stack([np.linspace(0, 20, 400), np.zeros(400), np.zeros(400)])


def test_exact_poses_are_the_true_ones_in_the_maps_frame():
    """A quarter turn and a shift: (x, 0) becomes (1, 2 + x)."""
    frame = Pose2(1.0, 2.0, math.pi / 2)

    poses = estimated_poses(LINE, PoseNoise(), np.random.default_rng(0), frame)

    assert poses[:, 0] == pytest.approx(1.0)
    assert poses[:, 1] == pytest.approx(2.0 + LINE[:, 0])
    assert poses[:, 2] == pytest.approx(math.pi / 2)
    assert moved_points(frame, np.array([[3.0, 0.0]])).tolist() == [pytest.approx([1.0, 5.0])]


def test_jitter_is_independent_and_of_the_size_asked_for():
    """The deviation per axis, and no memory from scan to scan."""
    error = estimated_poses(LINE, PoseNoise(jitter_m=0.05), np.random.default_rng(1))[:, :2] - LINE[:, :2]

    assert error.std(0) == pytest.approx([0.05, 0.05], rel=0.15)
    assert abs(np.corrcoef(error[1:, 0], error[:-1, 0])[0, 1]) < 0.15


def test_sway_is_slow_and_of_the_size_asked_for():
    """Over many runs its deviation is the one asked for; neighbours are nearly equal."""
    runs = [
        estimated_poses(LINE, PoseNoise(sway_m=0.03, memory=20), np.random.default_rng(seed))[:, 0] - LINE[:, 0]
        for seed in range(30)
    ]

    assert np.std(runs) == pytest.approx(0.03, rel=0.15)
    assert np.abs(np.diff(runs, axis=1)).max() < 0.02


def test_a_false_loop_closure_moves_a_stretch_rigidly():
    """A fifth of the scans, half a metre off; the others stay."""
    noise = PoseNoise(shifts=1, shift_m=0.5, shift_share=0.2)

    way = np.hypot(*(estimated_poses(LINE, noise, np.random.default_rng(2)) - LINE)[:, :2].T)

    assert (way > 0).sum() == 80
    assert way[way > 0] == pytest.approx(0.5)


def test_drift_grows_and_jumps_stay():
    """Both start from the true pose and never come back."""
    drifted = estimated_poses(LINE, PoseNoise(drift_yaw=0.02), np.random.default_rng(3))
    jumped = estimated_poses(LINE, PoseNoise(jumps=1, jump_m=1.0), np.random.default_rng(4))

    assert drifted[0].tolist() == [0, 0, 0]
    assert abs(drifted[-1, 2]) > 0
    assert len(np.unique(np.round((jumped - LINE)[:, 0], 6))) == 2


def test_tiers_are_ordered_by_their_errors():
    """Exact has none; noisy poses sway more than clean ones; only broken ones have false loop closures."""
    rng = np.random.default_rng(5)

    assert tier_noise("exact", rng) == PoseNoise()
    assert tier_noise("clean", rng).jitter_m < tier_noise("noisy", rng).jitter_m
    assert tier_noise("noisy", rng).shifts == 0
    assert tier_noise("broken", rng).shifts > 0


def test_a_tour_visits_what_it_should_over_open_sides():
    """All pallets, or the share asked for (a way may cross a few more); each step is one open side."""
    maze = random_maze(np.random.default_rng(6), (6, 8))

    whole, half = (tour(maze, np.random.default_rng(6), explored) for explored in (1.0, 0.5))

    assert len(set(whole)) == 48
    assert 24 <= len(set(half)) < 36
    assert all(b in maze.neighbours(a) for a, b in pairwise(whole))


def test_a_trajectory_keeps_its_distances():
    """Steps of the spacing or less, turns of 25 degrees or less, never nearer to a wall than 0.3 m."""
    maze = random_maze(np.random.default_rng(7), (4, 5), openness=0.0)

    poses = trajectory(maze, np.random.default_rng(7), spacing_m=0.2)

    step = np.diff(poses, axis=0)
    assert np.hypot(step[:, 0], step[:, 1]).max() < 0.21
    assert np.abs(step[:, 2]).max() <= TURN_PER_SCAN + 1e-9
    inside = np.mod(poses[:, :2] / 1.2, 1) * 1.2
    assert not (np.minimum(inside, 1.2 - inside) < 0.3).all(axis=1).any()


def test_half_the_faults_are_half_as_far_off():
    """With the same random numbers each pose lies half as far from the truth; as many faults, in the same scans."""
    noise = PoseNoise(jitter_m=0.02, jitter_yaw=0.01, sway_m=0.03, sway_yaw=0.01, shifts=1, shift_m=0.5)

    whole, half = (estimated_poses(LINE, n, np.random.default_rng(6)) - LINE for n in (noise, noise.times(0.5)))

    assert half == pytest.approx(whole / 2)
    assert noise.times(0.5).shifts == 1
    assert noise.times(0.5).memory == noise.memory
