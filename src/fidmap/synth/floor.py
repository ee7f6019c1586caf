"""What offices and fields are put together from: outlines and rounds on a plane, kept apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fidmap.model import Arena, FiducialPart, FloatArray, Group
from fidmap.synth.arena import SynthArena
from fidmap.synth.drive import FreeSpace

Point = tuple[float, float]
Interval = tuple[float, float]
WHOLE = 2 * math.pi
PALLET_M = 1.2  # walking distances are counted in pallets, whatever the place
LEFT, RIGHT = 1, -1


class Floor:
    """Collects segments and arcs, and remembers which discs of the plane are taken.

    arcs: x, y, radius, middle direction, opening. segments: x0, y0, x1, y1. objects: the fiducials, each the
    indices of its arcs.
    """

    def __init__(self, radius_m: float) -> None:
        self.radius_m = radius_m
        self.arcs: list[tuple[float, float, float, float, float]] = []
        self.segments: list[tuple[float, float, float, float]] = []
        self.objects: list[list[int]] = []
        self._discs: list[tuple[float, float, float]] = []

    def has_room(self, x_m: float, y_m: float, radius_m: float) -> bool:
        """Whether a disc touches nothing that was blocked."""
        return all((x - x_m) ** 2 + (y - y_m) ** 2 >= (r + radius_m) ** 2 for x, y, r in self._discs)

    def block(self, x_m: float, y_m: float, radius_m: float) -> None:
        """Keep later things out of a disc."""
        self._discs.append((x_m, y_m, radius_m))

    def line(self, points: Sequence[Point] | FloatArray, *, closed: bool = False) -> None:
        """A polyline through points (N, 2)."""
        xy = [(float(x), float(y)) for x, y in points]
        ends = [*xy[1:], xy[0]] if closed else xy[1:]
        self.segments.extend((*a, *b) for a, b in zip(xy, ends, strict=False))

    def box(self, centre: Point, half: Point, turn: float = 0.0, *, sides: int = 4) -> None:
        """A box turned by an angle; three sides are open towards its own -y, two towards -y and +x too."""
        x, y = half
        corners = np.array([[-x, -y], [-x, y], [x, y], [x, -y]])[: min(sides, 3) + 1]
        self.line(turned(corners, turn) + centre, closed=sides == 4)

    def round(self, x_m: float, y_m: float, radius_m: float, facing: float = 0.0, opening: float = WHOLE) -> None:
        """A whole round or an arc that shows towards `facing`."""
        self.arcs.append((x_m, y_m, radius_m, facing, opening))

    def fiducial(self, *parts: tuple[float, float, float, float]) -> None:
        """A fiducial of parts x, y, facing, opening; their surroundings are blocked."""
        self.objects.append(list(range(len(self.arcs), len(self.arcs) + len(parts))))
        for x, y, facing, opening in parts:
            self.round(x, y, self.radius_m, facing, opening)
            self.block(x, y, self.radius_m + 0.1)

    def outline(self) -> tuple[FloatArray, FloatArray]:
        """Segments (S, 4) and arcs (C, 5)."""
        return np.asarray(self.segments, float).reshape(-1, 4), np.asarray(self.arcs, float).reshape(-1, 5)


@dataclass(frozen=True)
class Rect:
    """An upright rectangle: a room or a corridor."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def size(self) -> Point:
        """Width and height."""
        return self.x1 - self.x0, self.y1 - self.y0

    def anywhere(self, rng: np.random.Generator, rim_m: float) -> Point:
        """A point at least `rim_m` from the sides, the middle where there is none."""
        points = []
        for low, high in ((self.x0, self.x1), (self.y0, self.y1)):
            slack = max(0.0, (high - low) / 2 - rim_m)
            points.append(float((low + high) / 2 + rng.uniform(-slack, slack)))
        return points[0], points[1]

    def along_side(self, rng: np.random.Generator, half: Point) -> tuple[Point, float]:
        """Where a box of half length and half depth stands with its back to a random side: centre, turn."""
        side = int(rng.integers(4))
        width, height = self.size if side % 2 == 0 else self.size[::-1]
        slack = max(0.0, width / 2 - half[0])
        local = np.array([[rng.uniform(-slack, slack), height / 2 - half[1]]])
        turn = side * math.pi / 2
        x, y = turned(local, turn)[0] + [(self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2]
        return (float(x), float(y)), turn


class Wall:
    """A straight wall of some thickness with gaps; places on it are metres along and across its middle line.

    sides: those that can be seen, LEFT or RIGHT of its direction.
    """

    def __init__(self, start: Point, end: Point, thick_m: float, sides: tuple[int, ...] = (LEFT, RIGHT)) -> None:
        self.start = start
        self.length = math.dist(start, end)
        self.direction = math.atan2(end[1] - start[1], end[0] - start[0])
        self.thick_m = thick_m
        self.sides = sides
        self.gaps: list[Interval] = []
        self._taken: dict[int, list[Interval]] = {LEFT: [], RIGHT: []}

    def xy(self, along: float, across: float) -> Point:
        """A place on the wall in the floor's frame."""
        c, s = math.cos(self.direction), math.sin(self.direction)
        return self.start[0] + along * c - across * s, self.start[1] + along * s + across * c

    def take(self, along: float, half: float, sides: Sequence[int] = (LEFT, RIGHT)) -> None:
        """Mark a stretch of some sides as used."""
        for side in sides:
            self._taken[side].append((along - half, along + half))

    def is_free(self, along: float, half: float, sides: Sequence[int] = (LEFT, RIGHT)) -> bool:
        """Whether nothing was put on a stretch of some sides."""
        if not half <= along <= self.length - half:
            return False
        return all(b <= along - half or a >= along + half for side in sides for a, b in self._taken[side])

    def find(self, rng: np.random.Generator, half: float, sides: Sequence[int]) -> float | None:
        """A free stretch at random, its middle; None where a dozen throws find none."""
        if self.length <= 2 * half:
            return None
        throws = rng.uniform(half, self.length - half, 12)
        return next((float(at) for at in throws if self.is_free(float(at), half, sides)), None)

    def box(self, floor: Floor, along: Interval, across: Interval) -> None:
        """A box in the wall's own directions."""
        centre = self.xy(sum(along) / 2, sum(across) / 2)
        floor.box(centre, ((along[1] - along[0]) / 2, (across[1] - across[0]) / 2), self.direction)

    def build(self, floor: Floor) -> None:
        """Draw what is left between the gaps."""
        begin = -self.thick_m / 2
        for a, b in [*sorted(self.gaps), (self.length + self.thick_m / 2, math.inf)]:
            if a - begin > 0.02:
                self.box(floor, (begin, a), (-self.thick_m / 2, self.thick_m / 2))
            begin = max(begin, b)


def turned(points: FloatArray, angle: float) -> FloatArray:
    """Points (N, 2) turned about the origin."""
    c, s = math.cos(angle), math.sin(angle)
    result: FloatArray = points @ np.array([[c, s], [-s, c]])
    return result


def finished(
    floor: Floor,
    space: FreeSpace,
    name: str,
    *,
    way: FloatArray,
    crowds: tuple[FloatArray, ...],
    wall_m: float,
) -> SynthArena:
    """The frozen arena: parts and groups named after the order of placing (1A and 1B are a pair)."""
    walls, arcs = floor.outline()
    arc_part = np.full(len(arcs), -1, np.int64)
    parts: list[FiducialPart] = []
    groups: list[Group] = []
    for number, members in enumerate(floor.objects, start=1):
        ids = tuple(f"{number}{'AB'[k] if len(members) > 1 else ''}" for k in range(len(members)))
        for part_id, arc in zip(ids, members, strict=True):
            x, y, _, facing, opening = floor.arcs[arc]
            arc_part[arc] = len(parts)
            parts.append(FiducialPart(part_id, x, y, None if opening == WHOLE else facing, opening))
        if len(members) > 1:
            first, second = arcs[members]
            walking = space.distance_m(_before(first), _before(second)) / PALLET_M
            groups.append(Group(str(number), ids, None, walking, math.dist(first[:2], second[:2])))
    arena = Arena(name, floor.radius_m, tuple(parts), tuple(groups), "relative", PALLET_M)
    return SynthArena(arena, space.maze, walls, arcs, arc_part, wall_m, way, crowds)


def _before(arc: FloatArray) -> Point:
    """Where a robot looks at an arc from: half a metre before its surface."""
    x, y, radius_m, facing, _ = arc.tolist()
    return x + (radius_m + 0.5) * math.cos(facing), y + (radius_m + 0.5) * math.sin(facing)
