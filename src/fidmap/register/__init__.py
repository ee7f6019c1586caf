"""Barrel parts + arena -> assignment and transform: the maximum that defines relative accuracy (SSRR 2011, II-B-2).

A search over the capped score itself, not least squares. The peaks of a coarse sweep of all placements are climbed by
exact matchings and truncated-L1 fits in turn; a sweep with inflated images, then branch and bound over what it leaves
open, prove that nothing else is better. Its effort is bounded by counts, never by time, and it works in an order of
its own, so that the order of its inputs does not matter.
"""

from __future__ import annotations

from dataclasses import replace

from fidmap.model import Arena, Assignment, BarrelPart, Displaced, Settings, StartPose, Transform
from fidmap.register.displaced import displaced_submaps
from fidmap.register.findings import ambiguous, name_findings
from fidmap.register.optimum import displacement, find
from fidmap.register.pairs import without_positions
from fidmap.register.polish import Placement
from fidmap.register.problem import Problem, make_problem
from fidmap.register.rivals import LEAST_PARTS
from fidmap.register.runner_up import find_runner_up

__all__ = ["register"]


def register(
    parts: tuple[BarrelPart, ...], arena: Arena, settings: Settings, start: StartPose | None = None, fast: bool = False
) -> Assignment:
    """The assignment and T_truth_map that maximise the sum over assigned parts of 1 - min(q(d), D)/D.

    Parts that a human fixed are always assigned. An arena without positions gets those, and the halves on one wall
    are paired. With a start pose only placements within its three sigma are searched; the value gets no prior.
    `fast` leaves out the proof, the runner-up and the search for displaced pieces.

    Raises:
        ArenaFileError: positions are missing, no part was fixed, and no group can be paired by itself.
    """
    by_place = sorted(range(len(parts)), key=lambda j: _place_of(parts[j]))
    by_id = sorted(range(len(arena.parts)), key=lambda i: arena.parts[i].id)
    ordered = replace(arena, parts=tuple(arena.parts[i] for i in by_id))
    placed = tuple(parts[j] for j in by_place)
    if arena.has_positions:
        found = _register(placed, ordered, settings, start, fast)
    else:
        found = without_positions(placed, ordered, settings)
    barrel_of: list[int | None] = [None] * len(by_id)
    for i, j in zip(by_id, found.barrel_of, strict=True):
        barrel_of[i] = None if j is None else by_place[j]
    fixed = tuple(j is not None and parts[j].fixed_id is not None for j in barrel_of)
    pieces = tuple(replace(one, barrels=tuple(by_place[j] for j in one.barrels)) for one in found.displaced)
    return replace(found, barrel_of=tuple(barrel_of), fixed=fixed, displaced=pieces)


def _register(
    parts: tuple[BarrelPart, ...], arena: Arena, settings: Settings, start: StartPose | None, fast: bool
) -> Assignment:
    """Register parts that stand in order; an arena with positions."""
    count = len(arena.parts)
    problem = make_problem(parts, arena, settings)
    optimum = find(problem, start, fast)
    if not optimum.maxima:
        return Assignment((None,) * count, (False,) * count, None, 0.0, optimum.upper_bound)
    chosen = _nearest(problem, optimum.maxima) if arena.frame == "map" else optimum.maxima[0]
    barrel_of: list[int | None] = [None] * count
    for i, j in chosen.pairs:
        barrel_of[int(i)] = int(j)
    findings = name_findings(chosen, optimum.maxima[0], parts, arena, settings)
    runner_up = None
    pieces: tuple[Displaced, ...] = ()
    if not fast:
        pieces, told = displaced_submaps(problem, chosen, [part.id for part in arena.parts])
        findings += told
    if not fast and len(chosen.pairs) >= LEAST_PARTS:
        runner_up, rival = find_runner_up(problem, arena, start, optimum, chosen)
        findings += ambiguous(chosen, rival, parts, arena)
    return Assignment(
        tuple(barrel_of), (False,) * count, chosen.transform, chosen.value, optimum.upper_bound, runner_up, findings,
        pieces,
    )  # fmt: skip


def _place_of(part: BarrelPart) -> tuple[float | str, ...]:
    """What sorts barrel parts whatever order they come in; equal ones can stand for each other."""
    facing = 10.0 if part.facing is None else part.facing
    return (part.x_m, part.y_m, facing, part.drawn, part.confidence, part.fixed_id or "")


def _nearest(problem: Problem, maxima: list[Placement]) -> Placement:
    """Of the local maxima within 1 % of the best, the one that moves its barrel parts least from the identity."""
    good = [m for m in maxima if m.value >= 0.99 * maxima[0].value]
    return min(good, key=lambda m: displacement(problem, m, Transform()))
