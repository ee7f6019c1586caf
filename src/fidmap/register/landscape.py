"""The registration as the search sees it: points about a pivot, which pairs may be, what a distance is worth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from fidmap.geometry import ComplexArray, angle_between, as_complex
from fidmap.model import FloatArray, StartPose, Transform
from fidmap.register.problem import Problem

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]
# distances are rounded on their way: a bound sees them this much (metres) nearer
ROUNDING_SLACK = 1e-7
FACING_SLACK = 1e-9


@dataclass(frozen=True, eq=False)
class Landscape:
    """A problem with its barrel parts turned over where asked, and the limits of its placements.

    A placement is (rotation, x, y, scale): barrel part b goes to scale * exp(i rotation) * b + (x + iy), where b is
    counted from the `pivot`, which is the middle of the barrel parts, or the map's origin where a start pose is given.
    """

    problem: Problem
    mirrored: bool = False
    start: StartPose | None = None

    @cached_property
    def fiducials(self) -> ComplexArray:
        """(N,) x + iy, metres, arena frame."""
        return as_complex(self.problem.fiducials)

    @cached_property
    def pivot(self) -> complex:
        """The point of the map (turned over where mirrored) that x and y place."""
        if self.start is not None:
            return 0j
        return complex(as_complex(self.problem.barrels, self.mirrored)[self.used].mean())

    @cached_property
    def barrels(self) -> ComplexArray:
        """(M,) x + iy from the pivot, metres, map frame (turned over where mirrored)."""
        return as_complex(self.problem.barrels, self.mirrored) - self.pivot

    @cached_property
    def possible(self) -> BoolArray:
        """(N, M) whether a pair may be assigned, facings aside; pairs fixed by a human among them."""
        possible = self.problem.allowed.copy()
        possible[self.problem.fixed[:, 0], self.problem.fixed[:, 1]] = True
        return possible

    @cached_property
    def used(self) -> IntArray:
        """Indices of the barrel parts that some fiducial part is possible for."""
        return np.flatnonzero(self.possible.any(axis=0))

    @cached_property
    def facings(self) -> tuple[FloatArray, FloatArray]:
        """(N,), (M,) facings that are tested, turned over where mirrored; NaN where not or fixed by a human."""
        barrel = (-1 if self.mirrored else 1) * self.problem.barrel_facings
        barrel[self.problem.fixed[:, 1]] = math.nan
        return self.problem.fiducial_facings, barrel

    @cached_property
    def faced(self) -> bool:
        """Whether any pair of facings is tested."""
        return all(bool(np.isfinite(one).any()) for one in self.facings)

    def clash(
        self, rows: IntArray, columns: IntArray, rotation: FloatArray | float, spread: FloatArray | float
    ) -> BoolArray:
        """Whether pairs' facings disagree for every rotation within `spread` of `rotation` (radians)."""
        away = angle_between(self.facings[0][rows], self.facings[1][columns] + rotation)
        return np.asarray(away >= self.problem.settings.facing_tolerance + spread + FACING_SLACK)

    def worth(self, distance: FloatArray) -> FloatArray:
        """1 - min(q(d), D)/D, 0 from D on; never less than the score of pairs that are a rounding error nearer."""
        near = np.maximum(distance - ROUNDING_SLACK, 0.0)
        return np.where(near < self.problem.d_max, 1 - self.problem.loss(near), 0.0)

    @cached_property
    def arms(self) -> FloatArray:
        """(M,) distance of every barrel part from the pivot, metres."""
        return np.abs(self.barrels)

    @cached_property
    def arm(self) -> float:
        """Root mean square of the arms of the used barrel parts, metres; what a turn is weighed with."""
        return float(np.sqrt(np.mean(self.arms[self.used] ** 2)))

    @cached_property
    def most(self) -> int:
        """No assignment has more pairs."""
        return int(min(self.possible.any(axis=0).sum(), self.possible.any(axis=1).sum()))

    def swing(self, boxes: FloatArray) -> FloatArray:
        """(K,) how far rotation and scale move a point within boxes (K, 8), per metre of its arm."""
        turn = 2 * np.sin(np.minimum(boxes[:, 4], math.pi) / 2)
        return np.asarray(turn * (boxes[:, 3] + boxes[:, 7]) + boxes[:, 7])

    def transform(self, placement: FloatArray) -> Transform:
        """T_truth_map of a placement (4,)."""
        rotation, x, y, scale = (float(v) for v in placement)
        shift = complex(x, y) - scale * complex(math.cos(rotation), math.sin(rotation)) * self.pivot
        return Transform(rotation, shift.real, shift.imag, scale, self.mirrored)

    def placement(self, transform: Transform) -> FloatArray:
        """The placement (4,) of a transform that is mirrored as this landscape is."""
        turn = transform.scale * complex(math.cos(transform.rotation), math.sin(transform.rotation))
        at = complex(transform.tx_m, transform.ty_m) + turn * self.pivot
        return np.array([transform.rotation, at.real, at.imag, transform.scale])

    @cached_property
    def unmoved(self) -> FloatArray:
        """(1, 4) the identity, or (0, 4) where scale or a start pose shut it out."""
        scale = float(np.clip(1.0, *self.problem.scale_range))
        return self.placement(Transform(scale=scale, mirrored=self.mirrored))[None]

    def cells(self, cell: float) -> float:
        """About how many cells of a side (metres) the pivot's possible places have."""
        low, high = self.limits
        return float(np.prod((high - low)[1:3] / cell + 1))

    @cached_property
    def limits(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest placement (4,), (4,): some part comes near a fiducial part, and the start pose holds."""
        near = self.fiducials[self.possible.any(axis=1)]
        low_scale, high_scale = self.problem.scale_range
        far = high_scale * float(self.arms[self.used].max()) + self.problem.d_max
        low = np.array([-math.pi, near.real.min() - far, near.imag.min() - far, low_scale])
        high = np.array([math.pi, near.real.max() + far, near.imag.max() + far, high_scale])
        if self.start is not None:
            pose, turn, side = self.start.pose, min(math.pi, 3 * self.start.sigma_yaw), 3 * self.start.sigma_m
            low[:3] = pose.yaw - turn, pose.x_m - side, pose.y_m - side
            high[:3] = pose.yaw + turn, pose.x_m + side, pose.y_m + side
        return low, high

    def limited(self, placements: FloatArray) -> FloatArray:
        """Placements (K, 4), moved into the start pose's limits where one is given."""
        if self.start is None:
            return placements
        low, high = self.limits
        inside = placements.copy()
        middle = (low[0] + high[0]) / 2
        inside[:, 0] = middle + (inside[:, 0] - middle + math.pi) % (2 * math.pi) - math.pi
        return np.asarray(np.clip(inside, low, high))

    def outside(self, boxes: FloatArray) -> BoolArray:
        """(K,) whether boxes (K, 8) lie wholly further from the start pose than three of its sigma."""
        if self.start is None:
            return np.zeros(len(boxes), bool)
        away = np.abs(boxes[:, 1:3] - [self.start.pose.x_m, self.start.pose.y_m]) - boxes[:, 5:7]
        return np.asarray(np.hypot(*np.maximum(away, 0.0).T) > 3 * self.start.sigma_m + 1e-9)
