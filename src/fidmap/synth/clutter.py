"""Where things can stand in a pallet maze, and the things that are no fiducials.

What a detector takes for a barrel: round objects of other radii, columns in corners, curved walls, boxes, and
wall ends as broad as a barrel (door frames).
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fidmap.synth.maze import STEPS, Pallet, PalletMaze, wall_count_at_corners

Arc = tuple[float, float, float, float, float]
Side = tuple[Pallet, str]

DIRECTION = {"E": 0.0, "N": math.pi / 2, "W": math.pi, "S": -math.pi / 2}
CLEARANCE_M = 0.05  # between objects


class Placer:
    """Collects the arcs and segments of an arena and keeps objects from standing in each other.

    arcs: x, y, radius, middle direction, opening. segments: x0, y0, x1, y1. objects: the fiducials, each the
    indices of its arcs. pallet_of: by arc, the pallet a half barrel is seen from.
    """

    def __init__(self, maze: PalletMaze, wall_m: float, radius_m: float) -> None:
        self.maze = maze
        self.wall_m = wall_m
        self.radius_m = radius_m
        self.arcs: list[Arc] = []
        self.segments: list[tuple[float, float, float, float]] = []
        self.objects: list[list[int]] = []
        self.pallet_of: dict[int, Pallet] = {}
        self._discs: list[tuple[float, float, float]] = []
        self._used_sides: set[Side] = set()

    def free_sides(self, rng: np.random.Generator) -> Iterator[Side]:
        """Sides of pallets with a wall and nothing on it, in random order."""
        rows, columns = self.maze.shape
        for index in rng.permutation(rows * columns * 4):
            pallet, side = (int(index) // 4 // columns, int(index) // 4 % columns), "ENWS"[int(index) % 4]
            if self.is_free(pallet, side):
                yield pallet, side

    def is_free(self, pallet: Pallet, side: str) -> bool:
        """Whether a side of a pallet has a wall, and nothing stands on it."""
        used = (pallet, side) in self._used_sides or bool(self.maze.void[pallet])
        return not used and not self.maze.is_open(pallet, side)

    def has_room(self, x_m: float, y_m: float, radius_m: float) -> bool:
        """Whether a disc would keep its distance from everything placed so far."""
        return all(math.hypot(x_m - x, y_m - y) >= radius_m + r + CLEARANCE_M for x, y, r in self._discs)

    def block(self, x_m: float, y_m: float, radius_m: float) -> None:
        """Keep later objects out of a disc."""
        self._discs.append((x_m, y_m, radius_m))

    def on_wall(self, pallet: Pallet, side: str, shift_m: float) -> tuple[float, float]:
        """The point on the wall's surface seen from a pallet, `shift_m` off its middle."""
        size = self.maze.pallet_m
        dr, dc = STEPS[side]
        inward = size / 2 - self.wall_m / 2
        x_m = (pallet[1] + 0.5) * size + dc * inward + abs(dr) * shift_m
        y_m = (pallet[0] + 0.5) * size + dr * inward + abs(dc) * shift_m
        return x_m, y_m

    def add_on_wall(self, pallet: Pallet, side: str, shift_m: float, radius_m: float, *, part: bool = False) -> bool:
        """Put a half round on a wall, seen from a pallet; returns whether there was room."""
        x_m, y_m = self.on_wall(pallet, side, shift_m)
        if not self.is_free(pallet, side) or not self.has_room(x_m, y_m, radius_m):
            return False
        if part:
            self.objects.append([len(self.arcs)])
            self.pallet_of[len(self.arcs)] = pallet
        self.arcs.append((x_m, y_m, radius_m, _turned(DIRECTION[side]), math.pi))
        self._used_sides.add((pallet, side))
        self.block(x_m, y_m, radius_m)
        return True

    def add_pair(self, first: Side, second: Side, shift_m: float) -> bool:
        """Put the two halves of a pair on their walls; returns whether there was room for both."""
        points = [self.on_wall(*first, shift_m), self.on_wall(*second, shift_m)]
        free = self.is_free(*first) and self.is_free(*second)
        if not free or not all(self.has_room(*point, self.radius_m) for point in points):
            return False
        members = []
        for (pallet, side), point in zip((first, second), points, strict=True):
            members.append(len(self.arcs))
            self.pallet_of[len(self.arcs)] = pallet
            self.arcs.append((*point, self.radius_m, _turned(DIRECTION[side]), math.pi))
            self._used_sides.add((pallet, side))
            self.block(*point, self.radius_m)
        self.objects.append(members)
        return True

    def add_at_corner(self, corner: Pallet, radius_m: float, *, part: bool = False) -> bool:
        """Put a whole round on a corner of the lattice; returns whether there was room."""
        x_m, y_m = corner[1] * self.maze.pallet_m, corner[0] * self.maze.pallet_m
        if not self.has_room(x_m, y_m, radius_m):
            return False
        if part:
            self.objects.append([len(self.arcs)])
        self.arcs.append((x_m, y_m, radius_m, 0.0, 2 * math.pi))
        self.block(x_m, y_m, radius_m)
        return True


def _turned(angle: float) -> float:
    """The opposite direction, in (-pi, pi]."""
    return angle - math.pi if angle > 0 else angle + math.pi


def add_clutter(rng: np.random.Generator, placer: Placer, count: int) -> None:
    """Add `count` things that are no fiducials, of all kinds in turn, as far as there is room."""
    kinds = (_half_round, _corner_thing, _box, _broad_wall_end, _free_round)
    placed = 0
    for attempt in range(6 * count):
        if placed == count:
            return
        placed += kinds[attempt % len(kinds)](rng, placer)


def other_radius(rng: np.random.Generator, radius_m: float) -> float:
    """A radius that is not the fiducials': 0.6 to 0.8 or 1.3 to 1.6 of it."""
    return radius_m * float(rng.uniform(0.6, 0.8) if rng.random() < 0.5 else rng.uniform(1.3, 1.6))


def _half_round(rng: np.random.Generator, placer: Placer) -> bool:
    """A half round of another radius on a wall."""
    radius_m = min(other_radius(rng, placer.radius_m), placer.maze.pallet_m / 2 - 0.12)
    for pallet, side in placer.free_sides(rng):
        if radius_m < placer.radius_m or len(placer.maze.neighbours(pallet)) > 1:  # dead ends are turned in
            return placer.add_on_wall(pallet, side, rng.uniform(-0.1, 0.1), radius_m)
    return False


def _free_round(rng: np.random.Generator, placer: Placer) -> bool:
    """A whole round of another radius on a wall's free end or a corner without walls."""
    corners = np.argwhere(wall_count_at_corners(placer.maze) <= 1)
    if not len(corners):
        return False
    r, c = corners[rng.integers(len(corners))]
    return placer.add_at_corner((int(r), int(c)), other_radius(rng, placer.radius_m))


def _corner_thing(rng: np.random.Generator, placer: Placer) -> bool:
    """A quarter column in a corner between two walls, or a curved wall that rounds the corner off."""
    for pallet, side in placer.free_sides(rng):
        turn = "ENWS"["ENWS".index(side) - 3]
        if not placer.is_free(pallet, turn):
            continue
        diagonal = DIRECTION[side] + math.pi / 4
        size = placer.maze.pallet_m
        middle = ((pallet[1] + 0.5) * size, (pallet[0] + 0.5) * size)
        reach = (size - placer.wall_m) / 2
        corner = tuple(m + math.copysign(reach, f(diagonal)) for m, f in zip(middle, _COS_SIN, strict=True))
        if not placer.has_room(corner[0], corner[1], 0.5 * size):
            return False
        if rng.random() < 0.5:
            arc = (*middle, reach, diagonal, math.pi / 2)
        else:
            arc = (
                corner[0],
                corner[1],
                rng.uniform(0.6, 1.6) * placer.radius_m,
                diagonal + math.pi,
                math.pi / 2,
            )
        placer.arcs.append(arc)
        placer.block(corner[0], corner[1], 0.5 * size)
        return True
    return False


_COS_SIN = (math.cos, math.sin)


def _box(rng: np.random.Generator, placer: Placer) -> bool:
    """A turned box beside the way, narrower than a barrel."""
    size = placer.maze.pallet_m
    rows, columns = placer.maze.shape
    r, c = int(rng.integers(rows)), int(rng.integers(columns))
    half = rng.uniform(0.06, 0.14, 2) * size
    quadrant = rng.choice([-1.0, 1.0], 2) * 0.3 * size
    x_m, y_m = (c + 0.5) * size + quadrant[0], (r + 0.5) * size + quadrant[1]
    if placer.maze.void[r, c] or not placer.has_room(x_m, y_m, float(np.hypot(*half))):
        return False
    _add_box(placer, (x_m, y_m), (float(half[0]), float(half[1])), rng.uniform(0, math.pi))
    return True


def _broad_wall_end(rng: np.random.Generator, placer: Placer) -> bool:
    """A door frame: the free end of a wall, 0.5 to 0.6 m broad and up to 0.3 m deep."""
    ends = np.argwhere(wall_count_at_corners(placer.maze) == 1)
    if not len(ends):
        return False
    r, c = ends[rng.integers(len(ends))]
    x_m, y_m = c * placer.maze.pallet_m, r * placer.maze.pallet_m
    broad = rng.uniform(0.8, 1.05) * placer.radius_m
    deep = rng.uniform(0.1, 0.5) * placer.radius_m
    half = (broad, deep) if rng.random() < 0.5 else (deep, broad)
    if not placer.has_room(x_m, y_m, broad):
        return False
    _add_box(placer, (x_m, y_m), half, 0.0)
    return True


def _add_box(placer: Placer, centre: tuple[float, float], half: tuple[float, float], turn: float) -> None:
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    c, s = math.cos(turn), math.sin(turn)
    corners = corners @ np.array([[c, s], [-s, c]]) + centre
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        placer.segments.append((float(a[0]), float(a[1]), float(b[0]), float(b[1])))
    placer.block(*centre, math.hypot(*half))
