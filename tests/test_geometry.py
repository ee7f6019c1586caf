"""Transforms of the plane against matrices written out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fidmap.geometry import angle_between, apply, apply_inverse, turn_directions, weighted_similarity
from fidmap.model import Transform

POINTS = np.array([[1.0, 0.0], [0.0, 2.0], [-3.0, 0.5]])


@pytest.mark.parametrize(
    ("a", "b", "apart"),
    [(0.0, 0.0, 0.0), (0.1, 2 * math.pi, 0.1), (math.pi, -math.pi, 0.0), (3.0, -3.0, 2 * math.pi - 6), (0, 7, 7 - 2 * math.pi)],
)
def test_angles_are_compared_around_the_circle(a: float, b: float, apart: float) -> None:
    """In [0, pi], either way round."""
    assert float(angle_between(a, b)) == pytest.approx(apart, abs=1e-12)
    assert float(angle_between(b, a)) == pytest.approx(apart, abs=1e-12)


def test_nothing_is_known_about_an_angle_that_is_not_there() -> None:
    """NaN stays NaN, so that comparisons with it are false."""
    assert math.isnan(float(angle_between(math.nan, 1.0)))


def test_a_quarter_turn_and_a_shift() -> None:
    """(1, 0) to (0, 1), then by (10, 20)."""
    moved = apply(Transform(math.pi / 2, 10, 20), POINTS)

    assert moved == pytest.approx(np.array([[10, 21], [8, 20], [9.5, 17]]))


def test_scale_comes_before_the_shift_and_the_mirror_before_both() -> None:
    """p_truth = scale * R * diag(1, -1) * p + t."""
    moved = apply(Transform(math.pi / 2, 10, 20, 2.0, True), np.array([[1.0, 3.0]]))

    assert moved == pytest.approx(np.array([[16, 22]]))


@pytest.mark.parametrize("mirrored", [False, True])
def test_the_inverse_undoes(mirrored: bool) -> None:
    """For any transform."""
    move = Transform(1.3, -4, 2, 0.9, mirrored)

    assert apply_inverse(move, apply(move, POINTS)) == pytest.approx(POINTS)


@pytest.mark.parametrize("mirrored", [False, True])
def test_directions_turn_as_points_do(mirrored: bool) -> None:
    """The direction of the moved arrow is the turned direction."""
    move = Transform(0.7, 5, 5, 1.1, mirrored)
    angles = np.array([0.0, 1.0, 2.5, -2.0])
    arrows = np.stack([np.cos(angles), np.sin(angles)], axis=1)

    moved = apply(move, arrows) - apply(move, np.zeros((1, 2)))

    assert np.abs(angle_between(np.arctan2(moved[:, 1], moved[:, 0]), turn_directions(move, angles))).max() < 1e-12


def as_complex(points: np.ndarray) -> np.ndarray:
    return points @ [1, 1j]


def test_the_fit_finds_a_move_back() -> None:
    """Exact points give the exact turn and translation, at any weight."""
    move = Transform(2.1, -3, 8)
    weight = np.array([1.0, 5.0, 0.1])

    z, t = weighted_similarity(as_complex(POINTS), as_complex(apply(move, POINTS)), weight, (1.0, 1.0))

    assert z == pytest.approx(np.exp(2.1j))
    assert t == pytest.approx(-3 + 8j)


def test_the_fit_keeps_the_scale_in_its_range() -> None:
    """A map at 1.3 of its size: free up to 2, bounded by 1.1, rigid."""
    target = as_complex(apply(Transform(0.5, 1, 1, 1.3), POINTS))

    sizes = [abs(weighted_similarity(as_complex(POINTS), target, np.ones(3), r)[0]) for r in ((0.5, 2), (0.9, 1.1), (1, 1))]

    assert sizes == pytest.approx([1.3, 1.1, 1])


def test_the_fit_minimises_the_weighted_squares() -> None:
    """No small change of turn or translation makes the sum smaller."""
    random = np.random.default_rng(4)
    source, target = (as_complex(random.normal(size=(6, 2))) for _ in range(2))
    weight = random.uniform(0.1, 2, 6)
    z, t = weighted_similarity(source, target, weight, (1.0, 1.0))

    def cost(z: complex, t: complex) -> float:
        return float(weight @ np.abs(z * source + t - target) ** 2)

    for turn, shift in ((1e-3, 0), (-1e-3, 0), (0, 1e-3), (0, -1e-3), (0, 1e-3j), (0, -1e-3j)):
        assert cost(z * np.exp(1j * turn), t + shift) > cost(z, t)


def test_points_that_coincide_leave_the_turn_at_zero() -> None:
    """One point, or the same one twice: a shift is all there is to find."""
    for count in (1, 2):
        z, t = weighted_similarity(np.full(count, 1 + 1j), np.full(count, 4 + 0j), np.ones(count), (1.0, 1.0))
        assert (z, t) == (1, 3 - 1j)
