"""Plain geometry on arrays (N, 2) of metres: transforms of the plane and angles."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from fidmap.model import FloatArray, Transform

ComplexArray = npt.NDArray[np.complex128]


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


def as_complex(points_xy: FloatArray, mirrored: bool = False) -> ComplexArray:
    """Points (N, 2) as x + iy (N,), or x - iy."""
    return np.asarray(points_xy[:, 0] + (-1j if mirrored else 1j) * points_xy[:, 1], np.complex128)


def weighted_similarity(
    source: ComplexArray, target: ComplexArray, weight: FloatArray, scale_range: tuple[float, float]
) -> tuple[complex, complex]:
    """Turn and scale z, translation t (both complex) that minimise sum w |z source + t - target|^2.

    source, target: (K,) points x + iy in metres; weight: (K,), at least one positive; |z| stays in the range, and
    (1, 1) makes it rigid. Closed form in the plane (Umeyama 1991); points that coincide leave the turn at 0.
    """
    w = weight / weight.sum()
    source_mean, target_mean = w @ source, w @ target
    centred = source - source_mean
    moment = complex((w * centred.conj()) @ (target - target_mean))
    size = abs(moment)
    scale = scale_range[0]
    if scale_range[0] < scale_range[1]:
        variance = float(w @ (centred.real**2 + centred.imag**2))
        scale = min(max(size / variance if variance > 0 else 1.0, scale_range[0]), scale_range[1])
    z = scale * (moment / size if size > 0 else 1.0)
    return z, complex(target_mean - z * source_mean)


def circle_through(points: FloatArray) -> tuple[FloatArray, float]:
    """Centre (2,) and radius of the circle nearest to points (N, 2), at least three that lie on no line.

    Algebraic start (Kasa 1976), then Gauss-Newton on the distances, since the start is too small for short arcs.
    """
    middle = points.mean(axis=0)
    p = points - middle
    solution = np.linalg.lstsq(np.column_stack([2 * p, np.ones(len(p))]), (p**2).sum(axis=1), rcond=None)[0]
    centre, radius = solution[:2], math.sqrt(max(1e-12, float(solution[2] + solution[:2] @ solution[:2])))
    for _ in range(5):
        away = p - centre
        distance = np.maximum(np.hypot(away[:, 0], away[:, 1]), 1e-9)
        design = np.column_stack([away / distance[:, None], np.ones(len(p))])
        step = np.linalg.lstsq(design, distance - radius, rcond=None)[0]
        centre, radius = centre + step[:2], radius + float(step[2])
    return centre + middle, radius
