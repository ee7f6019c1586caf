from __future__ import annotations

import itertools

import numpy as np
import pytest

from fidmap.model import Grid
from fidmap.synth.evening import evening
from fidmap.synth.suite import case_rng, suite

TIERS = ("exact", "clean", "noisy", "broken", "large", "office", "field")


def same(a: Grid, b: Grid) -> bool:
    """Whether two grids are equal to the bit."""
    return a.origin == b.origin and np.array_equal(a.occupancy, b.occupancy, equal_nan=True)


@pytest.mark.parametrize("tier", ["clean", "broken"])
def test_a_suite_can_be_made_again(tier):
    """Same seed, same maps and truth; the first case does not depend on how many follow."""
    first, again = next(suite("tune", 5, 1, tier)), next(suite("tune", 5, 3, tier))

    assert same(first.grid, again.grid)
    assert first.truths == again.truths
    assert first.arena.arena == again.arena.arena
    assert first.name == f"tune-{tier}-5-000"


def test_splits_seeds_tiers_and_cases_never_share_random_numbers():
    """All streams differ in their first four numbers."""
    streams = {
        tuple(case_rng(split, seed, tier, index).integers(2**62, size=4).tolist())
        for split, seed, tier, index in itertools.product(("tune", "test"), range(10), TIERS, range(10))
    }

    assert len(streams) == 2 * 10 * 7 * 10


@pytest.mark.slow
def test_large_maps_are_large():
    """A square of 1500 to 4000 cells with parts drawn in it."""
    case = next(suite("tune", 0, 1, "large"))

    assert 1500 <= min(case.grid.occupancy.shape) <= max(case.grid.occupancy.shape) <= 4000
    assert sum(truth.drawn == "yes" for truth in case.truths) > 10


def test_an_evening_has_one_arena_and_many_maps():
    """Maps of the size asked for, no two the same, and the same again for the same seed."""
    arena, maps = evening(seed=1, maps=2, cells=600)
    (name, first), (_, second) = maps
    again = next(evening(seed=1, maps=1, cells=600)[1])[1]

    assert len(arena.arena.parts) >= 10
    assert name == "team01"
    assert min(first.occupancy.shape) >= 600
    assert same(first, again)
    assert not same(first, second)
