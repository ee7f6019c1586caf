"""The runner-up: the best registration that is another than the best one, with its bound."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fidmap.geometry import ComplexArray, angle_between, apply, as_complex
from fidmap.model import FloatArray
from fidmap.register.bounds import greatest
from fidmap.register.landscape import BoolArray, Landscape
from fidmap.register.near import NearPairs
from fidmap.register.polish import Placement
from fidmap.register.problem import Problem

# a runner-up is another registration only where there is something to assign
LEAST_PARTS = 3


@dataclass(frozen=True, eq=False)
class Rivals:
    """Placements in which at least half of the barrel parts of `best` go elsewhere, or move by D (rms) and more.

    same: (N, N) whether two fiducial parts are one object. Going elsewhere is another object, or none.
    """

    problem: Problem
    best: Placement
    same: BoolArray

    @cached_property
    def keep(self) -> int:
        """So many barrel parts may stay with their object at most."""
        return len(self.best.pairs) // 2

    @cached_property
    def own(self) -> BoolArray:
        """(N, M) pairs that leave a barrel part with its object."""
        own = np.zeros(self.problem.allowed.shape, bool)
        own[:, self.best.pairs[:, 1]] = self.same[self.best.pairs[:, 0]].T
        return own

    @cached_property
    def places(self) -> ComplexArray:
        """(K,) where the best placement puts its barrel parts, x + iy metres in the arena."""
        return as_complex(apply(self.best.transform, self.problem.barrels[self.best.pairs[:, 1]]))

    def includes(self, trial: Placement) -> bool:
        """Whether a placement is another one than the best."""
        moved = as_complex(apply(trial.transform, self.problem.barrels[self.best.pairs[:, 1]]))
        away = math.sqrt(float(np.mean(np.abs(moved - self.places) ** 2)))
        stay = int(self.own[trial.pairs[:, 0], trial.pairs[:, 1]].sum())
        return away >= self.problem.d_max or stay <= self.keep

    def narrowed(self, land: Landscape, boxes: FloatArray, pairs: NearPairs, most: FloatArray) -> FloatArray:
        """(K,) upper bounds of the other placements in boxes (K, 8); infinite where all may be others."""
        bounds = np.full(len(boxes), math.inf)
        inside = self._reach(land, boxes) < self.problem.d_max
        if not inside.any():
            return bounds
        other = self._elsewhere(pairs, most, len(boxes))
        # where the old assignment is worth more than any other, the best assignment is not another one
        other[self._staying(land, boxes) > other + 1e-9] = 0.0
        return np.where(inside, other, bounds)

    def _reach(self, land: Landscape, boxes: FloatArray) -> FloatArray:
        """(K,) the greatest rms displacement from the best placement within boxes."""
        columns = self.best.pairs[:, 1]
        turned = boxes[:, 3] * np.exp(1j * boxes[:, 0])
        moved = turned[:, None] * land.barrels[columns] + (boxes[:, 1] + 1j * boxes[:, 2])[:, None]
        arm = math.sqrt(float(np.mean(land.arms[columns] ** 2)))
        return np.asarray(
            np.sqrt(np.mean(np.abs(moved - self.places) ** 2, axis=1))
            + land.swing(boxes) * arm + np.hypot(boxes[:, 5], boxes[:, 6])
        )  # fmt: skip

    def _elsewhere(self, pairs: NearPairs, most: FloatArray, count: int) -> FloatArray:
        """(count,) upper bounds of assignments that leave at most `keep` barrel parts with their object."""
        size = self.problem.allowed.shape[1]
        own = self.own[pairs.fiducial, pairs.barrel]
        key = pairs.box * size + pairs.barrel
        stay = greatest(key[own], count * size, most[own]).reshape(count, size)
        leave = greatest(key[~own], count * size, most[~own]).reshape(count, size)
        gain = np.sort(np.maximum(stay - leave, 0.0), axis=1)[:, size - self.keep :]
        return np.asarray(leave.sum(axis=1) + gain.sum(axis=1))

    def _staying(self, land: Landscape, boxes: FloatArray) -> FloatArray:
        """(K,) what the best placement's assignment is worth at least, everywhere in boxes."""
        rows, columns = self.best.pairs.T
        turned = boxes[:, 3] * np.exp(1j * boxes[:, 0])
        moved = turned[:, None] * land.barrels[columns] + (boxes[:, 1] + 1j * boxes[:, 2])[:, None]
        reach = land.arms[columns] * land.swing(boxes)[:, None] + np.hypot(boxes[:, 5], boxes[:, 6])[:, None]
        worth = land.worth(np.abs(moved - land.fiducials[rows]) + reach + 3e-7)
        turns = angle_between(land.facings[0][rows], land.facings[1][columns] + boxes[:, :1]) + boxes[:, 4:5]
        sure = ~(turns >= self.problem.settings.facing_tolerance - 1e-6)
        return np.asarray(np.where(sure, worth, 0.0).sum(axis=1))


def same_objects(ids: Sequence[str], pairs: Sequence[tuple[str, ...]]) -> BoolArray:
    """(N, N) whether parts are one object: the two of a short or long pair, and each with itself."""
    index = {name: k for k, name in enumerate(ids)}
    same = np.eye(len(ids), dtype=bool)
    for a, b in pairs:
        same[index[a], index[b]] = same[index[b], index[a]] = True
    return same
