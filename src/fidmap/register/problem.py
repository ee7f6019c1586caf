"""The registration as arrays, and its objective: the capped score that relative accuracy is the maximum of."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.optimize import linear_sum_assignment

from fidmap.geometry import angle_between, apply, turn_directions
from fidmap.model import Arena, BarrelPart, FloatArray, Settings, Transform
from fidmap.scoring import clipped_loss

# arcs are drawn in cells: the least opening is compared with a tenth of a degree to spare
OPENING_SLACK = math.radians(0.1)
# facings exactly at the tolerance clash, however their difference was rounded
FACING_SLACK = 1e-9


@dataclass(frozen=True, eq=False)
class Problem:
    """N fiducial parts, M barrel parts and the settings that decide what a placement is worth.

    fiducials, barrels: (N, 2), (M, 2) metres, each in its own frame. allowed: (N, M) pairs that openings,
    confidence and human decisions admit. fixed: (K, 2) index pairs set by a human. facing arrays hold NaN where
    a facing is not tested.
    """

    fiducials: FloatArray
    barrels: FloatArray
    fiducial_facings: FloatArray
    barrel_facings: FloatArray
    allowed: npt.NDArray[np.bool_]
    fixed: npt.NDArray[np.intp]
    settings: Settings
    radius_m: float

    @cached_property
    def d_max(self) -> float:
        """D of relative accuracy, metres."""
        return self.settings.d_max("relative_accuracy", self.radius_m)

    @cached_property
    def scale_range(self) -> tuple[float, float]:
        """Bounds of the scale; (1, 1) for a rigid registration."""
        return self.settings.scale_range if self.settings.transform == "similarity" else (1.0, 1.0)

    def loss(self, distance: FloatArray) -> FloatArray:
        """min(q(d), D)/D of relative accuracy."""
        return clipped_loss(distance, self.settings.rounding, self.radius_m, self.d_max)

    def distances(self, transform: Transform) -> FloatArray:
        """(N, M) metres between every fiducial part and every moved barrel part."""
        moved = apply(transform, self.barrels)
        return np.asarray(np.linalg.norm(self.fiducials[:, None] - moved[None], axis=2))

    def facings_agree(self, transform: Transform) -> npt.NDArray[np.bool_]:
        """(N, M) whether facings agree after the transform's rotation; true where one has none."""
        turned = turn_directions(transform, self.barrel_facings)
        return ~self.facings_clash(self.fiducial_facings[:, None], turned[None])

    def facings_clash(self, fiducial: FloatArray, barrel: FloatArray) -> npt.NDArray[np.bool_]:
        """Whether directions are the tolerance or more apart, the limit itself refused; false for NaN."""
        return np.asarray(angle_between(fiducial, barrel) >= self.settings.facing_tolerance - FACING_SLACK)

    def match(self, transform: Transform) -> tuple[float, float, npt.NDArray[np.intp]]:
        """The best assignment under a transform.

        Returns its value, its continuous value (without discretization) and (K, 2) index pairs, those fixed by
        a human among them. Of equal values the one with most pairs below D, then of greatest continuous value.
        """
        distance = self.distances(transform)
        value, closeness = 1 - self.loss(distance), 1 - np.minimum(distance, self.d_max) / self.d_max
        open_pairs = self.allowed & (distance < self.d_max) & self.facings_agree(transform)
        gain = np.where(open_pairs, value + 1e-7 + 1e-10 * closeness, 0.0)
        rows, columns = linear_sum_assignment(gain, maximize=True)
        used = open_pairs[rows, columns]
        pairs = np.concatenate([self.fixed, np.stack([rows[used], columns[used]], axis=1)])
        i, j = pairs[:, 0], pairs[:, 1]
        return float(value[i, j].sum()), float(closeness[i, j].sum()), pairs


def make_problem(parts: tuple[BarrelPart, ...], arena: Arena, settings: Settings) -> Problem:
    """Arrays of an arena with positions and the barrel parts of a map.

    A pair is allowed when the arc is drawn over `min_opening` of the part's opening and is confident enough;
    facings are not tested for whole barrels and parts without one. What a human fixed is taken out of the rest.
    """
    index = {part.id: i for i, part in enumerate(arena.parts)}
    fixed = [(index[b.fixed_id], j) for j, b in enumerate(parts) if b.fixed_id in index]
    drawn = np.array([b.drawn for b in parts], float)
    opening = np.array([f.opening for f in arena.parts], float)
    allowed = drawn[None] >= settings.min_opening * opening[:, None] - OPENING_SLACK
    allowed &= np.array([b.confidence >= settings.min_confidence for b in parts], bool)[None]
    for j, barrel in enumerate(parts):
        allowed[:, j] &= barrel.fixed_id is None
    for i, _ in fixed:
        allowed[i] = False
    whole = opening >= 2 * math.pi - 1e-9
    facings = np.array([math.nan if f.facing is None else f.facing for f in arena.parts], float)
    return Problem(
        fiducials=np.array([(f.x_m, f.y_m) for f in arena.parts], float).reshape(-1, 2),
        barrels=np.array([(b.x_m, b.y_m) for b in parts], float).reshape(-1, 2),
        fiducial_facings=np.where(whole, math.nan, facings),
        barrel_facings=np.array([math.nan if b.facing is None else b.facing for b in parts], float),
        allowed=allowed,
        fixed=np.array(fixed, np.intp).reshape(-1, 2),
        settings=settings,
        radius_m=arena.radius_m,
    )
