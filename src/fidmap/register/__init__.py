"""Barrel parts + arena -> assignment and transform: the maximum that defines relative accuracy (SSRR 2011, II-B-2).

A search over the capped score itself, not least squares: many placements from few points, scored with shared
parts, the best of them polished by alternating exact matching and truncated-L1 fitting. Its effort is bounded by
counts, never by time.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fidmap.geometry import apply
from fidmap.model import (
    Arena,
    ArenaFileError,
    Assignment,
    BarrelPart,
    FloatArray,
    Settings,
    StartPose,
    Transform,
)
from fidmap.register.findings import name_findings
from fidmap.register.hypotheses import placements, promising, within
from fidmap.register.polish import Placement, climb, place, settle_steps
from fidmap.register.problem import Problem, make_problem

__all__ = ["register"]

POLISHED = 60
KEPT = 12


def register(
    parts: tuple[BarrelPart, ...], arena: Arena, settings: Settings, start: StartPose | None = None
) -> Assignment:
    """The assignment and T_truth_map that maximise the sum over assigned parts of 1 - min(q(d), D)/D.

    Parts that a human fixed are always assigned. An arena without positions gets only those. With a start pose
    only placements within its three sigma are searched; the value gets no prior.

    Raises:
        ArenaFileError: positions are missing and no part was fixed.
    """
    if not arena.has_positions:
        return _fixed_only(parts, arena)
    best, others = best_placement(make_problem(parts, arena, settings), start)
    if best is None:
        return Assignment((None,) * len(arena.parts), (False,) * len(arena.parts), None, 0.0)
    chosen = best
    if arena.frame == "map":
        chosen = _nearest(best, others, parts)
    barrel_of, fixed = _as_tuples(chosen, parts, len(arena.parts))
    findings = name_findings(chosen, best, parts, arena, settings)
    return Assignment(barrel_of, fixed, chosen.transform, chosen.value, findings)


def best_placement(problem: Problem, start: StartPose | None) -> tuple[Placement | None, list[Placement]]:
    """The best placement found and all distinct local maxima, best first."""
    maxima = _maxima(problem, start)
    if problem.settings.mirror:
        flipped = replace(problem, barrels=problem.barrels * [1, -1], barrel_facings=-problem.barrel_facings)
        maxima += [place(problem, replace(m.transform, mirrored=True)) for m in _maxima(flipped, start)]
    maxima = sorted(maxima, key=lambda m: m.key, reverse=True)
    maxima = [m for m in maxima if len(m.pairs)]
    return (maxima[0] if maxima else None), maxima


def _maxima(problem: Problem, start: StartPose | None) -> list[Placement]:
    """Distinct local maxima from the most promising placements, unordered."""
    hypotheses = placements(problem, start)
    hypotheses = hypotheses[within(hypotheses, start)]
    rough = _distinct(problem, promising(problem, hypotheses)[:2000], 0.25, POLISHED)
    climbed = [climb(problem, t, start, rounds=4, steps=15) for t in rough]
    climbed = sorted(climbed, key=lambda m: m.key, reverse=True)[:KEPT]
    settled = [climb(problem, m.transform, start, rounds=20, steps=120) for m in climbed]
    if problem.settings.rounding != "none":
        settled = [settle_steps(problem, m, start) for m in settled]
    return settled


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


def _nearest(best: Placement, maxima: list[Placement], parts: tuple[BarrelPart, ...]) -> Placement:
    """Of the local maxima within 1 % of the best, the one that moves its barrel parts least from the identity."""
    points = np.array([(p.x_m, p.y_m) for p in parts])

    def moved(placement: Placement) -> float:
        own = points[placement.pairs[:, 1]]
        return float(np.sqrt(np.mean(np.sum((apply(placement.transform, own) - own) ** 2, axis=1))))

    return min((m for m in maxima if m.value >= 0.99 * best.value), key=moved)


def _fixed_only(parts: tuple[BarrelPart, ...], arena: Arena) -> Assignment:
    """The assignment of an arena without positions: what a human said, and no transform."""
    by_id = {part.fixed_id: j for j, part in enumerate(parts) if part.fixed_id not in {None, "-"}}
    if not by_id:
        raise ArenaFileError(
            f"{arena.path}: no part has a position, so nothing can be assigned by itself: give x_m and y_m for "
            "every part, or name the parts in the id column of a points file (--points)"
        )
    barrel_of = tuple(by_id.get(part.id) for part in arena.parts)
    return Assignment(barrel_of, tuple(j is not None for j in barrel_of), None, 0.0)


def _as_tuples(
    placement: Placement, parts: tuple[BarrelPart, ...], count: int
) -> tuple[tuple[int | None, ...], tuple[bool, ...]]:
    """Per fiducial part its barrel part, and whether a human said so."""
    barrel_of: list[int | None] = [None] * count
    for i, j in placement.pairs:
        barrel_of[int(i)] = int(j)
    return tuple(barrel_of), tuple(j is not None and parts[j].fixed_id is not None for j in barrel_of)
