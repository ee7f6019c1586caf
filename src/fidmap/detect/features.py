"""What the confidence of a half circle is computed from: its ring in sectors, relative to its facing."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fidmap.detect.arcs import Arcs, difference, support
from fidmap.detect.ring import RingSampler
from fidmap.model import FloatArray

SECTORS = 12
COUNT = 7 * SECTORS + 14


def features(sampler: RingSampler, arcs: Arcs) -> FloatArray:
    """(H, COUNT) numbers per hypothesis, the same for mirrored maps.

    Per sector of 15 degrees away from the facing (left and right averaged): close and loose support, wall, occupied
    inside, free inside, free outside, thickness; over the half the mean place of the edge. Then the evenness of the
    support, harmonics of the edge (a box has corners where an arc has shoulders) and the radius in cells.
    """
    ring = arcs.ring
    away = difference(sampler.theta[None, :], arcs.facings[:, None])
    sector = np.minimum((np.abs(away) / np.pi * SECTORS).astype(int), SECTORS - 1)
    tight, loose = (
        support(ring, max(1.2, 0.1 * sampler.radius)),
        support(ring, max(2.0, 0.25 * sampler.radius)),
    )
    channels = np.stack([tight, loose, ring.wall, ring.inner, ring.hollow, ring.outer, ring.thick])
    onehot = sector[..., None] == np.arange(SECTORS)
    means = np.einsum("chn,hns->hcs", channels, onehot) / np.maximum(onehot.sum(axis=1), 1)[:, None]
    half = np.abs(away) <= np.pi / 2
    known = np.isfinite(ring.edge)[..., None] & onehot[..., : SECTORS // 2]
    places = np.einsum("hn,hns->hs", np.nan_to_num(ring.edge), known) / np.maximum(known.sum(axis=1), 1)
    shape = _shape(sampler, ring.edge, tight, half, away)
    return np.concatenate([means.reshape(len(arcs.facings), -1), places, shape], axis=1)


def _shape(
    sampler: RingSampler, edge: FloatArray, tight: FloatArray, half: npt.NDArray[np.bool_], away: FloatArray
) -> FloatArray:
    """(H, 8): unevenness left to right, weakest sixths, harmonics and spread of the edge, size."""
    left = (tight * half * (away > 0)).sum(axis=1) / np.maximum((half & (away > 0)).sum(axis=1), 1)
    right = (tight * half * (away <= 0)).sum(axis=1) / np.maximum((half & (away <= 0)).sum(axis=1), 1)
    sixth = np.clip(((away + np.pi / 2) / np.pi * 6).astype(int), 0, 5)
    parts = np.stack(
        [(tight * half * (sixth == k)).sum(axis=1) / np.maximum((half & (sixth == k)).sum(axis=1), 1) for k in range(6)]
    )
    parts.sort(axis=0)
    known = half & np.isfinite(edge)
    residual = np.where(known, np.nan_to_num(edge), 0.0)
    count = np.maximum(known.sum(axis=1), 1)
    harmonics = [np.abs((residual * np.cos(k * away)).sum(axis=1)) / count for k in (2, 4)]
    spread = np.sqrt((residual**2).sum(axis=1) / count)
    size = np.full(len(edge), np.log(sampler.radius / 6))
    return np.stack([np.abs(left - right), parts[0], parts[1], parts[2], *harmonics, spread, size], axis=1)
