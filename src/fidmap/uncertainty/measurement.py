"""`low` and `high`: between which bounds the score would lie had survey and centres been free of error."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fidmap.geometry import apply
from fidmap.model import (
    Arena,
    Assignment,
    Attributes,
    FloatArray,
    PairResult,
    Settings,
    Span,
)
from fidmap.scoring import clipped_loss
from fidmap.uncertainty.posterior import (
    FAR,
    Nodes,
    beliefs_about_distances,
    beliefs_about_positions,
    joined,
    mean_loss,
    nodes,
    rice,
)

# lengths that a surveyed distance may truly have, looked at per pair
LENGTHS, VERSIONS = 64, 3
# correlation of two attributes' measurement errors: both come from the same centres
SHARED = 0.3
NO_NOISE = 1e-9


class Bounds(NamedTuple):
    """Between which a score truly lies; whether it may lie at its upper bound exactly, without any error."""

    low: float
    high: float
    without_error: bool


def bounds_of(losses: tuple[float, float], certain: float) -> Bounds:
    """Of a score from the bounds of what noise bears on of its loss, the rest of it being certain."""
    least, most = losses
    return Bounds(1 - certain - most, 1 - certain - least, least <= 0)


@dataclass(frozen=True, eq=False)
class Noise:
    """Standard deviations per axis, metres: of the survey (N,), and of the assigned barrel parts (N,), NaN for none."""

    survey: FloatArray
    centres: FloatArray

    @property
    def both(self) -> FloatArray:
        """(N,) of the difference of the two positions."""
        return np.hypot(self.survey, self.centres)


def noise_of(attributes: Attributes, arena: Arena, settings: Settings) -> Noise | None:
    """The noise behind a score; None where some assigned barrel part does not say its own."""
    survey = [settings.survey_sigma_m if p.sigma_m is None else p.sigma_m for p in arena.parts]
    barrels = [r.barrel for r in attributes.parts]
    if any(b is not None and b.sigma_m is None for b in barrels):
        return None
    centres = [math.nan if b is None or b.sigma_m is None else b.sigma_m for b in barrels]
    return Noise(np.array(survey, float), np.array(centres, float))


def accuracy_bounds(
    errors_m: FloatArray, sigma: FloatArray, loss: Callable[[FloatArray], FloatArray], d_max: float
) -> Bounds:
    """Bounds of 1 - mean loss over errors in the plane (K,), measured with noise (K,) per axis."""
    share = np.full(len(errors_m), 1 / len(errors_m))
    if sigma.max() < NO_NOISE:
        exact = float(loss(errors_m).mean())
        return bounds_of((exact, exact), 0.0)
    grid = nodes(errors_m, sigma, d_max)
    sigma = np.maximum(sigma, grid.at[16])
    near = np.minimum(errors_m, d_max + FAR * sigma)
    beliefs = beliefs_about_positions(grid, float(sigma.min()), d_max)
    likelihood = rice(near[:, None], sigma[:, None], grid.at[None])
    return bounds_of(mean_loss(likelihood, beliefs, loss(grid.at), share, 1.0).span(), 0.0)


def fit_leverage(places: FloatArray, freedoms: int) -> FloatArray:
    """(K,) share of a part's own noise, per axis, that a fit of the plane takes up; places (K, 2), 3 or 4 freedoms.

    That of least squares; a fit of capped distances takes up much the same.
    """
    arms = ((places - places.mean(axis=0)) ** 2).sum(axis=1)
    turn = arms / arms.sum() if arms.sum() > 0 else np.zeros(len(places))
    return np.asarray(np.minimum(1 / len(places) + (freedoms - 2) / 2 * turn, 1.0))


def relative_bounds(
    attributes: Attributes, arena: Arena, assignment: Assignment, settings: Settings, noise: Noise
) -> Bounds:
    """Bounds of relative accuracy; the fit has already taken up its share of the noise."""
    chosen = [i for i, r in enumerate(attributes.parts) if r.relative_error_m is not None]
    results = [attributes.parts[i] for i in chosen]
    barrels = [r.barrel for r in results if r.barrel is not None]
    own = np.array([(b.x_m, b.y_m) for b in barrels], float)
    move = assignment.transform
    assert move is not None
    sigma = np.hypot(noise.survey[chosen], move.scale * noise.centres[chosen])
    freedoms = 4 if settings.transform == "similarity" else 3
    sigma = sigma * np.sqrt(1 - fit_leverage(apply(move, own), freedoms))
    errors = np.array([r.relative_error_m for r in results], float)
    d_max = settings.d_max("relative_accuracy", arena.radius_m)
    bounds = accuracy_bounds(errors, sigma, _loss(settings, arena, "relative_accuracy"), d_max)
    return _with_flips(bounds, errors, sigma, [b.fixed_id for b in barrels], d_max)


def _with_flips(
    bounds: Bounds, errors: FloatArray, sigma: FloatArray, fixed: Sequence[str | None], d_max: float
) -> Bounds:
    """Wider where parts so near to D may truly not be assigned: without them the mean is higher."""
    free = np.array([name is None for name in fixed], bool)
    flips = int((free & (errors > d_max - 1.96 * sigma)).sum())
    count = len(errors)
    if not 0 < flips < count:
        return bounds
    return bounds._replace(high=min(1.0, bounds.high * count / (count - flips)))


def global_bounds(attributes: Attributes, arena: Arena, settings: Settings, noise: Noise) -> Bounds:
    """Bounds of global accuracy."""
    chosen = [i for i, r in enumerate(attributes.parts) if r.global_error_m is not None]
    errors = np.array([attributes.parts[i].global_error_m for i in chosen], float)
    d_max = settings.d_max("global_accuracy", arena.radius_m)
    return accuracy_bounds(errors, noise.both[chosen], _loss(settings, arena, "global_accuracy"), d_max)


def coverage_bounds(attributes: Attributes, arena: Arena, settings: Settings, noise: Noise) -> Bounds:
    """Bounds of coverage: parts whose distance is within the noise of D may truly not be assigned."""
    value = attributes.by_name["coverage"].value
    assert value is not None
    d_max = settings.d_max("relative_accuracy", arena.radius_m)
    flips = 0
    for result, sigma in zip(attributes.parts, noise.both, strict=True):
        fixed = result.barrel is not None and result.barrel.fixed_id is not None
        far = result.relative_error_m is not None and result.relative_error_m > d_max - 1.96 * sigma
        flips += far and not fixed
    return Bounds(value - flips / len(attributes.parts), value, True)


def class_bounds(attributes: Attributes, arena: Arena, settings: Settings, noise: Noise, name: str) -> Bounds:
    """Bounds of one class of groups; a pair with one part missing counts 1 for certain."""
    groups = [g for g in attributes.groups if g.group_class == name and g.loss is not None]
    pairs, shares, certain = [], [], 0.0
    for group in groups:
        known = [p for p in group.pairs if p.loss is not None]
        for pair in known:
            share = 1 / (len(groups) * len(known))
            if pair.distance_m is None:
                certain += share
            else:
                pairs.append(pair)
                shares.append(share)
    if not pairs:
        return bounds_of((0.0, 0.0), certain)
    index = {part.id: i for i, part in enumerate(arena.parts)}
    taped = {frozenset(g.parts) for g in arena.groups if g.distance_m is not None}
    survey = [_sigma(noise.survey, index, p) for p in pairs]
    tape = np.array([frozenset(p.parts) in taped for p in pairs], bool)
    centres = [_sigma(noise.centres, index, p) for p in pairs]
    losses = _distance_losses(
        pairs, np.where(tape, np.array(survey) / math.sqrt(2), survey), np.array(centres), tape,
        np.array(shares), _loss(settings, arena, "consistency"), settings.d_max("consistency", arena.radius_m),
    )  # fmt: skip
    return bounds_of(losses, certain)


def combined(parts: Sequence[tuple[float, Bounds]], shared: float) -> Bounds:
    """Bounds of a weighted mean from those of its parts (weight, bounds), whose errors are correlated by `shared`.

    Half widths add as deviations do; where the upper bounds are those of no error at all, all may be reached at once.
    """
    total = sum(weight for weight, _ in parts)
    middle = sum(w * (b.low + b.high) / 2 for w, b in parts) / total
    half = np.array([w * (b.high - b.low) / 2 / total for w, b in parts])
    best = np.array([b.without_error for _, b in parts], bool)

    def reach(one: FloatArray) -> float:
        return math.sqrt((1 - shared) * float((one**2).sum()) + shared * float(one.sum()) ** 2)

    return Bounds(middle - reach(half), middle + reach(half[~best]) + float(half[best].sum()), bool(best.all()))


def span(bounds: Bounds) -> Span:
    """Bounds as a span of a score."""
    return Span(max(0.0, min(1.0, bounds.low)), max(0.0, min(1.0, bounds.high)))


def _loss(settings: Settings, arena: Arena, attribute: str) -> Callable[[FloatArray], FloatArray]:
    d_max = settings.d_max(attribute, arena.radius_m)
    return lambda d: clipped_loss(np.abs(d), settings.rounding, arena.radius_m, d_max)


def _sigma(per_part: FloatArray, index: dict[str, int], pair: PairResult) -> float:
    """Noise per axis of the difference between the two parts of a pair."""
    return float(np.hypot(*per_part[[index[one] for one in pair.parts]]))


def _distance_losses(
    pairs: Sequence[PairResult],
    survey: FloatArray,
    centres: FloatArray,
    tape: FloatArray,
    share: FloatArray,
    loss: Callable[[FloatArray], FloatArray],
    d_max: float,
) -> tuple[float, float]:
    """Bounds of the weighted sum of the losses of pairs (K,)."""
    drawn = np.array([p.distance_m for p in pairs], float)
    expected = np.array([p.expected_m for p in pairs], float)
    sigma = np.hypot(survey, centres)
    if sigma.max() < NO_NOISE:
        exact = float(share @ loss(drawn - expected))
        return exact, exact
    grid = nodes(np.abs(drawn - expected), sigma, d_max)
    losses, sigma = loss(grid.mirrored.at), np.maximum(sigma, grid.at[16])
    near = np.minimum(drawn, expected) < 2 * FAR * sigma  # there noise makes lengths longer
    error = np.clip(drawn - expected, -d_max - FAR * sigma, d_max + FAR * sigma)
    likelihood = np.exp(-(((error[:, None] - grid.mirrored.at) / sigma[:, None]) ** 2) / 2)
    found = []
    for true, chance in _lengths(expected[near], survey[near], tape[near]) if near.any() else [(None, None)]:
        length = None
        if true is not None and chance is not None:
            likelihood[near] = _seen(drawn[near], centres[near], true, chance, grid.mirrored)
            length = float((chance @ true).mean()) if near.all() else None
        beliefs = beliefs_about_distances(grid.mirrored, float(sigma.min()), d_max, length)
        found.append(mean_loss(likelihood, beliefs, losses, share, _reuse(pairs)))
    return joined(found).span()


def _seen(drawn: FloatArray, centres: FloatArray, true: FloatArray, chance: FloatArray, grid: Nodes) -> FloatArray:
    """(K, G) likelihood of every error of pairs that are drawn so far apart, over their true lengths (A,)."""
    centres = np.maximum(centres, true[1])  # what lies between two lengths is seen as one of them
    length = true[:, None] + grid.at[None]
    possible, length = length >= 0, np.maximum(length, 0)
    seen = [
        weight @ np.where(possible, rice(d, s, length), 0.0)
        for d, s, weight in zip(drawn, centres, chance, strict=True)
    ]
    return np.array(seen) + 1e-300


def _lengths(expected: FloatArray, survey: FloatArray, tape: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """Lengths (A,) that pairs truly may have and their chances (K, A) after the survey, in a few alike versions.

    Walls of an arena are alike: how their lengths are spread is learned from all of them (as in `mean_loss`), over
    normal spreads, so that a rough survey does not make each of them longer. What the survey leaves open of their mean,
    all of them share: each version has another one.
    """
    top = float((expected + 4 * survey).max())
    true = np.linspace(0, top, LENGTHS)
    survey = np.maximum(survey, true[1])
    surveyed = rice(expected[:, None], survey[:, None], true)
    taped = np.exp(-(((expected[:, None] - true) / survey[:, None]) ** 2) / 2)
    likelihood = np.where(tape[:, None], taped, surveyed)
    spreads = np.geomspace(top / LENGTHS, top, 8)
    family = np.exp(-(((true - true[:, None, None]) / spreads[:, None]) ** 2) / 2).reshape(-1, len(true))
    family /= family.sum(axis=1, keepdims=True)
    log = np.log(likelihood @ family.T + 1e-300).sum(axis=0)
    weight = np.exp(log - log.max())
    order = np.argsort(family @ true, kind="stable")
    before = np.cumsum(weight[order]) / weight.sum() - weight[order] / weight.sum()
    versions = []
    for k in range(VERSIONS):
        chosen = order[(before >= k / VERSIONS) & (before < (k + 1) / VERSIONS)]
        if len(chosen):
            chance = likelihood * (weight[chosen] @ family[chosen] / weight[chosen].sum())
            versions.append((true, chance / (chance.sum(axis=1, keepdims=True) + 1e-300)))
    return versions


def _reuse(pairs: Sequence[PairResult]) -> float:
    """In how many pairs a part stands on average: so much wider, since those pairs share its noise."""
    uses = Counter(one for pair in pairs for one in pair.parts)
    return sum(uses[one] for pair in pairs for one in pair.parts) / (2 * len(pairs))
