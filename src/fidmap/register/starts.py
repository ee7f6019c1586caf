"""Where to climb from: the peaks of a coarse sweep, all of them drawn to their maxima at once."""

from __future__ import annotations

import numpy as np

from fidmap.model import FloatArray
from fidmap.register.ascent import ascend, attract
from fidmap.register.landscape import Landscape
from fidmap.register.near import Matcher
from fidmap.register.sweep import Sweep, raster

# cell of the coarse sweep as a share of D, and how far a half turn moves the parts in such cells
CELL_SHARE = 1 / 4
TURN_SHARE = 1.0
# peaks kept of every layer, of all layers, and drawn on to the end
PEAKS = 12
MOST = 400
DRAWN = 32
CLIMBED = 8
FINISHED = 3
# so few placements that lay one pair of parts on another are all looked at, and the best of them climbed from
LAID = 400
# peaks whose parts lie nearer than this share of D (rms) count as one
APART = 0.3


def starts(land: Landscape, matcher: Matcher) -> tuple[FloatArray, FloatArray]:
    """Local maxima of the continuous score: placements (K, 4), the best first, and their values (K,)."""
    found = peaks(land)
    near = APART * land.problem.d_max
    found = found[apart(land, found, near, DRAWN)]
    found, worth = attract(land, matcher, found, rounds=6)
    found = found[np.argsort(-worth, kind="stable")]
    found = found[apart(land, found, near / 4, CLIMBED)]
    found, worth = _climbed(land, matcher, np.concatenate([found[:CLIMBED], land.unmoved]), (3, 5, 0.7))
    begun = np.concatenate([found[:FINISHED], land.unmoved, _best_laid(land, matcher)])
    best, height = _climbed(land, matcher, begun, (4, 12, 0.75))
    return np.concatenate([best, found[FINISHED:]]), np.concatenate([height, worth[FINISHED:]])


def _best_laid(land: Landscape, matcher: Matcher) -> FloatArray:
    """The best placements (K, 4) of few parts that lay the middle and direction of two on those of two others.

    Maxima of few parts can lie nearer to each other than the sweep's cells.
    """
    rows, own = np.flatnonzero(land.possible.any(axis=1)), land.used
    if len(rows) * (len(rows) - 1) * len(own) * (len(own) - 1) > 2 * LAID:
        return np.empty((0, 4))
    i, j, a, b = (one.ravel() for one in np.meshgrid(rows, rows, own, own, indexing="ij"))
    two = (i != j) & (a < b)
    i, j, a, b = i[two], j[two], a[two], b[two]
    apart_m, wanted = land.barrels[b] - land.barrels[a], land.fiducials[j] - land.fiducials[i]
    turn = np.angle(wanted * apart_m.conj())
    scale = np.clip(np.abs(wanted) / np.maximum(np.abs(apart_m), 1e-9), *land.problem.scale_range)
    middle = (land.fiducials[i] + land.fiducials[j]) / 2
    shift = middle - scale * np.exp(1j * turn) * (land.barrels[a] + land.barrels[b]) / 2
    return _climbed(land, matcher, land.limited(np.stack([turn, shift.real, shift.imag, scale], axis=1)), (1, 1, 0.7))[
        0
    ][:FINISHED]


def _climbed(
    land: Landscape, matcher: Matcher, placements: FloatArray, effort: tuple[int, int, float]
) -> tuple[FloatArray, FloatArray]:
    """Placements (K, 4) climbed from with an effort of `ascend`, the best first, and their values (K,)."""
    top, worth = ascend(land, matcher, placements, *effort)
    order = np.argsort(-worth, kind="stable")
    return top[order], worth[order]


def peaks(land: Landscape) -> FloatArray:
    """The best cells (K, 4) of a sweep without inflation, the greatest sums first."""
    mesh = raster(land, CELL_SHARE * land.problem.d_max, TURN_SHARE)
    if mesh is None:
        return np.empty((0, 4))
    sweep = Sweep(land, mesh, inflated=False)
    kept, sums = [], []
    for layer in sweep.layers(land.most / 4):
        flat = layer.sums.ravel()
        if len(flat) == 0:
            continue
        best = np.argpartition(flat, -PEAKS)[-PEAKS:] if len(flat) > PEAKS else np.arange(len(flat))
        kept.append(layer.placements(*np.unravel_index(best, layer.sums.shape)))
        sums.append(flat[best])
    if not kept:
        return np.empty((0, 4))
    order = np.argsort(-np.concatenate(sums).astype(int), kind="stable")[:MOST]
    return np.concatenate(kept)[order]


def apart(land: Landscape, placements: FloatArray, least_m: float, most: int) -> list[int]:
    """Indices of the first `most` placements that put the parts at least `least_m` (rms) from one another."""
    middle = land.barrels[land.used].mean()
    moved = placements[:, 3] * np.exp(1j * placements[:, 0])
    at = placements[:, 1] + 1j * placements[:, 2] + moved * middle
    spread = float(np.mean(np.abs(land.barrels[land.used] - middle) ** 2))
    left = np.ones(len(placements), bool)
    kept: list[int] = []
    while left.any() and len(kept) < most:
        k = int(left.argmax())
        kept.append(k)
        left &= np.abs(at - at[k]) ** 2 + spread * np.abs(moved - moved[k]) ** 2 >= least_m**2
        left[k] = False
    return kept
