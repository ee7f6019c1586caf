"""The proof of a registration: bounds that hold, against every other way to look for something better."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from fidmap.model import CONTINUOUS, SSRR2011, Arena, Assignment, BarrelPart, Settings, Transform
from fidmap.register import register
from fidmap.register.bounds import loose_bounds, tight_bounds
from fidmap.register.certify import open_boxes
from fidmap.register.landscape import Landscape
from fidmap.register.majorant import affine_majorant
from fidmap.register.near import Matcher
from fidmap.register.optimum import find
from fidmap.register.polish import place
from fidmap.register.prices import matched
from fidmap.register.problem import Problem, make_problem
from fidmap.register.rivals import Rivals
from fidmap.register.runner_up import find_runner_up
from fidmap.register.sweep import Sweep, raster
from fiducials import arc, arena_of, drawn, half, pairs_arena

STEPPED = [replace(CONTINUOUS, rounding=one) for one in ("nearest", "down", "up")]
SIMILAR = replace(CONTINUOUS, transform="similarity")


def scattered(fiducials: int, barrels: int, seed: int, faced: bool = True) -> tuple[Arena, tuple[BarrelPart, ...]]:
    """Parts anywhere in 5 m, facing anywhere; some of the arcs near some of the parts."""
    random = np.random.default_rng(seed)
    points, turns = random.uniform(0, 5, (fiducials, 2)), random.uniform(-3, 3, fiducials + barrels)
    arena = arena_of(*(half(f"P{k}", *xy, turns[k] if faced else None) for k, xy in enumerate(points.tolist())))
    near = points[random.integers(0, fiducials, barrels)] + random.normal(0, 0.4, (barrels, 2))
    parts = (arc(k, *xy, turns[k] if faced else None) for k, xy in enumerate(near.tolist(), 1))
    return arena, tuple(parts)


def problem_of(arena: Arena, parts: tuple[BarrelPart, ...], profile: Settings) -> Problem:
    return make_problem(parts, arena, profile)


@pytest.mark.parametrize("profile", [CONTINUOUS, *STEPPED, SIMILAR], ids=["none", "nearest", "down", "up", "scale"])
@pytest.mark.parametrize("sizes", [(9, 6), (6, 9)], ids=["more parts", "more arcs"])
def test_no_placement_in_a_box_is_worth_more_than_its_bounds(profile: Settings, sizes: tuple[int, int]) -> None:
    """Boxes of all sizes, thirty random placements in each: loose and tight bounds hold."""
    random = np.random.default_rng(3)
    problem = problem_of(*scattered(*sizes, seed=4), profile)
    land = Landscape(problem)
    matcher = Matcher(land)
    for size in (1.0, 0.3, 0.1, 0.02, 0.0):
        halves = np.array([0.3, 1.0, 1.0, 0.1 if profile.transform == "similarity" else 0.0]) * size
        middles = np.concatenate([random.uniform([-3, 1, 1, 1.0], [3, 4, 4, 1.0], (12, 4)), [[0.0, 2.5, 2.5, 1.0]]])
        middles[-1] = land.placement(Transform())
        boxes = np.concatenate([middles, np.tile(halves, (13, 1))], axis=1)
        pairs = matcher.near(boxes)
        loose, most = loose_bounds(matcher, pairs, 13)
        values, prices = matched(matcher, pairs, 13)
        tight = tight_bounds(land, boxes, pairs, most, prices)
        for k, box in enumerate(boxes):
            inside = box[:4] + random.uniform(-1, 1, (30, 4)) * box[4:]
            worth = max(problem.match(land.transform(one))[0] for one in inside)
            assert worth <= min(loose[k], tight[k]) + 1e-6
        if size == 0.0 and profile.rounding == "none":
            assert tight == pytest.approx(values, abs=1e-5)  # the prices prove the matching


@pytest.mark.parametrize("profile", [CONTINUOUS, STEPPED[0], SIMILAR], ids=["none", "nearest", "scale"])
def test_a_sweep_bounds_every_placement(profile: Settings) -> None:
    """Random placements and the best one: the cell that they fall into is worth at least as much."""
    random = np.random.default_rng(5)
    arena, parts = scattered(8, 7, seed=6)
    problem = problem_of(arena, parts, profile)
    land = Landscape(problem)
    mesh = raster(land, 0.2, 1.0)
    assert mesh is not None
    sweep = Sweep(land, mesh, inflated=True)
    layers = list(sweep.layers(0.0))
    best = register(parts, arena, profile).transform
    assert best is not None
    trials = [land.placement(best), *random.uniform([-math.pi, 0, 0, 1.0], [math.pi, 5, 5, 1.0], (200, 4))]
    for trial in trials:
        rotation = math.remainder(trial[0], 2 * math.pi)
        layer = min(layers, key=lambda one: (abs(one.rotation - rotation), abs(one.scale - trial[3])))
        row, column = (round((trial[k] - layer.corner[k - 1]) / layer.cell) for k in (2, 1))
        assert problem.match(land.transform(trial))[0] <= layer.sums[row, column] / sweep.unit + 1e-6


@pytest.mark.parametrize("profile", STEPPED, ids=["nearest", "down", "up"])
def test_majorants_are_never_below_the_steps(profile: Settings) -> None:
    """Any distance and reach, looked at on a fine comb; tight where nothing falls."""
    random = np.random.default_rng(7)
    land = Landscape(problem_of(pairs_arena(), drawn(pairs_arena()), profile))
    distance, reach = random.uniform(0, 1.4, 500), random.uniform(0, 0.8, 500)
    height, slope = affine_majorant(land, distance, reach)
    for share in np.linspace(-1, 1, 201):
        d = np.maximum(distance + share * reach, 0.0)
        worth = np.where(d < land.problem.d_max, 1 - land.problem.loss(d), 0.0)
        assert (worth <= height - slope * d + 1e-9).all()


def test_of_too_many_open_boxes_the_best_are_kept_and_the_rest_stays_in_the_bound() -> None:
    land = Landscape(problem_of(*scattered(9, 6, seed=4), CONTINUOUS))
    cut = land.most / 4
    boxes, bounds, shut = open_boxes(land, cut, 1_000_000, (1 / 8,))
    assert shut == cut
    few, high, rest = open_boxes(land, cut, 100, (1 / 8,))
    kept = {tuple(box) for box in few.tolist()}
    dropped = [bound for box, bound in zip(boxes.tolist(), bounds.tolist(), strict=True) if tuple(box) not in kept]
    assert 0 < len(few) <= 100 < len(boxes)
    assert cut < max(dropped) == rest < high.min()


def exhaustive(problem: Problem) -> float:
    """The greatest value of all one-to-one assignments, each climbed from every pair of pairs: small problems only."""
    fiducials, barrels = problem.fiducials @ [1, 1j], problem.barrels @ [1, 1j]
    if len(fiducials) < len(barrels):
        fiducials, barrels = barrels, fiducials
    best = 0.0
    for chosen in permutations(range(len(fiducials)), len(barrels)):
        target = fiducials[list(chosen)]

        def loss(x: np.ndarray, target: np.ndarray = target) -> float:
            away = np.abs(np.exp(1j * x[0]) * barrels + x[1] + 1j * x[2] - target)
            return float(-np.maximum(0, 1 - away / problem.d_max).sum())

        for a in range(len(barrels)):
            for b in range(a):
                turn = np.angle((target[a] - target[b]) / (barrels[a] - barrels[b]))
                for anchor in (a, b):
                    at = target[anchor] - np.exp(1j * turn) * barrels[anchor]
                    best = max(best, -loss(np.array([turn, at.real, at.imag])))
        if len(barrels) > 2:
            best = max(best, -min(minimize(loss, x, method="Nelder-Mead").fun for x in _seeds(target, barrels)))
    return best


def _seeds(target: np.ndarray, barrels: np.ndarray) -> list[np.ndarray]:
    moment = ((barrels - barrels.mean()).conj() * (target - target.mean())).sum()
    at = target.mean() - moment / abs(moment) * barrels.mean()
    return [np.array([np.angle(moment), at.real, at.imag])]


@pytest.mark.parametrize("sizes", [(2, 2), (3, 3), (4, 3), (3, 4), (4, 4)])
@pytest.mark.parametrize("seed", [1, 2])
def test_small_problems_agree_with_exhaustive_search(sizes: tuple[int, int], seed: int) -> None:
    """Every assignment tried by itself finds nothing above the bound, and nothing that the search missed."""
    arena, parts = scattered(*sizes, seed=seed, faced=False)

    result = register(parts, arena, CONTINUOUS)

    known = exhaustive(problem_of(arena, parts, CONTINUOUS))
    assert result.upper_bound is not None
    assert known <= result.upper_bound + 1e-9
    assert result.value >= known * 0.999


@settings(derandomize=True, deadline=None, max_examples=8)
@given(seed=st.integers(0, 9999), sizes=st.tuples(st.integers(1, 7), st.integers(1, 7)), stepped=st.booleans())
def test_the_value_is_never_above_the_bound(seed: int, sizes: tuple[int, int], stepped: bool) -> None:
    """And the bound is within the tolerance; with steps it is the value."""
    arena, parts = scattered(*sizes, seed=seed)

    result = register(parts, arena, SSRR2011 if stepped else CONTINUOUS)

    assert result.upper_bound is not None
    assert result.value <= result.upper_bound + 1e-9
    assert result.upper_bound <= (result.value + 1e-9 if stepped else result.value * 1.001 + 1e-6)


@settings(derandomize=True, deadline=None, max_examples=2)
@given(seed=st.integers(0, 999), turn=st.floats(-3, 3), x=st.floats(-50, 50))
def test_rigid_moves_leave_the_optimum_where_it_is(seed: int, turn: float, x: float) -> None:
    """A map drawn elsewhere: the same value within the tolerance of the proof."""
    arena, parts = scattered(5, 5, seed=seed)
    c, s = math.cos(turn), math.sin(turn)
    moved = tuple(
        replace(p, x_m=c * p.x_m - s * p.y_m + x, y_m=s * p.x_m + c * p.y_m - x, facing=(p.facing or 0.0) + turn)
        for p in parts
    )

    assert register(moved, arena, CONTINUOUS).value == pytest.approx(register(parts, arena, CONTINUOUS).value, rel=1e-3)


def ring(count: int) -> Arena:
    """Parts on a circle, facing outwards: turning by one place fits as well."""
    angles = [2 * math.pi * k / count for k in range(count)]
    return arena_of(*(half(f"{k}", 5 * math.cos(a), 5 * math.sin(a), a) for k, a in enumerate(angles)))


def codes(result: Assignment) -> list[str]:
    return [finding.code for finding in result.findings]


def test_a_symmetric_layout_is_ambiguous() -> None:
    """Five turns of a ring of six are as good as the best one: told, with what would help."""
    arena = ring(6)

    result = register(drawn(arena), arena, CONTINUOUS)

    assert result.runner_up is not None
    assert result.runner_up.value == pytest.approx(6, abs=1e-3)
    assert result.runner_up.upper_bound <= 6 + 1e-9
    assert codes(result) == ["ambiguous"]
    assert "(6.000 against 6.000)" in result.findings[0].text
    assert "start pose (--start-pose)" in result.findings[0].text
    assert "facings" not in result.findings[0].text  # all are known already


def test_facings_are_no_remedy_for_whole_barrels() -> None:
    """A ring of barrels that stand free: nothing that faces anywhere could be told."""
    parts = (replace(p, facing=None, opening=2 * math.pi) for p in ring(5).parts)
    arena = arena_of(*parts)

    result = register(drawn(arena), arena, CONTINUOUS)

    assert codes(result) == ["ambiguous"]
    assert "facings" not in result.findings[0].text


def test_facings_break_a_symmetry() -> None:
    """The same ring, two halves turned round: exact maps of it are never ambiguous; without facings they are."""
    parts = list(ring(6).parts)
    for k in (0, 1):
        parts[k] = replace(parts[k], facing=(parts[k].facing or 0.0) + math.pi)
    faced = arena_of(*parts)
    bare = arena_of(*(replace(p, facing=None) for p in parts))

    sure, unsure = register(drawn(faced), faced, CONTINUOUS), register(drawn(bare), bare, CONTINUOUS)

    assert codes(sure) == []
    assert sure.runner_up is not None
    assert sure.runner_up.upper_bound < 0.95 * 6
    assert codes(unsure) == ["ambiguous"]
    assert "facings of the parts" in unsure.findings[0].text


@pytest.mark.parametrize("seed", [1, 2])
def test_no_other_registration_is_worth_more_than_the_runner_ups_bound(seed: int) -> None:
    """Six hundred random placements: those that are others than the best one stay below, the bound holds."""
    random = np.random.default_rng(seed)
    arena, parts = scattered(7, 7, seed=seed)
    problem = problem_of(arena, parts, CONTINUOUS)
    optimum = find(problem, None, fast=False)
    best = optimum.maxima[0]
    runner_up, rival = find_runner_up(problem, arena, None, optimum, best)
    rivals = Rivals(problem, best, np.eye(7, dtype=bool))
    land = Landscape(problem)
    near = land.placement(best.transform) + random.normal(0, 1, (300, 4)) * [0.2, 0.5, 0.5, 0]
    trials = np.concatenate([near, random.uniform([-math.pi, 0, 0, 1.0], [math.pi, 5, 5, 1.0], (300, 4))])

    others = [one.value for one in (place(problem, land.transform(t)) for t in trials) if rivals.includes(one)]

    assert len(others) > 100
    assert max(others) <= runner_up.upper_bound + 1e-9
    assert rival is not None
    assert rival.value == runner_up.value <= runner_up.upper_bound
    assert rivals.includes(rival)


def test_below_three_parts_there_is_no_runner_up() -> None:
    """Two parts fit anywhere."""
    arena = pairs_arena()

    assert register(drawn(arena)[:2], arena, CONTINUOUS).runner_up is None


def test_the_quick_search_gives_no_bound() -> None:
    """A value and its placement, but nothing that looks like a proof."""
    arena = pairs_arena()

    result = register(drawn(arena, noise_m=0.1), arena, CONTINUOUS, fast=True)

    assert result.upper_bound is result.runner_up is None
    assert result.value > 8


@pytest.mark.parametrize("profile", [CONTINUOUS, SSRR2011])
def test_what_a_human_fixed_wholly_is_found_within_a_ten_thousandth(profile: Settings) -> None:
    """All ids given: the bound is that near, or exact with steps."""
    arena = pairs_arena()
    parts = drawn(arena, Transform(0.4, 2, 1), noise_m=0.3, seed=8)
    fixed = tuple(replace(p, fixed_id=f.id) for p, f in zip(parts, arena.parts, strict=True))

    result = register(fixed, arena, profile)

    assert result.upper_bound is not None
    assert result.value <= result.upper_bound <= result.value * 1.0001 + 1e-9
