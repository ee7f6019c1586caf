"""The rule by which detections are counted, against cases counted by hand."""

from __future__ import annotations

import math

import pytest
from benchmarks.counting import Count, DrawnPart, average_precision, best_confidence, count, rates
from benchmarks.detect_tables import calibration_error, unit_variances

from fidmap.model import BarrelPart


def part(x: float, drawn: str = "yes", facing: float | None = 0.0, copies: tuple[tuple[float, float], ...] = ()):
    """A part on the x axis."""
    return DrawnPart(f"at {x}", x, 0.0, facing, drawn, copies)


def find(x: float, confidence: float, facing: float | None = 0.0, y: float = 0.0):
    """A detection, by default on the x axis."""
    return BarrelPart(1, x, y, facing, math.pi, 0.05, confidence)


def states(counted: Count) -> list[str]:
    """Verdicts in the order of confidence."""
    return [verdict.state for verdict in counted.verdicts]


def test_true_false_true_of_three_parts():
    """AP = (1/1 + 2/3) / 3 = 5/9; F1 = 2 * 2 / (3 detections + 3 parts) = 2/3; one part is missed."""
    counted = count([find(0, 0.9), find(9, 0.8), find(2, 0.7)], [part(0), part(2), part(4)])

    assert states(counted) == ["true", "false", "true"]
    assert [missed.x_m for missed in counted.missed] == [4]
    assert average_precision([counted]) == pytest.approx(5 / 9)
    assert rates([counted]).f1 == pytest.approx(2 / 3)
    assert (rates([counted]).precision, rates([counted]).recall) == pytest.approx((2 / 3, 2 / 3))


def test_average_precision_pools_the_maps_of_a_tier():
    """The false one of the second map ranks between: precisions 1 and 2/3 at the two parts, AP = 5/6."""
    first = count([find(0, 0.9), find(2, 0.5)], [part(0), part(2)])
    second = count([find(5, 0.7)], [])

    assert average_precision([first, second]) == pytest.approx((1 + 2 / 3) / 2)


def test_equal_confidence_gives_nothing_away():
    """A true and a false one of the same confidence: the false one is taken to come first, AP = 1/2."""
    assert average_precision([count([find(0, 0.9), find(9, 0.9)], [part(0)])]) == pytest.approx(1 / 2)


@pytest.mark.parametrize("drawn", ["partly", "no"])
def test_parts_that_are_hardly_drawn_count_neither_way(drawn):
    """Neither found nor missed nor false."""
    counted = count([find(0, 0.9)], [part(0, drawn)])

    assert states(counted) == ["ignored"]
    assert counted.drawn == 0
    assert math.isnan(rates([counted]).f1)


def test_other_copies_of_a_part_count_neither_way():
    """A part that the map draws twice."""
    counted = count([find(0, 0.9), find(3, 0.8)], [part(0, copies=((3.0, 0.0),))])

    assert states(counted) == ["true", "ignored"]


def test_a_part_found_twice_is_one_true_and_one_false():
    """Within R/3 and 60 degrees, even where a copy would excuse the second; beyond R/3 the copy does."""
    parts = [part(0, copies=((0.12, 0.0),))]

    assert states(count([find(0, 0.9), find(0.09, 0.8, math.radians(59))], parts)) == ["true", "false"]
    assert states(count([find(0, 0.9), find(0.11, 0.8)], parts)) == ["true", "ignored"]


def test_the_two_halves_on_a_wall_are_two_parts():
    """Centres 2 cm apart, facings opposite."""
    counted = count([find(0.01, 0.9, math.pi), find(0, 0.8, 0.0)], [part(0), part(0.02, facing=-math.pi)])

    assert states(counted) == ["true", "true"]
    assert counted.errors_m == pytest.approx([0.01, 0.0])


@pytest.mark.parametrize(
    ("x", "facing", "state"),
    [
        (0.149, 0.0, "true"),
        (0.151, 0.0, "false"),
        (0.0, 1.04, "true"),
        (0.0, 1.06, "false"),
        (0.0, None, "true"),
    ],
)
def test_within_15_cm_and_60_degrees(x, facing, state):
    """A tool that gives no facing is judged by the place alone."""
    assert states(count([find(x, 0.9, facing)], [part(0)])) == [state]


def test_the_nearest_free_part_is_taken():
    """Without facings two circles at a pair find both halves."""
    counted = count([find(0.04, 0.9, None), find(0.0, 0.8, None)], [part(0), part(0.05, facing=math.pi)])

    assert counted.errors_m == pytest.approx([0.01, 0.0])


def test_what_is_left_above_a_confidence():
    """The part of a detection that falls away is missed."""
    counted = count([find(0, 0.9), find(9, 0.6), find(2, 0.4)], [part(0), part(2)]).above(0.5)

    assert states(counted) == ["true", "false"]
    assert [missed.x_m for missed in counted.missed] == [2]


def test_best_confidence_in_hindsight():
    """F1 is 2/3 at 0.9, 1/2 at 0.8 and 4/5 at 0.7."""
    counted = count([find(0, 0.9), find(9, 0.8), find(2, 0.7), find(8, 0.1)], [part(0), part(2)])

    assert best_confidence([counted]) == 0.7
    assert best_confidence([count([], [part(0)])]) == 0.0


def test_honest_sigma_has_unit_variance():
    """Errors (0.05, 0.05) and sigma 0.05: (ex^2 + ey^2) / (2 sigma^2) = 1."""
    true = count([find(0.05, 0.9, y=0.05)], [part(0)]).of("true")

    assert unit_variances(true) == pytest.approx((1.0, 1 / math.log(2)))


def test_calibration_error_weighs_by_detections():
    """30 detections at 0.9 of which 0.8 are true, 10 right ones: 0.75 * 0.1."""
    assert calibration_error([(30, 0.9, 0.8), (10, 0.5, 0.5), (0, math.nan, math.nan)]) == pytest.approx(0.075)
