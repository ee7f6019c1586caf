"""Affine functions of the distance that are never below the score of a pair."""

from __future__ import annotations

import math

import numpy as np

from fidmap.model import FloatArray
from fidmap.register.landscape import ROUNDING_SLACK, Landscape


def affine_majorant(land: Landscape, distance: FloatArray, reach: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Height and slope (E,), (E,) with height - slope * d >= the score for all d within `reach` of `distance`.

    Without steps the score is such a function up to D. With steps it is the concave hull at `distance`: level where
    no step is near or the first one is not yet passed, else a line through the end of the first step.
    """
    d_max = land.problem.d_max
    if land.problem.settings.rounding == "none":
        return np.ones_like(distance), np.full_like(distance, 1 / d_max)
    low = np.maximum(distance - reach, 0.0)
    high = distance + reach
    top = land.worth(low)
    edges = steps(land)
    after = np.searchsorted(edges, low)
    first = np.append(edges, math.inf)[np.minimum(after, len(edges))]
    slope = np.full_like(distance, math.inf)
    for k, edge in enumerate(edges):
        beyond = (k > after) & (edge < high)
        fall = np.divide(top - land.worth(edges[k : k + 1])[0], edge - first, where=beyond, out=slope.copy())
        slope = np.where(beyond, np.minimum(slope, fall), slope)
    end = first < high
    last = np.divide(top - land.worth(high), high - first, where=end, out=slope.copy())
    slope = np.where(end, np.minimum(slope, last), slope)
    level = ~end | (distance <= first)
    slope = np.where(level, 0.0, slope)
    return top + slope * np.where(level, 0.0, first), slope


def steps(land: Landscape) -> FloatArray:
    """(S,) distances in metres at which the score falls, ascending, each the last one of its level; D is the last."""
    radius, d_max = land.problem.radius_m, land.problem.d_max
    first = {"nearest": 0.5, "down": 1.0, "up": 0.0}[land.problem.settings.rounding]
    edges = (np.arange(math.ceil(d_max / radius) + 2) + first) * radius
    # between the last distance of a level and where `worth` falls, which is the slack further on
    return np.append(edges[edges < d_max - 1e-6], d_max) + ROUNDING_SLACK / 2


def quantum(land: Landscape) -> float | None:
    """What scores with steps are multiples of; None where they are not multiples of anything."""
    if land.problem.settings.rounding == "none":
        return None
    count = land.problem.d_max / land.problem.radius_m
    return 1 / count if abs(count - round(count)) < 1e-9 else None
