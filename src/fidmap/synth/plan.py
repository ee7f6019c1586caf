"""Floor plans of offices: strips of rooms along corridors, walls with doors between them."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from fidmap.synth.floor import LEFT, RIGHT, Floor, Interval, Point, Rect, Wall
from fidmap.synth.joinery import Joinery, add_door

CLOSED = 0.18  # share of the doors that are shut
LOUNGES = 0.07  # share of the rooms without a wall towards the corridor


@dataclass(frozen=True)
class Strip:
    """Rooms side by side, or a corridor: from low to high across, over the whole width of the floor."""

    low: float
    high: float
    is_corridor: bool


@dataclass
class FloorPlan:
    """Walls, rooms and corridors; doors: by room, points before and behind those that are open.

    lines: the walls along the width, one more than strips. joint: where the cross corridor runs, or None.
    """

    width_m: float
    strips: list[Strip]
    joint: Interval | None
    style: Joinery
    lines: list[Wall] = field(default_factory=list)
    cross_walls: list[Wall] = field(default_factory=list)
    rooms: list[Rect] = field(default_factory=list)
    corridors: list[Rect] = field(default_factory=list)
    doors: dict[int, tuple[Point, Point]] = field(default_factory=dict)

    @property
    def walls(self) -> list[Wall]:
        """All walls."""
        return self.lines + self.cross_walls

    def towards_corridor(self, strip: int) -> list[tuple[int, int]]:
        """Lines between a strip of rooms and a corridor, each with the side on which the rooms are."""
        found = []
        if strip > 0 and self.strips[strip - 1].is_corridor:
            found.append((strip, LEFT))
        if strip + 1 < len(self.strips) and self.strips[strip + 1].is_corridor:
            found.append((strip + 1, RIGHT))
        return found


def random_plan(
    rng: np.random.Generator, floor: Floor, size: tuple[float, float], corridors: int, wall_m: float
) -> FloorPlan:
    """Draw up a floor with one or two corridors along its width; doors are drawn on the floor at once."""
    strips = _strips(rng, size[1], corridors)
    joint = None
    if corridors == 2:
        begin = float(rng.uniform(2.5, size[0] - 4.5))
        joint = (begin, begin + float(rng.uniform(1.5, 2.2)))
    plan = FloorPlan(size[0], strips, joint, Joinery.random(rng))
    outer_m = max(wall_m, float(rng.uniform(0.1, 0.3)))
    _add_lines(rng, plan, wall_m, outer_m)
    for number, strip in enumerate(strips):
        if strip.is_corridor:
            plan.corridors.append(Rect(0, strip.low, size[0], strip.high))
        else:
            _add_rooms(rng, floor, plan, number, wall_m)
    for x, sides in ((0.0, (RIGHT,)), (size[0], (LEFT,))):
        plan.cross_walls.append(Wall((x, 0.0), (x, size[1]), outer_m, sides))
    return plan


def _strips(rng: np.random.Generator, depth_m: float, corridors: int) -> list[Strip]:
    """The order of rooms (R) and corridors (C) across the floor, rooms sharing what corridors leave."""
    order = "RCR" if corridors == 1 else ("RCRCR", "RCRRCR", "RCRC")[int(rng.integers(3))]
    wide = {i: float(rng.uniform(1.4, 2.4)) for i, kind in enumerate(order) if kind == "C"}
    share = rng.uniform(0.8, 1.2, len(order)) * [kind == "R" for kind in order]
    share *= (depth_m - sum(wide.values())) / share.sum()
    strips, low = [], 0.0
    for i, kind in enumerate(order):
        high = low + wide.get(i, float(share[i]))
        strips.append(Strip(low, high, kind == "C"))
        low = high
    return strips


def _add_lines(rng: np.random.Generator, plan: FloorPlan, wall_m: float, outer_m: float) -> None:
    """The walls along the width, open where the cross corridor meets them."""
    ends = [0.0, *(strip.high for strip in plan.strips)]
    for number, y in enumerate(ends):
        sides = (LEFT,) if number == 0 else (RIGHT,) if number == len(ends) - 1 else (LEFT, RIGHT)
        thick_m = wall_m * float(rng.uniform(0.8, 1.2)) if len(sides) == 2 else outer_m
        wall = Wall((0.0, y), (plan.width_m, y), thick_m, sides)
        for end in (0.0, plan.width_m):
            wall.take(end, outer_m / 2)
        corridors = [i for i, strip in enumerate(plan.strips) if strip.is_corridor]
        if plan.joint and corridors[0] < number <= corridors[-1]:
            middle, half = sum(plan.joint) / 2, (plan.joint[1] - plan.joint[0]) / 2
            wall.gaps.append(plan.joint)
            wall.take(middle, half + 0.1)
        plan.lines.append(wall)


def _add_rooms(rng: np.random.Generator, floor: Floor, plan: FloorPlan, number: int, wall_m: float) -> None:
    """The rooms of a strip with the walls between them and their doors."""
    strip = plan.strips[number]
    corridors = [i for i, other in enumerate(plan.strips) if other.is_corridor]
    joint = plan.joint if plan.joint and corridors[0] < number < corridors[-1] else None
    spans = [(0.0, plan.width_m)] if joint is None else [(0.0, joint[0]), joint, (joint[1], plan.width_m)]
    cuts = [0.0]
    for span in spans:
        if span == joint:
            cuts.append(span[1])
            continue
        cuts += _cuts(rng, span)
    for x in cuts[1:-1]:
        _add_cross_wall(rng, floor, plan, (x, strip), wall_m, may_open=joint is None or x not in joint)
        for line, side in ((plan.lines[number], LEFT), (plan.lines[number + 1], RIGHT)):
            line.take(x, wall_m / 2, [side])
    for a, b in pairwise(cuts):
        room = Rect(a + wall_m / 2, strip.low + wall_m / 2, b - wall_m / 2, strip.high - wall_m / 2)
        if joint == (a, b):
            plan.corridors.append(room)
        else:
            plan.rooms.append(room)
            _open_room(rng, floor, plan, number, (a, b))


def _cuts(rng: np.random.Generator, span: Interval) -> list[float]:
    """Ends of the rooms of 2.2 to 6 m that fill a span."""
    length = span[1] - span[0]
    count = max(1, round(length / float(rng.uniform(2.6, 4.6))))
    share = rng.uniform(0.6, 1.4, count)
    return [float(x) for x in span[0] + np.cumsum(share) / share.sum() * length]


def _add_cross_wall(
    rng: np.random.Generator,
    floor: Floor,
    plan: FloorPlan,
    at: tuple[float, Strip],
    wall_m: float,
    *,
    may_open: bool,
) -> None:
    """A wall between two rooms: whole, with a door, or a stump that ends free in one large room."""
    x, strip = at
    thick_m = wall_m * float(rng.uniform(0.7, 1.3))
    wall = Wall((x, strip.low), (x, strip.high), thick_m)
    for end in (0.0, wall.length):
        wall.take(end, wall_m)
    kind = rng.random() if may_open else 1.0
    if kind < 0.12:
        begin, end = sorted(rng.uniform(0.3, wall.length - 0.3, 2))
        wall.gaps.append((float(begin), float(max(end, begin + 0.9))))
        wall.take((begin + end) / 2, (max(end, begin + 0.9) - begin) / 2)
    elif kind < 0.3 and (place := wall.find(rng, 0.7, (LEFT, RIGHT))) is not None:
        add_door(rng, floor, wall, place, plan.style, inside=int(rng.choice([LEFT, RIGHT])))
    plan.cross_walls.append(wall)


def _open_room(rng: np.random.Generator, floor: Floor, plan: FloorPlan, number: int, span: Interval) -> None:
    """A door towards a corridor, shut or open, or no wall there at all."""
    choices = plan.towards_corridor(number)
    line, side = choices[int(rng.integers(len(choices)))]
    wall, room = plan.lines[line], len(plan.rooms) - 1
    middle, half = sum(span) / 2, (span[1] - span[0]) / 2
    if rng.random() < LOUNGES:
        wide = half * float(rng.uniform(0.5, 0.95))
        wall.gaps.append((middle - wide, middle + wide))
        wall.take(middle, wide + 0.1)
        plan.doors[room] = (wall.xy(middle, -side * 0.8), wall.xy(middle, side * 0.8))
        return
    slack = max(0.0, half - 0.8)
    at = middle + (slack if rng.random() < 0.5 else float(rng.uniform(0, slack))) * float(rng.choice([-1, 1]))
    closed = bool(rng.random() < CLOSED)
    points = add_door(rng, floor, wall, at, plan.style, inside=side, closed=closed)
    if not closed:
        plan.doors[room] = points
