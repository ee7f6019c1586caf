"""From a rough placement to a local maximum of the capped score."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fidmap.geometry import apply, weighted_similarity
from fidmap.model import FloatArray, StartPose, Transform
from fidmap.register.hypotheses import nearest_within, within
from fidmap.register.problem import Problem

# seeded trials per maximum of a discretised value
SETTLE_ROUNDS = 24
SETTLE_TRIALS = 1500


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


def climb(problem: Problem, start: Transform, pose: StartPose | None, rounds: int, steps: int) -> Placement:
    """Alternate exact matching and truncated-L1 fitting until the continuous value stops growing."""
    best = place(problem, start)
    for _ in range(rounds):
        if len(best.pairs) == 0:
            break
        moved = fit_pairs(problem, best.pairs, best.transform, steps)
        trial = place(problem, moved if pose is None else nearest_within(moved, pose))
        if trial.closeness <= best.closeness + 1e-9:
            break
        best = trial
    return best


def fit_pairs(problem: Problem, pairs: npt.NDArray[np.intp], start: Transform, steps: int) -> Transform:
    """Maximise sum max(0, 1 - d/D) over fixed pairs near `start` by reweighted least squares.

    Each step minimises a quadratic that touches the truncated sum from below, so the value never falls (but for
    the smoothing of d near 0). A millionth of the squares is added: it decides where the sum is flat.
    """
    target = problem.fiducials[pairs[:, 0]] @ [1, 1j]
    source = problem.barrels[pairs[:, 1]] @ [1, -1j if start.mirrored else 1j]
    z, t = start.scale * np.exp(1j * start.rotation), complex(start.tx_m, start.ty_m)
    best, best_value, softness = (z, t), -1.0, 0.05 * problem.d_max
    for _ in range(steps):
        distance = np.abs(z * source + t - target)
        near = distance < problem.d_max
        value = float((1 - distance[near] / problem.d_max).sum() - 1e-6 * (distance @ distance))
        settled = softness < 1e-6 and value < best_value + 1e-12
        if value > best_value:
            best, best_value = (z, t), value
        if settled or not near.any():
            break
        weight = near / np.sqrt(distance * distance + softness * softness) + 1e-6
        z, t = weighted_similarity(source, target, weight, problem.scale_range)
        softness = max(softness * 0.7, 1e-7)
    z, t = best
    return Transform(float(np.angle(z)), t.real, t.imag, float(np.clip(abs(z), *problem.scale_range)), start.mirrored)


def settle_squares(problem: Problem, start: Placement, pose: StartPose | None) -> Placement:
    """Where the sum is flat, go towards the least squares as far as nothing is lost."""
    target = problem.fiducials[start.pairs[:, 0]] @ [1, 1j]
    source = problem.barrels[start.pairs[:, 1]] @ [1, -1j if start.transform.mirrored else 1j]
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
    best = start
    for k in range(SETTLE_ROUNDS):
        if best.value > len(best.pairs) - 1e-9 or (k == SETTLE_ROUNDS // 2 and best is start):
            break
        reach = problem.radius_m * 0.85 ** (k % 12)
        moves = random.normal(size=(SETTLE_TRIALS, 4)) * reach * [1 / arm, 1, 1, 1 / arm]
        trials = _perturbed(best.transform, moves, centre, problem.scale_range)
        trials = trials[within(trials, pose)]
        worth = _fixed_pair_values(problem, best, trials)
        for one in np.argsort(-worth, kind="stable")[:6]:
            rotation, tx, ty, scale = (float(v) for v in trials[one])
            trial = place(problem, Transform(rotation, tx, ty, scale, best.transform.mirrored))
            if (round(trial.value, 7), trial.closeness) > (round(best.value, 7), best.closeness):
                best = trial
    return best


def _perturbed(
    transform: Transform, moves: FloatArray, centre: FloatArray, scale_range: tuple[float, float]
) -> FloatArray:
    """Placements (T, 4) turned, shifted and scaled by moves (T, 4) about the barrel parts' middle, which a turn spares."""
    rotation = transform.rotation + moves[:, 0]
    scale = np.clip(transform.scale * (1 + moves[:, 3]), *scale_range)
    middle = centre @ [1, -1j if transform.mirrored else 1j]
    pivot = apply(transform, centre[None])[0] @ [1, 1j]
    shift = pivot + moves[:, 1:3] @ [1, 1j] - scale * np.exp(1j * rotation) * middle
    return np.stack([rotation, shift.real, shift.imag, scale], axis=1)


def _fixed_pair_values(problem: Problem, best: Placement, trials: FloatArray) -> FloatArray:
    """(T,) discretised value of the present pairs under placements (T, 4), with the continuous one as tie-break."""
    target = problem.fiducials[best.pairs[:, 0]] @ [1, 1j]
    source = problem.barrels[best.pairs[:, 1]] @ [1, -1j if best.transform.mirrored else 1j]
    moved = (trials[:, 3] * np.exp(1j * trials[:, 0]))[:, None] * source[None]
    distance = np.abs(moved + (trials[:, 1] + 1j * trials[:, 2])[:, None] - target[None])
    value = (1 - problem.loss(distance)).sum(axis=1)
    return np.asarray(value + 1e-3 * np.maximum(0, 1 - distance / problem.d_max).sum(axis=1))
