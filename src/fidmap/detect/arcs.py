"""Half circles around candidate centres: centre, facing, how sure, half or whole; and which of them are the same."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fidmap.detect.network import (
    JUDGE_ANGLES,
    JUDGE_STEPS,
    SPOT_ANGLES,
    SPOT_STEPS,
    judge,
    probability,
    spot,
)
from fidmap.detect.polar import Windower
from fidmap.model import FloatArray

HALF = np.pi / 2
LEAST_SPOTTED = 0.02
LEAST_JUDGED = 0.01
ROUNDS = 2


@dataclass(frozen=True)
class Arcs:
    """H arcs: centres (H, 2) in cells, facings (H,), and the probability (H,) that each is a part.

    reach: (H,) how far each goes to both sides of its facing: 90 degrees for half barrels, 180 for whole ones.
    """

    centres: FloatArray
    facings: FloatArray
    sure: FloatArray
    reach: FloatArray

    def take(self, index: npt.NDArray[np.intp] | npt.NDArray[np.bool_]) -> Arcs:
        """The hypotheses of these indices."""
        return Arcs(self.centres[index], self.facings[index], self.sure[index], self.reach[index])

    def moved(self, radius: float, along: FloatArray, across: FloatArray, turn: FloatArray, sure: FloatArray) -> Arcs:
        """Moved by so many radii along the facing and across it (counter-clockwise), and turned."""
        s, c = np.sin(self.facings), np.cos(self.facings)
        shift = radius * np.stack([along * s + across * c, along * c - across * s], axis=1)
        return Arcs(self.centres + shift, self.facings + turn, sure, self.reach)


def difference(a: FloatArray, b: FloatArray) -> FloatArray:
    """Signed angle a - b in [-pi, pi); broadcasts."""
    return (a - b + np.pi) % (2 * np.pi) - np.pi


def hypotheses(windower: Windower, candidates: FloatArray) -> Arcs:
    """Half circles around candidate centres (N, 2), moved and turned to where they fit, most probable first."""
    arcs = spotted(windower, candidates)
    for _ in range(ROUNDS):
        seen = judge(windower.cut(arcs.centres, arcs.facings, JUDGE_ANGLES, JUDGE_STEPS), windower.radius)
        sure = probability(seen[:, 0])
        arcs = arcs.moved(windower.radius, seen[:, 1], seen[:, 2], seen[:, 3], sure)
        arcs = replace(arcs, reach=np.where(seen[:, 4] > 0, np.pi, HALF)).take(sure > LEAST_JUDGED)
    return arcs.take(np.argsort(-arcs.sure, kind="stable"))


def spotted(windower: Windower, candidates: FloatArray, least: float = LEAST_SPOTTED) -> Arcs:
    """One look at each candidate: every direction that a half circle may face, where its centre is."""
    windows = windower.cut(candidates, np.zeros(len(candidates)), SPOT_ANGLES, SPOT_STEPS)
    seen = spot(windows, windower.radius)
    sure = probability(seen[..., 0])
    highest = np.max([np.roll(sure, k, axis=1) for k in range(-3, 4)], axis=0)
    which, angle = np.nonzero((sure >= highest) & (sure > least))
    facings = np.asarray(angle * (2 * np.pi / SPOT_ANGLES), np.float64)
    arcs = Arcs(candidates[which], facings, sure[which, angle], np.full(len(which), HALF))
    _, along, across, turn = seen[which, angle].T
    return _distinct(arcs.moved(windower.radius, along, across, turn, arcs.sure), windower.radius)


def _distinct(arcs: Arcs, radius: float) -> Arcs:
    """Of hypotheses at the same place (about R/7 and 15 degrees) the surest."""
    centres, facings = np.rint(arcs.centres / (0.15 * radius)), np.rint(arcs.facings / np.radians(15)) % 24
    keys = np.column_stack([centres, facings]).astype(np.int64)
    order = np.lexsort((-arcs.sure, keys[:, 2], keys[:, 1], keys[:, 0]))
    fresh = np.ones(len(order), bool)
    fresh[1:] = (np.diff(keys[order], axis=0) != 0).any(axis=1)
    return arcs.take(np.sort(order[fresh]))


def suppress(arcs: Arcs, radius: float) -> npt.NDArray[np.intp]:
    """Indices of arcs that are not the same as an earlier one (they come most confident first).

    Two barrels cannot stand closer than a radius with like facings; around one centre only opposite halves fit, and
    nothing fits beside a whole barrel.
    """
    centres, facings, reach = arcs.centres, arcs.facings, arcs.reach
    kept: list[int] = []
    for k in range(len(facings)):
        away = np.hypot(*(centres[kept] - centres[k]).T)
        turned = np.abs(difference(facings[kept], facings[k]))
        whole = np.maximum(reach[kept], reach[k]) > HALF
        same = ((away < radius) & (turned < np.radians(75))) | (
            (away < 0.5 * radius) & ((turned < np.radians(130)) | whole)
        )
        if not same.any():
            kept.append(k)
    return np.array(kept, np.intp)
