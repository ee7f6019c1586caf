"""Whether barrel parts fit an arena as they are, or only at another scale or turned over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fidmap.geometry import apply, as_complex, weighted_similarity
from fidmap.model import Arena, Assignment, BarrelPart, Settings, Transform
from fidmap.register import register

SCALES = (0.7, 1.4)
SCALE_OFF, SURE = 0.02, 3.0
# a fit is believed with so many parts, with this share of those that could be assigned, and with this mean worth
LEAST_PARTS, LEAST_SHARE, LEAST_WORTH = 5, 0.5, 0.85
LEAST_GAIN = 0.05  # of worth per part: what another fit has to be better by
SOUND_SHARE, SOUND_PARTS, SOUND_WORTH = 0.75, 8, 0.9
# so many parts fit nothing: with so little worth in all, and each of them so badly, as in a strange arena
STRANGE_PARTS, STRANGE_SHARE, STRANGE_WORTH = 8, 0.5, 0.8


@dataclass(frozen=True)
class Fit:
    """How well parts fit under an assignment.

    count: assigned parts; value: their sum of 1 - d/D; possible: as many as could be assigned; move: T_truth_map;
    scale, scale_error: the least squares' over the assigned pairs with its standard deviation (0, 0 below three pairs).
    """

    count: int = 0
    value: float = 0.0
    possible: int = 0
    move: Transform | None = None
    scale: float = 0.0
    scale_error: float = 0.0

    @property
    def worth(self) -> float:
        """Mean worth of an assigned part."""
        return self.value / self.count if self.count else 0.0

    @property
    def believed(self) -> bool:
        """Whether so many parts fit so well that it is no chance."""
        return self.count >= max(LEAST_PARTS, LEAST_SHARE * self.possible) and self.worth >= LEAST_WORTH

    @property
    def sound(self) -> bool:
        """Whether nothing better is looked for: most that was seen fits, or many parts fit well, at scale 1."""
        most = self.count >= LEAST_PARTS and self.value >= SOUND_SHARE * self.possible
        well = self.believed and self.count >= SOUND_PARTS and self.worth >= SOUND_WORTH
        return (most or well) and not self.is_scaled(self.scale)

    @property
    def strange(self) -> bool:
        """Whether many parts fit as badly as those of another arena's map do."""
        little = self.value < STRANGE_SHARE * self.possible and self.worth < STRANGE_WORTH
        return self.possible >= STRANGE_PARTS and little

    def is_scaled(self, scale: float) -> bool:
        """Whether a scale differs from 1 beyond its uncertainty and 2 %."""
        return abs(scale - 1) > SCALE_OFF + SURE * self.scale_error


def fit_of(parts: Sequence[BarrelPart], arena: Arena, assignment: Assignment, settings: Settings) -> Fit:
    """The fit of an assignment of parts; an arena with positions."""
    sure = sum(part.confidence >= settings.min_confidence for part in parts)
    pairs = [(i, j) for i, j in enumerate(assignment.barrel_of) if j is not None]
    possible, move = min(sure, len(arena.parts)), assignment.transform
    if move is None or not pairs:
        return Fit(possible=possible)
    barrels = np.array([(parts[j].x_m, parts[j].y_m) for _, j in pairs], float)
    truth = np.array([(arena.parts[i].x_m, arena.parts[i].y_m) for i, _ in pairs], float)
    loss = np.linalg.norm(apply(move, barrels) - truth, axis=1) / settings.d_max("relative_accuracy", arena.radius_m)
    value = float((1 - np.minimum(loss, 1)).sum())
    if len(pairs) < 3:
        return Fit(len(pairs), value, possible, move)
    source, target = as_complex(barrels, move.mirrored), as_complex(truth)
    z, t = weighted_similarity(source, target, np.ones(len(pairs)), (0.1, 10.0))
    # four parameters leave 2 n - 4 degrees of freedom; the scale's variance is that of a slope through the middle
    variance = float((np.abs(z * source + t - target) ** 2).sum()) / (2 * len(pairs) - 4)
    arms = float((np.abs(source - source.mean()) ** 2).sum())
    return Fit(len(pairs), value, possible, move, abs(z), (variance / arms) ** 0.5 if arms > 0 else 0.0)


def best_fit(parts: Sequence[BarrelPart], arena: Arena, settings: Settings, plain: Fit) -> Fit:
    """The plain fit, or one that is clearly better scaled, mirrored or both; the simplest of those that are as good."""
    if plain.sound or plain.possible < LEAST_PARTS:
        return plain
    free = _searched(parts, arena, settings, mirror=True)
    if free.move is not None and free.move.mirrored and not settings.mirror:
        upright = _searched(parts, arena, settings, mirror=False)  # a symmetric arena fits either way
        free = upright if free.value - upright.value <= LEAST_GAIN * free.count else free
    return free if free.believed and free.value - plain.value > LEAST_GAIN * free.count else plain


def _searched(parts: Sequence[BarrelPart], arena: Arena, settings: Settings, *, mirror: bool) -> Fit:
    """The best similarity, by the quick search: what has to be clearly better needs no proof."""
    free = replace(settings, transform="similarity", scale_range=SCALES, mirror=mirror, rounding="none")
    return fit_of(parts, arena, register(tuple(parts), arena, free, fast=True), free)
