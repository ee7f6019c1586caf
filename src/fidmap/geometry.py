"""Plain geometry on arrays (N, 2) of metres: transforms of the plane and angles."""

from __future__ import annotations

import math

import numpy as np

from fidmap.model import FloatArray, Transform


def angle_between(a: FloatArray | float, b: FloatArray | float) -> FloatArray:
    """Absolute angle between directions a and b, in [0, pi]; broadcasts."""
    return np.asarray(np.abs((np.asarray(a) - np.asarray(b) + math.pi) % (2 * math.pi) - math.pi))


def linear_part(transform: Transform) -> FloatArray:
    """The (2, 2) matrix scale * R(rotation) * diag(1, -1 if mirrored else 1)."""
    c, s = transform.scale * math.cos(transform.rotation), transform.scale * math.sin(transform.rotation)
    flip = -1.0 if transform.mirrored else 1.0
    return np.array([[c, -s * flip], [s, c * flip]])


def apply(transform: Transform, points_xy: FloatArray) -> FloatArray:
    """Map points (N, 2) to truth points (N, 2)."""
    return np.asarray(points_xy, float) @ linear_part(transform).T + [transform.tx_m, transform.ty_m]


def apply_inverse(transform: Transform, points_xy: FloatArray) -> FloatArray:
    """Truth points (N, 2) back to map points (N, 2)."""
    shifted = np.asarray(points_xy, float) - [transform.tx_m, transform.ty_m]
    return np.asarray(np.linalg.solve(linear_part(transform), shifted.T).T)


def turn_directions(transform: Transform, angles: FloatArray) -> FloatArray:
    """Directions in the map, as angles (N,), seen in the truth frame."""
    flip = -1.0 if transform.mirrored else 1.0
    return transform.rotation + flip * np.asarray(angles, float)


def weighted_similarity(
    source_xy: FloatArray, target_xy: FloatArray, weight: FloatArray, scale_range: tuple[float, float]
) -> Transform:
    """The rotation, translation and bounded scale that minimise sum w |s R source + t - target|^2.

    source_xy, target_xy: (K, 2) metres; weight: (K,), at least one positive. A range (1, 1) makes it rigid.
    Closed form in the plane (Umeyama 1991, written with complex numbers); points that coincide leave the
    rotation at 0.
    """
    w = weight / weight.sum()
    source, target = source_xy @ [1, 1j], target_xy @ [1, 1j]
    source_mean, target_mean = w @ source, w @ target
    moment = w @ (np.conj(source - source_mean) * (target - target_mean))
    rotation = float(np.angle(moment)) if abs(moment) > 0 else 0.0
    variance = float(w @ np.abs(source - source_mean) ** 2)
    scale = float(np.clip(abs(moment) / variance, *scale_range)) if variance > 0 else float(np.clip(1, *scale_range))
    shift = target_mean - scale * np.exp(1j * rotation) * source_mean
    return Transform(rotation, float(shift.real), float(shift.imag), scale)
