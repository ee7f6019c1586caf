"""How probable it is that one map's mapper is truly better than another's, in arenas of this kind."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr  # Student's t, without the half second that scipy.stats takes to load

from fidmap.model import LONG, SHORT, FloatArray
from fidmap.uncertainty.clusters import Sums, cluster_of, summed
from fidmap.uncertainty.population import draws

SURE = 0.95
# what resampling parts does not see: the fit adapts to them, and a bend of the map lies over many of them. Tuned on
# simulated pairs of mappers (`./run bench uncertainty --seed 1`)
UNSEEN = 1.2


@dataclass(frozen=True)
class PartLoss:
    """One fiducial part of a scored map: its losses in [0, 1], None where there is none."""

    id: str
    assigned: bool
    relative: float | None
    in_frame: float | None


@dataclass(frozen=True)
class GroupLoss:
    """One group of a scored map."""

    group_class: str
    parts: tuple[str, ...]
    loss: float | None


@dataclass(frozen=True)
class Losses:
    """What the overall score of a map is made of."""

    parts: tuple[PartLoss, ...]
    groups: tuple[GroupLoss, ...]
    weights: Mapping[str, float]

    @property
    def ids(self) -> frozenset[str]:
        """Of the arena's parts."""
        return frozenset(part.id for part in self.parts)


def probability_better(one: Losses, other: Losses) -> float | None:
    """The probability that the expected overall score of `one` is the greater; None where it cannot be told.

    Clusters of parts are resampled, the same for both maps where they are of the same arena; Student's t with n - 1
    degrees on the difference and its deviation, inflated by sqrt(n / (n - 1)) and UNSEEN.
    """
    paired = one.ids == other.ids
    values = [_overall(losses, 0 if paired else k) for k, losses in enumerate((one, other))]
    if any(found is None for found in values):
        return None
    (a, some, n), (b, others, m) = (found for found in values if found is not None)
    count = min(n, m)
    difference = some - others
    deviation = UNSEEN * float(np.nanstd(difference, ddof=1)) * math.sqrt(count / (count - 1))
    if deviation < 1e-12:
        return 0.5 if a == b else float(a > b)
    return float(stdtr(count - 1, (a - b) / deviation))


def _overall(losses: Losses, turn: int) -> tuple[float, FloatArray, int] | None:
    """The overall score, its replicates (B,) and the number of clusters; `turn` shifts the draws of another arena."""
    ids = [part.id for part in losses.parts]
    cluster = cluster_of(ids, [group.parts for group in losses.groups])
    count = int(cluster.max()) + 1
    if count < 2:
        return None
    every = np.concatenate([np.ones((1, count)), np.roll(draws(count), turn * 7, axis=0)])
    values = _ratios(losses, dict(zip(ids, cluster.tolist(), strict=True)), count, every)
    known = {name: (losses.weights.get(name, 0.0), found) for name, found in values.items()}
    known = {name: (w, found) for name, (w, found) in known.items() if w > 0 and math.isfinite(found[0])}
    if not known:
        return None
    total = np.stack([found for _, found in known.values()])
    weight = np.array([[w] for w, _ in known.values()]) * np.isfinite(total)
    mean = np.asarray((weight * np.nan_to_num(total)).sum(axis=0) / np.maximum(weight.sum(axis=0), 1e-12))
    return float(mean[0]), mean[1:], count


def _ratios(losses: Losses, home: Mapping[str, int], count: int, weight: FloatArray) -> dict[str, FloatArray]:
    """Attributes and classes (B,) under weights of the clusters."""
    parts = losses.parts
    found = {
        "coverage": _sums([(home[p.id], float(not p.assigned)) for p in parts], count).ratio(weight),
        "relative_accuracy": _sums([(home[p.id], p.relative) for p in parts], count).ratio(weight),
        "global_accuracy": _sums([(home[p.id], p.in_frame) for p in parts], count).ratio(weight),
    }
    for name in {group.group_class for group in losses.groups}:
        chosen = [(home[g.parts[0]], g.loss) for g in losses.groups if g.group_class == name]
        found[name] = _sums(chosen, count).ratio(weight)
    both = np.array([found[name] for name in (SHORT, LONG) if name in found])
    if len(both):
        known = np.isfinite(both)
        mean = np.nan_to_num(both).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        found["consistency"] = np.where(known.any(axis=0), mean, np.nan)
    return found


def _sums(items: Sequence[tuple[int, float | None]], count: int) -> Sums:
    known = [(k, loss) for k, loss in items if loss is not None]
    return summed(
        np.array([k for k, _ in known], np.intp), np.array([x for _, x in known], float), np.ones(len(known)), count
    )
