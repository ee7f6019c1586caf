"""Doors, niches and everything that sticks out of walls."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fidmap.synth.floor import LEFT, RIGHT, Floor, Point, Rect, Wall, turned
from fidmap.synth.furniture import unlike


@dataclass(frozen=True)
class Joinery:
    """How a building's doors are made: the frame's width along the wall and how far it sticks out of it.

    both: frames stick out on both sides of the wall. leaves: share of open doors whose leaf the laser sees.
    """

    frame_m: float
    proud_m: float
    both: bool
    leaves: float

    @staticmethod
    def random(rng: np.random.Generator) -> Joinery:
        """A building's style; one in five has no frames."""
        proud_m = 0.0 if rng.random() < 0.2 else float(rng.uniform(0.05, 0.15))
        return Joinery(float(rng.uniform(0.04, 0.12)), proud_m, bool(rng.random() < 0.6), float(rng.uniform(0.2, 0.9)))


def add_door(
    rng: np.random.Generator,
    floor: Floor,
    wall: Wall,
    at: float,
    style: Joinery,
    *,
    inside: int,
    closed: bool = False,
) -> tuple[Point, Point]:
    """An opening of 0.8 to 1.0 m (one in ten is double) with its frame, and its leaf open or shut.

    Args:
        rng: the only source of randomness.
        floor: where to draw.
        wall: the wall.
        at: metres along the wall to the middle of the opening.
        style: how doors are made here.
        inside: the side of the room, into which the leaf opens.
        closed: the leaf shuts the opening, somewhere in the depth of the wall.

    Returns:
        Points 0.7 m before and behind the opening, the one inside the room last.
    """
    half = float(rng.uniform(0.4, 0.5) if rng.random() < 0.9 else rng.uniform(0.6, 0.9))
    wall.gaps.append((at - half, at + half))
    wall.take(at, half + 0.15)
    deep = wall.thick_m / 2
    if style.proud_m:
        across = (
            -deep - style.proud_m * (style.both or inside == RIGHT),
            deep + style.proud_m * (style.both or inside == LEFT),
        )
        wall.box(floor, (at - half - style.frame_m, at - half), across)
        wall.box(floor, (at + half, at + half + style.frame_m), across)
    if closed:
        level = float(rng.uniform(-0.8, 0.8)) * deep
        floor.line([wall.xy(at - half, level), wall.xy(at + half, level)])
    elif rng.random() < style.leaves:
        _leaf(rng, floor, wall, (at, half), inside)
    for side in (LEFT, RIGHT):
        floor.block(*wall.xy(at, side * (deep + 0.45)), 0.4)
    outside, within = (wall.xy(at, side * (deep + 0.7)) for side in (-inside, inside))
    return outside, within


def _leaf(rng: np.random.Generator, floor: Floor, wall: Wall, gap: Point, inside: int) -> None:
    """A door's leaf of 4 cm that stands open by 75 to 175 degrees."""
    at, half = gap
    end = float(rng.choice([-1.0, 1.0]))
    hinge = wall.xy(at + end * half, inside * (wall.thick_m / 2 + 0.02))
    angle = math.radians(float(rng.uniform(75, 110) if rng.random() < 0.7 else rng.uniform(110, 175)))
    wide = 2 * half if half <= 0.55 else half
    leaf = np.array([[0, -0.02], [wide, -0.02], [wide, 0.02], [0, 0.02]])
    shut = wall.direction if end < 0 else wall.direction + math.pi
    opened = shut - end * inside * angle
    floor.line(turned(leaf, opened) + hinge, closed=True)
    middle = turned(np.array([[wide / 2, 0.0]]), opened)[0] + hinge
    floor.block(float(middle[0]), float(middle[1]), 0.3)
    wall.take(at + end * half, wide, [inside])


def add_niche(rng: np.random.Generator, floor: Floor, wall: Wall) -> bool:
    """A recess of 0.4 to 0.8 m, wider as a window's; a thin wall bulges on its other side."""
    wide = float(rng.uniform(0.4, 0.8) if rng.random() < 0.75 else rng.uniform(0.8, 1.6))
    deep = float(rng.uniform(0.06, 0.4))
    at = wall.find(rng, wide / 2 + 0.1, (LEFT, RIGHT))
    if at is None:
        return False
    wall.take(at, wide / 2 + 0.1)
    wall.gaps.append((at - wide / 2, at + wide / 2))
    open_to = int(rng.choice(wall.sides))
    front, back = open_to * wall.thick_m / 2, open_to * (wall.thick_m / 2 - deep)
    a, b = at - wide / 2, at + wide / 2
    floor.line([wall.xy(a, front), wall.xy(a, back), wall.xy(b, back), wall.xy(b, front)])
    behind = -open_to * max(wall.thick_m / 2, deep - wall.thick_m / 2 + 0.03)
    floor.line([wall.xy(s, n) for s, n in ((a, front * -1), (a, behind), (b, behind), (b, front * -1))])
    floor.block(*wall.xy(at, behind), wide / 2)
    return True


def add_pilaster(rng: np.random.Generator, floor: Floor, wall: Wall) -> bool:
    """Something on a wall: a pilaster or pier, a half round, a wall's stump, a radiator."""
    side = int(rng.choice(wall.sides))
    kind = rng.choice(["pier", "round", "stump", "broad", "flat"], p=[0.35, 0.2, 0.15, 0.15, 0.15])
    half, deep = {
        "pier": (rng.uniform(0.1, 0.3), rng.uniform(0.06, 0.35)),
        "round": (0.0, unlike(rng, 0.07, 0.5, floor.radius_m)),
        "stump": (rng.uniform(0.03, 0.1), rng.uniform(0.25, 0.9)),
        "broad": (rng.uniform(0.8, 1.05) * floor.radius_m, rng.uniform(0.4, 1.3) * floor.radius_m),
        "flat": (rng.uniform(0.4, 0.8), rng.uniform(0.06, 0.14)),
    }[str(kind)]
    half = deep if kind == "round" else half
    at = wall.find(rng, half + 0.05, [side])
    if at is None or not floor.has_room(*wall.xy(at, side * (wall.thick_m / 2 + deep / 2)), max(half, deep / 2)):
        return False
    wall.take(at, half, [side])
    face = side * wall.thick_m / 2
    if kind == "round":
        floor.round(*wall.xy(at, face), deep, wall.direction + side * math.pi / 2, math.pi)
    else:
        wall.box(floor, (at - half, at + half), (min(face, face + side * deep), max(face, face + side * deep)))
    floor.block(*wall.xy(at, face + side * deep / 2), max(half, deep / 2) * 0.8)
    return True


def cut_corner(rng: np.random.Generator, floor: Floor, room: Rect) -> bool:
    """A slanted or rounded wall, or a pier, in the corner of a room."""
    sx, sy = rng.choice([-1.0, 1.0], 2)
    x, y = (room.x1 if sx > 0 else room.x0), (room.y1 if sy > 0 else room.y0)
    a, b = rng.uniform(0.25, min(1.2, 0.4 * min(room.size)), 2)
    if not floor.has_room(x, y, max(a, b)):
        return False
    kind = rng.integers(3)
    if kind == 0:
        floor.line([(x - sx * a, y), (x, y - sy * b)])
    elif kind == 1:
        floor.round(x - sx * a, y - sy * a, float(a), math.atan2(sy, sx), math.pi / 2)
    else:
        floor.box((x, y), (float(a) / 2, float(b) / 2))
    floor.block(x, y, 0.8 * max(a, b))
    return True


def put_on_wall(rng: np.random.Generator, floor: Floor, wall: Wall, sides: tuple[int, ...]) -> bool:
    """A fiducial of half barrels, back to back on both sides of a wall or on one; whether there was room."""
    at = wall.find(rng, floor.radius_m + 0.12, sides)
    if at is None:
        return False
    places = [(*wall.xy(at, side * wall.thick_m / 2), side) for side in sides]
    if not all(floor.has_room(x, y, floor.radius_m) for x, y, _ in places):
        return False
    wall.take(at, floor.radius_m + 0.1, sides)
    facings = (math.remainder(wall.direction + side * math.pi / 2, 2 * math.pi) for _, _, side in places)
    floor.fiducial(*((x, y, facing, math.pi) for (x, y, _), facing in zip(places, facings, strict=True)))
    return True
