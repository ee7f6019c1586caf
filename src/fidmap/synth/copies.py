"""Where a map draws a part: the circle of its radius through the points that beams hit, as the map's poses put them.

A scan seen from a wrong pose moves all it saw rigidly, so each scan votes for one place; scans whose votes agree draw
one copy. Mappers forget: a hit counts for what is left of it after all later scans, and where the map shows it at all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from fidmap.model import FloatArray
from fidmap.synth.laser import Scans
from fidmap.synth.mappers import Mapper, remembered

IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]
SAME_COPY = 0.5  # radii; scans whose votes lie farther apart draw the part twice
BINS = 120  # directions of a whole circle
COPY_BINS = 10  # a copy of less than 30 degrees is a smear, not an arc
ROUNDS = 8
HELD = 0.01  # of all evidence: what holds the circle through a stub of an arc near the votes
HIDDEN = 1e-3  # what a hit that the map does not show counts beside one that it shows


@dataclass(frozen=True)
class Copy:
    """One place where a part is drawn: centre, turn against the arena, directions hit, scans.

    all_hits: the centre by all of them, whether the map shows them or not. voted: the mean of what its scans vote for.
    """

    centre: FloatArray
    all_hits: FloatArray
    voted: FloatArray
    turn: float
    hit: BoolArray
    scans: int


@dataclass(frozen=True)
class Hits:
    """N beams that hit one part, scan by scan.

    scan: (N,) index. points: (N, 2) where the map's poses put what they hit, noise included. votes: (N, 2) where they
    put the part's centre. direction: (N,) of the hit from that centre, in the arena. turn: (N,) of the map against it.
    shown: (N,) whether the map is black there.
    """

    scan: IntArray
    points: FloatArray
    votes: FloatArray
    direction: FloatArray
    turn: FloatArray
    shown: BoolArray

    def take(self, chosen: BoolArray) -> Hits:
        """The hits of a mask (N,)."""
        return Hits(*(getattr(self, field.name)[chosen] for field in fields(self)))


def hits_of(scans: Scans, poses: FloatArray, scan: IntArray, beam: IntArray, arc: FloatArray) -> Hits:
    """What the listed beams (N,) make of the part (x, y, ... in the arena) that they hit; poses (M, 3) of the map.

    All are taken to be shown.
    """
    true, believed = scans.poses[scan], poses[scan]
    ranges = scans.ranges[scan, beam][:, None]
    bearing = scans.bearings[beam]
    seen = true[:, :2] + ranges * _towards(true[:, 2] + bearing) - arc[:2]
    turn = believed[:, 2] - true[:, 2]
    offset = arc[:2] - true[:, :2]
    c, s = np.cos(turn), np.sin(turn)
    away = np.stack([c * offset[:, 0] - s * offset[:, 1], s * offset[:, 0] + c * offset[:, 1]], axis=1)
    points = believed[:, :2] + ranges * _towards(believed[:, 2] + bearing)
    direction = np.arctan2(seen[:, 1], seen[:, 0])
    return Hits(scan, points, believed[:, :2] + away, direction, turn, np.ones(len(scan), bool))


def _towards(angle: FloatArray) -> FloatArray:
    """(N, 2) unit vectors."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def copies_of(hits: Hits, radius_m: float, mapper: Mapper, resolution_m: float | None) -> list[Copy]:
    """The places where a part is drawn, the most complete first; without a map, as in cells of 3 degrees."""
    copies: list[Copy] = []
    left = np.ones(len(hits.scan), bool)
    while left.any():
        inside = _densest(hits.votes, left, SAME_COPY * radius_m)
        copy = _copy(hits.take(inside), radius_m, mapper, resolution_m)
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


def _copy(hits: Hits, radius_m: float, mapper: Mapper, resolution_m: float | None) -> Copy:
    cells = BINS if resolution_m is None else max(1, round(2 * math.pi * radius_m / resolution_m))
    stretch = np.floor(_turns(hits.direction) * cells).astype(np.int64)
    kept = remembered(mapper, *_later(stretch, hits.scan))
    weight = np.where(hits.shown, 1.0, HIDDEN) * kept
    turn = np.arctan2(weight @ np.sin(hits.turn), weight @ np.cos(hits.turn))
    bins = np.floor(_turns(hits.direction) * BINS).astype(np.int64)
    return Copy(
        _circle(hits, weight, radius_m),
        _circle(hits, kept, radius_m),
        hits.votes.mean(axis=0),
        float(turn),
        np.bincount(bins, minlength=BINS) > 0,
        len(np.unique(hits.scan)),
    )


def _turns(angle: FloatArray) -> FloatArray:
    """Angles as shares of a whole turn, below 1."""
    return np.asarray(np.mod(angle / (2 * math.pi), 1.0).clip(0, np.nextafter(1.0, 0.0)))


def _later(stretch: IntArray, scan: IntArray) -> tuple[IntArray, IntArray]:
    """How many beams (N,), and scans (N,), hit the same stretch of an arc in later scans."""
    base = int(scan.max()) + 1
    keys, group, beams = np.unique(stretch * base + scan, return_inverse=True, return_counts=True)
    last = np.searchsorted(keys // base, keys // base, "right") - 1
    total = np.cumsum(beams)
    return (total[last] - total)[group], (last - np.arange(len(keys)))[group]


def _circle(hits: Hits, weight: FloatArray, radius_m: float) -> FloatArray:
    """Centre of the circle of this radius through weighed points: least squares of distances (Gauss-Newton)."""
    start = np.average(hits.votes, axis=0, weights=weight)
    centre, held = start, HELD * weight.sum()
    for _ in range(ROUNDS):
        away = hits.points - centre
        distance = np.maximum(np.hypot(*away.T), 1e-9)
        outward = away / distance[:, None]
        pull = weight[:, None] * outward
        beyond = pull.T @ (distance - radius_m) + held * (start - centre)
        centre = centre + np.linalg.solve(pull.T @ outward + held * np.eye(2), beyond)
    return np.asarray(centre)
