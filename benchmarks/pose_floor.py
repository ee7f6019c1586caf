"""What the poses' errors leave of a centre at best: circles of the known radius through the very points that beams hit.

No map is drawn: cells, and what a mapper makes of them, come on top.
"""

from __future__ import annotations

import numpy as np

from fidmap.model import FloatArray
from fidmap.synth.poses import Tier
from fidmap.synth.suite import Split, case_rng, random_spec, scans_of, with_radius
from fidmap.synth.truth import part_truths

ROUNDS = 10
WIDTH_M = 0.05  # points farther from the circle pull no harder than this
LEAST_SEEN = 2 / 3


def pose_floor(split: Split, seed: int, tier: Tier, index: int, radius_m: float) -> list[float]:
    """How far (metres) such circles lie from where the map would draw each part that two thirds of are seen."""
    rng = case_rng(split, seed, tier, index)
    spec = with_radius(random_spec(rng, tier), radius_m)
    arena, scans, poses = scans_of(rng, spec)
    errors = []
    for number, truth in enumerate(part_truths(arena, scans, poses)):
        if truth.drawn_x_m is None or truth.drawn_y_m is None or truth.seen < LEAST_SEEN * truth.opening:
            continue
        drawn = np.array([truth.drawn_x_m, truth.drawn_y_m])
        scan, beam = np.nonzero(scans.parts == number)
        angle, reach = poses[scan, 2] + scans.bearings[beam], scans.ranges[scan, beam]
        points = poses[scan, :2] + reach[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        near = np.hypot(*(points - drawn).T) < 1.5 * radius_m  # other copies lie farther
        errors.append(float(np.hypot(*(_centre(points[near], drawn, radius_m) - drawn))))
    return errors


def _centre(points: FloatArray, start: FloatArray, radius_m: float) -> FloatArray:
    """Least squares (Gauss-Newton) over the points' distances (N, 2) from the circle, cut off at `WIDTH_M`."""
    centre = start
    for _ in range(ROUNDS):
        away = points - centre
        distance = np.maximum(np.hypot(*away.T), 1e-9)
        outward = away / distance[:, None]
        left = np.clip(distance - radius_m, -WIDTH_M, WIDTH_M)
        centre = centre + np.linalg.lstsq(outward, left, rcond=None)[0]
    return centre
