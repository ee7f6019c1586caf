"""Arenas without positions: halves on one wall are paired by facing apart and by the wall's thickness."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations, permutations
from random import Random

import numpy as np
import pytest

from fidmap.attributes import attributes
from fidmap.model import CONTINUOUS, SSRR2011, Arena, ArenaFileError, BarrelPart, FiducialPart, Group, Settings
from fidmap.register import register
from fidmap.register.pairs import pairable
from fiducials import HALF, arc, arena_of, names

D = 1.2


def bare(*groups: Group, opening: float = HALF) -> Arena:
    """An arena whose parts have ids alone."""
    ids = sorted({name for group in groups for name in group.parts})
    return arena_of(*(FiducialPart(name, opening=opening) for name in ids), groups=groups)


def wall(name: str, distance_m: float = 0.1, group_class: str = "short") -> Group:
    return Group(name, (f"{name}A", f"{name}B"), group_class, distance_m=distance_m)


def back_to_back(n: int, x: float, y: float, thickness_m: float, facing: float = 0.0) -> tuple[BarrelPart, BarrelPart]:
    """The two halves on a wall through (x, y), numbered n and n + 1."""
    dx, dy = thickness_m / 2 * math.cos(facing), thickness_m / 2 * math.sin(facing)
    return arc(n, x + dx, y + dy, facing), arc(n + 1, x - dx, y - dy, facing + math.pi)


def pairs_of(arena: Arena, parts: tuple[BarrelPart, ...], profile: Settings = CONTINUOUS) -> dict[str, set[int]]:
    """Group id -> the numbers of its two arcs."""
    found = names(arena, register(parts, arena, profile), parts)
    return {g.id: {found[p] for p in g.parts} for g in arena.groups if set(g.parts) <= found.keys()}


def codes(arena: Arena, parts: tuple[BarrelPart, ...]) -> list[str]:
    return [finding.code for finding in register(parts, arena, CONTINUOUS).findings]


def test_halves_on_a_wall_are_paired_and_scored() -> None:
    """Two walls of 10 cm, drawn 10 and 40 cm thick; a third is not drawn: coverage 4/6, consistency 1 - 0.3/1.2/2."""
    arena = bare(wall("1"), wall("2"), wall("3"))
    parts = (*back_to_back(1, 0, 0, 0.1), *back_to_back(3, 5, 2, 0.4, 1.0))

    found = register(parts, arena, CONTINUOUS)
    scores = attributes(parts, arena, found, CONTINUOUS)

    assert set(map(frozenset, pairs_of(arena, parts).values())) == {frozenset({1, 2}), frozenset({3, 4})}
    assert scores.by_name["coverage"].value == pytest.approx(4 / 6)
    assert scores.by_name["consistency"].value == pytest.approx(1 - 0.3 / 1.2 / 2)
    assert scores.by_name["relative_accuracy"].value is None
    assert scores.by_name["relative_accuracy"].reason == "the arena has no positions"
    assert found.transform is None
    assert [f.code for f in found.findings] == ["interchangeable"]
    assert found.findings[0].text.startswith("the arena has no positions: 2 of 3 pairs of halves were found")


def test_each_pair_goes_to_the_group_whose_distance_it_fits() -> None:
    """A thin and a thick wall: which is which follows from the thickness."""
    arena = bare(wall("thick", 0.5), wall("thin", 0.05))
    parts = (*back_to_back(1, 0, 0, 0.1), *back_to_back(3, 5, 2, 0.45))

    assert pairs_of(arena, parts) == {"thin": {1, 2}, "thick": {3, 4}}


def test_the_best_sum_not_the_nearest_first() -> None:
    """Nearest first would pair 2 with 3 and leave 1 and 4 alone."""
    arena = bare(wall("1", 0.3), wall("2", 0.3))
    parts = (arc(1, 0.9, 0, 0), arc(2, 0.3, 0, math.pi), arc(3, 0.5, 0, 0), arc(4, 0.0, 0, math.pi))

    assert set(map(frozenset, pairs_of(arena, parts).values())) == {frozenset({1, 2}), frozenset({3, 4})}


@pytest.mark.parametrize(
    ("other", "is_paired"),
    [
        (arc(2, -0.1, 0, math.pi), True),
        (arc(2, -0.1, 0, math.pi + math.radians(59)), True),
        (arc(2, -0.1, 0, math.pi + math.radians(60)), False),
        (arc(2, -1.29, 0, math.pi), True),  # 1.19 m thicker than the wall
        (arc(2, -1.31, 0, math.pi), False),
        (arc(2, 0.29, 0, math.pi), True),  # a wall drawn twice
        (arc(2, 1.0, 0, math.pi), False),  # face to face over a corridor
        (arc(2, -0.1, 1.25, math.pi), False),  # beside it
        (arc(2, -0.1, 0, None), False),
        (arc(2, -0.1, 0, math.pi, drawn=math.radians(119)), False),
        (arc(2, -0.1, 0, math.pi, confidence=0.4), False),
        (arc(2, -0.1, 0, math.pi, fixed_id="-"), False),
    ],
)  # fmt: skip
def test_which_arcs_are_a_pair(other: BarrelPart, is_paired: bool) -> None:
    """Facing apart within the tolerance, within D of the distance, back to back, drawn and confident enough."""
    arena = bare(wall("1", 0.1))

    assert bool(pairs_of(arena, (arc(1, 0, 0, 0), other))) == is_paired


def test_a_pair_stepped_to_d_is_assigned_with_error_one() -> None:
    """1.1 m off is nearest to four radii."""
    arena = bare(wall("1", 0.1))
    parts = back_to_back(1, 0, 0, 1.2)

    scores = attributes(parts, arena, register(parts, arena, SSRR2011), SSRR2011)

    assert scores.by_name["coverage"].value == 1
    assert scores.by_name["consistency"].value == 0


def exhaustive(parts: tuple[BarrelPart, ...], distances: list[float]) -> float:
    """The greatest sum over all ways to give disjoint pairs to the groups."""
    pairs: dict[tuple[int, int], tuple[complex, complex]] = {}
    for a, b in combinations(range(len(parts)), 2):
        one, other = parts[a], parts[b]
        turn = ((one.facing or 0) - (other.facing or 0)) % (2 * math.pi) - math.pi
        away = complex(one.x_m - other.x_m, one.y_m - other.y_m)
        out = np.exp(1j * (one.facing or 0)) - np.exp(1j * (other.facing or 0))
        out /= abs(out)
        if abs(turn) < math.pi / 3 and (away * np.conj(out)).real >= -0.3:
            pairs[a, b] = away, out
    best = 0.0
    for count in range(len(distances) + 1):
        for chosen in combinations(pairs, count):
            if len({k for pair in chosen for k in pair}) == 2 * count:
                for order in permutations(distances, count):
                    best = max(best, sum(worth(*pairs[p], t) for p, t in zip(chosen, order, strict=True)))
    return best


def worth(away: complex, out: complex, thickness: float) -> float:
    return 1 - abs(abs(away) - thickness) / D if abs(away - thickness * out) < D else 0.0


@pytest.mark.parametrize("seed", range(8))
def test_the_matching_is_the_best_of_all(seed: int) -> None:
    """Six crowded arcs and three groups against every possibility."""
    random = np.random.default_rng(seed)
    distances = [0.1, 0.1, 0.5]
    arena = bare(*(wall(str(k), d) for k, d in enumerate(distances)))
    facing = random.choice([0.0, math.pi], 6) + random.normal(0, 0.3, 6)
    parts = tuple(arc(k, *random.uniform(0, 1, 2).tolist(), float(facing[k])) for k in range(6))

    result = register(parts, arena, CONTINUOUS)

    scores = attributes(parts, arena, result, CONTINUOUS)
    total = sum(1 - g.loss for g in scores.groups if g.loss is not None)
    assert total == pytest.approx(exhaustive(parts, distances), abs=1e-6)


def test_the_order_of_inputs_changes_nothing() -> None:
    """Arcs, parts and groups shuffled: the same ids."""
    arena = bare(*(wall(str(k)) for k in range(5)))
    parts = tuple(p for k in range(5) for p in back_to_back(2 * k, k, k % 2, 0.1 + 0.02 * k, 0.5 * k))
    first = names(arena, register(parts, arena, CONTINUOUS), parts)
    assert len(first) == 10
    random = Random(3)
    for _ in range(3):
        mixed, ids, groups = list(parts), list(arena.parts), list(arena.groups)
        for one in (mixed, ids, groups):
            random.shuffle(one)
        other = replace(arena, parts=tuple(ids), groups=tuple(groups))
        assert names(other, register(tuple(mixed), other, CONTINUOUS), mixed) == first


def test_what_a_human_named_stays_and_the_rest_is_paired() -> None:
    """1A is named: its other half is found; 2 is named wholly, though its arcs face anywhere."""
    arena = bare(wall("1"), wall("2"), wall("3"))
    a, b = back_to_back(1, 0, 0, 0.1)
    one = (a, replace(b, fixed_id="1A"))
    two = (arc(5, 9, 9, None, fixed_id="2A"), arc(6, 9, 9.2, None, fixed_id="2B"))
    parts = (*one, *two, *back_to_back(7, 4, 4, 0.1))

    result = register(parts, arena, CONTINUOUS)

    found = names(arena, result, parts)
    assert (found["1A"], found["1B"], found["2A"], found["2B"]) == (2, 1, 5, 6)
    assert {found["3A"], found["3B"]} == {7, 8}
    assert result.fixed == (True, False, True, True, False, False)


def test_only_halves_on_one_wall_are_paired() -> None:
    """Groups of far parts, of whole barrels, and of parts that are in other pairs too need ids."""
    far = Group("far", ("5A", "6B"), "long", distance_m=7.0)
    chain = Group("chain", ("1A", "2A"), "long", distance_m=0.1)

    assert pairable(bare(wall("1"), far)) == (("1A", "1B"),)
    assert pairable(bare(wall("1"), wall("2"), chain)) == ()
    assert pairable(bare(wall("1"), replace(wall("1"), id="w", named_class="walls"))) == (("1A", "1B"),)
    assert pairable(bare(wall("1", 0.59), wall("2", 0.61), opening=2 * math.pi)) == (("1A", "1B"),)
    with pytest.raises(ArenaFileError, match="put the two halves on each wall into a group with distance_m"):
        register(back_to_back(1, 0, 0, 0.1), bare(far), CONTINUOUS)


def test_classes_that_could_change_places_are_told() -> None:
    """A short and a long pair on walls of the same thickness; with different walls nothing is said."""
    parts = (*back_to_back(1, 0, 0, 0.1), *back_to_back(3, 5, 2, 0.1))

    assert codes(bare(wall("1"), wall("2", group_class="long")), parts) == ["interchangeable", "class-unknown"]
    assert codes(bare(wall("1"), wall("2", 0.5, "long")), parts) == ["interchangeable"]


@pytest.mark.parametrize("parts", [(), (arc(1, 0, 0, 0),), (arc(1, 0, 0, None), arc(2, 0, 0, None))])
def test_a_map_without_pairs(parts: tuple[BarrelPart, ...]) -> None:
    """Nothing assigned: coverage 0."""
    arena = bare(wall("1"))

    result = register(parts, arena, CONTINUOUS)

    assert result.barrel_of == (None, None)
    assert "0 of 1 pairs" in result.findings[0].text
