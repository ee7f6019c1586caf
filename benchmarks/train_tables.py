"""The rows that the detector's networks learn from: windows and strips of maps, with what is true of them.

Labels are -1 (counts neither way), 0 and 1; targets are lengths along and across a facing, turns, and 1 for wholes.
"""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.counting import NEAR_ANGLE, DrawnPart
from benchmarks.train_maps import IDEAL, Drawn, ideal_drawing, real_maps
from fidmap.detect import half_circles
from fidmap.detect.arcs import Arcs, difference, spotted
from fidmap.detect.coarse import coarser, factor
from fidmap.detect.fits import circles
from fidmap.detect.measure import sizes
from fidmap.detect.network import JUDGE_ANGLES, JUDGE_STEPS, SPOT_ANGLES, SPOT_STEPS
from fidmap.detect.polar import INNERMOST, OUTERMOST, Windower
from fidmap.detect.strips import DIRECTIONS, strips
from fidmap.detect.votes import boundary, centre_candidates
from fidmap.model import FloatArray, Label

MOST_WINDOWS = 300  # per map; more come from a few crowded maps
BIN = 2 * np.pi / SPOT_ANGLES
HALF_STEP = np.pi / 2 / DIRECTIONS  # of a half circle's directions
Table = tuple[npt.NDArray[np.generic], ...]


def tables(make, paths: Sequence[Path], copies: int, worn: int) -> list[npt.NDArray[np.generic]]:  # type: ignore[no-untyped-def]
    """The rows that `make` finds on artificial and on real maps, each so many times, and on ideal drawings."""
    with ProcessPoolExecutor(2) as pool:
        drawn = (pickle.loads(path.read_bytes()) for path in paths)
        rows = list(pool.map(make, (again for one in drawn for again in _again(one, worn)), chunksize=4))
        rows += pool.map(make, (ideal_drawing(k) for k in range(IDEAL)), chunksize=4)
    rows += [make(again) for drawn in real_maps() for again in _again(drawn, copies)]
    return [np.concatenate(column) for column in zip(*rows, strict=True)]


def _again(drawn: Drawn, copies: int) -> list[Drawn]:
    """The same map with other random numbers."""
    return [replace(drawn, number=drawn.number + 1000 * k) for k in range(copies)]


def spot_table(drawn: Drawn) -> Table:
    """Windows (M, A, steps) of candidates, labels (M, A) and targets (M, A, 4) of every direction, radii (M,)."""
    random = np.random.default_rng(drawn.number)
    windower, drawn = _coarse(drawn.worn(random))
    edge = boundary(drawn.grid.labels, windower.radius)
    places = _few(centre_candidates(edge, windower.radius, 0.33), random)
    places = places + random.normal(0, 0.05 * windower.radius, places.shape)
    start = random.uniform(0, BIN)
    windows = windower.cut(places, np.full(len(places), start), SPOT_ANGLES, SPOT_STEPS)
    theta = np.tile(start + np.arange(SPOT_ANGLES) * BIN, (len(places), 1))
    labels, targets = label(windower, drawn, places, theta, near=0.65, turn=np.radians(13))
    return windows, labels, targets, np.full(len(places), windower.radius, np.float32)


def judge_table(drawn: Drawn) -> Table:
    """Windows (M, A, steps) of half circles as `spotted` finds them, labels (M,), targets (M, 4), radii (M,)."""
    random = np.random.default_rng(drawn.number + 1)
    windower, drawn = _coarse(drawn.worn(random))
    edge = boundary(drawn.grid.labels, windower.radius)
    arcs = spotted(windower, centre_candidates(edge, windower.radius), least=0.0075)
    arcs = arcs.take(_few(np.arange(len(arcs.sure)), random))
    centres = np.concatenate(
        [arcs.centres, arcs.centres + random.normal(0, 0.05 * windower.radius, arcs.centres.shape)]
    )
    facings = np.concatenate([arcs.facings, arcs.facings + random.normal(0, np.radians(6), arcs.facings.shape)])
    windows = windower.cut(centres, facings, JUDGE_ANGLES, JUDGE_STEPS)
    labels, targets = label(windower, drawn, centres, facings[:, None], near=0.4, turn=np.radians(35))
    return windows, labels[:, 0], targets[:, 0], np.full(len(centres), windower.radius, np.float32)


def vote_table(drawn: Drawn) -> Table:
    """Strips (K, D, S), directions (K, D), sizes (K, 4), confidences (K,) of a map's arcs, and what is to be learned.

    That is what is left to their centres (K, 2, 2) in cells, where the map shows them and where its scans put them, NaN
    where they are no parts. Last, the map's first arc (K,).
    """
    random = np.random.default_rng(drawn.number + 2)
    drawn = drawn.worn(random) if random.random() < 0.3 else drawn
    arcs, _ = half_circles(drawn.grid.labels, drawn.radius)
    arcs = arcs.take(arcs.sure >= 0.1)
    at = circles(drawn.grid.labels, arcs, drawn.radius).centres
    at = at + random.normal(0, 0.1, at.shape)
    arcs = replace(arcs, facings=arcs.facings + random.uniform(-1, 1) * HALF_STEP)
    left = np.stack([_left(drawn, parts, arcs, at) for parts in (drawn.shown, drawn.parts)], axis=1)
    seen = strips(drawn.grid.labels, at, arcs.facings, arcs.reach, drawn.radius)
    first = np.arange(len(at)) == 0
    return seen.labels, seen.relative, sizes(arcs, drawn.radius, drawn.grid.resolution_m), arcs.sure, left, first


def _left(drawn: Drawn, parts: Iterable[DrawnPart], arcs: Arcs, at: FloatArray) -> FloatArray:
    """What is left from places (K, 2) to the parts of the arcs there, along their facings and across, in cells."""
    left = np.full(at.shape, np.nan)
    for part in _yes(parts):
        away = drawn.place(part.x_m, part.y_m) - at  # type: ignore[arg-type]
        turned = np.abs(_turn(part, drawn, arcs.facings))
        fits = (np.hypot(*away.T) < 0.5 * drawn.radius) & (turned < NEAR_ANGLE)
        if fits.any():
            k = int(np.argmax(np.where(fits, arcs.sure, -1)))
            left[k] = np.stack(_along(away[k], arcs.facings[k]))
    return left


def label(
    windower: Windower, drawn: Drawn, centres: FloatArray, facings: FloatArray, near: float, turn: float
) -> tuple[npt.NDArray[np.int8], npt.NDArray[np.float32]]:
    """Labels (M, F) and targets (M, F, 4) of half circles at centres (M, 2), facings (M, F): the nearest part."""
    labels, targets = np.zeros(facings.shape, np.int8), np.zeros((*facings.shape, 4), np.float32)
    nearest = np.full(facings.shape, np.inf)
    for part in drawn.parts:
        for copy in part.copies:
            away = np.hypot(*(centres - drawn.place(*copy)).T) / windower.radius
            labels[(away < 0.75)[:, None] & (labels == 0)] = -1
        if part.x_m is None or part.y_m is None:
            continue
        shift = (drawn.place(part.x_m, part.y_m) - centres) / windower.radius
        away, turned = np.hypot(*shift.T)[:, None], _turn(part, drawn, facings)
        if part.facing is None:  # only facings that see its ring
            turned = np.where(_standing(windower, drawn.place(part.x_m, part.y_m), facings), 0.0, np.pi)
        labels[(away < max(0.67, 1.5 * near)) & (np.abs(turned) < np.radians(55)) & (labels == 0)] = -1
        if part.drawn == "yes":
            true = (away < near) & (np.abs(turned) < turn) & (away < nearest)
            nearest = np.where(true, away, nearest)
            labels[true] = 1
            whole = np.full(facings.shape, float(part.facing is None))
            targets[true] = np.stack([*_along(shift[:, None], facings), turned, whole], axis=-1)[true]
    return labels, targets


def _coarse(drawn: Drawn) -> tuple[Windower, Drawn]:
    """The map in the cells that the detector looks at."""
    times = factor(drawn.radius)
    grid = replace(drawn.grid, labels=coarser(drawn.grid.labels, times), resolution_m=drawn.grid.resolution_m * times)
    return Windower(grid.labels, drawn.radius / times), replace(drawn, grid=grid)


def _yes(parts: Iterable[DrawnPart]) -> list[DrawnPart]:
    return [part for part in parts if part.drawn == "yes" and part.x_m is not None]


def _few(rows: npt.NDArray[np.generic], random: np.random.Generator) -> npt.NDArray:  # type: ignore[type-arg]
    """At most so many rows, drawn at random, in their order."""
    return rows[np.sort(random.permutation(len(rows))[:MOST_WINDOWS])]


def _turn(part: DrawnPart, drawn: Drawn, facings: FloatArray) -> FloatArray:
    """How far facings must turn to agree with a part's; 0 where it has none."""
    if part.facing is None:
        return np.zeros(facings.shape)
    return difference(np.array(part.facing - drawn.grid.origin.yaw), facings)


def _along(shift: FloatArray, facing: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Parts of (..., 2) (row, column) shifts along facings and across them."""
    s, c = np.sin(facing), np.cos(facing)
    return shift[..., 0] * s + shift[..., 1] * c, shift[..., 0] * c - shift[..., 1] * s


def _standing(windower: Windower, centre: FloatArray, facings: FloatArray) -> npt.NDArray[np.bool_]:
    """Which facings see about as much of a whole barrel's ring as the best one: it may be drawn on one side only."""
    window = windower.cut(centre[None], np.zeros(1), SPOT_ANGLES, SPOT_STEPS)[0]
    away = np.abs(np.linspace(INNERMOST, OUTERMOST, SPOT_STEPS) - 1)
    black = ((window == Label.OCCUPIED) & (away <= max(0.2, 1.3 / windower.radius))).any(axis=1)
    half = np.sum([np.roll(black, k) for k in range(-SPOT_ANGLES // 4, SPOT_ANGLES // 4 + 1)], axis=0)
    return np.asarray((half >= half.max() - 2)[np.rint(facings / BIN).astype(int) % SPOT_ANGLES])
