"""Whole cases, map and truth together, and suites of them whose splits never share a seed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from fidmap.model import Grid, Pose2
from fidmap.synth.arena import ArenaSpec, SynthArena, make_arena
from fidmap.synth.draws import (
    REAL_RESOLUTIONS_M,
    RESOLUTIONS_M,
    WIDEST,
    any_laser,
    any_noise,
    random_field_spec,
    random_laser,
    random_mapper,
    random_maze_spec,
    random_office_spec,
    random_radius,
)
from fidmap.synth.field import FieldSpec, make_field
from fidmap.synth.laser import Laser, scan
from fidmap.synth.mappers import MAPPERS, Mapper, draw_map
from fidmap.synth.office import OfficeSpec, make_office
from fidmap.synth.poses import PoseNoise, Tier, estimated_poses, tier_noise
from fidmap.synth.trajectory import drive
from fidmap.synth.truth import PartTruth, part_truths

Split = Literal["tune", "test"]

_SPLIT_WORD = {"tune": 0x7475_6E65, "test": 0x7465_7374}  # the words' ASCII codes
_TIER_WORD = {"exact": 0, "clean": 1, "noisy": 2, "broken": 3, "large": 4, "office": 5, "field": 6}


@dataclass(frozen=True)
class CaseSpec:
    """What one case is made of.

    explored: share of the pallets visited. spacing_m: way between scans. frame: the arena's frame seen from
    the map's. min_cells: least side of the map in cells (more unknown rim).
    """

    arena: ArenaSpec | OfficeSpec | FieldSpec = field(default_factory=ArenaSpec)
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
    arena = arena or build_arena(rng, spec.arena)
    poses = drive(arena, rng, spec.explored, spec.spacing_m)
    scans = scan(arena, poses, spec.laser, rng)
    believed = estimated_poses(poses, spec.noise, rng, spec.frame)
    grid = draw_map(scans, believed, spec.mapper, spec.resolution_m, min_cells=spec.min_cells, name=name)
    every = slice(None, None, spec.mapper.every)
    used = np.zeros(len(believed), bool)
    used[every] = True
    truths = part_truths(arena, scans.only(used), believed[every], grid, spec.mapper)
    return SynthCase(name, tier, spec, arena, grid, truths)


def build_arena(rng: np.random.Generator, spec: ArenaSpec | OfficeSpec | FieldSpec) -> SynthArena:
    """An arena of whatever kind is specified."""
    if isinstance(spec, OfficeSpec):
        return make_office(rng, spec)
    return make_field(rng, spec) if isinstance(spec, FieldSpec) else make_arena(rng, spec)


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
        tier: how good the poses are ('large': good, but a big arena on a big map), or another place
            than a maze ('office', 'field') with poses of all qualities.
    """
    for index in range(n):
        rng = case_rng(split, seed, tier, index)
        yield make_case(rng, random_spec(rng, tier), tier=tier, name=f"{split}-{tier}-{seed}-{index:03d}")


def random_spec(rng: np.random.Generator, tier: Tier) -> CaseSpec:
    """A case of a tier, everything about it drawn at random.

    The radius has random numbers of its own, so that mazes of 0.30 m are what they were without it.
    """
    radius_rng = rng.spawn(1)[0]
    if tier in {"office", "field"}:
        return _random_place(rng, tier, radius_rng)
    resolution_m = float(rng.choice(RESOLUTIONS_M))
    frame = Pose2(rng.uniform(-8, 8), rng.uniform(-8, 8), rng.uniform(-math.pi, math.pi))
    maze = random_maze_spec(rng)
    spec = CaseSpec(
        arena=maze,
        laser=random_laser(rng, tier),
        noise=tier_noise(tier, rng),
        mapper=MAPPERS[random_mapper(rng, tier)],
        resolution_m=resolution_m,
        explored=float(rng.uniform(0.4, 0.9)) if rng.random() < 0.25 else 1.0,
        spacing_m=float(rng.uniform(0.2, 0.4)),
        frame=frame,
    )
    if tier == "large":
        return _enlarged(rng, spec, maze, radius_rng)
    return replace(spec, arena=_with_radius(maze, random_radius(radius_rng, resolution_m)))


def _random_place(rng: np.random.Generator, tier: Tier, radius_rng: np.random.Generator) -> CaseSpec:
    """A case in an office or a field, by any laser and mapper; scans are fewer where beams are many."""
    resolution_m = float(rng.choice(REAL_RESOLUTIONS_M))
    radius_m = random_radius(radius_rng, resolution_m)
    laser = any_laser(rng)
    usable_m = float(rng.uniform(8, 20) * min(1.0, resolution_m / 0.04))
    spacing_m = float(rng.uniform(0.2, 0.5)) + (0.15 if laser.step < math.radians(0.4) else 0.0)
    return CaseSpec(
        arena=random_office_spec(rng, radius_m) if tier == "office" else random_field_spec(rng, radius_m),
        laser=laser,
        noise=any_noise(rng),
        mapper=replace(MAPPERS[random_mapper(rng, tier)], usable_m=usable_m),
        resolution_m=resolution_m,
        explored=float(rng.uniform(0.4, 0.9)) if rng.random() < 0.25 else 1.0,
        spacing_m=spacing_m,
        frame=Pose2(rng.uniform(-8, 8), rng.uniform(-8, 8), rng.uniform(-math.pi, math.pi)),
    )


def with_radius(spec: CaseSpec, radius_m: float) -> CaseSpec:
    """The case with barrels of another radius."""
    arena = spec.arena
    if isinstance(arena, ArenaSpec):
        return replace(spec, arena=_with_radius(arena, radius_m))
    return replace(spec, arena=replace(arena, radius_m=radius_m))


def _with_radius(maze: ArenaSpec, radius_m: float) -> ArenaSpec:
    """A maze for other barrels, on wider pallets where they would block the way."""
    return replace(maze, radius_m=radius_m, pallet_m=max(maze.pallet_m, 2 * radius_m / WIDEST))


def _enlarged(rng: np.random.Generator, spec: CaseSpec, maze: ArenaSpec, radius_rng: np.random.Generator) -> CaseSpec:
    """A big arena with more objects on a map of 1500 to 4000 cells, seen with fewer and coarser scans."""
    resolution_m = float(rng.choice([0.02, 0.025, 0.05], p=[0.4, 0.4, 0.2]))
    pallets = int(rng.integers(16, 29))
    maze = _with_radius(maze, random_radius(radius_rng, resolution_m))
    across = pallets * maze.pallet_m / resolution_m
    cells = int(np.clip(across * rng.uniform(1.0, 2.5), 1500, 4000))
    arena = replace(
        maze,
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
