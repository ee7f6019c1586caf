"""Placements worth a closer look: from two points each, from one point with its facing, from a start pose."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.geometry import angle_between
from fidmap.model import FloatArray, StartPose, Transform
from fidmap.register.problem import Problem

# bounds of the work, counted and not timed, so that the same input gives the same answer anywhere
MOST_HYPOTHESES = 20_000
DISTANCES = 2_000_000
FIELD_CELLS = 1_000_000
FIELD_SIDE = 20_000
SECTORS = 12
HEADINGS = 24


@dataclass(frozen=True, eq=False)
class _Pairs:
    """P candidate pairs: indices of fiducial and barrel part (P,), their facings (P,), NaN where not tested."""

    rows: npt.NDArray[np.intp]
    columns: npt.NDArray[np.intp]
    fiducial_facings: FloatArray
    barrel_facings: FloatArray


def _facings(
    problem: Problem, rows: npt.NDArray[np.intp], columns: npt.NDArray[np.intp]
) -> tuple[FloatArray, FloatArray]:
    """Facings of candidate pairs; those that a human fixed (the last ones) count whatever their facing."""
    by_program = np.arange(len(rows)) < len(rows) - len(problem.fixed)
    return (
        np.where(by_program, problem.fiducial_facings[rows], math.nan),
        np.where(by_program, problem.barrel_facings[columns], math.nan),
    )


def placements(problem: Problem, start: StartPose | None) -> FloatArray:
    """Hypotheses (H, 4): rotation, x, y of the translation, scale; unmirrored, in no order."""
    rows, columns = np.nonzero(problem.allowed)
    rows, columns = (
        np.concatenate([rows, problem.fixed[:, 0]]),
        np.concatenate([columns, problem.fixed[:, 1]]),
    )
    if len(rows) == 0:
        return np.empty((0, 4))
    pairs = _Pairs(rows, columns, *_facings(problem, rows, columns))
    found = [_from_one_point(problem, pairs), _from_two_points(problem, pairs)]
    found.append(np.array([[0.0, 0.0, 0.0, np.clip(1.0, *problem.scale_range)]]))
    if start is not None:
        found.append(_from_start_pose(start))
    return np.concatenate(found)


def within(hypotheses: FloatArray, start: StartPose | None) -> npt.NDArray[np.bool_]:
    """(H,) whether a placement puts the map's origin within three sigma of the start pose."""
    if start is None:
        return np.ones(len(hypotheses), bool)
    away = np.hypot(hypotheses[:, 1] - start.pose.x_m, hypotheses[:, 2] - start.pose.y_m)
    turned = angle_between(hypotheses[:, 0], start.pose.yaw)
    return np.asarray((away <= 3 * start.sigma_m) & (turned <= 3 * start.sigma_yaw))


def nearest_within(transform: Transform, start: StartPose) -> Transform:
    """The transform, moved into three sigma of the start pose where it lies outside."""
    turn = math.remainder(transform.rotation - start.pose.yaw, 2 * math.pi)
    dx, dy = transform.tx_m - start.pose.x_m, transform.ty_m - start.pose.y_m
    turn_by = _share(3 * start.sigma_yaw, abs(turn))
    go = _share(3 * start.sigma_m, math.hypot(dx, dy))
    return replace(
        transform,
        rotation=start.pose.yaw + turn_by * turn,
        tx_m=start.pose.x_m + go * dx,
        ty_m=start.pose.y_m + go * dy,
    )


def _share(most: float, wanted: float) -> float:
    """What share of `wanted` stays within `most`, a hair inside."""
    return 1.0 if wanted <= most else most / wanted * (1 - 1e-12)


def promising(problem: Problem, hypotheses: FloatArray) -> FloatArray:
    """The hypotheses (K, 4) of greatest promise, best first.

    First all by one look per barrel part into a distance field, then the best of them with parts shared fairly;
    H * M look-ups and at most `DISTANCES` distances.
    """
    rough = field_scores(problem, hypotheses)
    some = np.argsort(-rough, kind="stable")[: max(200, DISTANCES // max(1, problem.allowed.size))]
    fair = _two_sided_scores(problem, hypotheses[some])
    return hypotheses[some[np.argsort(-fair, kind="stable")]]


def field_scores(problem: Problem, hypotheses: FloatArray) -> FloatArray:
    """(H,) sum over barrel parts of 1 - min(d, D)/D to the nearest fiducial part of a fitting facing."""
    field = _DistanceField(problem)
    total = np.zeros(len(hypotheses))
    turn = hypotheses[:, 3] * np.exp(1j * hypotheses[:, 0])
    usable = np.union1d(np.flatnonzero(problem.allowed.any(axis=0)), problem.fixed[:, 1])
    facings = problem.barrel_facings.copy()
    facings[problem.fixed[:, 1]] = math.nan
    for j in usable:
        x, y = problem.barrels[j]
        moved = turn * (x + 1j * y) + (hypotheses[:, 1] + 1j * hypotheses[:, 2])
        distance = field.look(moved, hypotheses[:, 0] + facings[j])
        total += np.maximum(0.0, 1 - distance / problem.d_max)
    return total


class _DistanceField:
    """Clipped distance to the nearest fiducial part, for each of twelve facings; cells of a twelfth of D or coarser."""

    def __init__(self, problem: Problem) -> None:
        margin = 1.5 * problem.d_max
        self.low = problem.fiducials.min(axis=0) - margin
        side = problem.fiducials.max(axis=0) + margin - self.low
        self.cell = max(problem.d_max / 12, math.sqrt(side.prod() / FIELD_CELLS), side.max() / FIELD_SIDE)
        height, width = np.ceil(side / self.cell).astype(int)[::-1] + 1
        at = ((problem.fiducials - self.low) / self.cell).astype(int)
        faced = np.isfinite(problem.fiducial_facings)
        self.sectors = SECTORS if faced.any() and np.isfinite(problem.barrel_facings).any() else 1
        fields = []
        for k in range(self.sectors):
            apart = angle_between(problem.fiducial_facings, (k + 0.5) * 2 * math.pi / self.sectors)
            fits = ~(apart >= problem.settings.facing_tolerance + math.pi / self.sectors)
            empty = np.ones((height, width), np.uint8)
            empty[at[fits, 1], at[fits, 0]] = 0
            fields.append(cv2.distanceTransform(empty, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * self.cell)
        fields.append(np.min(fields, axis=0))
        self.fields = np.stack(fields)

    def look(self, points: npt.NDArray[np.complex128], facings: FloatArray) -> FloatArray:
        """(H,) metres; points outside of the field are far away, parts without facing fit every sector."""
        column = np.floor((points.real - self.low[0]) / self.cell)
        row = np.floor((points.imag - self.low[1]) / self.cell)
        height, width = self.fields.shape[1:]
        inside = (row >= 0) & (column >= 0) & (row < height) & (column < width)
        sector = np.floor(np.nan_to_num(facings) % (2 * math.pi) / (2 * math.pi) * self.sectors)
        sector = np.where(np.isfinite(facings), np.minimum(sector, self.sectors - 1), self.sectors)
        index = np.where(inside, (sector * height + row) * width + column, 0).astype(np.intp)
        return np.where(inside, self.fields.reshape(-1)[index], np.inf)


def _two_sided_scores(problem: Problem, hypotheses: FloatArray) -> FloatArray:
    """(H,) the lesser of the sums over fiducial parts and over barrel parts of the best pair each."""
    moved = (hypotheses[:, 3] * np.exp(1j * hypotheses[:, 0]))[:, None] * (problem.barrels @ [1, 1j])[None]
    moved = moved + (hypotheses[:, 1] + 1j * hypotheses[:, 2])[:, None]
    distance = np.abs(moved[:, None, :] - (problem.fiducials @ [1, 1j])[None, :, None])
    worth = np.where(problem.allowed[None], np.maximum(0.0, 1 - distance / problem.d_max), 0.0)
    turned = hypotheses[:, 0, None] + problem.barrel_facings[None]
    worth[problem.facings_clash(problem.fiducial_facings[None, :, None], turned[:, None, :])] = 0.0
    fixed = np.maximum(0.0, 1 - distance[:, problem.fixed[:, 0], problem.fixed[:, 1]] / problem.d_max).sum(axis=1)
    return np.asarray(
        fixed + np.minimum(worth.max(axis=1, initial=0).sum(axis=1), worth.max(axis=2, initial=0).sum(axis=1))
    )


def _place(rotation: FloatArray, source: FloatArray, target: FloatArray, scale: FloatArray) -> FloatArray:
    """Placements (H, 4) that turn by `rotation` and carry complex points `source` to `target`."""
    shift = target - scale * np.exp(1j * rotation) * source
    return np.stack([rotation, shift.real, shift.imag, scale], axis=1)


def _from_one_point(problem: Problem, pairs: _Pairs) -> FloatArray:
    """One pair fixes the translation; its facings fix the rotation, or a fan of headings does."""
    turn = pairs.fiducial_facings - pairs.barrel_facings
    headings = np.arange(HEADINGS) * (2 * math.pi / HEADINGS)
    known = np.isfinite(turn)
    rotation = np.concatenate([turn[known], np.tile(headings, int((~known).sum()))])
    again = np.concatenate([np.flatnonzero(known), np.repeat(np.flatnonzero(~known), HEADINGS)])
    source, target = problem.barrels[pairs.columns[again]] @ [1, 1j], problem.fiducials[pairs.rows[again]] @ [1, 1j]
    chosen = _thin(len(again))
    scale = np.full(len(chosen), np.clip(1.0, *problem.scale_range))
    return _place(rotation[chosen], source[chosen], target[chosen], scale)


def _from_two_points(problem: Problem, pairs: _Pairs) -> FloatArray:
    """Two pairs whose lengths agree fix everything; their middle is carried onto each other."""
    barrel, fiducial = problem.barrels[pairs.columns] @ [1, 1j], problem.fiducials[pairs.rows] @ [1, 1j]
    a, b = _pairs_of_pairs(len(pairs.rows))
    usable = (pairs.rows[a] != pairs.rows[b]) & (pairs.columns[a] != pairs.columns[b])
    a, b = a[usable], b[usable]
    target, source = fiducial[b] - fiducial[a], barrel[b] - barrel[a]
    low, high = problem.scale_range
    slack = 0.75 * problem.d_max
    fits = (np.abs(target) <= high * np.abs(source) + slack) & (np.abs(target) >= low * np.abs(source) - slack)
    # neighbours (the two halves on one wall) tell nothing about the rotation
    fits &= (np.abs(source) > 0.5 * problem.d_max) & (np.abs(target) > 0.5 * problem.d_max)
    rotation = np.angle(target * np.conj(source))
    for one in (a, b):
        fits &= ~problem.facings_clash(pairs.fiducial_facings[one], rotation + pairs.barrel_facings[one])
    best = np.flatnonzero(fits)
    best = best[_thin(len(best))]
    scale = np.clip(np.abs(target[best]) / np.abs(source[best]), low, high)
    middle = [0.5 * (points[a[best]] + points[b[best]]) for points in (barrel, fiducial)]
    return _place(rotation[best], middle[0], middle[1], scale)


def _pairs_of_pairs(count: int, most: int = 2_000_000) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """All index pairs a < b below `count`, or an even share of them where they are too many."""
    total = count * (count - 1) // 2
    if total <= most:
        first, second = np.triu_indices(count, 1)
        return first, second
    random = np.random.default_rng(0)
    return random.integers(0, count, most), random.integers(0, count, most)


def _thin(count: int) -> npt.NDArray[np.intp]:
    """Indices of an even share of `count` hypotheses, at most `MOST_HYPOTHESES`."""
    if count <= MOST_HYPOTHESES:
        return np.arange(count)
    return np.sort(np.random.default_rng(0).choice(count, MOST_HYPOTHESES, replace=False))


def _from_start_pose(start: StartPose) -> FloatArray:
    """A fan of placements inside the three-sigma box of the start pose."""
    steps = np.linspace(-2.5, 2.5, 11)
    turn, x, y = np.meshgrid(steps * start.sigma_yaw, steps * start.sigma_m, steps * start.sigma_m)
    pose = start.pose
    return np.stack([pose.yaw + turn.ravel(), pose.x_m + x.ravel(), pose.y_m + y.ravel(), np.ones(turn.size)], axis=1)
