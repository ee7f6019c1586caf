"""The truth about every fiducial part of one map: where this map draws it, how much of it, and how often.

No detector is involved: the laser knows which beams hit which part, and the estimated poses say where the map
puts them. A scan seen from a wrong pose moves all it saw rigidly, so each scan votes for one drawn centre.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from fidmap.grid import metres_to_cells, trinarize
from fidmap.model import FiducialPart, FloatArray, Grid, Label
from fidmap.synth.arena import SynthArena
from fidmap.synth.laser import Scans

IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]
SAME_COPY = 0.5  # radii; scans whose votes lie farther apart draw the part twice
BINS = 120  # directions of a whole circle
COPY_BINS = 10  # a copy of less than 30 degrees is a smear, not an arc
INK_CELLS = 1.5  # how far from its circle an arc is drawn
INK_RADII = 0.35  # the same for small circles: farther off is another circle
CLUTTER = 0.4  # radii beyond the thickness of drawn arcs (and 1.5 cells more): black there is not the arc's


@dataclass(frozen=True)
class PartTruth:
    """One fiducial part in one map.

    id, x_m, y_m, facing: as in the arena (facing None for a whole barrel). drawn_x_m, drawn_y_m,
    drawn_facing: in the map's frame, None where no scan saw the part. seen: angle that beams hit, in the main
    copy. support: angle of these hits at which the map has occupied cells. clutter: angle at which it also
    has some outside the arc.
    drawn: 'yes' at support >= 2/3 and support - clutter >= 0.3 of the part's opening, 'partly' at 0.5 and
    0.2. A whole barrel needs less support, 'yes' at 1/2 (180 degrees: the least opening that a profile may
    ask for) and 'partly' at 1/3 (120 degrees), since who drives by sees no more of it.
    copies: other places where the part is drawn, map frame. scans: how many made the main copy.
    """

    id: str
    x_m: float
    y_m: float
    facing: float | None
    opening: float
    drawn_x_m: float | None = None
    drawn_y_m: float | None = None
    drawn_facing: float | None = None
    seen: float = 0.0
    support: float = 0.0
    clutter: float = 0.0
    drawn: Literal["yes", "partly", "no"] = "no"
    copies: tuple[tuple[float, float], ...] = ()
    scans: int = 0


@dataclass(frozen=True)
class _Copy:
    """One place where a part is drawn: centre, turn against the arena, directions hit, scans."""

    centre: FloatArray
    turn: float
    hit: BoolArray
    scans: int


@dataclass(frozen=True, eq=False)
class _Ink:
    """Where a map is black."""

    grid: Grid
    occupied: BoolArray

    def on_circle(self, copy: _Copy, radius_m: float, cells: float) -> BoolArray:
        """(BINS,) whether a map is black within so many cells of a circle about a copy, by direction."""
        angle = (np.arange(BINS) + 0.5) * 2 * math.pi / BINS + copy.turn
        outward = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        reach = cells * self.grid.resolution_m
        found = np.zeros(BINS, bool)
        for shift in np.linspace(-reach, reach, 7):
            ring = copy.centre + (radius_m + shift) * outward
            at = np.floor(metres_to_cells(ring, self.grid.resolution_m, self.grid.origin)).astype(np.int64)
            inside = np.all((at >= 0) & (at < self.occupied.shape), axis=1)
            rows, columns = (at * inside[:, None]).T
            np.logical_or(found, inside & self.occupied[rows, columns], out=found)
        return found


def part_truths(arena: SynthArena, scans: Scans, poses: FloatArray, grid: Grid | None = None) -> tuple[PartTruth, ...]:
    """The truth about all parts, in the order of `arena.arena.parts`.

    Args:
        arena: what was seen.
        scans: with their true poses (M scans).
        poses: (M, 3) the poses that the map was made with, map frame.
        grid: the map; without it support is `seen` and clutter 0.
    """
    scan, beam = np.nonzero(scans.parts >= 0)
    part = scans.parts[scan, beam]
    order = np.argsort(part, kind="stable")
    scan, beam = scan[order], beam[order]
    bounds = np.searchsorted(part[order], np.arange(len(arena.arena.parts) + 1))
    ink = None if grid is None else _Ink(grid, trinarize(grid).labels == Label.OCCUPIED)
    truths = []
    for index in range(len(arena.arena.parts)):
        mine = slice(bounds[index], bounds[index + 1])
        arc = arena.arcs[np.nonzero(arena.arc_part == index)[0][0]]
        copies = _copies(scans, poses, scan[mine], beam[mine], arc)
        truths.append(_truth(arena.arena.parts[index], arc, copies, ink))
    return tuple(truths)


def _copies(scans: Scans, poses: FloatArray, scan: IntArray, beam: IntArray, arc: FloatArray) -> list[_Copy]:
    """The places where a part is drawn, the most complete first."""
    true, believed = scans.poses[scan], poses[scan]
    angle = true[:, 2] + scans.bearings[beam]
    ranges = scans.ranges[scan, beam]
    points = true[:, :2] + ranges[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    direction = np.arctan2(*(points - arc[:2]).T[::-1])
    bins = np.floor((direction / (2 * math.pi) % 1) * BINS).astype(np.int64) % BINS
    turn = believed[:, 2] - true[:, 2]
    offset = arc[:2] - true[:, :2]
    c, s = np.cos(turn), np.sin(turn)
    votes = believed[:, :2] + np.stack(
        [c * offset[:, 0] - s * offset[:, 1], s * offset[:, 0] + c * offset[:, 1]], axis=1
    )
    copies: list[_Copy] = []
    left = np.ones(len(votes), bool)
    while left.any():
        inside = _densest(votes, left, SAME_COPY * float(arc[2]))
        copy = _Copy(
            votes[inside].mean(0),
            float(np.arctan2(s[inside].mean(), c[inside].mean())),
            np.bincount(bins[inside], minlength=BINS) > 0,
            len(np.unique(scan[inside])),
        )
        left &= ~inside
        if not copies or int(copy.hit.sum()) >= COPY_BINS:
            copies.append(copy)
    return sorted(copies, key=lambda copy: (-int(copy.hit.sum()), -copy.scans))


def _densest(votes: FloatArray, left: BoolArray, reach_m: float) -> BoolArray:
    """Mask of the votes left within reach of where most of them agree (mean shift from the densest vote)."""
    candidates = votes[left]
    seeds = np.unique(candidates, axis=0)  # all beams of a scan vote for one place
    seeds = seeds[:: max(1, len(seeds) // 200)]
    near = np.hypot(*(seeds[:, None] - candidates[None, :: max(1, len(candidates) // 2000)]).T) < reach_m
    centre = seeds[np.argmax(near.sum(0))]
    inside: BoolArray = left
    for _ in range(5):
        inside = left & (np.hypot(*(votes - centre).T) < reach_m)
        centre = votes[inside].mean(0) if inside.any() else centre
    if not inside.any():
        inside = left & np.equal(votes, candidates[0]).all(axis=1)
    return inside


def _truth(part: FiducialPart, arc: FloatArray, copies: list[_Copy], ink: _Ink | None) -> PartTruth:
    known = PartTruth(part.id, float(arc[0]), float(arc[1]), part.facing, part.opening)
    if not copies:
        return known
    angles = [_angles(copy, part.opening, float(arc[2]), ink) for copy in copies]
    # What the map shows best is where it draws the part; ties go to the copy that was seen most completely.
    best = max(range(len(copies)), key=lambda k: (angles[k][1] - angles[k][2], -k))
    main, (seen, support, clutter) = copies[best], angles[best]
    return replace(
        known,
        drawn_x_m=float(main.centre[0]),
        drawn_y_m=float(main.centre[1]),
        drawn_facing=None if part.facing is None else math.remainder(part.facing + main.turn, 2 * math.pi),
        seen=seen,
        support=support,
        clutter=clutter,
        drawn=_drawn(support, clutter, part.opening),
        copies=tuple((float(c.centre[0]), float(c.centre[1])) for c in copies if c is not main),
        scans=main.scans,
    )


def _angles(copy: _Copy, opening: float, radius_m: float, ink: _Ink | None) -> tuple[float, float, float]:
    """Angles of a copy: seen by beams; of these black in the map; of these black outside the arc too."""
    if ink is None:
        seen = _angle(_closed(copy.hit, 1), opening)
        return seen, seen, 0.0
    cells = radius_m / ink.grid.resolution_m
    covered = _closed(copy.hit, max(1, round(BINS / (2 * math.pi * cells))))
    black = covered & ink.on_circle(copy, radius_m, cells=min(INK_CELLS, max(1.0, INK_RADII * cells)))
    outside_m = (1 + CLUTTER) * radius_m + 1.5 * ink.grid.resolution_m
    dirty = black & ink.on_circle(copy, outside_m, cells=0.5)
    return _angle(covered, opening), _angle(black, opening), _angle(dirty, opening)


def _closed(hit: BoolArray, gap: int) -> BoolArray:
    """Directions hit, with gaps of up to so many bins closed.

    Beams seen from afar are 3 degrees (one bin) apart on the arc, and a cell hit shows all directions in it.
    """
    around = np.concatenate([hit[-gap:], hit, hit[:gap]])
    closed = ndimage.binary_closing(np.pad(around, gap), np.ones(gap + 1))
    return np.asarray(closed[2 * gap : 2 * gap + BINS], bool)


def _angle(mask: BoolArray, opening: float) -> float:
    """Angle of the marked directions; a half's two outermost bins are cut by the wall, hence the limit."""
    return min(opening, float(mask.sum()) * 2 * math.pi / BINS)


def _drawn(support: float, clutter: float, opening: float) -> Literal["yes", "partly", "no"]:
    """How well a part is drawn; see `PartTruth`."""
    yes, partly = (1 / 2, 1 / 3) if opening >= 2 * math.pi else (2 / 3, 1 / 2)
    share, clean = support / opening + 1e-9, (support - clutter) / opening
    if share >= yes and clean >= 0.3:
        return "yes"
    return "partly" if share >= partly and clean >= 0.2 else "no"
