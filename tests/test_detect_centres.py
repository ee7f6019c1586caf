"""Strips along found arcs, what their directions vote for, and the centres that follow."""

from __future__ import annotations

import numpy as np
import pytest

from fidmap.detect.ballot import Votes, vote
from fidmap.detect.centres import centres
from fidmap.detect.strips import DIRECTIONS, FAR, NEAR, Strips, strips
from fidmap.model import FloatArray, Label

HALF = np.pi / 2


def looked(labels: np.ndarray, centre: tuple[float, float], facing: float, reach: float, radius: float) -> Strips:
    """The strip of one arc."""
    return strips(labels, np.array([centre]), np.array([facing]), np.array([reach]), radius)


def test_a_strip_shows_what_lies_that_far_from_the_circle() -> None:
    """A map whose labels depend on the distance from the centre alone: every direction sees the same."""
    rows, columns = np.mgrid[0:80, 0:80] + 0.5
    away = np.hypot(rows - 40.2, columns - 39.7)
    labels = np.where(away < 14, Label.UNKNOWN, np.where(away < 16, Label.OCCUPIED, Label.FREE)).astype(np.uint8)

    seen = looked(labels, (40.2, 39.7), 0.7, HALF, 15.0)

    assert seen.labels.shape == (1, DIRECTIONS, len(NEAR) + len(FAR))
    at = np.concatenate([NEAR, 15 * FAR])
    for label, low, high in ((Label.UNKNOWN, -99, -2), (Label.OCCUPIED, -0.25, 0.25), (Label.FREE, 2, 99)):
        assert (seen.labels[0][:, (at >= low) & (at <= high)] == label).all()


def test_directions_cover_a_half_and_a_little_more_or_all_around() -> None:
    """Evenly, the facing in the middle."""
    labels = np.full((50, 50), Label.FREE, np.uint8)

    half = looked(labels, (25, 25), 1.0, HALF, 6.0).relative[0]
    whole = looked(labels, (25, 25), 1.0, np.pi, 6.0).relative[0]

    assert half == pytest.approx(-half[::-1])
    assert 90 < np.degrees(half[-1]) < 96
    assert np.diff(np.append(whole, whole[0] + 2 * np.pi)) == pytest.approx(2 * np.pi / DIRECTIONS)


def test_beyond_the_map_nothing_is_known() -> None:
    """From its rim outwards; a centre that a fit has moved out of the map is looked around at the rim."""
    labels = np.full((40, 40), Label.OCCUPIED, np.uint8)

    at_rim = looked(labels, (0.0, 20.0), -HALF, HALF, 6.0)
    outside = looked(labels, (-500.0, 20.0), -HALF, HALF, 6.0)

    outwards = np.abs(at_rim.relative[0]) < np.radians(80)
    assert (at_rim.labels[0, outwards] == Label.UNKNOWN).all()
    assert (outside.labels == at_rim.labels).all()


def test_a_mirrored_strip_votes_the_same_mirrored() -> None:
    """To the last bit but rounding, whatever the strip shows."""
    random = np.random.default_rng(1)
    labels = random.integers(0, 3, (5, DIRECTIONS, len(NEAR) + len(FAR))).astype(np.uint8)
    relative = np.tile(np.linspace(-1.6, 1.6, DIRECTIONS), (5, 1))
    sizes, sure = random.normal(0, 1, (5, 4)), np.array([0.99, 0.9, 0.7, 0.4, 0.1])

    one = vote(Strips(labels, relative), sizes, sure)
    other = vote(Strips(np.ascontiguousarray(labels[:, ::-1]), relative), sizes, sure)

    assert other.outward[:, ::-1] == pytest.approx(one.outward, abs=1e-4)
    assert other.weight[:, ::-1] == pytest.approx(one.weight, rel=1e-3)
    assert other.widened == pytest.approx(one.widened, rel=1e-3)


def votes(shifts: FloatArray, offsets: FloatArray, weight: float = 1e4) -> Votes:
    """What half circles shifted (K, 2) and drawn larger (K,) show without any error."""
    relative = np.tile(np.linspace(-1.5, 1.5, DIRECTIONS), (len(shifts), 1))
    outward = shifts[:, :1] * np.cos(relative) + shifts[:, 1:] * np.sin(relative) + offsets[:, None]
    return Votes(outward, np.full(relative.shape, weight), relative, np.ones(len(shifts)))


def test_exact_votes_give_the_shifts_whatever_radius_is_drawn() -> None:
    """A radius that all arcs of the map share, or each its own, does not move the centres."""
    random = np.random.default_rng(2)
    shifts = random.normal(0, 0.5, (8, 2))

    for offsets in (np.full(8, 0.4), random.normal(0, 0.3, 8)):
        found = centres(votes(shifts, offsets), np.full(8, 0.95))
        assert found.shifts == pytest.approx(shifts, abs=0.01)


def test_arcs_share_a_radius_where_one_alone_cannot_tell_it() -> None:
    """A quarter circle does not fix its centre along the facing; with others of its map it is surer and nearer."""
    offsets = np.full(9, 0.6)
    all_of_them = votes(np.zeros((9, 2)), offsets, weight=2.0)
    quarter = np.abs(all_of_them.relative[0]) > np.radians(40)
    all_of_them.weight[0, quarter] = 1e-6
    alone = Votes(*(values[:1] for values in vars(all_of_them).values()))

    by_itself, together = centres(alone, np.array([0.95])), centres(all_of_them, np.full(9, 0.95))

    assert together.sigma[0] < 0.8 * by_itself.sigma[0]
    assert abs(together.shifts[0, 0]) < 0.7 * abs(by_itself.shifts[0, 0])


def test_doubtful_arcs_do_not_tell_how_a_map_is_drawn() -> None:
    """Whatever they show, the others' centres stay."""
    shifts, offsets = np.zeros((6, 2)), np.array([0.3, 0.3, 0.3, 5.0, 5.0, 5.0])
    sure = np.array([0.95, 0.95, 0.95, 0.4, 0.4, 0.4])

    found, without = centres(votes(shifts, offsets, 2.0), sure), centres(votes(shifts[:3], offsets[:3], 2.0), sure[:3])

    assert found.shifts[:3] == pytest.approx(without.shifts)


def test_weights_are_told_as_sigma() -> None:
    """Four times the weight is half the sigma; the shift's error is as large as it says (many draws)."""
    random = np.random.default_rng(3)
    plain = votes(np.zeros((2000, 2)), np.zeros(2000), weight=4.0)
    noisy = Votes(random.normal(0, 0.5, plain.outward.shape), plain.weight, plain.relative, plain.widened)

    found = centres(noisy, np.full(2000, 0.95))
    sharper = centres(Votes(noisy.outward, 4 * noisy.weight, noisy.relative, noisy.widened), np.full(2000, 0.95))

    assert np.mean(found.shifts**2) < 1.1 * np.mean(found.sigma**2)
    assert sharper.sigma == pytest.approx(found.sigma / 2, rel=0.25)
