"""The maps that come with fidmap: one arena, mapped well, badly, and brokenly."""

from __future__ import annotations

import math

import numpy as np

from fidmap.model import Grid, Pose2
from fidmap.synth.arena import ArenaSpec, SynthArena, make_arena
from fidmap.synth.laser import Laser, scan
from fidmap.synth.mappers import MAPPERS, draw_map
from fidmap.synth.poses import PoseNoise, estimated_poses
from fidmap.synth.trajectory import trajectory

ARENA_SEED = 7
RESOLUTION_M = 0.05
FRAME = Pose2(1.0, 0.8, math.radians(7))  # a robot never starts on the arena's axes

NOISES: dict[str, PoseNoise] = {
    "good": PoseNoise(0.003, 0.0005, 0.005, 0.001),
    "noisy": PoseNoise(0.02, 0.004, 0.045, 0.012, drift_yaw=0.003, drift_scale=0.01),
    "broken": PoseNoise(0.008, 0.002, 0.015, 0.004, shifts=1, shift_m=0.75, shift_yaw=0.12, shift_share=0.22),
}
EXPLORED = {"good": 1.0, "noisy": 1.0, "broken": 0.75}


def demo_arena() -> SynthArena:
    """RoboCup-like: 8 x 6 pallets, five pairs on walls and two over a void, short and long ways."""
    spec = ArenaSpec(pairs=5, void_pairs=2, wall_m=0.02, openness=0.12, name="demo")
    return make_arena(np.random.default_rng(ARENA_SEED), spec)


def demo_maps() -> tuple[SynthArena, list[tuple[str, Grid]]]:
    """The arena and its maps 'good', 'noisy' and 'broken' (one part displaced, one not explored)."""
    arena = demo_arena()
    maps = []
    for seed, (name, noise) in enumerate(NOISES.items()):
        rng = np.random.default_rng([ARENA_SEED, seed])
        poses = trajectory(arena.maze, rng, EXPLORED[name])
        scans = scan(arena, poses, Laser(step=math.radians(0.5)), rng)
        believed = estimated_poses(poses, noise, rng, FRAME)
        maps.append((name, draw_map(scans, believed, MAPPERS["hits"], RESOLUTION_M, name=name)))
    return arena, maps
