"""Assignment -> attributes: the scores of the Fiducial Map Metric (SSRR 2011, II-B)."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from fidmap.geometry import apply, apply_inverse
from fidmap.model import (
    ATTRIBUTES,
    LONG,
    SHORT,
    Arena,
    Assignment,
    Attributes,
    BarrelPart,
    FloatArray,
    Group,
    GroupResult,
    PairResult,
    PartResult,
    Settings,
    Value,
)
from fidmap.scoring import clipped_loss

NOTHING_ASSIGNED = "no part is assigned"


def attributes(parts: tuple[BarrelPart, ...], arena: Arena, assignment: Assignment, settings: Settings) -> Attributes:
    """All attributes, what became of each part and group, and the weighted mean."""
    results = part_results(parts, arena, assignment)
    groups = group_results(results, arena, settings)
    classes = class_consistency(groups)
    by_name = {
        "coverage": coverage(results),
        "relative_accuracy": relative_accuracy(results, arena, settings),
        "consistency": consistency(classes),
        "global_accuracy": global_accuracy(results, arena, settings),
        "resolution_quality": resolution_quality(results, arena),
    }
    overall, missing = weighted_mean(by_name, classes, settings)
    return Attributes(by_name, classes, overall, missing, results, groups)


def coverage(results: tuple[PartResult, ...]) -> Value:
    """Assigned fiducial parts / all fiducial parts (SSRR 2011, II-B-4)."""
    return Value(sum(r.barrel is not None for r in results) / len(results))


def mean_accuracy(errors_m: FloatArray, settings: Settings, radius_m: float, attribute: str) -> Value:
    """1 - mean of min(q(d), D)/D over errors (K,) in metres (SSRR 2011, II-B-1)."""
    if len(errors_m) == 0:
        return Value(None, NOTHING_ASSIGNED)
    loss = clipped_loss(errors_m, settings.rounding, radius_m, settings.d_max(attribute, radius_m))
    return Value(float(1 - loss.mean()))


def relative_accuracy(results: tuple[PartResult, ...], arena: Arena, settings: Settings) -> Value:
    """Accuracy of the assigned parts after the registration (SSRR 2011, II-B-2)."""
    if not arena.has_positions:
        return Value(None, "the arena has no positions")
    errors = np.array([r.relative_error_m for r in results if r.relative_error_m is not None], float)
    return mean_accuracy(errors, settings, arena.radius_m, "relative_accuracy")


def global_accuracy(results: tuple[PartResult, ...], arena: Arena, settings: Settings) -> Value:
    """Accuracy of the assigned parts where they are, in the agreed frame (SSRR 2011, II-B-1)."""
    if not arena.has_positions:
        return Value(None, "the arena has no positions")
    if arena.frame != "map":
        return Value(None, "the arena's frame is relative")
    errors = np.array([r.global_error_m for r in results if r.global_error_m is not None], float)
    return mean_accuracy(errors, settings, arena.radius_m, "global_accuracy")


def resolution_quality(results: tuple[PartResult, ...], arena: Arena) -> Value:
    """Median over assigned arcs of 1 - min(1, s/(R/2)), s the radial spread of an arc's cells beyond the raster.

    The paper names the attribute without a formula (SSRR 2011, I); this one is ours.
    """
    barrels = [r.barrel for r in results if r.barrel is not None]
    if not barrels:
        return Value(None, NOTHING_ASSIGNED)
    spreads = [b.spread_m for b in barrels if b.spread_m is not None]
    if not spreads:
        return Value(None, "the parts were located by hand, not in a map")
    return Value(float(np.median(1 - np.minimum(1, np.array(spreads) / (arena.radius_m / 2)))))


def class_consistency(groups: tuple[GroupResult, ...]) -> dict[str, Value]:
    """Per class 1 - mean loss of its groups with at least one assigned part (SSRR 2011, II-B-3)."""
    values = {}
    for name in sorted({g.group_class for g in groups}, key=lambda c: ((SHORT, LONG, c).index(c), c)):
        losses = [g.loss for g in groups if g.group_class == name and g.loss is not None]
        reason = "no group of this class has an assigned part"
        values[name] = Value(float(1 - np.mean(losses))) if losses else Value(None, reason)
    return values


def consistency(classes: dict[str, Value]) -> Value:
    """Mean of the computable ones of short and long range (SSRR 2011, IV)."""
    if not {SHORT, LONG} & set(classes):
        return Value(None, "the arena has no short or long groups")
    known = [v.value for name, v in classes.items() if name in {SHORT, LONG} and v.value is not None]
    return Value(float(np.mean(known))) if known else Value(None, "no short or long group has an assigned part")


def weighted_mean(
    by_name: dict[str, Value], classes: dict[str, Value], settings: Settings
) -> tuple[Value, tuple[str, ...]]:
    """Overall score: weighted mean of the computable attributes, and the names of those left out.

    Weights of what cannot be computed are shared among the rest (SSRR 2011, I: attributes are weighed by need).
    """
    values = by_name | {name: v for name, v in classes.items() if name not in by_name}
    wanted = {name: weight for name, weight in settings.weights.items() if weight > 0}
    missing = [name for name in ATTRIBUTES if by_name[name].value is None]
    missing += [name for name in wanted if name not in by_name and values.get(name, Value(None)).value is None]
    known = {n: (w, v) for n, w in wanted.items() if n in values and (v := values[n].value) is not None}
    if not known:
        return Value(None, "none of the weighted attributes can be computed"), tuple(missing)
    total = sum(weight for weight, _ in known.values())
    return Value(float(sum(weight * value for weight, value in known.values()) / total)), tuple(missing)


def part_results(parts: tuple[BarrelPart, ...], arena: Arena, assignment: Assignment) -> tuple[PartResult, ...]:
    """Errors of the assigned parts and the expected places of all parts, in the map's frame."""
    move = assignment.transform
    results = []
    for fiducial, j in zip(arena.parts, assignment.barrel_of, strict=True):
        truth = np.array([[fiducial.x_m, fiducial.y_m]], float)
        expected = apply_inverse(move, truth)[0] if move is not None else [None, None]
        relative = global_ = None
        if j is not None and move is not None:
            own = np.array([[parts[j].x_m, parts[j].y_m]])
            relative = float(np.linalg.norm(apply(move, own) - truth))
            global_ = float(np.linalg.norm(own - truth)) if arena.frame == "map" else None
        x, y = (None if e is None else float(e) for e in expected)
        results.append(PartResult(fiducial.id, None if j is None else parts[j], relative, global_, x, y))
    return tuple(results)


def group_results(results: tuple[PartResult, ...], arena: Arena, settings: Settings) -> tuple[GroupResult, ...]:
    """Distances and losses of all groups; a group's loss is the mean over its pairs with an assigned part."""
    barrel = {r.id: r.barrel for r in results}
    found = []
    for group in arena.groups:
        pairs = tuple(
            _pair(a, b, barrel, expected_distance(group, arena, a, b), settings, arena.radius_m)
            for a, b in combinations(group.parts, 2)
        )
        losses = [p.loss for p in pairs if p.loss is not None]
        group_class = group.resolved_class(settings.long_if_walking_pallets_over)
        found.append(GroupResult(group.id, group_class, pairs, float(np.mean(losses)) if losses else None))
    return tuple(found)


def expected_distance(group: Group, arena: Arena, a: str, b: str) -> float:
    """The true distance between two parts: measured on its own where given, else from their positions; metres."""
    if group.distance_m is not None:
        return group.distance_m
    where = {part.id: np.array([part.x_m, part.y_m], float) for part in arena.parts if part.id in {a, b}}
    return float(np.linalg.norm(where[a] - where[b]))


def _pair(
    a: str, b: str, barrel: dict[str, BarrelPart | None], expected: float, settings: Settings, radius_m: float
) -> PairResult:
    """Error and loss of one pair: 1 when one part is missing, None when both are (SSRR 2011, II-B-3)."""
    one, other = barrel[a], barrel[b]
    if one is None or other is None:
        return PairResult((a, b), None, expected, None, None if one is other else 1.0)
    distance = float(np.hypot(one.x_m - other.x_m, one.y_m - other.y_m))
    error = abs(distance - expected)
    d_max = settings.d_max("consistency", radius_m)
    return PairResult(
        (a, b),
        distance,
        expected,
        error,
        float(clipped_loss(np.array(error), settings.rounding, radius_m, d_max)),
    )
