"""The floor of a point cloud and the direction that is up.

The floor is taken for the largest flat area that has (nearly) everything else on one side; the file's own +z is
preferred to other directions, and so are those across which the cloud is thin: maps are wider than high. Planes are
proposed from random triples (RANSAC, Fischler and Bolles 1981) and from the heights at which most points lie along
each axis; areas are compared by voxels, because points are dense near the sensor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.maps.overrides import AXES
from fidmap.model import FloatArray

VOXEL_M = 0.1
THICKNESS_M = 0.05
MAX_VOXELS = 20_000
TRIED_VOXELS = 6_000
TRIPLES = 600
LEAST_SHARE = 0.03
BESIDE_Z = 0.5


@dataclass(frozen=True, eq=False)
class Floor:
    """up (3,): unit vector. height_m: up . p of the points on the floor. found: whether there is a flat floor."""

    up: FloatArray
    height_m: float
    found: bool

    @property
    def tilt(self) -> float:
        """Angle between up and the file's z axis."""
        return math.acos(min(1.0, max(-1.0, float(self.up[2]))))


def find_floor(points: FloatArray, axis: str | None = None) -> Floor:
    """The floor beneath points (N, 3), N >= 1, in metres.

    Args:
        points: a sample of the cloud.
        axis: which axis is roughly up, where the user says so (a key of `AXES`).
    """
    wanted = np.array(AXES[axis or "z"], float)
    voxels = _thinned(points)
    middle = voxels.mean(axis=0)  # surveyed coordinates have too many digits for float32
    tried = (voxels[:TRIED_VOXELS] - middle).astype(np.float32)
    best, best_score = None, LEAST_SHARE * len(tried)
    spread = np.cov(tried.T.astype(float)) if len(tried) > 1 else np.eye(3)
    thinnest = math.sqrt(max(float(np.linalg.eigvalsh(spread)[0]), THICKNESS_M**2))
    normals, heights = _proposals(voxels)
    distances = normals.astype(np.float32) @ tried.T - (heights - normals @ middle).astype(np.float32)[:, None]
    flat = np.count_nonzero(np.abs(distances) < THICKNESS_M, axis=1)
    across = np.sqrt(np.einsum("ij,jk,ik->i", normals, spread, normals))
    fair = flat * thinnest / np.maximum(across, thinnest)
    for sign in (1.0, -1.0):
        beneath = np.count_nonzero(distances * np.float32(sign) < -3 * THICKNESS_M, axis=1) / len(tried)
        near = sign * normals @ wanted > math.cos(math.pi / 4)
        scores = fair * np.where(near, 1.0, 0.0 if axis else BESIDE_Z) * np.maximum(0, 1 - 10 * beneath)
        k = int(np.argmax(scores))
        if scores[k] > best_score:
            best, best_score = (sign * normals[k], sign * float(heights[k])), float(scores[k])
    if best is None:
        return Floor(wanted, float(np.percentile(points @ wanted, 1)), False)
    return _polished(voxels, *best)


def _thinned(points: FloatArray) -> FloatArray:
    """One point of each voxel (M, 3), in random order; voxels grow until they are few enough to try planes on."""
    order = np.random.default_rng(0).permutation(len(points))
    side = VOXEL_M
    while True:
        cells = np.floor((points - points.min(axis=0)) / side)
        shape = cells.max(axis=0) + 1
        keys = (cells[:, 0] * shape[1] + cells[:, 1]) * shape[2] + cells[:, 2]
        first = np.sort(np.unique(keys[order], return_index=True)[1])
        if len(first) <= 5 * MAX_VOXELS or side > 100:
            return points[order[first[:MAX_VOXELS]]]
        side *= 2


def _proposals(voxels: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Planes as normals (K, 3) with heights (K,); either side of one may be up."""
    rng = np.random.default_rng(1)
    a, b, c = (voxels[rng.integers(0, len(voxels), TRIPLES)] for _ in range(3))
    normals = np.cross(b - a, c - a)
    size = np.linalg.norm(normals, axis=1)
    real = size > 1e-9
    normals, start = normals[real] / size[real, None], a[real]
    aligned, levels = _layers(voxels)
    return np.vstack([normals, aligned]), np.concatenate([np.einsum("ij,ij->i", normals, start), levels])


def _layers(voxels: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Per axis the three levels where most voxels lie."""
    normals, heights = [], []
    for axis in range(3):
        levels = np.floor(voxels[:, axis] / THICKNESS_M)
        values, counts = np.unique(levels, return_counts=True)
        for k in np.argsort(counts)[-3:]:
            normals.append(np.eye(3)[axis])
            heights.append((values[k] + 0.5) * THICKNESS_M)
    return np.array(normals), np.array(heights)


def _polished(voxels: FloatArray, normal: FloatArray, height: float) -> Floor:
    """Least squares over the voxels near the plane, three times."""
    for _ in range(3):
        near: npt.NDArray[np.bool_] = np.abs(voxels @ normal - height) < THICKNESS_M
        if near.sum() < 3:
            break
        middle = voxels[near].mean(axis=0)
        fitted = np.linalg.svd(voxels[near] - middle, full_matrices=False)[2][2]
        fitted = fitted if fitted @ normal > 0 else -fitted
        if fitted @ normal < math.cos(math.radians(10)):
            break
        normal, height = fitted, float(fitted @ middle)
    return _straightened(voxels, normal, height)


def _straightened(voxels: FloatArray, normal: FloatArray, height: float) -> Floor:
    """The file's own axis where a plane across it holds nearly as much of the floor: maps are mostly upright."""
    k = int(np.argmax(np.abs(normal)))
    axis = np.eye(3)[k] * np.sign(normal[k])
    near = np.abs(voxels @ normal - height) < THICKNESS_M
    level = float(np.median((voxels @ axis)[near])) if near.any() else height
    straight = np.abs(voxels @ axis - level) < THICKNESS_M
    if straight.sum() >= 0.8 * near.sum():
        return Floor(axis, float((voxels @ axis)[straight].mean()), True)
    return Floor(normal, height, True)
