"""Degrees and radians without losing a bit."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fidmap.angles import degrees_of, degrees_text, radians_of_text


@settings(derandomize=True, deadline=None, max_examples=1000)
@given(st.floats(-2 * math.pi, 2 * math.pi, allow_subnormal=False))
def test_radians_survive_the_way_through_text(radians: float) -> None:
    """Every facing that can be computed has a text that brings it back; `math.radians` misses some."""
    assert radians_of_text(degrees_text(radians)) == radians


@settings(derandomize=True, deadline=None, max_examples=1000)
@given(st.floats(0.0, 360))
def test_degrees_of_settings_are_shown_as_written(degrees: float) -> None:
    """The degrees shown give the same radians back."""
    assert math.radians(degrees_of(math.radians(degrees))) == math.radians(degrees)


@pytest.mark.parametrize(
    ("radians", "text"), [(math.pi, "180"), (2 * math.pi, "360"), (-math.pi / 2, "-90"), (0.0, "0")]
)
def test_plain_angles_have_plain_texts(radians: float, text: str) -> None:
    """No 179.99999999999997 in a file for people."""
    assert degrees_text(radians) == text
    assert degrees_of(radians) == float(text)


def test_sixty_degrees_stay_sixty() -> None:
    """The default facing tolerance, pi / 3, is shown as 60."""
    assert degrees_of(math.pi / 3) == 60
