"""Both intervals: what must hold of them whatever the map, and what known noise must give."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fidmap.attributes import attributes
from fidmap.evaluate import evaluate_points
from fidmap.model import CONTINUOUS, SSRR2011, Arena, Attributes, BarrelPart, Group, Settings, Span, Transform
from fidmap.register import register
from fidmap.report.json_line import report_document
from fidmap.uncertainty import NO_SIGMA, with_intervals
from fidmap.uncertainty.clusters import cluster_of
from fidmap.uncertainty.measurement import accuracy_bounds, fit_leverage
from fidmap.uncertainty.population import FEW, wilson
from fiducials import drawn, pairs_arena
from sample_report import SETTINGS_DOCUMENT

GROUPS = tuple(Group(str(k), (f"{k}A", f"{k}B"), "short" if k < 4 else "long") for k in range(1, 6))


def arena_with(survey_m: float = 0.02) -> Arena:
    arena = pairs_arena(groups=GROUPS)
    return replace(arena, parts=tuple(replace(p, sigma_m=survey_m) for p in arena.parts))


def map_of(arena: Arena, noise_m: float, sigma_m: float | None, seed: int = 0) -> tuple[BarrelPart, ...]:
    return tuple(replace(p, sigma_m=sigma_m) for p in drawn(arena, Transform(0.4, 2, -1), noise_m, seed))


def scored(arena: Arena, parts: tuple[BarrelPart, ...], profile: Settings = CONTINUOUS) -> Attributes:
    assignment = register(parts, arena, profile, fast=True)
    return with_intervals(attributes(parts, arena, assignment, profile), arena, assignment, profile)


def spans(found: Attributes, kind: str) -> dict[str, Span]:
    every = {**found.by_name, **found.classes, "overall": found.overall}
    return {name: getattr(v.interval, kind) for name, v in every.items() if v.interval is not None}


def plain(found: Attributes) -> dict[str, tuple[float | None, ...]]:
    return {
        f"{kind} {name}": (one.low, one.high)
        for kind in ("measurement", "population")
        for name, one in spans(found, kind).items()
    }


@pytest.mark.parametrize("profile", [CONTINUOUS, SSRR2011])
@pytest.mark.parametrize("seed", range(3))
def test_bounds_are_ordered_fractions_and_the_population_holds_the_score(profile: Settings, seed: int) -> None:
    arena = arena_with()
    parts = map_of(arena, 0.2, 0.02, seed)[: 10 - seed]
    found = scored(arena, parts, profile)
    every = {**found.by_name, **found.classes, "overall": found.overall}
    for kind in ("measurement", "population"):
        for name, one in spans(found, kind).items():
            if one.low is None or one.high is None:
                assert one.reason, name
                continue
            assert 0 <= one.low <= one.high <= 1, name
            if kind == "population":
                assert one.low - 1e-9 <= (every[name].value or 0) <= one.high + 1e-9, name


def test_without_noise_the_measurement_is_exact() -> None:
    arena = arena_with(0.0)
    found = scored(arena, map_of(arena, 0.1, 0.0))
    for name in ("coverage", "relative_accuracy", "consistency"):
        value = found.by_name[name]
        assert value.interval is not None
        assert value.interval.measurement == Span(pytest.approx(value.value), pytest.approx(value.value))


def test_a_perfect_map_is_not_refuted_by_a_rough_survey() -> None:
    """All errors are the survey's own: 100 % must stay possible, although the score is lower."""
    arena = arena_with(0.05)
    held = 0
    for seed in range(40):
        found = scored(arena, map_of(arena, 0.05, 0.001, seed)).by_name["relative_accuracy"]
        assert found.value is not None
        assert found.interval is not None
        held += (found.interval.measurement.high or 0) > 1 - 1e-9
    assert held >= 34


def test_rougher_surveys_give_wider_measurements_and_the_same_population() -> None:
    fine, rough = (scored(a := arena_with(s), map_of(a, 0.15, 0.01)) for s in (0.005, 0.05))
    for name in ("relative_accuracy", "consistency", "overall"):
        a, b = (spans(f, "measurement")[name] for f in (fine, rough))
        assert (b.high or 0) - (b.low or 0) > 1.5 * ((a.high or 0) - (a.low or 0)) > 0
    assert spans(fine, "population") == spans(rough, "population")


def test_the_order_of_parts_groups_and_arcs_does_not_matter() -> None:
    arena = arena_with()
    parts = map_of(arena, 0.15, 0.02)[:9]
    expected = plain(scored(arena, parts))
    shuffle = Random(3)
    for _ in range(3):
        fiducials, groups, arcs = list(arena.parts), list(arena.groups), list(parts)
        for one in (fiducials, groups, arcs):
            shuffle.shuffle(one)
        mixed = scored(replace(arena, parts=tuple(fiducials), groups=tuple(groups)), tuple(arcs))
        assert plain(mixed) == {k: pytest.approx(v, abs=1e-9, nan_ok=False) for k, v in expected.items()}
    assert plain(scored(arena, parts)) == expected


def test_parts_without_sigma_leave_the_measurement_open_and_say_why() -> None:
    arena = arena_with()
    found = scored(arena, map_of(arena, 0.1, None))
    assert set(spans(found, "measurement").values()) == {Span(reason=NO_SIGMA)}
    assert spans(found, "population")["overall"].low is not None


def test_the_report_has_every_bound_or_its_reason() -> None:
    arena = arena_with()
    for sigma_m in (None, 0.02):
        report = evaluate_points(map_of(arena, 0.1, sigma_m), arena, fast=True)
        entries = report_document(report, SETTINGS_DOCUMENT, 0.1)["attributes"]
        entries = {**entries, **entries["consistency"]["classes"]}
        for entry in entries.values():
            for key in ("low", "high", "population_low", "population_high"):
                if entry["value"] is not None:
                    assert isinstance(entry[key], float) or entry[f"{key}_reason"]


def test_one_cluster_has_no_population() -> None:
    arena = arena_with()
    tied = replace(arena, groups=(Group("all", tuple(p.id for p in arena.parts), "short"),))
    found = scored(tied, map_of(tied, 0.1, 0.02))
    assert spans(found, "population")["overall"] == Span(reason=FEW)
    assert cluster_of(["b", "a", "c", "d"], [("d", "b"), ("b", "c")]).tolist() == [1, 0, 1, 1]


def test_wilson_by_hand() -> None:
    """8 of 10: (0.8 + 0.19207 +- 1.96 sqrt(0.016 + 0.0096)) / 1.38415 (Wilson 1927)."""
    assert wilson(0.8, 10) == (pytest.approx(0.4902, abs=1e-4), pytest.approx(0.9433, abs=1e-4))
    assert wilson(1.0, 10) == (pytest.approx(10 / (10 + 1.959964**2), abs=1e-6), pytest.approx(1.0))


def test_leverages_sum_to_the_freedoms_of_a_fit() -> None:
    """Per axis, so half of them: 3 of a rigid move, 4 of a similarity."""
    places = np.random.default_rng(5).normal(size=(20, 2)) * 4
    assert float(fit_leverage(places, 3).sum()) == pytest.approx(1.5)
    assert float(fit_leverage(places, 4).sum()) == pytest.approx(2.0)


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(0, 3), min_size=1, max_size=12), st.floats(1e-4, 0.3), st.integers(0, 5))
def test_any_errors_give_ordered_bounds(errors: list[float], sigma: float, seed: int) -> None:
    noise = sigma * np.random.default_rng(seed).uniform(0.5, 1, len(errors))
    low, high, _ = accuracy_bounds(np.array(errors), noise, lambda d: np.minimum(d, 1.2) / 1.2, 1.2)
    assert -1e-6 <= low <= high <= 1 + 1e-6


def test_measurement_intervals_hold_about_as_often_as_they_say() -> None:
    """300 sets of 30 errors of 5 cm seen through noise of 4 cm: 95 % within four standard errors."""
    random = np.random.default_rng(7)
    held = 0
    for _ in range(300):
        true = random.normal(0, 0.05, (30, 2))
        seen = np.linalg.norm(true + random.normal(0, 0.04, (30, 2)), axis=1)
        low, high, _ = accuracy_bounds(seen, np.full(30, 0.04), lambda d: np.minimum(d, 1.2) / 1.2, 1.2)
        held += low <= 1 - float(np.linalg.norm(true, axis=1).mean()) / 1.2 <= high
    assert abs(held / 300 - 0.95) < 4 * math.sqrt(0.95 * 0.05 / 300)


@pytest.mark.parametrize(("size", "told"), [(1.05, "large"), (0.96, "small"), (1.0, None)])
def test_a_scale_is_told_where_its_interval_excludes_1(size: float, told: str | None) -> None:
    """Drawn 5 % too large, with 2 cm of noise: told with its interval, but only where a scale was searched."""
    arena = arena_with()
    parts = tuple(replace(p, sigma_m=0.02) for p in drawn(arena, Transform(0.3, 1, 2, scale=size), 0.02, 4))
    similar = replace(CONTINUOUS, transform="similarity")
    texts = [f.text for f in evaluate_points(parts, arena, similar, fast=True).findings if f.code == "scale"]
    assert len(texts) == (told is not None)
    for text in texts:
        percent, word = re.match(r"the map is drawn (\S+) % too (\w+): ", text).groups()
        assert word == told
        assert float(percent) == pytest.approx(100 * abs(size - 1), abs=1)
    assert not [f for f in evaluate_points(parts, arena, fast=True).findings if f.code == "scale"]


def test_the_pairs_of_a_class_may_all_be_short_or_measured_by_tape() -> None:
    """Walls of 4 cm: their distances are far below the noise; a tape's have the noise of one survey."""
    arena = arena_with(0.05)
    tape = replace(arena, groups=tuple(replace(g, distance_m=0.04) for g in arena.groups))
    for one in (arena, tape):
        found = spans(scored(one, map_of(one, 0.02, 0.02)), "measurement")["consistency"]
        assert found.low is not None
        assert 0.8 < found.low < (found.high or 0) <= 1


def test_with_steps_bounds_are_whole_steps_apart() -> None:
    """The profile of the paper: one of eight parts without error may still be a step off, hardly four."""
    low, high, _ = accuracy_bounds(
        np.full(8, 0.1), np.full(8, 0.03), lambda d: np.minimum(np.floor(d / 0.3 + 0.5) * 0.3, 1.2) / 1.2, 1.2
    )
    assert high == pytest.approx(1)
    assert 1 - 4 * 0.25 / 8 < low <= 1 - 0.25 / 8
