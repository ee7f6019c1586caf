from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from fidmap.synth.arena import ArenaSpec, make_arena
from fidmap.synth.maze import walking_distances

FULL = ArenaSpec(pairs=6, void_pairs=2, singles=2, wholes=2, clutter=8, wall_m=0.04)


@pytest.mark.parametrize("seed", range(4))
def test_pairs_stand_back_to_back(seed):
    """Centres are one wall thickness apart, over a void one pallet more; facings are opposite, outwards."""
    arena = make_arena(np.random.default_rng(seed), FULL).arena
    parts = {part.id: part for part in arena.parts}

    assert len(arena.groups) >= 7
    for number, group in enumerate(arena.groups):
        a, b = (parts[name] for name in group.parts)
        apart = np.array([b.x_m - a.x_m, b.y_m - a.y_m])
        outward = np.array([math.cos(b.facing), math.sin(b.facing)])
        expected = 1.24 if number < 2 else 0.04
        assert group.distance_m == pytest.approx(expected)
        assert apart @ outward == pytest.approx(expected)
        assert abs(math.remainder(a.facing - b.facing, 2 * math.pi)) == pytest.approx(math.pi)


def test_walking_pallets_are_those_of_the_maze():
    """The two pallets from which a pair is seen, by breadth-first search."""
    made = make_arena(np.random.default_rng(3), FULL)
    parts = {part.id: part for part in made.arena.parts}

    for group in made.arena.groups:
        first, second = (
            (
                int((parts[n].y_m + 0.2 * math.sin(parts[n].facing)) // 1.2),
                int((parts[n].x_m + 0.2 * math.cos(parts[n].facing)) // 1.2),
            )
            for n in group.parts
        )
        assert walking_distances(made.maze, first)[second] == group.walking_pallets


def test_objects_keep_their_distance():
    """No two fiducial parts of different objects touch."""
    arena = make_arena(np.random.default_rng(5), FULL).arena

    for a, b in itertools.combinations(arena.parts, 2):
        if a.id[:-1] != b.id[:-1] or a.facing is None:
            assert math.hypot(a.x_m - b.x_m, a.y_m - b.y_m) > 2 * 0.30


def test_clutter_is_no_fiducial_and_has_other_radii():
    """Arcs that belong to no part never have the fiducials' radius to within 15 percent, unless quarters."""
    for seed in range(10):
        made = make_arena(np.random.default_rng(seed), FULL)
        clutter = made.arcs[made.arc_part < 0]
        rounds = clutter[clutter[:, 4] > 2]

        assert np.all(np.abs(rounds[:, 2] / 0.30 - 1) > 0.15)
        assert len(made.arena.parts) == (made.arc_part >= 0).sum()


def test_the_same_seed_gives_the_same_arena():
    """All randomness comes from the generator."""
    first, again = (make_arena(np.random.default_rng(9), FULL) for _ in range(2))

    assert first.arena == again.arena
    assert np.array_equal(first.walls, again.walls)


def test_arrays_are_read_only():
    """Nobody can move a wall of a finished arena."""
    with pytest.raises(ValueError, match="read-only"):
        make_arena(np.random.default_rng(0)).walls[0] = 0


@pytest.mark.parametrize("spec", [ArenaSpec(columns=1), ArenaSpec(radius_m=0.5)])
def test_impossible_arenas_are_refused(spec):
    """Too few pallets, or barrels that would block the way."""
    with pytest.raises(ValueError, match="an arena needs"):
        make_arena(np.random.default_rng(0), spec)
