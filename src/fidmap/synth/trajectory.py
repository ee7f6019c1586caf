"""Where the robot drives: a tour through the open pallets of a maze, smoothed, as true poses of scans."""

from __future__ import annotations

import math

import numpy as np

from fidmap.model import FloatArray
from fidmap.synth.arena import SynthArena
from fidmap.synth.maze import Pallet, PalletMaze, shortest_way, walking_distances

TURN_PER_SCAN = math.radians(25)
LOOK_IN = 0.24  # pallets; corner cutting leaves three quarters of it


def tour(maze: PalletMaze, rng: np.random.Generator, explored: float = 1.0) -> list[Pallet]:
    """Pallets in driving order: always on to the nearest one not yet visited.

    Args:
        maze: the pallets.
        rng: chooses where to start.
        explored: share of the reachable pallets that is visited, those nearest to the start; 0 to 1.
    """
    free = np.argwhere(~maze.void)
    first = free[rng.integers(len(free))]
    here: Pallet = (int(first[0]), int(first[1]))
    distances = walking_distances(maze, here)
    reachable = distances >= 0
    nearest = np.argsort(np.where(reachable, distances, distances.size), axis=None, kind="stable")
    wanted = np.zeros(maze.shape, bool)
    wanted.flat[nearest[: round(explored * reachable.sum())]] = True
    way = [here]
    wanted[here] = False
    while step := shortest_way(maze, here, wanted):
        way += step
        here = step[-1]
        for pallet in step:
            wanted[pallet] = False
    return way


def trajectory(
    maze: PalletMaze, rng: np.random.Generator, explored: float = 1.0, spacing_m: float = 0.25
) -> FloatArray:
    """True poses of the scans along a smoothed tour.

    Args:
        maze: the pallets.
        rng: start and how far off the pallets' centres the robot drives.
        explored: share of the pallets visited.
        spacing_m: way between scans; turns on the spot are scanned every 25 degrees.

    Returns:
        (M, 3) x, y, yaw in the arena's frame.
    """
    pallets = np.array(tour(maze, rng, explored), float)
    return poses_along((_looking_around(pallets)[:, ::-1] + 0.5) * maze.pallet_m, rng, spacing_m)


def drive(arena: SynthArena, rng: np.random.Generator, explored: float = 1.0, spacing_m: float = 0.25) -> FloatArray:
    """True poses (M, 3) of the scans: along the arena's own way, as far as explored, or through its maze."""
    if arena.way is None:
        return trajectory(arena.maze, rng, explored, spacing_m)
    return poses_along(arena.way[: max(1, round(explored * len(arena.way)))], rng, spacing_m)


def poses_along(points: FloatArray, rng: np.random.Generator, spacing_m: float) -> FloatArray:
    """Poses (M, 3) of scans every `spacing_m` along a smoothed polyline (N, 2), and in turns."""
    points = points + np.clip(0.04 * rng.standard_normal(points.shape), -0.06, 0.06)
    for _ in range(2):
        points = _corners_cut(points)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.linspace(0, along[-1], max(2, math.ceil(along[-1] / spacing_m) + 1))
    xy = np.stack([np.interp(at, along, points[:, k]) for k in range(2)], axis=1)
    if along[-1] == 0:
        return np.column_stack([xy[:1], [0.0]])
    ahead = np.gradient(xy, axis=0)
    yaw = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))
    return _turns_filled(np.column_stack([xy, yaw]))


def _looking_around(pallets: FloatArray) -> FloatArray:
    """The pallets (N, 2) of a tour, at dead ends with a point farther in.

    From a pallet's centre only 118 of 180 degrees of a half barrel on its wall are in sight; people drive a
    robot a little farther before it turns round.
    """
    before, here, after = pallets[:-2], pallets[1:-1], pallets[2:]
    ends = (before == after).all(1)
    farther = here + LOOK_IN * (here - before)
    blocks = [pallets[:1]]
    for place, inside, is_end in zip(here, farther, ends, strict=True):
        blocks.append(np.array([place, inside, place]) if is_end else place[None])
    return np.concatenate([*blocks, pallets[1:][-1:]])


def _corners_cut(points: FloatArray) -> FloatArray:
    """One round of Chaikin's corner cutting on a polyline (N, 2); its ends stay."""
    a, b = points[:-1], points[1:]
    cut = np.stack([0.75 * a + 0.25 * b, 0.25 * a + 0.75 * b], axis=1).reshape(-1, 2)
    return np.concatenate([points[:1], cut, points[-1:]])


def _turns_filled(poses: FloatArray) -> FloatArray:
    """Poses between those where the heading turns by more than one scan's share."""
    parts = np.ceil(np.abs(np.diff(poses[:, 2])) / TURN_PER_SCAN).astype(np.int64)
    parts = np.append(np.maximum(parts, 1), 1)
    index = np.repeat(np.arange(len(poses)), parts)
    share = (np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)) / np.repeat(parts, parts)
    step = np.diff(poses, axis=0, append=poses[-1:])
    return poses[index] + share[:, None] * step[index]
