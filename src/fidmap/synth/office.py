"""Artificial offices: corridors and small rooms full of what a detector takes for half barrels.

Door frames, wall ends, niches, pilasters and cupboards as wide as a barrel, columns and bins nearly as round,
legs, plants and people; rooms that the robot enters, looks into from the door, or passes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fidmap.synth.arena import SynthArena
from fidmap.synth.drive import FreeSpace
from fidmap.synth.floor import WHOLE, Floor, Point, finished
from fidmap.synth.furniture import IN_CORRIDORS, IN_ROOMS, crowds, furnish
from fidmap.synth.joinery import add_niche, add_pilaster, cut_corner, put_on_wall
from fidmap.synth.plan import FloorPlan, random_plan


@dataclass(frozen=True)
class OfficeSpec:
    """What to build.

    width_m, depth_m: of the floor (corridors run along the width). corridors: 1 or 2; two are joined by a
    cross corridor. pairs: half barrels on both sides of a wall. singles: without a partner. wholes:
    free-standing. wall_m: thickness of inner walls. furniture: pieces per 3 m2 of a room. features: niches,
    pilasters and wall ends per 5 m of wall. people: at once, on average. entered: share of the rooms that are
    driven through; half of the others are looked into from the door.
    """

    width_m: float = 18.0
    depth_m: float = 11.0
    corridors: int = 1
    pairs: int = 5
    singles: int = 1
    wholes: int = 1
    wall_m: float = 0.12
    furniture: float = 0.8
    features: float = 1.0
    people: int = 1
    entered: float = 0.5
    radius_m: float = 0.30
    name: str = "office"


def make_office(rng: np.random.Generator, spec: OfficeSpec | None = None) -> SynthArena:
    """Build an office at random from its specification; where there is no room left, fewer objects stand.

    Raises:
        ValueError: the floor is too small for its corridors and rooms.
    """
    spec = spec or OfficeSpec()
    if spec.corridors not in {1, 2} or spec.width_m < 8 or spec.depth_m < 3 + 4 * spec.corridors:
        raise ValueError("an office needs 1 or 2 corridors, 8 m of width, and 7 or 11 m of depth")
    floor = Floor(spec.radius_m)
    plan = random_plan(rng, floor, (spec.width_m, spec.depth_m), spec.corridors, spec.wall_m)
    _add_barrels(rng, floor, plan, spec)
    _add_features(rng, floor, plan, spec)
    for wall in plan.walls:
        wall.build(floor)
    for areas, things, density in ((plan.rooms, IN_ROOMS, 3.0), (plan.corridors, IN_CORRIDORS, 8.0)):
        for area in areas:
            count = rng.poisson(spec.furniture * area.size[0] * area.size[1] / density)
            furnish(rng, floor, area, int(count), things)
    space = FreeSpace(*floor.outline(), (spec.width_m, spec.depth_m))
    way = space.tour(_goals(rng, plan, spec.entered))
    people = crowds(rng, space.centres, spec.people, stretches=8)
    return finished(floor, space, spec.name, way=way, crowds=people, wall_m=spec.wall_m)


def _add_barrels(rng: np.random.Generator, floor: Floor, plan: FloorPlan, spec: OfficeSpec) -> None:
    """Pairs, singles and whole barrels, as far as a few throws find places for them."""
    inner = [wall for wall in plan.walls if len(wall.sides) == 2]
    weights = np.array([wall.length for wall in inner])
    for wanted, paired in ((spec.pairs, True), (spec.singles, False)):
        placed = 0
        for index in rng.choice(len(inner), 5 * wanted, p=weights / weights.sum()):
            if placed < wanted:
                wall = inner[index]
                sides = wall.sides if paired else (int(rng.choice(wall.sides)),)
                placed += put_on_wall(rng, floor, wall, sides)
    for _ in range(4 * spec.wholes):
        area = (plan.rooms + plan.corridors)[int(rng.integers(len(plan.rooms + plan.corridors)))]
        x, y = area.anywhere(rng, floor.radius_m + 0.6)
        if len([o for o in floor.objects if floor.arcs[o[0]][4] == WHOLE]) < spec.wholes and floor.has_room(
            x, y, floor.radius_m + 0.3
        ):
            floor.fiducial((x, y, 0.0, WHOLE))


def _add_features(rng: np.random.Generator, floor: Floor, plan: FloorPlan, spec: OfficeSpec) -> None:
    """Niches and things on walls, more on longer walls, and slanted or rounded corners of rooms."""
    for wall in plan.walls:
        for _ in range(rng.poisson(spec.features * wall.length / 5)):
            if rng.random() < 0.3:
                add_niche(rng, floor, wall)
            else:
                add_pilaster(rng, floor, wall)
    for room in plan.rooms:
        if rng.random() < 0.2:
            cut_corner(rng, floor, room)


def _goals(rng: np.random.Generator, plan: FloorPlan, entered: float) -> list[Point]:
    """Where the robot goes: along corridors, before doors, through some rooms, just into others."""
    goals: list[Point] = []
    for corridor in plan.corridors:
        long = int(max(corridor.size) // 2.5) + 1
        xs, ys = (
            np.linspace(a + 0.7, b - 0.7, long + 1) for a, b in ((corridor.x0, corridor.x1), (corridor.y0, corridor.y1))
        )
        goals += [(float(x), float(y)) for x, y in zip(xs, ys, strict=True)]
    for number, (before, behind) in plan.doors.items():
        room = plan.rooms[number]
        goals.append(before)
        chance = rng.random()
        if chance < entered:
            goals.append(behind)
            goals += [room.anywhere(rng, 0.5) for _ in range(1 + round(room.size[0] * room.size[1] / 6))]
        elif chance < (1 + entered) / 2:
            goals.append(behind)
    return goals
