"""Everything about a case drawn at random: arenas, offices, fields, sensors, mappers, radii."""

from __future__ import annotations

import math

import numpy as np

from fidmap.synth.arena import ArenaSpec
from fidmap.synth.field import FieldSpec, Pattern
from fidmap.synth.laser import Laser
from fidmap.synth.mappers import MAPPERS
from fidmap.synth.office import OfficeSpec
from fidmap.synth.poses import PoseNoise, Tier, tier_noise

RESOLUTIONS_M = (0.02, 0.025, 0.05, 0.05, 0.10)
REAL_RESOLUTIONS_M = (0.025, 0.05, 0.05, 0.05, 0.10)  # of offices and fields
RADIUS_M = 0.30  # of RoboCup's barrels
CELLS_PER_RADIUS = 2.8  # fewer do not make an arc
WIDEST = 0.58  # of a pallet: barrels that leave a way beside them


def random_radius(rng: np.random.Generator, resolution_m: float) -> float:
    """A fiducials' radius: RoboCup's in 60 of 100 cases, else one of 0.12 to 0.45 m of enough cells."""
    if rng.random() < 0.6:
        return RADIUS_M
    return float(rng.uniform(max(0.12, CELLS_PER_RADIUS * resolution_m), 0.45))


def random_maze_spec(rng: np.random.Generator) -> ArenaSpec:
    """A pallet maze of the size of a competition's."""
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


def random_office_spec(rng: np.random.Generator, radius_m: float) -> OfficeSpec:
    """A small office floor, tidy or crammed."""
    corridors = int(rng.integers(1, 3))
    return OfficeSpec(
        width_m=float(rng.uniform(10, 22)),
        depth_m=float(rng.uniform(8, 13) + 5 * (corridors - 1)),
        corridors=corridors,
        pairs=int(rng.integers(3, 9)),
        singles=int(rng.integers(0, 4)),
        wholes=int(rng.integers(0, 3)),
        wall_m=float(rng.uniform(0.05, 0.25)),
        furniture=float(rng.uniform(0.3, 3.0)),
        features=float(rng.uniform(0.3, 2.0)),
        people=int(rng.integers(0, 4)),
        entered=float(rng.uniform(0.3, 1.0)),
        radius_m=radius_m,
    )


def random_field_spec(rng: np.random.Generator, radius_m: float) -> FieldSpec:
    """An open field of 6 to 30 m, smaller ones more often."""
    size_m = float(6 + 24 * rng.random() ** 2)
    patterns: tuple[Pattern, ...] = ("alone", "row", "grid")
    return FieldSpec(
        size_m=size_m,
        wholes=int(rng.integers(3, 13)),
        pattern=patterns[int(rng.integers(3))],
        pairs=int(rng.integers(0, 3)),
        walls=int(rng.integers(0, 5)),
        things=int(rng.integers(2, 8) + size_m * rng.uniform(0.2, 1.2)),
        fenced=bool(rng.random() < 0.6),
        one_sided=bool(rng.random() < 0.4),
        people=int(rng.integers(0, 3)),
        wall_m=float(rng.uniform(0.02, 0.2)),
        radius_m=radius_m,
    )


def random_laser(rng: np.random.Generator, tier: Tier) -> Laser:
    """A Hokuyo of average quality, swaying in the worse tiers."""
    swaying = tier in {"noisy", "broken"}
    return Laser(
        noise_m=float(rng.uniform(0.005, 0.02)),
        mixed=float(rng.uniform(0.1, 0.5)),
        dropout=float(rng.uniform(0.0, 0.01)),
        skew=float(rng.uniform(0.0, 0.1)) if swaying else 0.0,
        tilt=math.radians(rng.uniform(0, 2)) if swaying else 0.0,
    )


def any_laser(rng: np.random.Generator) -> Laser:
    """Any robot's laser: 180 to 270 degrees in steps of 0.25 to 1 degree; a third are like a SICK LMS."""
    if rng.random() < 0.35:
        fov, step = math.radians(180), math.radians(float(rng.choice([0.5, 1.0], p=[0.3, 0.7])))
    else:
        fov = math.radians(float(rng.choice([180, 240, 270])))
        step = math.radians(float(rng.choice([0.25, 0.36, 0.5, 1.0])))
    return Laser(
        fov=fov,
        step=step,
        max_range_m=float(rng.uniform(8, 30)),
        noise_m=float(rng.uniform(0.01, 0.03)),
        mixed=float(rng.uniform(0.1, 0.5)),
        dropout=float(rng.uniform(0.0, 0.01)),
        skew=float(rng.uniform(0.0, 0.1)) if rng.random() < 0.5 else 0.0,
        silent=bool(rng.random() < 0.6),
    )


def any_noise(rng: np.random.Generator) -> PoseNoise:
    """Poses as good as those of the clean tier, or as bad as those of the noisy one."""
    return tier_noise("clean" if rng.random() < 0.5 else "noisy", rng)


def random_mapper(rng: np.random.Generator, tier: Tier) -> str:
    """The name of a manner of mapping."""
    names = sorted(MAPPERS)
    if tier in {"clean", "exact", "large"}:  # CoreSLAM erases halves whatever the poses: it is no clean map
        names = [name for name in names if "coreslam" not in name]
    return str(rng.choice(names))
