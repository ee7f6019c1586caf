"""Pieces of a broken map: arcs left over that fit unassigned parts under a second rigid move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fidmap.geometry import apply, turn_directions
from fidmap.model import Displaced, Finding, FloatArray, Transform
from fidmap.register.optimum import displacement, local_maxima
from fidmap.register.polish import Placement
from fidmap.register.problem import Problem

LEAST_PARTS = 3
Indices = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class _LeftOver:
    """What the chosen placement does not assign, seen in the arena's frame; rows, columns: indices in the problem."""

    problem: Problem
    rows: Indices
    columns: Indices


def displaced_submaps(
    problem: Problem, chosen: Placement, ids: Sequence[str]
) -> tuple[tuple[Displaced, ...], tuple[Finding, ...]]:
    """Pieces of at least three parts, and a finding `displaced-submap` for each; the parts stay unassigned.

    Each pair of a piece is within D/4 under the piece's own rigid move (within D/2 three parts often fit by
    chance), and that move takes its arcs at least D/2 (rms) away from where the chosen placement puts them.
    """
    found, told = [], []
    left = _left_over(problem, chosen)
    while (piece := _piece(left, problem.d_max)) is not None:
        rows, columns = left.rows[piece.pairs[:, 0]], left.columns[piece.pairs[:, 1]]
        pairs = sorted((ids[i], int(j)) for i, j in zip(rows, columns, strict=True))
        names, barrels = zip(*pairs, strict=True)
        found.append(Displaced(names, barrels, piece.transform))
        told.append(_finding(names, left.problem.barrels[piece.pairs[:, 1]], piece.transform))
        left = _take(left.problem, left.rows, left.columns, piece.pairs)
    return tuple(found), tuple(told)


def _left_over(problem: Problem, chosen: Placement) -> _LeftOver:
    """The rest of a problem, its barrel parts moved by the chosen transform, its pairs within D/4 or none."""
    stricter = {**problem.settings.d_max_m, "relative_accuracy": problem.d_max / 4}
    moved = replace(
        problem,
        barrels=apply(chosen.transform, problem.barrels),
        barrel_facings=turn_directions(chosen.transform, problem.barrel_facings),
        fixed=np.empty((0, 2), np.intp),
        settings=replace(problem.settings, d_max_m=stricter, rounding="none", transform="rigid", mirror=False),
    )
    rows, columns = np.arange(len(problem.fiducials)), np.arange(len(problem.barrels))
    return _take(moved, rows, columns, chosen.pairs)


def _take(problem: Problem, rows: Indices, columns: Indices, pairs: Indices) -> _LeftOver:
    """Leave out the parts of `pairs` and whatever nothing is allowed for."""
    allowed = problem.allowed.copy()
    allowed[pairs[:, 0]], allowed[:, pairs[:, 1]] = False, False
    i, j = np.flatnonzero(allowed.any(axis=1)), np.flatnonzero(allowed.any(axis=0))
    rest = replace(
        problem,
        fiducials=problem.fiducials[i],
        barrels=problem.barrels[j],
        fiducial_facings=problem.fiducial_facings[i],
        barrel_facings=problem.barrel_facings[j],
        allowed=allowed[np.ix_(i, j)],
    )
    return _LeftOver(rest, rows[i], columns[j])


def _piece(left: _LeftOver, d_max: float) -> Placement | None:
    """The best placement of what is left over that is a piece of its own, None where there is none."""
    if min(left.problem.allowed.shape) < LEAST_PARTS:
        return None
    return next(
        (
            m
            for m in local_maxima(left.problem)
            if len(m.pairs) >= LEAST_PARTS and displacement(left.problem, m, Transform()) >= d_max / 2
        ),
        None,
    )


def _finding(names: Sequence[str], arcs: FloatArray, home: Transform) -> Finding:
    """`home` moves the piece's arcs (K, 2) to where they belong; told is how they lie against that."""
    away = arcs.mean(axis=0) - apply(home, arcs).mean(axis=0)
    turn = -math.degrees(math.remainder(home.rotation, 2 * math.pi))
    return Finding(
        "warning", "displaced-submap",
        f"{', '.join(names)} fit together, but lie {math.hypot(*away):.2f} m (x {away[0]:+.2f}, y {away[1]:+.2f} in "
        f"the arena) from their places, turned by {turn:+.1f} degrees: the map is broken there; they stay unassigned",
    )  # fmt: skip
