"""How far an arc reaches to both sides, and which hypotheses are the same arc."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.detect.arcs import Arcs, close_tolerance, difference, fit_all_around, support
from fidmap.detect.ring import RingSampler
from fidmap.model import FloatArray

HALF = np.pi / 2
GAP = np.radians(24)
# a half barrel that reaches this far beyond its half is no half but a piece of a whole barrel
BEYOND = np.radians(20)


@dataclass(frozen=True)
class Extents:
    """Centres (K, 2), facings (K,) and reach to each side (K,): 90 degrees for half barrels, up to 180 for whole."""

    centres: FloatArray
    facings: FloatArray
    reach: FloatArray


def extents(sampler: RingSampler, arcs: Arcs) -> Extents:
    """How far each arc reaches.

    An arc is more than a half when no wall leaves the ring at either end of the half and, seen from the centre that
    fits the whole ring, its support goes on beyond both ends together by more than 20 degrees.
    """
    away = np.abs(difference(sampler.theta[None, :], arcs.facings[:, None]))
    on_wall = ((arcs.ring.wall >= 0.5) & (np.abs(away - HALF) < np.radians(25))).any(axis=1)
    centres, ring = fit_all_around(sampler, arcs.centres, arcs.ring)
    stands = support(ring, close_tolerance(sampler.radius)) > 0.3
    away = difference(sampler.theta[None, :], arcs.facings[:, None])
    left, right = (_run(stands, ring.wall >= 0.5, turned, sampler.angles) for turned in (away, -away))
    longer = ~on_wall & (left + right > 2 * HALF + BEYOND)
    whole = longer & (left + right > 2 * np.pi - GAP)
    facings = np.where(longer & ~whole, arcs.facings + (left - right) / 2, arcs.facings)
    reach = np.where(whole, np.pi, np.where(longer, (left + right) / 2, HALF))
    return Extents(np.where(longer[:, None], centres, arcs.centres), facings, reach)


def _run(stands: npt.NDArray[np.bool_], walls: npt.NDArray[np.bool_], away: FloatArray, count: int) -> FloatArray:
    """How far (K,) the support goes on from the facing in the direction of growing `away`, up to pi."""
    order = np.argsort(np.where(away >= 0, away, np.inf), axis=1, kind="stable")[:, : count // 2]
    rows = np.arange(len(away))[:, None]
    angle, ahead = away[rows, order], stands[rows, order] & ~walls[rows, order]
    last = np.zeros(len(away))
    going = np.ones(len(away), bool)
    for k in range(angle.shape[1]):  # over angles, not cells
        going &= angle[:, k] - last <= GAP
        last = np.where(going & ahead[:, k], np.maximum(last, angle[:, k]), last)
    return last


def suppress(seen: Extents, radius: float) -> npt.NDArray[np.intp]:
    """Indices of arcs that are not the same as an earlier one (they come most confident first).

    Two barrels cannot stand closer than a radius with like facings; around one centre only opposite halves fit, and
    nothing fits beside a whole barrel.
    """
    centres, facings, reach = seen.centres, seen.facings, seen.reach
    kept: list[int] = []
    for k in range(len(facings)):
        away = np.hypot(*(centres[kept] - centres[k]).T)
        turned = np.abs(difference(facings[kept], facings[k]))
        more = np.maximum(reach[kept], reach[k]) > HALF
        same = ((away < radius) & (turned < np.radians(75))) | (
            (away < 0.5 * radius) & ((turned < np.radians(130)) | more)
        )
        if not same.any():
            kept.append(k)
    return np.array(kept, np.intp)
