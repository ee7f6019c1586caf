"""Placements with their worth, told apart where they are equally good."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fidmap.geometry import apply, as_complex, weighted_similarity
from fidmap.model import FloatArray, StartPose, Transform
from fidmap.register.problem import Problem
from fidmap.register.start_pose import nearest_within, within

# seeded trials per maximum of a discretised value
SETTLE_ROUNDS = 24
SETTLE_TRIALS = 1500
SETTLE_SIZE = 2500  # pairs; matching many of equal worth takes long


@dataclass(frozen=True, eq=False)
class Placement:
    """A transform with its assignment and worth; sorted by `order`."""

    transform: Transform
    value: float
    closeness: float
    pairs: npt.NDArray[np.intp]
    squares: float

    @property
    def order(self) -> tuple[object, ...]:
        """What sorts placements, the best first, so that equal optima are told apart.

        Greatest value, greatest continuous value, least squares, least rotation, least translation, then the first
        assignment: fiducial parts stand in the order of their ids, barrel parts in that of their x and y.
        """
        move = self.transform
        return (
            -round(self.value, 7),
            -round(self.closeness, 3),
            round(self.squares, 6),
            round(abs(math.remainder(move.rotation, 2 * math.pi)), 6),
            round(math.hypot(move.tx_m, move.ty_m), 6),
            sorted((int(i), int(j)) for i, j in self.pairs),
        )


def place(problem: Problem, transform: Transform) -> Placement:
    """Match under a transform."""
    value, closeness, pairs = problem.match(transform)
    error = apply(transform, problem.barrels[pairs[:, 1]]) - problem.fiducials[pairs[:, 0]]
    return Placement(transform, value, closeness, pairs, float((error**2).sum()))


def settle_squares(problem: Problem, start: Placement, pose: StartPose | None) -> Placement:
    """Where the sum is flat, go towards the least squares as far as nothing is lost."""
    target = as_complex(problem.fiducials[start.pairs[:, 0]])
    source = as_complex(problem.barrels[start.pairs[:, 1]], start.transform.mirrored)
    here = start.transform
    z, t = weighted_similarity(source, target, np.ones(len(target)), problem.scale_range)
    turn = math.remainder(float(np.angle(z)) - here.rotation, 2 * math.pi)
    for share in (1.0, 0.5, 0.25, 0.125):
        moved = replace(
            here,
            rotation=here.rotation + share * turn,
            tx_m=here.tx_m + share * (t.real - here.tx_m),
            ty_m=here.ty_m + share * (t.imag - here.ty_m),
            scale=here.scale + share * (abs(z) - here.scale),
        )
        trial = place(problem, moved if pose is None else nearest_within(moved, pose))
        if min(trial.value - start.value, trial.closeness - start.closeness) > -1e-9 and trial.squares < start.squares:
            return trial
    return start


def settle_steps(problem: Problem, start: Placement, pose: StartPose | None) -> Placement:
    """Raise a discretised value by seeded perturbations: it is flat between jumps, so gradients tell nothing."""
    random = np.random.default_rng(0)
    centre = problem.barrels.mean(axis=0)
    arm = float(np.sqrt(np.mean(np.sum((problem.barrels - centre) ** 2, axis=1)))) or 1.0
    tries = 6 if problem.allowed.size <= SETTLE_SIZE else 2
    best = start
    for k in range(SETTLE_ROUNDS):
        if best.value > len(best.pairs) - 1e-9 or (k == SETTLE_ROUNDS // 2 and best is start):
            break
        reach = problem.radius_m * 0.85 ** (k % 12)
        moves = random.normal(size=(SETTLE_TRIALS, 4)) * reach * [1 / arm, 1, 1, 1 / arm]
        trials = _perturbed(best.transform, moves, centre, problem.scale_range)
        trials = trials[within(trials, pose)]
        worth = _fixed_pair_values(problem, best, trials)
        for one in np.argsort(-worth, kind="stable")[:tries]:
            rotation, tx, ty, scale = (float(v) for v in trials[one])
            trial = place(problem, Transform(rotation, tx, ty, scale, best.transform.mirrored))
            if (round(trial.value, 7), trial.closeness) > (round(best.value, 7), best.closeness):
                best = trial
    return best


def _perturbed(
    transform: Transform, moves: FloatArray, centre: FloatArray, scale_range: tuple[float, float]
) -> FloatArray:
    """Placements (T, 4) turned, shifted and scaled by moves (T, 4) about the middle of the barrel parts."""
    rotation = transform.rotation + moves[:, 0]
    scale = np.clip(transform.scale * (1 + moves[:, 3]), *scale_range)
    middle = centre @ [1, -1j if transform.mirrored else 1j]
    pivot = apply(transform, centre[None])[0] @ [1, 1j]
    shift = pivot + moves[:, 1:3] @ [1, 1j] - scale * np.exp(1j * rotation) * middle
    return np.stack([rotation, shift.real, shift.imag, scale], axis=1)


def _fixed_pair_values(problem: Problem, best: Placement, trials: FloatArray) -> FloatArray:
    """(T,) discretised value of the present pairs under placements (T, 4), with the continuous one as tie-break."""
    target = as_complex(problem.fiducials[best.pairs[:, 0]])
    source = as_complex(problem.barrels[best.pairs[:, 1]], best.transform.mirrored)
    moved = (trials[:, 3] * np.exp(1j * trials[:, 0]))[:, None] * source[None]
    distance = np.abs(moved + (trials[:, 1] + 1j * trials[:, 2])[:, None] - target[None])
    value = (1 - problem.loss(distance)).sum(axis=1)
    return np.asarray(value + 1e-3 * np.maximum(0, 1 - distance / problem.d_max).sum(axis=1))
