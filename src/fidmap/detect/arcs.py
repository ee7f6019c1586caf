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
LEAST_SPOTTED = 0.01
LEAST_JUDGED = 0.01
PLAIN = 0.9  # who is as sure as this needs no second look


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

    def beside(self, other: Arcs) -> Arcs:
        """These and the others."""
        both = (self.centres, other.centres), (self.facings, other.facings), (self.sure, other.sure)
        return Arcs(*map(np.concatenate, (*both, (self.reach, other.reach))))

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
    arcs = judged(windower, spotted(windower, candidates))
    arcs = arcs.take(arcs.sure > LEAST_JUDGED)
    again = (arcs.sure < PLAIN).nonzero()[0]
    arcs = arcs.take((arcs.sure >= PLAIN).nonzero()[0]).beside(judged(windower, arcs.take(again)))
    return arcs.take(np.argsort(-arcs.sure, kind="stable"))


def judged(windower: Windower, arcs: Arcs) -> Arcs:
    """One look at each half circle: how sure it is, where it fits, and whether it is a piece of a whole one."""
    seen = judge(windower.cut(arcs.centres, arcs.facings, JUDGE_ANGLES, JUDGE_STEPS), windower.radius)
    arcs = arcs.moved(windower.radius, seen[:, 1], seen[:, 2], seen[:, 3], probability(seen[:, 0]))
    return replace(arcs, reach=np.where(seen[:, 4] > 0, np.pi, HALF))


def spotted(windower: Windower, candidates: FloatArray, least: float = LEAST_SPOTTED) -> Arcs:
    """One look at each candidate: every direction that a half circle may face, where its centre is."""
    windows = windower.cut(candidates, np.zeros(len(candidates)), SPOT_ANGLES, SPOT_STEPS)
    seen = spot(windows, windower.radius)
    sure = probability(seen[..., 0])
    highest = np.concatenate([sure[:, -3:], sure, sure[:, :3]], axis=1)
    for step in (1, 2, 3):  # of three directions to both sides
        highest = np.maximum(highest[:, :-step], highest[:, step:])
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
    first, second = _close(arcs.centres, radius)
    away = np.hypot(*(arcs.centres[first] - arcs.centres[second]).T)
    turned = np.abs(difference(arcs.facings[first], arcs.facings[second]))
    whole = np.maximum(arcs.reach[first], arcs.reach[second]) > HALF
    same = (away < radius) & (turned < np.radians(75))
    same |= (away < 0.5 * radius) & ((turned < np.radians(130)) | whole)
    kept = np.ones(len(arcs.sure), bool)
    for earlier, later in sorted(zip(first[same].tolist(), second[same].tolist(), strict=True)):
        kept[later] &= not kept[earlier]
    return np.flatnonzero(kept)


def _close(centres: FloatArray, radius: float) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """All pairs of indices, the lesser first, whose rows are less than a radius apart."""
    order = np.argsort(centres[:, 0], kind="stable")
    rows = centres[order, 0]
    after = np.searchsorted(rows, rows + radius) - np.arange(len(rows)) - 1
    first = np.repeat(np.arange(len(rows)), after)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(after) - after, after)
    return np.minimum(order[first], order[second]), np.maximum(order[first], order[second])
