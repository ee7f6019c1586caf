"""What stands in rooms, corridors and fields besides fiducials, cut at the height of a robot's laser.

Each thing takes (rng, floor, area) and returns whether it found room in the area.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from fidmap.model import FloatArray
from fidmap.synth.floor import Floor, Point, Rect, turned

Thing = Callable[[np.random.Generator, Floor, Rect], bool]
OVERLAP = 0.75  # things stand closer together than their circumscribed circles would


def unlike(rng: np.random.Generator, low: float, high: float, radius_m: float) -> float:
    """A radius between two bounds that is not within 15 percent of the fiducials'."""
    for _ in range(20):
        drawn = float(rng.uniform(low, high))
        if abs(drawn / radius_m - 1) > 0.16:
            return drawn
    return radius_m * (0.75 if (low + high) / 2 < radius_m else 1.3)


def _settled(floor: Floor, centre: Point, radius_m: float) -> bool:
    """Take a place for a thing with this circumscribed circle, if there is room."""
    if not floor.has_room(*centre, radius_m):
        return False
    floor.block(*centre, OVERLAP * radius_m)
    return True


def desk(rng: np.random.Generator, floor: Floor, area: Rect) -> bool:
    """A desk at a wall: on four legs, with panels on two or three sides, or closed; perhaps with a chair."""
    half = (float(rng.uniform(0.5, 0.9)), float(rng.uniform(0.3, 0.42)))
    centre, turn = area.along_side(rng, half)
    if not _settled(floor, centre, half[0]):
        return False
    if rng.random() < 0.4:
        _legs(rng, floor, centre, half, turn)
    else:
        floor.box(centre, half, turn, sides=int(rng.integers(2, 5)))
    if rng.random() < 0.7:
        at = turned(np.array([[rng.uniform(-0.3, 0.3), -half[1] - rng.uniform(0.0, 0.5)]]), turn)[0]
        _chair_at(rng, floor, (centre[0] + float(at[0]), centre[1] + float(at[1])))
    return True


def table(rng: np.random.Generator, floor: Floor, area: Rect) -> bool:
    """A table on four legs somewhere in the room, with chairs around it."""
    half = (float(rng.uniform(0.3, 0.9)), float(rng.uniform(0.3, 0.5)))
    centre, turn = area.anywhere(rng, half[0] + 0.4), float(rng.uniform(0, math.pi))
    if not _settled(floor, centre, math.hypot(*half)):
        return False
    _legs(rng, floor, centre, half, turn)
    for side in (-1, 1):
        if rng.random() < 0.7:
            at = turned(np.array([[rng.uniform(-0.5, 0.5) * half[0], side * (half[1] + 0.2)]]), turn)[0]
            _chair_at(rng, floor, (centre[0] + float(at[0]), centre[1] + float(at[1])))
    return True


def chair(rng: np.random.Generator, floor: Floor, area: Rect) -> bool:
    """A chair somewhere."""
    return _chair_at(rng, floor, area.anywhere(rng, 0.4))


def _chair_at(rng: np.random.Generator, floor: Floor, centre: Point) -> bool:
    """Four thin legs in a square of 0.4 m, or the five feet and the column of an office chair."""
    if not floor.has_room(*centre, 0.25):
        return False
    floor.block(*centre, 0.15)
    turn = float(rng.uniform(0, 2 * math.pi))
    if rng.random() < 0.5:
        _legs(rng, floor, centre, (0.2, 0.2), turn, inset=0.0)
        return True
    reach = float(rng.uniform(0.22, 0.32))
    floor.round(*centre, float(rng.uniform(0.02, 0.035)))
    for angle in turn + np.arange(5) * 2 * math.pi / 5:
        floor.round(
            centre[0] + reach * math.cos(angle),
            centre[1] + reach * math.sin(angle),
            float(rng.uniform(0.02, 0.035)),
        )
    return True


def _legs(
    rng: np.random.Generator, floor: Floor, centre: Point, half: Point, turn: float, *, inset: float = 0.05
) -> None:
    radius_m = float(rng.uniform(0.01, 0.03))
    x, y = half[0] - inset, half[1] - inset
    for px, py in turned(np.array([[-x, -y], [x, -y], [x, y], [-x, y]]), turn) + centre:
        floor.round(float(px), float(py), radius_m)


def cupboard(rng: np.random.Generator, floor: Floor, area: Rect) -> bool:
    """A closed box at a wall, often as wide as a barrel; not always quite straight."""
    if rng.random() < 0.5:
        half = (
            float(rng.uniform(0.85, 1.05)) * floor.radius_m,
            float(rng.uniform(0.4, 1.1)) * floor.radius_m,
        )
    else:
        half = (float(rng.uniform(0.2, 0.6)), float(rng.uniform(0.15, 0.3)))
    half = (half[0], min(half[1], 0.3))
    centre, turn = area.along_side(rng, half)
    if not _settled(floor, centre, math.hypot(*half)):
        return False
    floor.box(centre, half, turn + float(rng.normal(0, 0.03)))
    return True


def box(rng: np.random.Generator, floor: Floor, area: Rect) -> bool:
    """A turned box somewhere, sometimes with its corners cut or only three of its sides in the beams."""
    half = (float(rng.uniform(0.12, 0.4)), float(rng.uniform(0.12, 0.35)))
    centre, turn = area.anywhere(rng, 0.4), float(rng.uniform(0, math.pi))
    if not _settled(floor, centre, math.hypot(*half)):
        return False
    if rng.random() < 0.3:
        floor.line(turned(_cut_corners(half, float(rng.uniform(0.05, 0.12))), turn) + centre, closed=True)
    else:
        floor.box(centre, half, turn, sides=int(rng.choice([2, 3, 4], p=[0.1, 0.2, 0.7])))
    return True


def _cut_corners(half: Point, cut: float) -> FloatArray:
    """The eight corners of a box whose own four are cut off."""
    x, y = half
    ring = [(x, y - cut), (x - cut, y), (cut - x, y), (-x, y - cut)]
    return np.array([*ring, *((-px, -py) for px, py in ring)])


def round_bin(rng: np.random.Generator, floor: Floor, area: Rect) -> bool:
    """A bin, bucket or water cooler at a wall or in the open."""
    radius_m = unlike(rng, 0.1, 0.25, floor.radius_m)
    at_wall = area.along_side(rng, (radius_m + 0.02, radius_m + float(rng.uniform(0.0, 0.1))))[0]
    return _round_at(floor, at_wall if rng.random() < 0.7 else area.anywhere(rng, 0.4), radius_m)


def column(rng: np.random.Generator, floor: Floor, area: Rect) -> bool:
    """A round column in the open or sunk into a wall, a little or much bigger or smaller than barrels."""
    low, high = ((0.2, 0.28), (0.33, 0.6))[int(rng.integers(2))]
    radius_m = unlike(rng, low, high, floor.radius_m)
    if rng.random() < 0.5:
        return _round_at(floor, area.along_side(rng, (radius_m, float(rng.uniform(0.0, 1.0)) * radius_m))[0], radius_m)
    return _round_at(floor, area.anywhere(rng, radius_m + 0.6), radius_m)


def cone(rng: np.random.Generator, floor: Floor, area: Rect) -> bool:
    """A traffic cone or post somewhere."""
    return _round_at(floor, area.anywhere(rng, 0.3), unlike(rng, 0.05, 0.2, floor.radius_m))


def _round_at(floor: Floor, centre: Point, radius_m: float) -> bool:
    if not _settled(floor, centre, radius_m + 0.05):
        return False
    floor.round(*centre, radius_m)
    return True


def plant(rng: np.random.Generator, floor: Floor, area: Rect) -> bool:
    """Leaves, cables, coats: a ragged line within a disc, no two sides alike, with loose ends."""
    reach = float(rng.uniform(0.2, 0.5))
    centre = area.along_side(rng, (reach, 0.7 * reach))[0] if rng.random() < 0.7 else area.anywhere(rng, 0.5)
    if not _settled(floor, centre, reach):
        return False
    for _ in range(int(rng.integers(2, 6))):
        start = rng.uniform(-0.6, 0.6, 2) * reach
        steps = rng.normal(0, 0.3 * reach, (int(rng.integers(2, 7)), 2))
        path = start + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
        norm = np.hypot(*path.T)
        path *= np.minimum(1, reach / np.maximum(norm, 1e-9))[:, None]
        floor.line(path + centre)
    return True


def counter(rng: np.random.Generator, floor: Floor, area: Rect) -> bool:
    """A curved counter: a slice of a ring of 0.6 to 1.5 m, two arcs and two ends."""
    outer, deep = unlike(rng, 0.6, 1.5, floor.radius_m), float(rng.uniform(0.2, 0.5))
    facing, opening = float(rng.uniform(-math.pi, math.pi)), float(rng.uniform(1.0, 2.8))
    back = outer * float(rng.uniform(0.5, 0.9))
    middle = area.anywhere(rng, 0.8)
    if not _settled(floor, middle, 0.8):
        return False
    x, y = middle[0] - back * math.cos(facing), middle[1] - back * math.sin(facing)
    for radius_m in (outer, outer - deep):
        floor.round(x, y, radius_m, facing, opening)
    for end in (facing - opening / 2, facing + opening / 2):
        way = np.array([[math.cos(end), math.sin(end)]])
        floor.line(np.array([[x, y]]) + [[outer - deep], [outer]] * way)
    return True


def partition(rng: np.random.Generator, floor: Floor, area: Rect) -> bool:
    """A thin screen at any angle, straight or bent once."""
    length, turn = float(rng.uniform(0.8, 1.8)), float(rng.uniform(0, 2 * math.pi))
    centre = area.anywhere(rng, 0.6)
    if not _settled(floor, centre, length / 2):
        return False
    points = [[-length / 2, 0.0], [length / 2, 0.0]]
    if rng.random() < 0.5:
        points.append([length / 2, float(rng.uniform(0.4, 1.0))])
    floor.line(turned(np.array(points), turn) + centre)
    return True


def sofa(rng: np.random.Generator, floor: Floor, area: Rect) -> bool:
    """A couch or an armchair with its back to a wall: a box with round arms."""
    half = (float(rng.uniform(0.4, 1.0)), float(rng.uniform(0.35, 0.45)))
    arm = unlike(rng, 0.08, 0.14, floor.radius_m)
    centre, turn = area.along_side(rng, half)
    if not _settled(floor, centre, half[0]):
        return False
    floor.box(centre, half, turn, sides=4)
    for x, y in turned(np.array([[-half[0], -half[1]], [half[0], -half[1]]]), turn) + centre:
        floor.round(float(x), float(y), arm)
    return True


def person(rng: np.random.Generator, x_m: float, y_m: float) -> FloatArray:
    """Arcs of somebody who stands there: two legs, or a body of two overlapping rounds."""
    turn = float(rng.uniform(0, math.pi))
    legs = rng.random() < 0.7
    radius_m, apart = (rng.uniform(0.05, 0.09), rng.uniform(0.1, 0.2)) if legs else (rng.uniform(0.11, 0.15), 0.1)
    away = apart * np.array([[math.cos(turn), math.sin(turn)]])
    places = np.array([x_m, y_m]) + [[1.0], [-1.0]] * away
    return np.column_stack([places, np.full((2, 3), [radius_m, 0.0, 2 * math.pi])])


def crowds(rng: np.random.Generator, places: FloatArray, people: int, stretches: int) -> tuple[FloatArray, ...]:
    """Who stands about during each of some stretches of a drive: up to twice `people`, at places (N, 2)."""
    result = []
    for _ in range(stretches if people and len(places) else 0):
        count = int(rng.integers(0, 2 * people + 1))
        chosen = places[rng.integers(len(places), size=count)]
        bodies = [person(rng, float(x), float(y)) for x, y in chosen]
        result.append(np.concatenate([np.zeros((0, 5)), *bodies]))
    return tuple(result)


IN_ROOMS: tuple[tuple[Thing, float], ...] = (
    (desk, 5), (table, 1.5), (chair, 2), (cupboard, 4), (box, 1.5), (round_bin, 1.5), (column, 0.5),
    (plant, 1.5), (counter, 0.3), (partition, 1), (sofa, 0.8),
)  # fmt: skip
IN_CORRIDORS: tuple[tuple[Thing, float], ...] = (
    (cupboard, 3), (round_bin, 1.5), (column, 0.7), (plant, 1), (chair, 0.5), (box, 0.3),
)  # fmt: skip
IN_FIELDS: tuple[tuple[Thing, float], ...] = (
    (cone, 4), (box, 3), (column, 2), (partition, 1), (plant, 1), (counter, 0.5), (table, 0.5), (chair, 0.5),
)  # fmt: skip


def furnish(
    rng: np.random.Generator, floor: Floor, area: Rect, count: int, things: tuple[tuple[Thing, float], ...]
) -> None:
    """Try to place so many things of the given kinds and weights in an area."""
    weights = np.array([weight for _, weight in things])
    for index in rng.choice(len(things), count, p=weights / weights.sum()):
        things[index][0](rng, floor, area)
