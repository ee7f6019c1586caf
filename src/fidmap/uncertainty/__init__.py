"""How sure every score is: two 95 % intervals that are never mixed.

Measurement: the score that this map in this arena would have with an error-free survey and error-free centres.
Population: the expected score of this mapper over arenas of this kind with as many parts.
"""

from __future__ import annotations

from dataclasses import replace

from fidmap.model import (
    Arena,
    Assignment,
    Attributes,
    Interval,
    Settings,
    Span,
    Value,
)
from fidmap.uncertainty import measurement, population
from fidmap.uncertainty.measurement import Bounds, Noise

__all__ = ["with_intervals"]

NO_SIGMA = "barrel parts without sigma_m are assigned; give it for every one in the points file"
NO_MODEL = "how survey and centres bear on it is not known"
NO_PART = "a part of it has no interval"
CONSISTENT = ("short", "long")


def with_intervals(attributes: Attributes, arena: Arena, assignment: Assignment, settings: Settings) -> Attributes:
    """The attributes with both intervals beside every value that could be computed."""
    measured = _measured(attributes, arena, assignment, settings)
    expected = _expected(attributes, arena, assignment, settings)

    def joined(key: str, value: Value) -> Value:
        if value.value is None:
            return value
        return replace(value, interval=Interval(measured[key], expected[key]))

    return replace(
        attributes,
        by_name={name: joined(name, value) for name, value in attributes.by_name.items()},
        classes={name: joined(f"class {name}", value) for name, value in attributes.classes.items()},
        overall=joined("overall", attributes.overall),
    )


def _measured(attributes: Attributes, arena: Arena, assignment: Assignment, settings: Settings) -> dict[str, Span]:
    """Measurement spans of all that could be computed, classes as 'class NAME'."""
    names = _computable(attributes)
    noise = measurement.noise_of(attributes, arena, settings)
    if noise is None:
        return dict.fromkeys(names, Span(reason=NO_SIGMA))
    bounds = _bounds(attributes, arena, assignment, settings, noise)
    found = {name: measurement.span(one) for name, one in bounds.items()}
    found["resolution_quality"] = Span(reason=NO_MODEL)
    weighed = _weighed(attributes, settings)
    if all(name in bounds for name in weighed):
        parts = [(weight, bounds[name]) for name, weight in weighed.items()]
        found["overall"] = measurement.span(measurement.combined(parts, measurement.SHARED))
    return {name: found.get(name, Span(reason=NO_PART)) for name in names}


def _bounds(
    attributes: Attributes, arena: Arena, assignment: Assignment, settings: Settings, noise: Noise
) -> dict[str, Bounds]:
    """Measurement bounds of the attributes and classes, not of their mean."""
    by_name = attributes.by_name
    found = {"coverage": measurement.coverage_bounds(attributes, arena, settings, noise)}
    if by_name["relative_accuracy"].value is not None:
        found["relative_accuracy"] = measurement.relative_bounds(attributes, arena, assignment, settings, noise)
    if by_name["global_accuracy"].value is not None:
        found["global_accuracy"] = measurement.global_bounds(attributes, arena, settings, noise)
    for name, value in attributes.classes.items():
        if value.value is not None:
            found[f"class {name}"] = measurement.class_bounds(attributes, arena, settings, noise, name)
    known = [found[f"class {name}"] for name in CONSISTENT if f"class {name}" in found]
    if known:
        found["consistency"] = measurement.combined([(1.0, one) for one in known], 0.0)
    return found


def _expected(attributes: Attributes, arena: Arena, assignment: Assignment, settings: Settings) -> dict[str, Span]:
    """Population spans of all that could be computed, classes as 'class NAME'."""
    values = _computable(attributes)
    cluster = population.clusters_of(arena)
    if int(cluster.max()) < 1:
        return dict.fromkeys(values, Span(reason=population.FEW))
    found = population.resampled(attributes, arena, assignment, settings, cluster)
    known = [n for n in CONSISTENT if f"class {n}" in found]
    if known:
        found["consistency"] = population.mean_of([(1.0, values[f"class {n}"], found[f"class {n}"]) for n in known])
    weighed = _weighed(attributes, settings)
    if weighed and all(name in found for name in weighed):
        found["overall"] = population.mean_of([(w, values[n], found[n]) for n, w in weighed.items()])
    return {name: found[name].span if name in found else Span(reason=NO_PART) for name in values}


def _computable(attributes: Attributes) -> dict[str, float]:
    """Every score that has a value."""
    every = {**attributes.by_name, **{f"class {n}": v for n, v in attributes.classes.items()}}
    every["overall"] = attributes.overall
    return {name: value.value for name, value in every.items() if value.value is not None}


def _weighed(attributes: Attributes, settings: Settings) -> dict[str, float]:
    """Weights of what the overall score is a mean of."""
    known = _computable(attributes)
    keys = {n: n if n in attributes.by_name else f"class {n}" for n in settings.weights}
    return {keys[n]: w for n, w in settings.weights.items() if w > 0 and keys[n] in known}
