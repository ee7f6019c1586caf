"""A referee's evening: many teams map one arena; what the speed of a whole evening is measured with."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fidmap.model import Grid, Pose2
from fidmap.synth.arena import ArenaSpec, SynthArena, make_arena
from fidmap.synth.laser import Laser, scan
from fidmap.synth.mappers import MAPPERS, draw_map
from fidmap.synth.poses import Tier, estimated_poses, tier_noise
from fidmap.synth.trajectory import trajectory

RESOLUTION_M = 0.02
TEAMS = ("hits", "log_odds", "half_hits", "thin", "thick")
TIERS: tuple[Tier, ...] = ("clean", "noisy", "clean", "noisy", "broken")


def evening(seed: int = 0, maps: int = 20, cells: int = 2000) -> tuple[SynthArena, Iterator[tuple[str, Grid]]]:
    """An arena with 20 parts and one map of each team, `cells` x `cells` or a little more where broken.

    The robot drives once and every team gets its scans: what differs is the poses and the mapper.

    Args:
        seed: which evening.
        maps: number of teams.
        cells: least side of a map in cells of 2 cm.
    """
    rng = np.random.default_rng(np.random.SeedSequence([0x6576_656E, seed]))
    pallets = max(6, int(0.6 * cells * RESOLUTION_M / 1.2))
    spec = ArenaSpec(pallets, int(0.8 * pallets), pairs=8, void_pairs=2, clutter=6, openness=0.4, name="evening")
    arena = make_arena(rng, spec)
    poses = trajectory(arena.maze, rng, spacing_m=0.8)
    scans = scan(arena, poses, Laser(step=math.radians(0.5), max_range_m=12.0), rng)

    def each() -> Iterator[tuple[str, Grid]]:
        for team in range(maps):
            noise = tier_noise(TIERS[team % len(TIERS)], rng)
            frame = Pose2(rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(-0.2, 0.2))
            believed = estimated_poses(poses, noise, rng, frame)
            mapper, name = MAPPERS[TEAMS[team // 2 % len(TEAMS)]], f"team{team + 1:02d}"
            yield name, draw_map(scans, believed, mapper, RESOLUTION_M, min_cells=cells, name=name)

    return arena, each()
