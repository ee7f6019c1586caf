"""q(d) and the capped loss, computed by hand."""

from __future__ import annotations

import numpy as np
import pytest

from fidmap.model import Rounding
from fidmap.scoring import clipped_loss, discretise

R = 0.3


@pytest.mark.parametrize(
    ("rounding", "distance", "steps"),
    [
        ("nearest", 0.0, 0),
        ("nearest", 0.14, 0),
        ("nearest", 0.15, 0),  # an exact half goes down, as in the paper's tables
        ("nearest", 0.16, 1),
        ("nearest", 0.45, 1),
        ("nearest", 0.75, 2),
        ("nearest", 1.05, 3),
        ("nearest", 1.06, 4),
        ("down", 0.0, 0),
        ("down", 0.299, 0),
        ("down", 0.3, 1),
        ("down", 0.9, 3),
        ("down", 1.19, 3),
        ("up", 0.0, 0),
        ("up", 0.01, 1),
        ("up", 0.3, 1),
        ("up", 0.9, 3),
        ("up", 0.91, 4),
        ("up", 2.1, 7),  # 2.1 / 0.3 is 7.000000000000001 in doubles
    ],
)
def test_multiples_of_the_radius(rounding: Rounding, distance: float, steps: int) -> None:
    """Nearest with halves down, down, up; a multiple itself stays what it is."""
    assert discretise(np.array(distance), rounding, R) == pytest.approx(steps * R)


def test_without_rounding_a_distance_stays_as_it_is() -> None:
    """The profile 'continuous'."""
    distance = np.array([0.0, 0.123, 7.0])

    assert np.array_equal(discretise(distance, "none", R), distance)


def test_loss_is_capped_at_d_max() -> None:
    """min(q(d), D) / D with D = 1.2 m."""
    loss = clipped_loss(np.array([0.0, 0.3, 0.6, 1.2, 5.0]), "none", R, 1.2)

    assert loss == pytest.approx([0, 0.25, 0.5, 1, 1])


def test_loss_of_stepped_distances() -> None:
    """0.44 m is nearest to one radius, a quarter of D; 1.1 m to four radii, all of it."""
    assert clipped_loss(np.array([0.44, 1.1]), "nearest", R, 1.2) == pytest.approx([0.25, 1])


def test_d_max_need_not_be_a_multiple_of_the_radius() -> None:
    """q(d) is two radii, 0.6 m, over a D of half a metre: the loss is 1, not 1.2."""
    assert clipped_loss(np.array(0.5), "nearest", R, 0.5) == pytest.approx(1)


@pytest.mark.parametrize("rounding", ["none", "nearest", "down", "up"])
def test_a_greater_distance_never_scores_better(rounding: Rounding) -> None:
    """The loss is monotonic and stays in [0, 1]."""
    loss = clipped_loss(np.linspace(0, 2, 4001), rounding, R, 1.2)

    assert (np.diff(loss) >= 0).all()
    assert loss.min() == 0
    assert loss.max() == 1


@pytest.mark.parametrize("rounding", ["none", "nearest", "down", "up"])
def test_only_the_ratio_of_lengths_counts(rounding: Rounding) -> None:
    """An arena in other units (all lengths times 1000) has the same losses."""
    distance = np.array([0.1, 0.4, 0.8, 1.0])

    assert clipped_loss(distance * 1000, rounding, R * 1000, 1200) == pytest.approx(
        clipped_loss(distance, rounding, R, 1.2)
    )
