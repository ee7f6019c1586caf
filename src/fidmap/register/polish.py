"""From a rough placement to a local maximum of the capped score."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fidmap.geometry import apply, weighted_similarity
from fidmap.model import FloatArray, StartPose, Transform
from fidmap.register.hypotheses import within
from fidmap.register.problem import Problem


@dataclass(frozen=True, eq=False)
class Placement:
    """A transform with its assignment and worth; ordered by `key`, the greatest first."""

    transform: Transform
    value: float
    closeness: float
    pairs: npt.NDArray[np.intp]
    squares: float

    @property
    def key(self) -> tuple[float, ...]:
        """Greatest value, then continuous value, then least squares, then the smallest move."""
        move = self.transform
        return (
            round(self.value, 7),
            round(self.closeness, 3),
            -round(self.squares, 6),
            -round(abs(np.angle(np.exp(1j * move.rotation))), 6),
            -round(float(np.hypot(move.tx_m, move.ty_m)), 6),
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
        if not within(np.array([[moved.rotation, moved.tx_m, moved.ty_m, moved.scale]]), pose)[0]:
            break
        trial = place(problem, moved)
        if trial.closeness <= best.closeness + 1e-9:
            break
        best = trial
    return best


def fit_pairs(problem: Problem, pairs: npt.NDArray[np.intp], start: Transform, steps: int) -> Transform:
    """Maximise sum max(0, 1 - d/D) over fixed pairs near `start` by reweighted least squares.

    Each step minimises a quadratic that touches the truncated sum from below, so the value never falls (but for
    the smoothing of d near 0). A millionth of the squares is added: it decides where the sum is flat.
    """
    target, source = problem.fiducials[pairs[:, 0]], problem.barrels[pairs[:, 1]]
    unflipped = replace(start, mirrored=False)
    if start.mirrored:
        source = source * [1, -1]
    best, best_value, softness = unflipped, -1.0, 0.05 * problem.d_max
    current = unflipped
    for _ in range(steps):
        distance = np.linalg.norm(apply(current, source) - target, axis=1)
        value = float(np.maximum(0, 1 - distance / problem.d_max).sum() - 1e-6 * (distance**2).sum())
        if value > best_value:
            best, best_value = current, value
        near = distance < problem.d_max
        if not near.any() or (softness < 1e-6 and value < best_value + 1e-12 and current is not best):
            break
        weight = np.where(near, 1 / np.sqrt(distance**2 + softness**2), 0.0) + 1e-6
        current = weighted_similarity(source, target, weight, problem.scale_range)
        softness = max(softness * 0.7, 1e-7)
    return replace(best, mirrored=start.mirrored)


def settle_steps(problem: Problem, start: Placement, pose: StartPose | None, rounds: int = 10) -> Placement:
    """Raise a discretised value by seeded perturbations: it is flat between jumps, so gradients tell nothing."""
    random = np.random.default_rng(0)
    arm = float(np.sqrt(np.mean(np.sum((problem.barrels - problem.barrels.mean(axis=0)) ** 2, axis=1)))) or 1.0
    best, reach = start, problem.radius_m
    for _ in range(rounds):
        moves = random.normal(size=(200, 4)) * reach * [1 / arm, 1, 1, 1 / arm]
        trials = _perturb(best.transform, moves, problem.barrels.mean(axis=0), problem.scale_range)
        trials = [t for t in trials if within(np.array([[t.rotation, t.tx_m, t.ty_m, t.scale]]), pose)[0]]
        worth = _fixed_pair_values(problem, best.pairs, trials)
        for k in np.argsort(-worth, kind="stable")[:8]:
            trial = place(problem, trials[k])
            if (trial.value, trial.closeness) > (best.value + 1e-9, -1.0) or (
                abs(trial.value - best.value) <= 1e-9 and trial.closeness > best.closeness
            ):
                best = trial
        reach *= 0.75
    return best


def _perturb(
    transform: Transform, moves: FloatArray, centre: FloatArray, scale_range: tuple[float, float]
) -> list[Transform]:
    """Turn, shift and scale about the middle of the barrel parts, so that a turn moves them least."""
    pivot = apply(transform, centre[None])[0]
    trials = []
    for turn, dx, dy, grow in moves:
        scale = float(np.clip(transform.scale * (1 + grow), *scale_range))
        rough = replace(transform, rotation=transform.rotation + turn, tx_m=0.0, ty_m=0.0, scale=scale)
        shift = pivot + np.array([dx, dy]) - apply(rough, centre[None])[0]
        trials.append(replace(rough, tx_m=float(shift[0]), ty_m=float(shift[1])))
    return trials


def _fixed_pair_values(problem: Problem, pairs: npt.NDArray[np.intp], trials: list[Transform]) -> FloatArray:
    """(T,) discretised value of the present pairs under each trial, with the continuous one as tie-break."""
    target, source = problem.fiducials[pairs[:, 0]], problem.barrels[pairs[:, 1]]
    moved = np.array([apply(trial, source) for trial in trials])
    distance = np.linalg.norm(moved - target[None], axis=2)
    value = (1 - problem.loss(distance)).sum(axis=1)
    return np.asarray(value + 1e-3 * np.maximum(0, 1 - distance / problem.d_max).sum(axis=1))
