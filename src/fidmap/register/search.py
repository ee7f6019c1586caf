"""The search for placements: many hypotheses, the promising ones climbed, their local maxima compared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fidmap.geometry import apply
from fidmap.model import FloatArray, StartPose, Transform
from fidmap.register.hypotheses import placements, promising, within
from fidmap.register.polish import Placement, climb, place, settle_squares, settle_steps
from fidmap.register.problem import Problem

POLISHED = 60
KEPT = 12


def local_maxima(problem: Problem, start: StartPose | None = None) -> list[Placement]:
    """Distinct local maxima of the capped score, the best first; those that assign nothing are left out.

    Placements that differ by less than half of D (rms over barrel parts) are one; the best of them stands for it.
    """
    found = _maxima(problem, start)
    if problem.settings.mirror:
        flipped = replace(problem, barrels=problem.barrels * [1, -1], barrel_facings=-problem.barrel_facings)
        found += [place(problem, replace(m.transform, mirrored=True)) for m in _maxima(flipped, start)]
    maxima = _apart(problem, found, problem.d_max / 2)
    return sorted((settle_squares(problem, m, start) for m in maxima), key=lambda m: m.order)


def displacement(problem: Problem, placement: Placement, other: Transform) -> float:
    """How far (rms, metres) the barrel parts that a placement assigns lie from where another transform puts them."""
    own = problem.barrels[placement.pairs[:, 1]]
    away = apply(placement.transform, own) - apply(other, own)
    return float(np.sqrt(np.mean(np.sum(away**2, axis=1))))


def _maxima(problem: Problem, start: StartPose | None) -> list[Placement]:
    """Local maxima from the most promising placements, unordered and with repetitions.

    The identity is always among the starts: where a frame was agreed, the placement nearest to it is wanted.
    """
    hypotheses = placements(problem, start)
    hypotheses = hypotheses[within(hypotheses, start)]
    if len(hypotheses) == 0:
        return []
    rough = _distinct(problem, promising(problem, hypotheses)[:2000], 0.25, POLISHED)
    climbed = [climb(problem, t, start, rounds=4, steps=15) for t in rough]
    starts = [m.transform for m in _apart(problem, climbed, problem.d_max / 12)[:KEPT]]
    unmoved = Transform(scale=float(np.clip(1.0, *problem.scale_range)))
    if within(np.array([[0.0, 0.0, 0.0, unmoved.scale]]), start)[0]:
        starts.append(unmoved)
    settled = [climb(problem, t, start, rounds=20, steps=120) for t in starts]
    if problem.settings.rounding != "none":
        settled = [settle_steps(problem, m, start) for m in _apart(problem, settled, problem.d_max / 12)]
    return settled


def _apart(problem: Problem, found: list[Placement], least_m: float) -> list[Placement]:
    """The best placements first, each at least so far (rms) from all better ones; none that assigns nothing."""
    kept: list[Placement] = []
    for trial in sorted((m for m in found if len(m.pairs)), key=lambda m: m.order):
        if all(displacement(problem, m, trial.transform) >= least_m for m in kept):
            kept.append(trial)
    return kept


def _distinct(problem: Problem, hypotheses: FloatArray, apart_m: float, most: int) -> list[Transform]:
    """The first `most` hypotheses that put the barrel parts at least `apart_m` (rms) from one another."""
    barrels = problem.barrels @ [1, 1j]
    moved = (hypotheses[:, 3] * np.exp(1j * hypotheses[:, 0]))[:, None] * barrels[None]
    moved = moved + (hypotheses[:, 1] + 1j * hypotheses[:, 2])[:, None]
    left = np.ones(len(hypotheses), bool)
    kept: list[Transform] = []
    while left.any() and len(kept) < most:
        k = int(left.argmax())
        rotation, tx, ty, scale = (float(v) for v in hypotheses[k])
        kept.append(Transform(rotation, tx, ty, scale))
        left &= np.sqrt(np.mean(np.abs(moved - moved[k]) ** 2, axis=1)) >= apart_m
        left[k] = False
    return kept
