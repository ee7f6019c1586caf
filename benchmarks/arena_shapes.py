"""One artificial arena as other programs would record or draw it: points of a 3D scanner, lines and arcs."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fidmap.model import FloatArray
from fidmap.synth.arena import SynthArena
from fidmap.synth.demo import demo_arena

HEIGHT_M = 1.2


def arena() -> SynthArena:
    """The arena of the demo: 14 parts on thin walls and over voids."""
    return demo_arena()


def arc_points(arc: FloatArray, spacing_m: float) -> FloatArray:
    """Points (N, 2) on an arc given as x, y, radius, middle direction, opening."""
    x, y, radius, middle, opening = arc
    count = max(2, math.ceil(opening * radius / spacing_m) + 1)
    angles = middle + np.linspace(-opening / 2, opening / 2, count)
    return np.stack([x + radius * np.cos(angles), y + radius * np.sin(angles)], axis=1)


def wall_points(walls: FloatArray, spacing_m: float) -> FloatArray:
    """Points (N, 2) on segments (S, 4) of x0, y0, x1, y1."""
    parts = []
    for x0, y0, x1, y1 in walls:
        count = max(2, math.ceil(math.hypot(x1 - x0, y1 - y0) / spacing_m) + 1)
        parts.append(np.linspace((x0, y0), (x1, y1), count))
    return np.concatenate(parts)


def surface_points(made: SynthArena, spacing_m: float = 0.03, noise_m: float = 0.004, seed: int = 0) -> FloatArray:
    """(N, 3): walls and barrels up to 1.2 m, and the floor at z = 0 but inside of barrels."""
    rng = np.random.default_rng(seed)
    plan = np.concatenate([wall_points(made.walls, spacing_m), *(arc_points(arc, spacing_m) for arc in made.arcs)])
    heights = np.arange(0, HEIGHT_M, spacing_m)
    upright = np.column_stack([np.repeat(plan, len(heights), axis=0), np.tile(heights, len(plan))])
    low, high = plan.min(axis=0), plan.max(axis=0)
    floor = np.stack(np.meshgrid(*(np.arange(a, b, spacing_m) for a, b in zip(low, high, strict=True))), -1)
    floor = floor.reshape(-1, 2)
    for x, y, radius, *_ in made.arcs:
        floor = floor[np.hypot(floor[:, 0] - x, floor[:, 1] - y) > radius]
    points = np.concatenate([upright, np.column_stack([floor, np.zeros(len(floor))])])
    return np.asarray(points + rng.normal(0, noise_m, points.shape))


def strokes(made: SynthArena) -> Iterator[tuple[str, FloatArray]]:
    """('line', x0 y0 x1 y1) of walls and ('arc', x, y, radius, middle, opening) of barrels."""
    for wall in made.walls:
        yield "line", wall
    for arc in made.arcs:
        yield "arc", arc
