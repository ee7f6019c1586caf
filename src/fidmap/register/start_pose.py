"""Placements and the three sigma of a start pose."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from fidmap.geometry import angle_between
from fidmap.model import FloatArray, StartPose, Transform


def within(placements: FloatArray, start: StartPose | None) -> npt.NDArray[np.bool_]:
    """(H,) whether a placement puts the map's origin within three sigma of the start pose."""
    if start is None:
        return np.ones(len(placements), bool)
    away = np.hypot(placements[:, 1] - start.pose.x_m, placements[:, 2] - start.pose.y_m)
    turned = angle_between(placements[:, 0], start.pose.yaw)
    return np.asarray((away <= 3 * start.sigma_m) & (turned <= 3 * start.sigma_yaw))


def nearest_within(transform: Transform, start: StartPose) -> Transform:
    """The transform, moved into three sigma of the start pose where it lies outside."""
    turn = math.remainder(transform.rotation - start.pose.yaw, 2 * math.pi)
    dx, dy = transform.tx_m - start.pose.x_m, transform.ty_m - start.pose.y_m
    turn_by = _share(3 * start.sigma_yaw, abs(turn))
    go = _share(3 * start.sigma_m, math.hypot(dx, dy))
    return replace(
        transform,
        rotation=start.pose.yaw + turn_by * turn,
        tx_m=start.pose.x_m + go * dx,
        ty_m=start.pose.y_m + go * dy,
    )


def _share(most: float, wanted: float) -> float:
    """What share of `wanted` stays within `most`, a hair inside."""
    return 1.0 if wanted <= most else most / wanted * (1 - 1e-12)
