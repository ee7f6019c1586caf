from __future__ import annotations

import numpy as np
import pytest

from fidmap.synth.maze import (
    PalletMaze,
    open_around,
    random_maze,
    shortest_way,
    walking_distances,
    wall_boxes,
    wall_count_at_corners,
)


def snake() -> PalletMaze:
    """Three rows of three pallets, walked like a snake: east, up at (0, 2), west, up at (1, 0), east."""
    north = np.array([[False, False, True], [True, False, False]])
    return PalletMaze(np.ones((3, 2), bool), north, np.zeros((3, 3), bool), pallet_m=1.0)


def test_walking_distances_of_a_hand_made_maze():
    """Both sides of the wall between (0, 0) and (1, 0) are five pallets apart: the snake must be walked."""
    assert walking_distances(snake(), (0, 0)).tolist() == [[0, 1, 2], [5, 4, 3], [6, 7, 8]]


def test_a_void_has_no_way():
    """A pallet without any open side is at distance -1."""
    maze = PalletMaze(np.zeros((1, 1), bool), np.zeros((0, 2), bool), np.array([[False, True]]))

    assert walking_distances(maze, (0, 0)).tolist() == [[0, -1]]


def test_shortest_way_ends_at_the_nearest_wanted_pallet():
    """Of two wanted pallets the nearer one is reached; none wanted gives no way."""
    wanted = np.zeros((3, 3), bool)
    wanted[1, 1] = wanted[2, 2] = True

    assert shortest_way(snake(), (0, 1), wanted) == [(0, 2), (1, 2), (1, 1)]
    assert shortest_way(snake(), (0, 1), np.zeros((3, 3), bool)) == []


def test_walls_in_one_line_are_one_box():
    """A single room of one pallet has four walls, each a box centred on its lattice line."""
    room = PalletMaze(np.zeros((1, 0), bool), np.zeros((0, 1), bool), np.zeros((1, 1), bool), 1.2)

    boxes = wall_boxes(room, 0.02)

    assert boxes.tolist() == pytest.approx(
        np.array(
            [
                [-0.01, -0.01, 1.21, 0.01],
                [-0.01, 1.19, 1.21, 1.21],
                [-0.01, -0.01, 0.01, 1.21],
                [1.19, -0.01, 1.21, 1.21],
            ]
        )
    )
    assert len(wall_boxes(snake(), 0.02)) == 4 + 2


def test_free_wall_ends_are_corners_with_one_wall():
    """The snake's two inner walls have their free ends at (row 1, column 2) and (row 2, column 1)."""
    assert np.argwhere(wall_count_at_corners(snake()) == 1).tolist() == [[1, 2], [2, 1]]


def test_open_around_takes_four_walls_away():
    """No wall is left at the corner."""
    assert wall_count_at_corners(open_around(snake(), (1, 1)))[1, 1] == 0


@pytest.mark.parametrize("seed", range(5))
def test_every_pallet_of_a_random_maze_can_be_reached(seed):
    """A void stays closed, all else hangs together."""
    void = np.zeros((5, 7), bool)
    void[2, 3] = True

    maze = random_maze(np.random.default_rng(seed), (5, 7), void=void, openness=0.1)

    assert np.array_equal(walking_distances(maze, (0, 0)) < 0, void)


def test_voids_that_cut_the_maze_apart_are_refused():
    """A wall of voids leaves two mazes."""
    void = np.zeros((3, 3), bool)
    void[:, 1] = True

    with pytest.raises(ValueError, match="must hang together"):
        random_maze(np.random.default_rng(0), (3, 3), void=void)


def test_shapes_that_do_not_fit_are_refused():
    """The message names the expected and the given shapes."""
    with pytest.raises(ValueError, match=r"needs east \(2, 1\) and north \(1, 2\)"):
        PalletMaze(np.ones((2, 2), bool), np.ones((1, 2), bool), np.zeros((2, 2), bool))
