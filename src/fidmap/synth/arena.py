"""Artificial arenas: a pallet maze with half barrels, whole barrels and things that look like them.

Everything is in the arena's frame: metres, x right, y up, angles counter-clockwise in radians.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.model import Arena, FiducialPart, FloatArray, Group
from fidmap.synth.clutter import Placer, Side, add_clutter
from fidmap.synth.maze import (
    OPPOSITE,
    STEPS,
    BoolArray,
    Pallet,
    PalletMaze,
    hangs_together,
    open_around,
    random_maze,
    walking_distances,
    wall_boxes,
)

LONG_OVER = 6  # pallets: half of the pairs are sought beyond it, so that both classes exist


@dataclass(frozen=True)
class ArenaSpec:
    """What to build.

    columns, rows: size in pallets. pairs: half barrels on both sides of a wall. void_pairs: on both sides of
    a closed pallet. singles: halves without a partner. wholes: free-standing barrels. clutter: round things
    of other radii, columns, curved walls, boxes and broad wall ends. wall_m: thickness of walls. openness:
    share of walls left out of the maze. Where the maze has no room left, fewer objects are placed.
    """

    columns: int = 8
    rows: int = 6
    pairs: int = 6
    void_pairs: int = 1
    singles: int = 0
    wholes: int = 0
    clutter: int = 0
    wall_m: float = 0.02
    openness: float = 0.15
    radius_m: float = 0.30
    pallet_m: float = 1.2
    name: str = "synthetic"


@dataclass(frozen=True, eq=False)
class SynthArena:
    """An arena with all that a laser can hit.

    arena: the ground truth as fidmap scores it. maze: the pallets. walls: (S, 4) segments x0, y0, x1, y1.
    arcs: (C, 5) x, y, radius, middle direction, opening; an opening of 2 pi is a whole circle.
    arc_part: (C,) index of the arc's fiducial part in `arena.parts`, -1 for clutter.
    way: (K, 2) points that the robot drives along; None: through the maze, pallet by pallet.
    crowds: people as arcs (P, 5), each there during an equal share of the drive only.
    """

    arena: Arena
    maze: PalletMaze
    walls: FloatArray
    arcs: FloatArray
    arc_part: npt.NDArray[np.int64]
    wall_m: float
    way: FloatArray | None = None
    crowds: tuple[FloatArray, ...] = ()

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        for name in ("walls", "arcs", "arc_part"):
            view = getattr(self, name).view()
            view.setflags(write=False)
            object.__setattr__(self, name, view)

    def part_arc(self, index: int) -> FloatArray:
        """(5,) the arc of a fiducial part, by its index in `arena.parts`."""
        return np.asarray(self.arcs[np.flatnonzero(self.arc_part == index)[0]])


def make_arena(rng: np.random.Generator, spec: ArenaSpec | None = None) -> SynthArena:
    """Build an arena at random from its specification.

    Raises:
        ValueError: the specification asks for less than 2 x 2 pallets or barrels too big for a pallet.
    """
    spec = spec or ArenaSpec()
    if min(spec.columns, spec.rows) < 2 or 2 * spec.radius_m > 0.6 * spec.pallet_m:
        raise ValueError("an arena needs 2 x 2 pallets or more, and barrels no wider than 0.6 of a pallet")
    voids = _choose_voids(rng, spec)
    maze = random_maze(
        rng,
        (spec.rows, spec.columns),
        void=_void_map(spec, voids),
        openness=spec.openness,
        pallet_m=spec.pallet_m,
    )
    maze, corners = _clear_corners(rng, maze, spec.wholes)
    placer = Placer(maze, spec.wall_m, spec.radius_m)
    _place_void_pairs(rng, placer, voids)
    _place_pairs(rng, placer, spec.pairs)
    _place_singles(rng, placer, spec.singles)
    for corner in corners:
        placer.add_at_corner(corner, spec.radius_m, part=True)
    add_clutter(rng, placer, spec.clutter)
    return _build(spec, maze, placer)


def _choose_voids(rng: np.random.Generator, spec: ArenaSpec) -> list[tuple[Pallet, str]]:
    """Inner pallets for voids, each with the side (E or N) of its pair's second half."""
    taken = np.zeros((spec.rows, spec.columns), bool)
    chosen: list[tuple[Pallet, str]] = []
    for _ in range(40 * spec.void_pairs):
        if len(chosen) == spec.void_pairs or min(spec.rows, spec.columns) < 3:
            break
        r, c = int(rng.integers(1, spec.rows - 1)), int(rng.integers(1, spec.columns - 1))
        trial = taken.copy()
        trial[r, c] = True
        apart = all(abs(r - p[0]) + abs(c - p[1]) > 2 for p, _ in chosen)
        if apart and hangs_together(trial):
            taken = trial
            chosen.append(((r, c), "EN"[int(rng.integers(2))]))
    return chosen


def _void_map(spec: ArenaSpec, voids: list[tuple[Pallet, str]]) -> BoolArray:
    void = np.zeros((spec.rows, spec.columns), bool)
    for pallet, _ in voids:
        void[pallet] = True
    return void


def _clear_corners(rng: np.random.Generator, maze: PalletMaze, count: int) -> tuple[PalletMaze, list[Pallet]]:
    """Take the walls away around some inner corners, where whole barrels will stand."""
    rows, columns = maze.shape
    corners: list[Pallet] = []
    for _ in range(20 * count):
        if len(corners) == count or min(rows, columns) < 3:
            break
        r, c = int(rng.integers(1, rows)), int(rng.integers(1, columns))
        apart = all(abs(r - p[0]) + abs(c - p[1]) > 1 for p in corners)
        if apart and not maze.void[r - 1 : r + 1, c - 1 : c + 1].any():
            maze = open_around(maze, (r, c))
            corners.append((r, c))
    return maze, corners


def _place_void_pairs(rng: np.random.Generator, placer: Placer, voids: list[tuple[Pallet, str]]) -> None:
    for (r, c), side in voids:
        dr, dc = STEPS[side]
        shift = rng.uniform(-0.12, 0.12)
        placer.add_pair(((r - dr, c - dc), side), ((r + dr, c + dc), OPPOSITE[side]), shift)


def _place_pairs(rng: np.random.Generator, placer: Placer, count: int) -> None:
    """Pairs on inner walls: long and short ways between the halves in turn, as far as the maze has them."""
    walls = list(_inner_walls(placer.maze))
    order = rng.permutation(len(walls))
    short: list[tuple[Side, Side]] = []
    long: list[tuple[Side, Side]] = []
    for pallet, side in (walls[i] for i in order):
        other = (pallet[0] + STEPS[side][0], pallet[1] + STEPS[side][1])
        way = int(walking_distances(placer.maze, pallet)[other]) if len(long) + len(short) < 4 * count else 0
        (long if way > LONG_OVER else short).append(((pallet, side), (other, OPPOSITE[side])))
    placed = 0
    while placed < count and (short or long):
        source = long if (placed % 2 == 0 and long) or not short else short
        first, second = source.pop(0)
        placed += placer.add_pair(first, second, rng.uniform(-0.15, 0.15))


def _inner_walls(maze: PalletMaze) -> Iterator[tuple[Pallet, str]]:
    rows, columns = maze.shape
    for r in range(rows):
        for c in range(columns):
            for side in "EN":
                dr, dc = STEPS[side]
                other = (r + dr, c + dc)
                inside = other[0] < rows and other[1] < columns
                if inside and not (maze.is_open((r, c), side) or maze.void[r, c] or maze.void[other]):
                    yield (r, c), side


def _place_singles(rng: np.random.Generator, placer: Placer, count: int) -> None:
    placed = 0
    for pallet, side in placer.free_sides(rng):
        if placed == count:
            return
        placed += placer.add_on_wall(pallet, side, rng.uniform(-0.15, 0.15), placer.radius_m, part=True)


def _build(spec: ArenaSpec, maze: PalletMaze, placer: Placer) -> SynthArena:
    """The frozen arena: parts and groups named after the order of placing (1A and 1B are a pair)."""
    parts: list[FiducialPart] = []
    groups: list[Group] = []
    arc_part = np.full(len(placer.arcs), -1, np.int64)
    for number, members in enumerate(placer.objects, start=1):
        ids = [f"{number}{'AB'[k] if len(members) > 1 else ''}" for k in range(len(members))]
        for part_id, arc in zip(ids, members, strict=True):
            arc_part[arc] = len(parts)
            parts.append(_part(part_id, placer.arcs[arc]))
        if len(members) > 1:
            first, second = (placer.pallet_of[arc] for arc in members)
            way = int(walking_distances(maze, first)[second])
            distance = math.dist(placer.arcs[members[0]][:2], placer.arcs[members[1]][:2])
            groups.append(Group(str(number), tuple(ids), None, float(way), distance))
    arena = Arena(spec.name, spec.radius_m, tuple(parts), tuple(groups), "relative", spec.pallet_m)
    boxes = wall_boxes(maze, spec.wall_m)
    walls = np.concatenate([box_segments(boxes), np.asarray(placer.segments, float).reshape(-1, 4)])
    return SynthArena(arena, maze, walls, np.asarray(placer.arcs, float).reshape(-1, 5), arc_part, spec.wall_m)


def _part(part_id: str, arc: tuple[float, float, float, float, float]) -> FiducialPart:
    x_m, y_m, _, facing, opening = arc
    return FiducialPart(part_id, x_m, y_m, None if opening > 6 else facing, opening)


def box_segments(boxes: FloatArray) -> FloatArray:
    """The four sides of each box (K, 4) x_min, y_min, x_max, y_max, as segments (4 K, 4)."""
    x0, y0, x1, y1 = boxes.T
    sides = [(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)]
    return np.concatenate([np.stack(side, axis=1) for side in sides])
