"""The capped loss that every distance attribute is a mean of."""

from __future__ import annotations

import numpy as np

from fidmap.model import FloatArray, Rounding


def discretise(distance: FloatArray, rounding: Rounding, radius_m: float) -> FloatArray:
    """q(d): distances (any shape, metres) to multiples of the radius (SSRR 2011, II-A and III).

    'nearest' takes an exact half down, as the paper's tables do.
    """
    if rounding == "none":
        return distance
    ratio = distance / radius_m
    steps = {
        "nearest": np.floor(ratio + 0.5 - 1e-9),
        "down": np.floor(ratio + 1e-9),
        "up": np.ceil(ratio - 1e-9),
    }
    return np.asarray(steps[rounding] * radius_m)


def clipped_loss(distance: FloatArray, rounding: Rounding, radius_m: float, d_max: float) -> FloatArray:
    """min(q(d), D)/D in [0, 1], any shape (SSRR 2011, II-B-1)."""
    return np.asarray(np.minimum(discretise(distance, rounding, radius_m), d_max) / d_max)
