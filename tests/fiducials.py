"""Small arenas and barrel parts for tests: numbers that can be followed by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fidmap.model import Arena, Assignment, BarrelPart, FiducialPart, Group, Transform

R = 0.3
HALF = math.pi
SPOTS = ((0.0, 0.0, 0.0), (3.6, 1.2, math.pi / 2), (1.2, 4.8, math.pi), (6.0, 4.2, -math.pi / 2), (7.4, 0.5, 0.0))


def half(part_id: str, x_m: float, y_m: float, facing: float | None = 0.0) -> FiducialPart:
    """A half barrel."""
    return FiducialPart(part_id, x_m, y_m, facing, HALF)


def arc(n: int, x_m: float, y_m: float, facing: float | None = 0.0, **more: object) -> BarrelPart:
    """A half circle as a map shows it."""
    return replace(BarrelPart(n, x_m, y_m, facing, HALF), **more)


def arena_of(*parts: FiducialPart, groups: Sequence[Group] = (), **more: object) -> Arena:
    """An arena of barrels of 0.3 m."""
    return replace(Arena("test", R, parts, tuple(groups)), **more)


def pairs_arena(**more: object) -> Arena:
    """Five half barrels on both sides of walls of 4 cm, in no symmetry."""
    parts = []
    for k, (x, y, facing) in enumerate(SPOTS, 1):
        dx, dy = 0.02 * math.cos(facing), 0.02 * math.sin(facing)
        parts += [half(f"{k}A", x + dx, y + dy, facing), half(f"{k}B", x - dx, y - dy, facing + math.pi)]
    return arena_of(*parts, **more)


def drawn(arena: Arena, move: Transform | None = None, noise_m: float = 0.0, seed: int = 0) -> tuple[BarrelPart, ...]:
    """The barrel parts of a map of the whole arena: T_map_truth = `move`, then noise."""
    move = move or Transform()
    shift = np.random.default_rng(seed).normal(0, noise_m, (len(arena.parts), 2))
    c, s = math.cos(move.rotation), math.sin(move.rotation)
    flip = -1 if move.mirrored else 1
    parts = []
    for n, (part, (ex, ey)) in enumerate(zip(arena.parts, shift, strict=True), 1):
        x, y = float(part.x_m or 0), flip * float(part.y_m or 0)
        facing = None if part.facing is None else flip * part.facing + move.rotation
        x, y = move.scale * (c * x - s * y) + move.tx_m + ex, move.scale * (s * x + c * y) + move.ty_m + ey
        parts.append(BarrelPart(n, float(x), float(y), facing, part.opening))
    return tuple(parts)


def assigned(*barrel_of: int | None, transform: Transform | None = None) -> Assignment:
    """An assignment by hand, with the identity as its registration."""
    return Assignment(tuple(barrel_of), (False,) * len(barrel_of), transform or Transform(), 0.0)


def names(arena: Arena, assignment: Assignment, parts: Sequence[BarrelPart]) -> dict[str, int]:
    """Fiducial part id -> number of its barrel part."""
    pairs = zip(arena.parts, assignment.barrel_of, strict=True)
    return {part.id: parts[j].n for part, j in pairs if j is not None}
