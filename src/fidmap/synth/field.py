"""Artificial fields: open ground with whole barrels alone, in rows and in grids, among cones and people.

Worlds of simulators look like this. A robot that drives by on one side sees only that side of the barrels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fidmap.model import FloatArray
from fidmap.synth.arena import SynthArena
from fidmap.synth.drive import FreeSpace
from fidmap.synth.floor import LEFT, RIGHT, WHOLE, Floor, Point, Rect, Wall, finished, turned
from fidmap.synth.furniture import IN_FIELDS, crowds, furnish
from fidmap.synth.joinery import put_on_wall

RIM_M = 1.0  # free ground along the field's edge
Pattern = Literal["alone", "row", "grid"]


@dataclass(frozen=True)
class FieldSpec:
    """What to build.

    size_m: side of the square. wholes: whole barrels, pattern: how they stand. pairs: half barrels on both
    sides of free-standing walls. walls: how many of these. things: cones, boxes, columns and the like.
    fenced: a wall runs around the field. one_sided: the robot stays on the lower third. people: at once, on
    average.
    """

    size_m: float = 12.0
    wholes: int = 8
    pattern: Pattern = "alone"
    pairs: int = 1
    walls: int = 3
    things: int = 10
    fenced: bool = True
    one_sided: bool = False
    people: int = 1
    wall_m: float = 0.1
    radius_m: float = 0.30
    name: str = "field"


def make_field(rng: np.random.Generator, spec: FieldSpec | None = None) -> SynthArena:
    """Build a field at random from its specification; where there is no room left, fewer objects stand.

    Raises:
        ValueError: the field is smaller than 5 m.
    """
    spec = spec or FieldSpec()
    if spec.size_m < 5:
        raise ValueError("a field needs 5 m or more")
    floor, side = Floor(spec.radius_m), spec.size_m
    for x, y in _places(rng, spec):
        inside = max(abs(x - side / 2), abs(y - side / 2)) < side / 2 - RIM_M
        if inside and floor.has_room(x, y, spec.radius_m + 0.1):
            floor.fiducial((x, y, 0.0, WHOLE))
    _add_walls(rng, floor, spec)
    furnish(rng, floor, Rect(RIM_M, RIM_M, side - RIM_M, side - RIM_M), spec.things, IN_FIELDS)
    if spec.fenced:
        floor.box((side / 2, side / 2), (side / 2 - 0.05, side / 2 - 0.05))
    space = FreeSpace(*floor.outline(), (side, side))
    way = space.tour(_goals(rng, spec))
    people = crowds(rng, space.centres, spec.people, stretches=6)
    return finished(floor, space, spec.name, way=way, crowds=people, wall_m=spec.wall_m)


def _places(rng: np.random.Generator, spec: FieldSpec) -> FloatArray:
    """Places (N, 2) for the whole barrels; rows and grids are turned and not quite even."""
    middle = np.array([0.5, 0.65 if spec.one_sided else 0.5]) * spec.size_m
    if spec.pattern == "alone":
        low = [RIM_M, 0.35 * spec.size_m if spec.one_sided else RIM_M]
        return rng.uniform(low, spec.size_m - RIM_M, (3 * spec.wholes, 2))[: 2 * spec.wholes]
    columns = spec.wholes if spec.pattern == "row" else math.ceil(math.sqrt(spec.wholes))
    apart = 2 * spec.radius_m + float(rng.uniform(0.3, 2.5))
    number = np.arange(spec.wholes)
    lattice = np.stack([number % columns, number // columns], axis=1) * apart
    uneven = rng.normal(0, 0.02 if rng.random() < 0.7 else 0.15, lattice.shape)
    turn = float(rng.uniform(0, math.pi)) if not spec.one_sided else float(rng.normal(0, 0.1))
    return turned(lattice - lattice.mean(axis=0) + uneven, turn) + middle


def _add_walls(rng: np.random.Generator, floor: Floor, spec: FieldSpec) -> None:
    """Free-standing walls at any angle, the first ones with pairs on them."""
    pairs = 0
    for _ in range(spec.walls):
        length, turn = (
            float(rng.uniform(1.0, min(5.0, 0.4 * spec.size_m))),
            float(rng.uniform(-math.pi, math.pi)),
        )
        away = length / 2 * np.array([[math.cos(turn), math.sin(turn)]])
        reach = RIM_M + length / 2
        x, y = rng.uniform(reach, max(reach, spec.size_m - reach), 2)
        along = [(x + t * away[0, 0], y + t * away[0, 1]) for t in np.linspace(-1, 1, math.ceil(length / 0.4) + 1)]
        if not all(floor.has_room(px, py, 0.3) for px, py in along):
            continue
        wall = Wall(along[0], along[-1], spec.wall_m)
        if pairs < spec.pairs:
            pairs += put_on_wall(rng, floor, wall, (LEFT, RIGHT))
        for px, py in along:
            floor.block(px, py, 0.2)
        wall.build(floor)


def _goals(rng: np.random.Generator, spec: FieldSpec) -> list[Point]:
    """All over the field, or in its lower third only."""
    count = 6 + round(spec.size_m)
    high = 0.3 * spec.size_m if spec.one_sided else spec.size_m - 0.6
    points = rng.uniform(0.6, [spec.size_m - 0.6, high], (count, 2))
    return [(float(x), float(y)) for x, y in points]
