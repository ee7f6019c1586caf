"""`population_low` and `population_high`: the expected score of this mapper in arenas of this kind."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit  # Student's t, without the half second that scipy.stats takes to load

from fidmap.geometry import ComplexArray, as_complex
from fidmap.model import Arena, Assignment, Attributes, FloatArray, GroupResult, Settings, Span
from fidmap.scoring import clipped_loss
from fidmap.uncertainty.clusters import Indices, Sums, cluster_of, summed

REPLICATES = 200
SEED = 2011
POLISH_ROUNDS = 6
NEAREST = 1e-3  # of D: nearer parts draw no harder
NORMAL_95 = 1.959964
FEW = "fewer than two fiducials have assigned parts"


def clusters_of(arena: Arena) -> Indices:
    """(N,) the cluster of every part of an arena."""
    return cluster_of([part.id for part in arena.parts], [group.parts for group in arena.groups])


def draws(count: int) -> FloatArray:
    """Bootstrap weights (B, C): how often each cluster is drawn, `count` draws per replicate, seeded."""
    return np.random.default_rng(SEED).multinomial(count, np.full(count, 1 / count), REPLICATES).astype(float)


@dataclass(frozen=True, eq=False)
class Resampled:
    """One score over the population.

    values: (B,) under resampled clusters. span: its interval.
    """

    values: FloatArray
    span: Span


def resampled(
    attributes: Attributes, arena: Arena, assignment: Assignment, settings: Settings, cluster: Indices
) -> dict[str, Resampled]:
    """Every attribute and class ('class NAME') that is no mean of others, where it has a value."""
    weight = draws(int(cluster.max()) + 1)
    found = {"coverage": coverage(attributes, cluster, weight)}
    for name, key in (("relative_accuracy", "relative_error_m"), ("global_accuracy", "global_error_m")):
        if attributes.by_name[name].value is None:
            continue
        errors = np.array([getattr(r, key) for r in attributes.parts], float)
        loss = clipped_loss(errors, settings.rounding, arena.radius_m, settings.d_max(name, arena.radius_m))
        anew = name == "relative_accuracy"
        values = refitted(attributes, arena, assignment, settings, weight[:, cluster]) if anew else None
        found[name] = accuracy(errors, values, loss, cluster, weight)
    home = {part.id: int(k) for part, k in zip(arena.parts, cluster, strict=True)}
    for name, value in attributes.classes.items():
        if value.value is not None:
            found[f"class {name}"] = group_class(attributes, name, home, weight)
    return found


def coverage(attributes: Attributes, cluster: Indices, weight: FloatArray) -> Resampled:
    """Wilson's interval; parts of a cluster that are seen or missed together count as fewer."""
    missing = np.array([r.barrel is None for r in attributes.parts], float)
    clusters = weight.shape[1]
    table = summed(cluster, missing, np.ones(len(missing)), clusters)
    values, share = table.ratio(weight), 1 - float(missing.mean())
    low, high = wilson(share, effective(share, values, len(missing), clusters))
    return Resampled(values, Span(low, high))


def accuracy(
    errors_m: FloatArray, values: FloatArray | None, loss: FloatArray, cluster: Indices, weight: FloatArray
) -> Resampled:
    """Student's interval of 1 - mean loss over parts with an error; `values` (B,) where replicates are fitted anew."""
    known = np.isfinite(errors_m)
    table = summed(cluster[known], loss[known], np.ones(int(known.sum())), weight.shape[1])
    values = table.ratio(weight) if values is None else values
    return Resampled(values, student_span(1 - float(loss[known].mean()), values, table.clusters))


def group_class(attributes: Attributes, name: str, home: dict[str, int], weight: FloatArray) -> Resampled:
    """A class of groups: Wilson's interval for pairs with one part missing, t for the losses of the others."""
    groups = [g for g in attributes.groups if g.group_class == name and g.loss is not None]
    cluster = np.array([home[g.pairs[0].parts[0]] for g in groups], np.intp)
    gone, rest = np.array([missing_and_rest(g) for g in groups], float).T
    count, ones = weight.shape[1], np.ones(len(groups))
    lost = summed(cluster, gone, ones, count)
    kept = Sums(summed(cluster, rest, ones, count).loss, lost.count - lost.loss)
    values = summed(cluster, gone + rest, ones, count).ratio(weight)
    share, mean = float(gone.mean()), float(rest.sum() / max(1e-12, (1 - gone).sum()))
    least, most = wilson(share, effective(share, lost.ratio(weight), len(groups), lost.clusters))
    if share == 1:
        return Resampled(values, Span(1 - most, 1 - least))
    others = student_span(1 - mean, kept.ratio(weight), kept.clusters)
    if others.low is None or others.high is None:
        return Resampled(values, others)
    total = share + (1 - share) * mean
    worse = math.hypot((most - share) * (1 - mean), (1 - share) * (1 - mean - others.low))
    better = math.hypot((share - least) * (1 - mean), (1 - share) * (others.high - 1 + mean))
    return Resampled(values, Span(max(0.0, 1 - total - worse), min(1.0, 1 - total + better)))


def missing_and_rest(group: GroupResult) -> tuple[float, float]:
    """A group's loss, split: the share of its pairs with one part missing, and what the others add."""
    known = [p for p in group.pairs if p.loss is not None]
    gone = sum(p.distance_m is None for p in known) / len(known)
    return gone, sum(p.loss for p in known if p.distance_m is not None and p.loss is not None) / len(known)


def mean_of(parts: Sequence[tuple[float, float, Resampled]]) -> Resampled:
    """A weighted mean of scores (weight, value, resampled), each side of its interval from that side of theirs.

    Variances are recovered from the bounds (Zou, Donner 2008, 'Construction of confidence limits about effect
    measures'), correlations from the replicates.
    """
    if any(one.span.low is None for _, _, one in parts):
        return Resampled(parts[0][2].values, Span(reason=next(o.span.reason for _, _, o in parts if o.span.reason)))
    weight = np.array([w for w, _, _ in parts]) / sum(w for w, _, _ in parts)
    value = float(weight @ [v for _, v, _ in parts])
    every = np.stack([one.values for _, _, one in parts])
    known = every[:, np.isfinite(every).all(axis=0)]
    centred = known - known.mean(axis=1, keepdims=True)
    size = np.sqrt((centred**2).sum(axis=1)) + 1e-12
    together = (centred @ centred.T) / np.outer(size, size)
    np.fill_diagonal(together, 1.0)
    worse = weight * [v - (one.span.low or 0.0) for _, v, one in parts]
    better = weight * [(one.span.high or 0.0) - v for _, v, one in parts]
    low, high = (value + sign * math.sqrt(max(0.0, d @ together @ d)) for sign, d in ((-1, worse), (1, better)))
    values = np.where(np.isfinite(every), every, np.nanmean(every, axis=1, keepdims=True))
    return Resampled(weight @ values, Span(max(0.0, low), min(1.0, high)))


def refitted(
    attributes: Attributes, arena: Arena, assignment: Assignment, settings: Settings, weight: FloatArray
) -> FloatArray:
    """(B,) relative accuracy with weights (B, N) on the parts, the pairs as found, each replicate polished."""
    source, target, weight = _pairs(attributes, arena, assignment, weight)
    z, t = _polished(source, target, arena, assignment, settings, weight)
    distance = np.abs(z[:, None] * source + t[:, None] - target)
    d_max = settings.d_max("relative_accuracy", arena.radius_m)
    loss = clipped_loss(distance, settings.rounding, arena.radius_m, d_max)
    total = weight.sum(axis=1)
    return np.asarray(1 - np.where(total > 0, (weight * loss).sum(axis=1), np.nan) / np.maximum(total, 1))


def scale_bounds(
    attributes: Attributes, arena: Arena, assignment: Assignment, settings: Settings
) -> tuple[float, float] | None:
    """The 95 % interval of a similarity's scale, by the same replicates; None with fewer than three clusters."""
    cluster = clusters_of(arena)
    known = [r.relative_error_m is not None for r in attributes.parts]
    clusters = len(set(cluster[known].tolist()))
    if clusters < 3 or assignment.transform is None:
        return None
    weight = draws(int(cluster.max()) + 1)[:, cluster]
    source, target, weight = _pairs(attributes, arena, assignment, weight)
    weight = weight[(weight > 0).sum(axis=1) > 1]
    scales = np.abs(_polished(source, target, arena, assignment, settings, weight)[0])
    deviation = float(scales.std(ddof=1)) * math.sqrt(clusters / (clusters - 1))
    reach = float(stdtrit(clusters - 1, 0.975)) * deviation
    return assignment.transform.scale - reach, assignment.transform.scale + reach


def _pairs(
    attributes: Attributes, arena: Arena, assignment: Assignment, weight: FloatArray
) -> tuple[ComplexArray, ComplexArray, FloatArray]:
    """Assigned barrel parts (K,) and their places (K,), x + iy, with their weights (B, K) of those of all parts."""
    chosen = [i for i, r in enumerate(attributes.parts) if r.relative_error_m is not None]
    assert assignment.transform is not None
    barrels = [b for i in chosen if (b := attributes.parts[i].barrel) is not None]
    source = as_complex(np.array([(b.x_m, b.y_m) for b in barrels], float), assignment.transform.mirrored)
    target = as_complex(np.array([(arena.parts[i].x_m, arena.parts[i].y_m) for i in chosen], float))
    return source, target, weight[:, chosen]


def _polished(
    source: ComplexArray,
    target: ComplexArray,
    arena: Arena,
    assignment: Assignment,
    settings: Settings,
    weight: FloatArray,
) -> tuple[ComplexArray, ComplexArray]:
    """Placements z, t (B,) from the found one by truncated-L1 fits, all replicates at once.

    With steps, where a polish tells nothing of the score, a rigid one stays.
    """
    move, d_max = assignment.transform, settings.d_max("relative_accuracy", arena.radius_m)
    assert move is not None
    z = np.full(len(weight), move.scale * np.exp(1j * move.rotation))
    t = np.full(len(weight), complex(move.tx_m, move.ty_m))
    similar = settings.transform == "similarity"
    bounds = settings.scale_range if similar else (1.0, 1.0)
    for _ in range(POLISH_ROUNDS if settings.rounding == "none" or similar else 0):
        z, t = fitted(source, target, z, t, weight, d_max, bounds)
    return z, t


def fitted(
    source: ComplexArray,
    target: ComplexArray,
    z: ComplexArray,
    t: ComplexArray,
    weight: FloatArray,
    d_max: float,
    scale_range: tuple[float, float],
) -> tuple[ComplexArray, ComplexArray]:
    """One round of iteratively reweighted least squares over points x + iy (K,), placements z, t (B,)."""
    distance = np.abs(z[:, None] * source + t[:, None] - target)
    pull = np.where(distance < d_max, weight / np.maximum(distance, NEAREST * d_max), 0.0) + 1e-12
    pull /= pull.sum(axis=1, keepdims=True)
    middle, goal = pull @ source, pull @ target
    arms = source - middle[:, None]
    moment = (pull * arms.conj() * (target - goal[:, None])).sum(axis=1)
    size = np.abs(moment)
    spread = (pull * np.abs(arms) ** 2).sum(axis=1)
    scale = np.clip(size / np.where(spread > 0, spread, 1.0), *scale_range)
    z = np.where(size > 1e-12, scale * moment / np.where(size > 1e-12, size, 1.0), z)
    return np.asarray(z), np.asarray(goal - z * middle)


def student_span(value: float, values: FloatArray, clusters: int) -> Span:
    """Student's interval: t(n - 1) deviations of the replicates, inflated by sqrt(n / (n - 1)) for n clusters.

    Losses are skewed: the deviations are taken of the logarithm of the mean loss. Where all clusters are alike they
    say nothing, and Wilson's interval takes their place.
    """
    if clusters < 2:
        return Span(reason=FEW)
    deviation = float(np.nanstd(values, ddof=1)) * math.sqrt(clusters / (clusters - 1))
    loss = 1 - value
    if deviation < 1e-9 or loss < 1e-9:
        low, high = wilson(value, clusters)
        return Span(low, high)
    reach = min(20.0, float(stdtrit(clusters - 1, 0.975)) * deviation / loss)
    return Span(max(0.0, 1 - loss * math.exp(reach)), 1 - loss * math.exp(-reach))


def effective(share: float, values: FloatArray, items: int, clusters: int) -> float:
    """How many independent items a share comes from: fewer where clusters agree within themselves."""
    variance = float(np.nanvar(values)) * clusters / max(1, clusters - 1)
    n = share * (1 - share) / variance if variance > 0 else float(clusters)
    return min(max(n, clusters), items)


def wilson(share: float, n: float) -> tuple[float, float]:
    """Wilson's 95 % interval of a share of n (Wilson 1927, 'Probable inference')."""
    z2 = NORMAL_95**2
    middle = (share + z2 / (2 * n)) / (1 + z2 / n)
    reach = NORMAL_95 / (1 + z2 / n) * math.sqrt(share * (1 - share) / n + z2 / (4 * n**2))
    return max(0.0, middle - reach), min(1.0, middle + reach)
