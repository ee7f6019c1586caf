"""Whole cases, map and truth together, and suites of them whose splits never share a seed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from fidmap.model import Grid, Pose2
from fidmap.synth.arena import ArenaSpec, SynthArena, make_arena
from fidmap.synth.laser import Laser, scan
from fidmap.synth.mappers import MAPPERS, Mapper, draw_map
from fidmap.synth.poses import PoseNoise, Tier, estimated_poses, tier_noise
from fidmap.synth.trajectory import trajectory
from fidmap.synth.truth import PartTruth, part_truths

Split = Literal["tune", "test"]

RESOLUTIONS_M = (0.02, 0.025, 0.05, 0.05, 0.10)
_SPLIT_WORD = {"tune": 0x7475_6E65, "test": 0x7465_7374}  # the words' ASCII codes
_TIER_WORD = {"exact": 0, "clean": 1, "noisy": 2, "broken": 3, "large": 4}


@dataclass(frozen=True)
class CaseSpec:
    """What one case is made of.

    explored: share of the pallets visited. spacing_m: way between scans. frame: the arena's frame seen from
    the map's. min_cells: least side of the map in cells (more unknown rim).
    """

    arena: ArenaSpec = field(default_factory=ArenaSpec)
    laser: Laser = field(default_factory=Laser)
    noise: PoseNoise = field(default_factory=PoseNoise)
    mapper: Mapper = field(default_factory=Mapper)
    resolution_m: float = 0.05
    explored: float = 1.0
    spacing_m: float = 0.25
    frame: Pose2 = field(default_factory=Pose2)
    min_cells: int = 0


@dataclass(frozen=True, eq=False)
class SynthCase:
    """An artificial map with its truth."""

    name: str
    tier: Tier
    spec: CaseSpec
    arena: SynthArena
    grid: Grid
    truths: tuple[PartTruth, ...]


def make_case(
    rng: np.random.Generator,
    spec: CaseSpec | None = None,
    *,
    arena: SynthArena | None = None,
    tier: Tier = "exact",
    name: str = "synthetic",
) -> SynthCase:
    """Build an arena (unless one is given), drive through it, map it with its faults, tell the truth."""
    spec = spec or CaseSpec()
    arena = arena or make_arena(rng, spec.arena)
    poses = trajectory(arena.maze, rng, spec.explored, spec.spacing_m)
    scans = scan(arena, poses, spec.laser, rng)
    believed = estimated_poses(poses, spec.noise, rng, spec.frame)
    grid = draw_map(scans, believed, spec.mapper, spec.resolution_m, min_cells=spec.min_cells, name=name)
    every = slice(None, None, spec.mapper.every)
    used = np.zeros(len(poses), bool)
    used[every] = True
    truths = part_truths(arena, scans.only(used), believed[every], grid)
    return SynthCase(name, tier, spec, arena, grid, truths)


def case_rng(split: Split, seed: int, tier: Tier, index: int) -> np.random.Generator:
    """The random numbers of one case: the split is part of the entropy, so splits never share any."""
    words = [_SPLIT_WORD[split], _TIER_WORD[tier], seed, index]
    return np.random.default_rng(np.random.SeedSequence(words))


def suite(split: Split, seed: int, n: int, tier: Tier) -> Iterator[SynthCase]:
    """`n` cases of a tier, made one by one.

    Args:
        split: 'tune' to develop on, 'test' to report on.
        seed: which suite; not negative.
        n: number of cases; the first ones do not depend on it.
        tier: how good the poses are ('large': good, but a big arena on a big map).
    """
    for index in range(n):
        rng = case_rng(split, seed, tier, index)
        yield make_case(rng, random_spec(rng, tier), tier=tier, name=f"{split}-{tier}-{seed}-{index:03d}")


def random_spec(rng: np.random.Generator, tier: Tier) -> CaseSpec:
    """A case of a tier, everything about it drawn at random."""
    resolution_m = float(rng.choice(RESOLUTIONS_M))
    frame = Pose2(rng.uniform(-8, 8), rng.uniform(-8, 8), rng.uniform(-math.pi, math.pi))
    spec = CaseSpec(
        arena=_random_arena(rng),
        laser=_random_laser(rng, tier),
        noise=tier_noise(tier, rng),
        mapper=MAPPERS[_random_mapper(rng, tier)],
        resolution_m=resolution_m,
        explored=float(rng.uniform(0.4, 0.9)) if rng.random() < 0.25 else 1.0,
        spacing_m=float(rng.uniform(0.2, 0.4)),
        frame=frame,
    )
    return _enlarged(rng, spec) if tier == "large" else spec


def _random_arena(rng: np.random.Generator) -> ArenaSpec:
    return ArenaSpec(
        columns=int(rng.integers(6, 10)),
        rows=int(rng.integers(5, 8)),
        pairs=int(rng.integers(4, 9)),
        void_pairs=int(rng.integers(0, 3)),
        singles=int(rng.integers(0, 3)),
        wholes=int(rng.integers(0, 3)),
        clutter=int(rng.integers(0, 9)),
        wall_m=float(rng.uniform(0.01, 0.08)),
        openness=float(rng.uniform(0.05, 0.4)),
    )


def _random_laser(rng: np.random.Generator, tier: Tier) -> Laser:
    swaying = tier in {"noisy", "broken"}
    return Laser(
        noise_m=float(rng.uniform(0.005, 0.02)),
        mixed=float(rng.uniform(0.1, 0.5)),
        dropout=float(rng.uniform(0.0, 0.01)),
        skew=float(rng.uniform(0.0, 0.1)) if swaying else 0.0,
        tilt=math.radians(rng.uniform(0, 2)) if swaying else 0.0,
    )


def _random_mapper(rng: np.random.Generator, tier: Tier) -> str:
    names = sorted(MAPPERS)
    if tier in {"clean", "exact", "large"}:  # CoreSLAM erases halves whatever the poses: it is no clean map
        names = [name for name in names if "coreslam" not in name]
    return str(rng.choice(names))


def _enlarged(rng: np.random.Generator, spec: CaseSpec) -> CaseSpec:
    """A big arena with more objects on a map of 1500 to 4000 cells, seen with fewer and coarser scans."""
    resolution_m = float(rng.choice([0.02, 0.025, 0.05], p=[0.4, 0.4, 0.2]))
    pallets = int(rng.integers(16, 29))
    across = pallets * spec.arena.pallet_m / resolution_m
    cells = int(np.clip(across * rng.uniform(1.0, 2.5), 1500, 4000))
    arena = replace(
        spec.arena,
        columns=pallets,
        rows=max(6, round(pallets * rng.uniform(0.7, 1.0))),
        pairs=pallets,
        void_pairs=pallets // 5,
        singles=pallets // 4,
        wholes=pallets // 4,
        clutter=pallets,
        openness=float(rng.uniform(0.3, 0.6)),
    )
    laser = replace(spec.laser, step=math.radians(0.5), max_range_m=12.0)
    return replace(
        spec, arena=arena, laser=laser, mapper=replace(spec.mapper, every=1),
        resolution_m=resolution_m, spacing_m=0.6, min_cells=cells,
    )  # fmt: skip
