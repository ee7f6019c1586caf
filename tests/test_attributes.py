"""Every attribute by hand: what each formula gives on arenas of two to six parts."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from fidmap.attributes import attributes
from fidmap.model import CONTINUOUS, SSRR2011, Arena, ArenaFileError, Assignment, Attributes, BarrelPart, Group
from fidmap.model import Settings, Transform
from fiducials import arc, arena_of, assigned, drawn, half, pairs_arena

GROUPS = tuple(
    Group(str(k), (f"{k}A", f"{k}B"), walking_pallets=way) for k, way in enumerate((1, 6, 6.5, 9, 2), 1)
)


def six_parts(**more: object) -> Arena:
    """Three pairs, ten metres apart, halves 4 cm apart; '1' short, '2' long, '3' short."""
    parts = [half(f"{k}{side}", 10.0 * k, y) for k in (1, 2, 3) for side, y in (("A", 0.0), ("B", 0.04))]
    groups = [Group("1", ("1A", "1B"), "short"), Group("2", ("2A", "2B"), "long"), Group("3", ("3A", "3B"), "short")]
    return arena_of(*parts, groups=groups, **more)


def scored(
    arena: Arena, parts: tuple[BarrelPart, ...], assignment: Assignment, settings: Settings = CONTINUOUS
) -> Attributes:
    return attributes(parts, arena, assignment, settings)


def value(found: Attributes, name: str) -> float | None:
    return {**found.classes, **found.by_name, "overall": found.overall}[name].value


@pytest.mark.parametrize("settings", [CONTINUOUS, SSRR2011])
def test_a_perfect_map_has_all_attributes_at_one(settings: Settings) -> None:
    """Every part at its place, seen sharply, in the agreed frame."""
    arena = pairs_arena(groups=GROUPS, frame="map")
    parts = tuple(replace(p, spread_m=0.0) for p in drawn(arena))

    found = scored(arena, parts, assigned(*range(10)), settings)

    assert [v.value for v in found.by_name.values()] == pytest.approx([1] * 5)
    assert found.overall.value == pytest.approx(1)
    assert found.missing == ()


def test_coverage_counts_parts_in_no_group_too() -> None:
    """Two of three, the third in no group."""
    arena = arena_of(half("A", 0, 0), half("B", 5, 0), half("C", 9, 0), groups=[Group("1", ("A", "B"), "short")])

    found = scored(arena, (arc(1, 0, 0), arc(2, 9, 0)), assigned(0, None, 1))

    assert value(found, "coverage") == pytest.approx(2 / 3)


def test_relative_accuracy_is_one_minus_the_mean_capped_error() -> None:
    """Errors 0, 0.3, 0.6 and 9 m with D = 1.2 m: losses 0, 1/4, 1/2, 1; missing parts do not count."""
    arena = six_parts()
    parts = (arc(1, 10, 0), arc(2, 10.3, 0.04), arc(3, 20, 0.6), arc(4, 30, 9))

    found = scored(arena, parts, assigned(0, 1, 2, None, 3, None))

    assert value(found, "relative_accuracy") == pytest.approx(1 - 1.75 / 4)
    assert [r.relative_error_m for r in found.parts] == pytest.approx([0, 0.3, 0.6, None, 9, None])


def test_relative_accuracy_is_measured_after_the_transform() -> None:
    """A map turned by 90 degrees and shifted, put right by its registration."""
    arena = six_parts()
    parts = drawn(arena, Transform(math.pi / 2, 3.0, -1.0))

    found = scored(arena, parts, assigned(*range(6), transform=Transform(-math.pi / 2, 1.0, 3.0)))

    assert value(found, "relative_accuracy") == pytest.approx(1)


def test_expected_places_are_in_the_maps_frame() -> None:
    """The inverse of the transform, for parts that are missing too."""
    arena = six_parts()
    parts = drawn(arena, Transform(math.pi / 2, 3.0, -1.0))

    found = scored(arena, parts[:5], assigned(0, 1, 2, 3, 4, None, transform=Transform(-math.pi / 2, 1.0, 3.0)))

    assert (found.parts[5].expected_x_m, found.parts[5].expected_y_m) == pytest.approx((parts[5].x_m, parts[5].y_m))


def test_global_accuracy_takes_the_identity_with_the_registrations_assignment() -> None:
    """Shifted by 0.6 m, half of D: global 0.5, relative 1."""
    arena = six_parts(frame="map")
    parts = drawn(arena, Transform(0, 0.6, 0))

    found = scored(arena, parts, assigned(*range(6), transform=Transform(0, -0.6, 0)))

    assert value(found, "relative_accuracy") == pytest.approx(1)
    assert value(found, "global_accuracy") == pytest.approx(0.5)


def test_global_accuracy_needs_an_agreed_frame() -> None:
    """With frame 'relative' it is not computable, and listed as missing although it weighs nothing."""
    arena = six_parts()

    found = scored(arena, drawn(arena), assigned(*range(6)))

    assert found.by_name["global_accuracy"].value is None
    assert found.by_name["global_accuracy"].reason == "the arena's frame is relative"
    assert "global_accuracy" in found.missing


def test_consistency_compares_distances_not_places() -> None:
    """Pair '1' is 0.64 m apart in place of 0.04: 0.6 of 1.2 lost; far from its place, which does not matter."""
    arena = six_parts()

    found = scored(arena, (arc(1, 50, 50), arc(2, 50.64, 50)), assigned(0, 1, None, None, None, None))

    group = found.groups[0].pairs[0]
    assert (group.distance_m, group.expected_m, group.error_m, group.loss) == pytest.approx((0.64, 0.04, 0.6, 0.5))
    assert value(found, "short") == pytest.approx(0.5)


def test_too_near_is_as_wrong_as_too_far() -> None:
    """The absolute value of the difference (SSRR 2011, II-B-3): 3 m apart in truth, 2.4 and 3.6 m in maps."""
    arena = arena_of(half("A", 0, 0), half("B", 3, 0), groups=[Group("1", ("A", "B"), "long")])

    for x in (2.4, 3.6):
        assert value(scored(arena, (arc(1, 0, 0), arc(2, x, 0)), assigned(0, 1)), "long") == pytest.approx(0.5)


def test_one_part_of_a_pair_missing_costs_all_of_it() -> None:
    """Pair '1' complete and right, pair '3' half there: short is the mean of 1 and 0."""
    arena = six_parts()

    found = scored(arena, drawn(arena), assigned(0, 1, None, None, 4, None))

    assert found.groups[2].loss == 1
    assert found.groups[2].pairs[0].error_m is None
    assert value(found, "short") == pytest.approx(0.5)


def test_a_pair_without_any_part_is_left_out() -> None:
    """Pair '3' is not there at all: short is that of pair '1' alone."""
    arena = six_parts()

    found = scored(arena, drawn(arena), assigned(0, 1, None, None, None, None))

    assert found.groups[2].loss is None
    assert value(found, "short") == pytest.approx(1)


def test_consistency_is_the_mean_of_the_computable_ones_of_short_and_long() -> None:
    """Short 1 and long 0 give one half; without any long part it is short alone."""
    arena = six_parts()

    both = scored(arena, drawn(arena), assigned(0, 1, 2, None, None, None))
    short_only = scored(arena, drawn(arena), assigned(0, 1, None, None, None, None))

    assert value(both, "consistency") == pytest.approx(0.5)
    assert value(short_only, "long") is None
    assert short_only.classes["long"].reason == "no group of this class has an assigned part"
    assert value(short_only, "consistency") == pytest.approx(1)


def test_classes_weigh_the_same_however_many_groups_they_have() -> None:
    """Two short groups at 1, one long at 0: the mean of the classes, not of the groups (SSRR 2011, IV)."""
    arena = six_parts()

    found = scored(arena, drawn(arena), assigned(0, 1, 2, None, 4, 5))

    assert value(found, "consistency") == pytest.approx(0.5)


def room(*more: Group) -> Arena:
    """Three parts at (0, 0), (3, 0), (0, 4): distances 3, 4 and 5 m."""
    return arena_of(
        half("A", 0, 0), half("B", 3, 0), half("C", 0, 4), groups=[Group("r", ("A", "B", "C"), "room"), *more]
    )


def test_a_group_of_three_is_the_mean_over_its_pairs() -> None:
    """B drawn 0.6 m too far: 3.6 for 3, and to C sqrt(3.6^2 + 4^2) for 5; A to C is right."""
    parts = (arc(1, 0, 0), arc(2, 3.6, 0), arc(3, 0, 4))
    loss = [0.5, 0, (math.hypot(3.6, 4) - 5) / 1.2]

    found = scored(room(), parts, assigned(0, 1, 2))

    assert [p.loss for p in found.groups[0].pairs] == pytest.approx(loss)
    assert value(found, "room") == pytest.approx(1 - sum(loss) / 3)


def test_a_group_of_three_with_one_part_leaves_out_the_pair_of_nothing() -> None:
    """A alone: A-B and A-C lost, B-C left out; with A and B: A-B right, the two with C lost."""
    parts = drawn(room())

    alone = scored(room(), parts, assigned(0, None, None))
    two = scored(room(), parts, assigned(0, 1, None))

    assert [p.loss for p in alone.groups[0].pairs] == [1, 1, None]
    assert value(alone, "room") == 0
    assert value(two, "room") == pytest.approx(1 / 3)


def test_a_measured_distance_overrides_the_positions() -> None:
    """The wall is 0.1 m thick whatever the survey says: 0.04 m apart in the map is 0.06 m off."""
    arena = arena_of(half("A", 0, 0), half("B", 0, 0.04), groups=[Group("1", ("A", "B"), "short", distance_m=0.1)])

    found = scored(arena, drawn(arena), assigned(0, 1))

    assert value(found, "short") == pytest.approx(1 - 0.06 / 1.2)


def test_consistency_needs_no_positions() -> None:
    """The wall's thickness is all that is known (SSRR 2011, V); accuracies have their reason."""
    parts = tuple(replace(half(name, 0, 0), x_m=None, y_m=None) for name in "AB")
    arena = arena_of(*parts, groups=[Group("1", ("A", "B"), "short", distance_m=0.1)])

    found = scored(arena, (arc(1, 0, 0), arc(2, 0.4, 0)), Assignment((0, 1), (True, True), None, 0.0))

    assert value(found, "short") == pytest.approx(0.75)
    assert found.by_name["relative_accuracy"].reason == "the arena has no positions"
    assert found.by_name["global_accuracy"].reason == "the arena has no positions"
    assert found.parts[0].expected_x_m is None


@pytest.mark.parametrize(("pallets", "name"), [(0, "short"), (6, "short"), (6.01, "long"), (7, "long")])
def test_more_than_six_pallets_are_long(pallets: float, name: str) -> None:
    """Six itself is short (SSRR 2011, III); a number need not be an integer."""
    assert Group("1", ("A", "B"), walking_pallets=pallets).resolved_class(6) == name


def test_the_limit_is_a_setting_and_a_named_class_wins() -> None:
    """Four pallets are long where the limit is three; a room stays a room."""
    assert Group("1", ("A", "B"), walking_pallets=4).resolved_class(3) == "long"
    assert Group("1", ("A", "B"), "room", walking_pallets=40).resolved_class(3) == "room"


def test_a_group_without_class_and_way_is_refused() -> None:
    """One sentence that says what to give."""
    with pytest.raises(ArenaFileError, match="group '1' has neither a class nor walking_pallets; give one of them"):
        Group("1", ("A", "B")).resolved_class(6)


def test_the_limit_of_the_settings_reaches_the_groups() -> None:
    """Walking distances 1, 6 and 2 are short, 6.5 and 9 long; with a limit of 8 only 9 is."""
    arena = pairs_arena(groups=GROUPS)
    arguments = (drawn(arena), arena, assigned(*range(10)))

    usual = attributes(*arguments, CONTINUOUS)
    wider = attributes(*arguments, replace(CONTINUOUS, long_if_walking_pallets_over=8))

    assert [g.group_class for g in usual.groups] == ["short", "short", "long", "long", "short"]
    assert [g.group_class for g in wider.groups] == ["short", "short", "short", "long", "short"]


def test_other_classes_are_shown_and_weigh_only_what_the_profile_says() -> None:
    """A room at 0.5 changes nothing by default; with weight 3 beside coverage and accuracy at 1 it does."""
    arena = room()
    parts = (arc(1, 0, 0), arc(2, 3, 0), arc(3, 0, 4))
    settings = replace(CONTINUOUS, weights={"coverage": 1, "relative_accuracy": 1, "room": 3})

    default = scored(arena, parts, assigned(0, 1, None))
    weighed = scored(arena, parts, assigned(0, 1, None), settings)

    assert value(default, "room") == pytest.approx(1 / 3)
    assert default.by_name["consistency"].reason == "the arena has no short or long groups"
    assert value(default, "overall") == pytest.approx((2 / 3 + 1) / 2)
    assert value(weighed, "overall") == pytest.approx((2 / 3 + 1 + 3 / 3) / 5)


def test_each_attribute_has_its_own_d_max() -> None:
    """In radii or in metres; metres win."""
    settings = replace(
        CONTINUOUS,
        d_max_radii={"relative_accuracy": 8.0, "consistency": 2.0, "global_accuracy": 4.0},
        d_max_m={"global_accuracy": 6.0},
    )
    arena = arena_of(half("A", 0, 0), half("B", 3, 0), groups=[Group("1", ("A", "B"), "long")], frame="map")

    found = scored(arena, (arc(1, 0, 0), arc(2, 3.3, 0)), assigned(0, 1), settings)

    assert value(found, "relative_accuracy") == pytest.approx(1 - 0.3 / 2.4 / 2)
    assert value(found, "consistency") == pytest.approx(0.5)
    assert value(found, "global_accuracy") == pytest.approx(1 - 0.3 / 6 / 2)


def test_distances_are_stepped_before_they_are_capped() -> None:
    """0.44 m counts as one radius with ssrr2011, in accuracy and consistency alike."""
    arena = arena_of(half("A", 0, 0), half("B", 3, 0), groups=[Group("1", ("A", "B"), "long")])

    found = scored(arena, (arc(1, 0, 0), arc(2, 3.44, 0)), assigned(0, 1), SSRR2011)

    assert value(found, "relative_accuracy") == pytest.approx(1 - 0.25 / 2)
    assert value(found, "consistency") == pytest.approx(0.75)


def test_weights_are_shared_among_what_can_be_computed() -> None:
    """Consistency is not computable without groups: overall is the mean of coverage 1/2 and accuracy 1."""
    arena = arena_of(half("A", 0, 0), half("B", 3, 0))

    found = scored(arena, (arc(1, 0, 0),), assigned(0, None))

    assert value(found, "overall") == pytest.approx(0.75)
    assert found.missing == ("consistency", "global_accuracy", "resolution_quality")


def test_only_the_ratio_of_weights_counts() -> None:
    """Twice the weights, the same score; a weight of 0 takes an attribute out."""
    arena = six_parts()
    base = replace(CONTINUOUS, weights={"coverage": 1, "consistency": 3, "relative_accuracy": 0})
    twice = replace(CONTINUOUS, weights={"coverage": 2, "consistency": 6, "relative_accuracy": 0})
    arguments = (arena, drawn(arena), assigned(0, 1, 2, None, None, None))

    assert value(scored(*arguments, base), "overall") == pytest.approx((0.5 + 3 * 0.5) / 4)
    assert value(scored(*arguments, twice), "overall") == value(scored(*arguments, base), "overall")


def test_a_weighted_class_that_no_group_has_is_missing() -> None:
    """A profile may weigh rooms in an arena without any."""
    settings = replace(CONTINUOUS, weights={"coverage": 1, "room": 1})
    arena = six_parts()

    found = scored(arena, drawn(arena), assigned(*range(6)), settings)

    assert "room" in found.missing
    assert value(found, "overall") == pytest.approx(1)


def test_nothing_assigned() -> None:
    """Coverage is 0, the rest not computable with its reason, so overall is 0."""
    arena = six_parts(frame="map")

    found = scored(arena, (), Assignment((None,) * 6, (False,) * 6, None, 0.0))

    assert value(found, "coverage") == 0
    assert value(found, "overall") == 0
    assert found.missing == ("relative_accuracy", "consistency", "global_accuracy", "resolution_quality")
    assert found.by_name["relative_accuracy"].reason == "no part is assigned"
    assert found.by_name["consistency"].reason == "no short or long group has an assigned part"
    assert found.by_name["resolution_quality"].reason == "no part is assigned"


def test_overall_without_any_weighted_attribute_has_a_reason() -> None:
    """Never 0 where nothing was computed."""
    settings = replace(CONTINUOUS, weights={"relative_accuracy": 1})

    found = scored(six_parts(), (), Assignment((None,) * 6, (False,) * 6, None, 0.0), settings)

    assert found.overall.value is None
    assert found.overall.reason == "none of the weighted attributes can be computed"


def test_resolution_quality_is_the_median_over_assigned_arcs() -> None:
    """Spreads of 0, R/4 and 2 R: qualities 1, 1/2 and 0, the median 1/2; an arc of no part does not count."""
    arena = six_parts()
    spreads = (0.0, 0.075, 0.6, 0.6, 0.6)
    parts = tuple(arc(n, 10 * n, 0, spread_m=s) for n, s in enumerate(spreads, 1))

    found = scored(arena, parts, assigned(0, None, 1, None, 2, None))

    assert value(found, "resolution_quality") == pytest.approx(0.5)


def test_resolution_quality_needs_a_map() -> None:
    """Parts that somebody located have no spread."""
    found = scored(six_parts(), drawn(six_parts()), assigned(*range(6)))

    assert found.by_name["resolution_quality"].reason == "the parts were located by hand, not in a map"


def test_the_order_of_parts_and_groups_does_not_matter() -> None:
    """Fiducial parts, barrel parts and groups the other way round, the same scores."""
    arena = six_parts(frame="map")
    parts = drawn(arena, noise_m=0.2)
    turned = replace(arena, parts=arena.parts[::-1], groups=arena.groups[::-1])

    one = scored(arena, parts, assigned(0, 1, 2, None, 4, None))
    other = scored(turned, parts[::-1], assigned(None, 1, None, 3, 4, 5))

    assert {n: v.value for n, v in other.by_name.items()} == pytest.approx({n: v.value for n, v in one.by_name.items()})
    assert other.overall.value == pytest.approx(one.overall.value)
