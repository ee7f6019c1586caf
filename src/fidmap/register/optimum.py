"""The greatest value of a problem with its proof, and the local maxima that were met on the way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fidmap.geometry import apply
from fidmap.model import FloatArray, StartPose, Transform
from fidmap.register.ascent import ascend
from fidmap.register.branch import Improve
from fidmap.register.certify import MOST_NODES, prove, stop_of
from fidmap.register.landscape import Landscape
from fidmap.register.near import Matcher
from fidmap.register.polish import Placement, place, settle_squares, settle_steps
from fidmap.register.problem import Problem
from fidmap.register.start_pose import nearest_within
from fidmap.register.starts import starts

# maxima of less than this share of the best are nobody's answer: they stay as they were climbed to
SETTLED = 0.95


@dataclass(frozen=True, eq=False)
class Optimum:
    """Local maxima, the best first, the upper bound of all values (None: not certified) and the boxes it took.

    met: all placements that were met on the way.
    """

    maxima: list[Placement]
    upper_bound: float | None
    nodes: int = 0
    met: tuple[Placement, ...] = ()


def find(problem: Problem, start: StartPose | None, fast: bool) -> Optimum:
    """Climb from the most promising placements; unless `fast`, prove how much better others could be."""
    if not problem.allowed.any() and len(problem.fixed) == 0:
        return Optimum([], 0.0)
    lands, matchers = landscapes(problem, start)
    found: list[Placement] = []
    for land, matcher in zip(lands, matchers, strict=True):
        found += reached(land, starts(land, matcher)[0])
    if fast:
        return Optimum(settled(problem, found, start), None)
    upper, nodes, value = 0.0, 0, max((one.value for one in found), default=0.0)
    for land, matcher in zip(lands, matchers, strict=True):
        proof = prove(land, matcher, value, improver(land, matcher, found), stop_of(land), MOST_NODES)
        value, upper, nodes = max(value, proof.value), max(upper, proof.upper_bound), nodes + proof.nodes
    maxima = settled(problem, found, start)
    return Optimum(maxima, max(upper, maxima[0].value) if maxima else upper, nodes, tuple(found))


def landscapes(problem: Problem, start: StartPose | None) -> tuple[list[Landscape], list[Matcher]]:
    """The map as it is and, where mirrored maps are allowed, turned over."""
    lands = [
        Landscape(problem, mirrored, start) for mirrored in ((False, True) if problem.settings.mirror else (False,))
    ]
    return lands, [Matcher(land) for land in lands]


def local_maxima(problem: Problem) -> list[Placement]:
    """Distinct local maxima without proof, the best first."""
    return find(problem, None, fast=True).maxima


def reached(land: Landscape, placements: FloatArray) -> list[Placement]:
    """Placements (K, 4) with their assignments, inside of the start pose's limits."""
    found = []
    for one in placements:
        transform = land.transform(one)
        if land.start is not None:
            transform = nearest_within(transform, land.start)
        found.append(place(land.problem, transform))
    return found


def improver(land: Landscape, matcher: Matcher, found: list[Placement], both: bool = False) -> Improve:
    """Climbs from placements of a landscape and keeps what it finds.

    Where steps or a start pose's limits can make the maximum another than that of the climb, what is climbed from is
    kept too; always with `both`.
    """
    both = both or land.problem.settings.rounding != "none" or land.start is not None

    def improve(placement: FloatArray) -> tuple[float, FloatArray]:
        top, _ = ascend(land, matcher, placement[None], rounds=8, steps=12, decay=0.75)
        tried = reached(land, np.concatenate([top, placement[None]]) if both else top)
        found.extend(tried)
        return max(one.value for one in tried), top[0]

    return improve


def settled(problem: Problem, found: list[Placement], start: StartPose | None) -> list[Placement]:
    """The distinct maxima, ties told apart: a flat maximum ends at its least squares."""
    maxima = separate(found, problem, problem.d_max / 2)
    if problem.settings.rounding != "none" and maxima:
        maxima[0] = settle_steps(problem, maxima[0], start)
    level = SETTLED * maxima[0].value if maxima else 0.0
    moved = (settle_squares(problem, m, start) if m.value >= level else m for m in maxima)
    return sorted(moved, key=lambda m: m.order)


def separate(found: list[Placement], problem: Problem, least_m: float) -> list[Placement]:
    """The best placements first, each at least so far (rms) from all better ones; none that assigns nothing."""
    kept: list[Placement] = []
    for trial in sorted((m for m in found if len(m.pairs)), key=lambda m: m.order):
        if all(displacement(problem, m, trial.transform) >= least_m for m in kept):
            kept.append(trial)
    return kept


def displacement(problem: Problem, placement: Placement, other: Transform) -> float:
    """How far (rms, metres) the barrel parts that a placement assigns lie from where another transform puts them."""
    own = problem.barrels[placement.pairs[:, 1]]
    away = apply(placement.transform, own) - apply(other, own)
    return float(np.sqrt(np.mean(np.sum(away**2, axis=1))))
