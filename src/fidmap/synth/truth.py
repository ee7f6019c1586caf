"""The truth about every fiducial part of one map: where this map draws it, how much of it, and how often.

No detector is involved: the laser knows which beams hit which part, the estimated poses say where the map puts them,
and the mapper how long it remembers them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import cv2
import numpy as np
import numpy.typing as npt
from scipy import ndimage

from fidmap.grid import metres_to_cells, trinarize
from fidmap.model import FiducialPart, FloatArray, Grid, Label
from fidmap.synth.arena import SynthArena
from fidmap.synth.copies import BINS, Copy, copies_of, hits_of
from fidmap.synth.laser import Scans
from fidmap.synth.mappers import Mapper

IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]
INK_CELLS = 1.5  # how far from its circle an arc is drawn
INK_RADII = 0.35  # the same for small circles: farther off is another circle
CLUTTER = 0.4  # radii beyond the thickness of drawn arcs (and 1.5 cells more): black there is not the arc's


@dataclass(frozen=True)
class PartTruth:
    """One fiducial part in one map.

    id, x_m, y_m, facing: as in the arena (facing None for a whole barrel). drawn_x_m, drawn_y_m,
    drawn_facing: in the map's frame, None where no scan saw the part. voted_x_m, voted_y_m: where the scans that drew
    it put it on average, whatever the map still shows of them. seen: angle that beams hit, in the main
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
    voted_x_m: float | None = None
    voted_y_m: float | None = None
    seen: float = 0.0
    support: float = 0.0
    clutter: float = 0.0
    drawn: Literal["yes", "partly", "no"] = "no"
    copies: tuple[tuple[float, float], ...] = ()
    scans: int = 0


@dataclass(frozen=True, eq=False)
class _Ink:
    """Where a map is black."""

    grid: Grid
    occupied: BoolArray

    def on_circle(self, copy: Copy, radius_m: float, cells: float) -> BoolArray:
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

    def shows(self, points: FloatArray) -> BoolArray:
        """(N,) whether a map is black in the cell of each point or beside it."""
        at = np.floor(metres_to_cells(points, self.grid.resolution_m, self.grid.origin)).astype(np.int64)
        rows, columns = np.clip(at, 0, np.array(self.occupied.shape) - 1).T
        return np.asarray(self._widened[rows, columns] > 0)

    @cached_property
    def _widened(self) -> npt.NDArray[np.uint8]:
        return np.asarray(cv2.dilate(self.occupied.astype(np.uint8), np.ones((3, 3), np.uint8)))


def part_truths(
    arena: SynthArena, scans: Scans, poses: FloatArray, grid: Grid | None = None, mapper: Mapper | None = None
) -> tuple[PartTruth, ...]:
    """The truth about all parts, in the order of `arena.arena.parts`.

    Args:
        arena: what was seen.
        scans: with their true poses (M scans).
        poses: (M, 3) the poses that the map was made with, map frame.
        grid: the map; without it support is `seen` and clutter 0.
        mapper: what drew it; without it hits are counted, up to 20 m.
    """
    mapper = mapper or Mapper()
    ink = None if grid is None else _Ink(grid, trinarize(grid).labels == Label.OCCUPIED)
    truths = []
    for index, (scan, beam) in enumerate(_beams_by_part(scans, len(arena.arena.parts), mapper)):
        arc = arena.part_arc(index)
        hits = hits_of(scans, poses, scan, beam, arc)
        if ink is not None:
            hits = replace(hits, shown=ink.shows(hits.points))
        copies = copies_of(hits, float(arc[2]), mapper, None if grid is None else grid.resolution_m)
        truths.append(_truth(arena.arena.parts[index], arc, copies, ink))
    return tuple(truths)


def _beams_by_part(scans: Scans, parts: int, mapper: Mapper) -> list[tuple[IntArray, IntArray]]:
    """Scans and beams, scan by scan, that hit each part within a mapper's range."""
    scan, beam = np.nonzero((scans.parts >= 0) & (scans.ranges < mapper.usable_m))
    part = scans.parts[scan, beam]
    order = np.argsort(part, kind="stable")
    bounds = np.searchsorted(part[order], np.arange(1, parts))
    return list(zip(np.split(scan[order], bounds), np.split(beam[order], bounds), strict=True))[:parts]


def _truth(part: FiducialPart, arc: FloatArray, copies: list[Copy], ink: _Ink | None) -> PartTruth:
    known = PartTruth(part.id, float(arc[0]), float(arc[1]), part.facing, part.opening)
    if not copies:
        return known
    # What the map shows best is where it draws the part; ties go to the copy that was seen most completely. The few
    # hits that a map shows of a faint copy may lie on another one's cells, so all are asked where they are.
    there = [_angles(replace(copy, centre=copy.all_hits), part.opening, float(arc[2]), ink) for copy in copies]
    main = copies[max(range(len(copies)), key=lambda k: (there[k][1] - there[k][2], -k))]
    seen, support, clutter = _angles(main, part.opening, float(arc[2]), ink)
    return replace(
        known,
        drawn_x_m=float(main.centre[0]),
        drawn_y_m=float(main.centre[1]),
        drawn_facing=None if part.facing is None else math.remainder(part.facing + main.turn, 2 * math.pi),
        voted_x_m=float(main.voted[0]),
        voted_y_m=float(main.voted[1]),
        seen=seen,
        support=support,
        clutter=clutter,
        drawn=_drawn(support, clutter, part.opening),
        copies=tuple((float(c.centre[0]), float(c.centre[1])) for c in copies if c is not main),
        scans=main.scans,
    )


def _angles(copy: Copy, opening: float, radius_m: float, ink: _Ink | None) -> tuple[float, float, float]:
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
