"""Imperfect SLAM without running one: the true poses with the errors that programs leave."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Literal

import numpy as np
from scipy import ndimage

from fidmap.model import FloatArray, Pose2

Tier = Literal["exact", "clean", "noisy", "broken", "large", "office", "field"]


@dataclass(frozen=True)
class PoseNoise:
    """What is wrong with the estimated poses.

    jitter_m, jitter_yaw: independent error of each scan, per axis.
    sway_m, sway_yaw: slow error that comes and goes, with a memory of `memory` scans (scan matching).
    drift_yaw: random walk of the heading, deviation after one metre; drift_scale: of the way's length.
    jumps: sudden lasting errors of jump_m and jump_yaw. shifts: false loop closures, each moves a submap of
    shift_share of the scans by shift_m and shift_yaw.
    """

    jitter_m: float = 0.0
    jitter_yaw: float = 0.0
    sway_m: float = 0.0
    sway_yaw: float = 0.0
    memory: float = 60.0
    drift_yaw: float = 0.0
    drift_scale: float = 0.0
    jumps: int = 0
    jump_m: float = 0.0
    jump_yaw: float = 0.0
    shifts: int = 0
    shift_m: float = 0.0
    shift_yaw: float = 0.0
    shift_share: float = 0.2

    def times(self, factor: float) -> PoseNoise:
        """The same faults, as many of them, with every length and angle so many times as large."""
        sized = [f.name for f in fields(self) if f.name.endswith(("_m", "_yaw", "_scale"))]
        return replace(self, **{name: factor * getattr(self, name) for name in sized})


def tier_noise(tier: Tier, rng: np.random.Generator) -> PoseNoise:
    """Pose errors drawn at random within a tier; 'large' arenas are mapped as well as 'clean' ones."""
    if tier == "exact":
        return PoseNoise()
    if tier in {"clean", "large"}:
        return PoseNoise(0.003, 0.0005, rng.uniform(0.002, 0.012), rng.uniform(0.0005, 0.002))
    noisy = PoseNoise(
        jitter_m=rng.uniform(0.004, 0.02),
        jitter_yaw=rng.uniform(0.001, 0.006),
        sway_m=rng.uniform(0.01, 0.035),
        sway_yaw=rng.uniform(0.002, 0.008),
        drift_yaw=rng.uniform(0.0, 0.004),
        drift_scale=rng.uniform(0.0, 0.01),
    )
    if tier == "noisy":
        return noisy
    return PoseNoise(
        noisy.jitter_m, noisy.jitter_yaw, noisy.sway_m, noisy.sway_yaw, noisy.memory,
        drift_yaw=rng.uniform(0.0, 0.005), drift_scale=rng.uniform(0.0, 0.01),
        jumps=int(rng.integers(0, 3)), jump_m=0.15, jump_yaw=0.03,
        shifts=int(rng.integers(1, 3)), shift_m=rng.uniform(0.2, 0.9), shift_yaw=rng.uniform(0.0, 0.2),
        shift_share=rng.uniform(0.1, 0.3),
    )  # fmt: skip


def estimated_poses(
    poses: FloatArray, noise: PoseNoise, rng: np.random.Generator, frame: Pose2 | None = None
) -> FloatArray:
    """The poses as a SLAM program with these faults would give them, in the map's frame.

    Args:
        poses: (M, 3) true poses in the arena's frame.
        noise: the faults.
        rng: the only source of randomness.
        frame: the arena's frame seen from the map's (T_map_arena); None: the same.

    Returns:
        (M, 3) x, y, yaw in the map's frame.
    """
    estimate = _drifted(poses, noise, rng)
    for _ in range(noise.shifts):
        estimate = _submap_shifted(estimate, noise, rng)
    count = len(poses)
    sway = _slow(rng, count, noise.memory) * [noise.sway_m, noise.sway_m, noise.sway_yaw]
    jitter = rng.standard_normal((count, 3)) * [noise.jitter_m, noise.jitter_m, noise.jitter_yaw]
    return moved(frame or Pose2(), estimate + sway + jitter)


def _drifted(poses: FloatArray, noise: PoseNoise, rng: np.random.Generator) -> FloatArray:
    """Dead reckoning: steps whose heading has walked away, with jumps; starts at the true pose."""
    step = np.diff(poses, axis=0)
    way = np.hypot(step[:, 0], step[:, 1])
    walk = noise.drift_yaw * np.sqrt(way) * rng.standard_normal(len(way))
    scale = 1 + noise.drift_scale * rng.standard_normal()
    leap = np.zeros((len(way), 2))
    for at in rng.integers(len(way), size=noise.jumps) if len(way) else []:
        leap[at] += noise.jump_m * rng.standard_normal(2)
        walk[at] += noise.jump_yaw * rng.standard_normal()
    off = np.cumsum(walk)
    c, s = np.cos(off), np.sin(off)
    moved_step = scale * np.stack([c * step[:, 0] - s * step[:, 1], s * step[:, 0] + c * step[:, 1]], axis=1)
    xy = poses[:1, :2] + np.concatenate([np.zeros((1, 2)), np.cumsum(moved_step + leap, axis=0)])
    return np.column_stack([xy, poses[:, 2] + np.concatenate([[0.0], off])])


def _submap_shifted(poses: FloatArray, noise: PoseNoise, rng: np.random.Generator) -> FloatArray:
    """A stretch of the trajectory moved rigidly about its middle, as a false loop closure leaves it."""
    length = max(1, round(noise.shift_share * len(poses)))
    begin = int(rng.integers(len(poses) - length + 1))
    part = poses[begin : begin + length]
    turn = rng.choice([-1.0, 1.0]) * noise.shift_yaw
    way = rng.uniform(0, 2 * math.pi)
    pivot = part[:, :2].mean(0)
    c, s = math.cos(turn), math.sin(turn)
    xy = (part[:, :2] - pivot) @ np.array([[c, s], [-s, c]]) + pivot
    xy = xy + noise.shift_m * np.array([math.cos(way), math.sin(way)])
    result = poses.copy()
    result[begin : begin + length] = np.column_stack([xy, part[:, 2] + turn])
    return result


def _slow(rng: np.random.Generator, count: int, memory: float) -> FloatArray:
    """(count, 3) smooth noise of unit deviation: white noise through a Gaussian of `memory` / 2 scans."""
    white = rng.standard_normal((count, 3))
    sigma = max(memory / 2, 1e-3)
    smooth: FloatArray = ndimage.gaussian_filter1d(white, sigma, axis=0, mode="reflect")
    # A Gaussian filter leaves 1 / (2 sigma sqrt(pi)) of white noise's variance.
    return smooth * math.sqrt(2 * sigma * math.sqrt(math.pi))


def moved(frame: Pose2, poses: FloatArray) -> FloatArray:
    """Poses (M, 3) seen from the frame in which `frame` is the pose of their own frame's origin."""
    c, s = math.cos(frame.yaw), math.sin(frame.yaw)
    x, y, yaw = poses[:, 0], poses[:, 1], poses[:, 2]
    return np.stack([frame.x_m + c * x - s * y, frame.y_m + s * x + c * y, yaw + frame.yaw], axis=1)


def moved_points(frame: Pose2, points_xy: FloatArray) -> FloatArray:
    """Points (N, 2) seen from the frame in which `frame` is the pose of their own frame's origin."""
    return moved(frame, np.column_stack([points_xy, np.zeros(len(points_xy))]))[:, :2]
