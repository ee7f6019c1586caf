"""The registration: when a part is assigned, which maximum is taken, and what must not change it."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fidmap.geometry import angle_between, apply
from fidmap.model import (
    CONTINUOUS,
    SSRR2011,
    Arena,
    ArenaFileError,
    Assignment,
    BarrelPart,
    FiducialPart,
    Pose2,
    Settings,
    StartPose,
    Transform,
)
from fidmap.register import register
from fiducials import R, arc, arena_of, drawn, half, names, pairs_arena
from real_data import real_data

ALL = {f"{k}{side}": 2 * k - (side == "A") for k in range(1, 6) for side in "AB"}
WHOLE = 2 * math.pi
HERE = StartPose(Pose2(), 0.0, 0.0)  # nothing but the identity is searched


def found(arena: Arena, parts: tuple[BarrelPart, ...], profile: Settings = CONTINUOUS) -> dict[str, int]:
    return names(arena, register(parts, arena, profile), parts)


def in_place(arena: Arena, parts: tuple[BarrelPart, ...], profile: Settings = CONTINUOUS) -> Assignment:
    """The registration with the map where it is: what is assigned can be followed by hand."""
    return register(parts, arena, profile, HERE)


def line(*more: FiducialPart) -> Arena:
    """Three parts on a line, all facing up, and more."""
    return arena_of(*(half(name, x, 0, math.pi / 2) for name, x in (("A", 0), ("B", 4), ("C", 9))), *more)


def line_arcs(*more: BarrelPart) -> tuple[BarrelPart, ...]:
    return (*(arc(n, x, 0, math.pi / 2) for n, x in ((1, 0), (2, 4), (3, 9))), *more)


# what a perfect or noisy map gives


@pytest.mark.parametrize(
    "move", [Transform(), Transform(2.0, -30, 12), Transform(-0.4, 0.3, 0.1), Transform(math.pi, 7, 5)]
)
def test_a_moved_map_is_moved_back(move: Transform) -> None:
    """Every part found again, the full value, and the inverse of the move as the transform."""
    arena = pairs_arena()
    parts = drawn(arena, move)

    result = register(parts, arena, CONTINUOUS)

    assert names(arena, result, parts) == ALL
    assert result.value == pytest.approx(10, abs=1e-4)
    assert result.transform is not None
    assert float(angle_between(result.transform.rotation, -move.rotation)) < 1e-4
    assert result.findings == ()


def test_rigid_moves_leave_the_value_unchanged() -> None:
    """A noisy map, drawn anywhere and in any direction: the same value and the same parts."""
    arena = pairs_arena()
    moves = [Transform(), *(Transform(1.1 * k, 3.0 * k, -k) for k in range(1, 4))]
    results = []
    for move in moves:
        noisy = drawn(arena, noise_m=0.12, seed=3)
        moved = apply(move, np.array([(p.x_m, p.y_m) for p in noisy]))
        parts = tuple(
            replace(p, x_m=float(x), y_m=float(y), facing=(p.facing or 0) + move.rotation)
            for p, (x, y) in zip(noisy, moved, strict=True)
        )
        result = register(parts, arena, CONTINUOUS)
        results.append((pytest.approx(result.value, abs=1e-5), names(arena, result, parts)))

    assert all(one == results[0] for one in results[1:])


def test_the_sum_of_capped_scores_is_maximised_not_the_squares() -> None:
    """Four parts right and one 1.1 m off: the four stay exactly right, nobody shares the fifth's error."""
    arena = arena_of(
        *(half(name, x, y, 0) for name, x, y in (("A", 0, 0), ("B", 5, 0), ("C", 0, 7), ("D", 6, 8), ("E", 2, 3)))
    )
    parts = list(drawn(arena))
    parts[4] = replace(parts[4], x_m=parts[4].x_m + 1.1)

    result = register(tuple(parts), arena, CONTINUOUS)

    assert result.value == pytest.approx(4 + 1 - 1.1 / 1.2, abs=1e-3)


def test_value_is_the_sum_that_the_transform_gives() -> None:
    """Added up again from the transform and the assignment, with steps and without."""
    arena = pairs_arena()
    parts = drawn(arena, Transform(0.5, 1, 2), noise_m=0.15)
    for profile in (CONTINUOUS, SSRR2011):
        result = register(parts, arena, profile)
        assert result.transform is not None
        total = 0.0
        for part, j in zip(arena.parts, result.barrel_of, strict=True):
            if j is not None:
                x, y = apply(result.transform, np.array([[parts[j].x_m, parts[j].y_m]]))[0]
                d = math.hypot(x - (part.x_m or 0), y - (part.y_m or 0))
                q = d if profile is CONTINUOUS else math.floor(d / R + 0.5 - 1e-9) * R
                total += 1 - min(q, 1.2) / 1.2
        assert result.value == pytest.approx(total)


# when a part is assigned


@pytest.mark.parametrize(("away", "is_assigned"), [(1.19, True), (1.2, False), (1.21, False)])
def test_nearer_than_d_max(away: float, is_assigned: bool) -> None:
    """D < D after the registration; D itself is too far."""
    arena, parts = line(half("D", 20, 5)), line_arcs(arc(4, 20, 5 + away))

    assert ("D" in names(arena, in_place(arena, parts), parts)) == is_assigned


def test_stepped_to_d_max_is_assigned_with_error_one() -> None:
    """1.1 m is nearest to four radii: assigned, for the value of the other three."""
    arena, parts = line(half("D", 20, 5)), line_arcs(arc(4, 20, 6.1))

    result = in_place(arena, parts, SSRR2011)

    assert names(arena, result, parts)["D"] == 4
    assert result.value == pytest.approx(3)


def test_of_equal_values_the_one_with_most_pairs() -> None:
    """With steps 'up' both of 1.0 m and 1.15 m are worth nothing; all the same both parts are assigned."""
    arena = line(half("D", 20, 0), half("E", 22, 0))
    parts = line_arcs(arc(4, 20, 1.0), arc(5, 22, 1.15))
    up = replace(CONTINUOUS, rounding="up")

    assert len(names(arena, in_place(arena, parts, up), parts)) == 5


def test_then_the_greatest_continuous_value() -> None:
    """Two arcs within the first step of D: both worth 1, the nearer is taken."""
    arena, parts = line(half("D", 20, 0)), line_arcs(arc(4, 20, 0.1), arc(5, 20, -0.05))

    assert names(arena, in_place(arena, parts, SSRR2011), parts)["D"] == 5


def test_one_barrel_part_serves_one_fiducial_part() -> None:
    """Two parts near one arc: the nearer gets it, the other nothing."""
    arena, parts = line(half("D", 20, 0), half("E", 20.5, 0)), line_arcs(arc(4, 20.1, 0))

    assigned = names(arena, in_place(arena, parts), parts)

    assert assigned["D"] == 4
    assert "E" not in assigned


def test_the_best_sum_not_the_nearest_first() -> None:
    """Nearest first would give D-4 and E-5 (0.1 and 0.75 m); D-5 and E-4 (0.15 and 0.5 m) are worth more."""
    arena = line(half("D", 20, 0), half("E", 20.6, 0))
    parts = line_arcs(arc(4, 20.1, 0), arc(5, 19.85, 0))

    assigned = names(arena, in_place(arena, parts), parts)

    assert (assigned["D"], assigned["E"]) == (5, 4)


@pytest.mark.parametrize(
    ("opening", "drawn_deg", "is_assigned"),
    [(180, 120, True), (180, 119.95, True), (180, 119.8, False), (360, 240, True), (360, 239.8, False), (90, 60, True)],
)
def test_two_thirds_of_the_opening(opening: float, drawn_deg: float, is_assigned: bool) -> None:
    """A tenth of a degree to spare."""
    part = replace(half("D", 20, 0, 0.0), opening=math.radians(opening))
    arena, parts = line(part), line_arcs(arc(4, 20, 0, drawn=math.radians(drawn_deg)))

    assert ("D" in names(arena, in_place(arena, parts), parts)) == is_assigned


def test_the_least_opening_is_a_setting() -> None:
    """One half of a whole barrel is enough where the profile says so."""
    arena, parts = line(FiducialPart("D", 20, 0)), line_arcs(arc(4, 20, 0, drawn=math.radians(185)))

    assert "D" not in names(arena, in_place(arena, parts), parts)
    assert "D" in names(arena, in_place(arena, parts, replace(CONTINUOUS, min_opening=0.5)), parts)


@pytest.mark.parametrize(
    ("turned_deg", "is_assigned"),
    [(0, True), (59, True), (59.999, True), (60, False), (61, False), (180, False), (-60, False)],
)
def test_facings_agree_within_sixty_degrees(turned_deg: float, is_assigned: bool) -> None:
    """Exactly sixty is refused, at any facing, though doubles round the difference either way."""
    for facing_deg in (0, 37, 90, 180, 200, 270):
        arena = line(half("D", 20, 0, math.radians(facing_deg)))
        parts = line_arcs(arc(4, 20, 0, math.radians(facing_deg + turned_deg)))
        assert ("D" in names(arena, in_place(arena, parts), parts)) == is_assigned


def test_facings_are_compared_after_the_rotation() -> None:
    """A map that is drawn upside down keeps all its parts."""
    arena = pairs_arena()

    assert found(arena, drawn(arena, Transform(math.pi, 1, 1))) == ALL


def test_an_arc_on_the_wrong_side_of_the_wall_is_not_that_part() -> None:
    """Only half 1B is drawn, exactly where 1A should be: it is 1B, and 1A is missing."""
    arena = pairs_arena()
    a, b, *rest = drawn(arena)
    parts = (replace(b, x_m=a.x_m, y_m=a.y_m), *rest)

    assigned = found(arena, parts)

    assert assigned["1B"] == b.n
    assert "1A" not in assigned


def test_whole_barrels_have_no_facing_to_test() -> None:
    """A barrel that stands free, drawn from one side only or all around, and with a facing in the arena file."""
    for whole in (FiducialPart("D", 20, 0), FiducialPart("D", 20, 0, 0.0, WHOLE)):
        arena = line(whole)
        for shown in (arc(4, 20, 0, math.pi, drawn=math.radians(250)), arc(4, 20, 0, None, drawn=WHOLE)):
            parts = line_arcs(shown)
            assert names(arena, in_place(arena, parts), parts)["D"] == 4


def test_parts_without_facing_are_not_tested() -> None:
    """On either side."""
    arena, parts = line(half("D", 20, 0, None)), line_arcs(arc(4, 20, 0, 2.0))
    assert "D" in names(arena, in_place(arena, parts), parts)

    arena, parts = line(half("D", 20, 0, 2.0)), line_arcs(arc(4, 20, 0, None))
    assert "D" in names(arena, in_place(arena, parts), parts)


def test_unsure_arcs_are_not_assigned() -> None:
    """Below `min_confidence`; at it they are."""
    arena = line(half("D", 20, 0))
    for confidence, expected in ((0.49, False), (0.5, True)):
        parts = line_arcs(arc(4, 20, 0, confidence=confidence))
        assert ("D" in names(arena, in_place(arena, parts), parts)) == expected


# what a human said


def test_fixed_parts_are_assigned_whatever_arc_facing_and_distance() -> None:
    """Drawn over 10 degrees, facing away, unsure, and 20 m off: assigned, worth nothing, and told as fixed."""
    arena = line(half("D", 20, 0, 0.0))
    parts = line_arcs(arc(4, 40, 0, math.pi, drawn=0.17, confidence=0.0, fixed_id="D"))

    result = register(parts, arena, CONTINUOUS)

    assert names(arena, result, parts)["D"] == 4
    assert result.fixed == (False, False, False, True)
    assert result.value == pytest.approx(3, abs=1e-6)


def test_all_parts_fixed_against_their_facings() -> None:
    """A human read the map, the facings are the wrong way round: ids decide, the transform is found all the same."""
    arena = pairs_arena()
    parts = tuple(
        replace(p, facing=(p.facing or 0) + math.pi, fixed_id=f.id)
        for p, f in zip(drawn(arena, Transform(1.0, 5, 5)), arena.parts, strict=True)
    )

    result = register(parts, arena, CONTINUOUS)

    assert names(arena, result, parts) == ALL
    assert result.value == pytest.approx(10, abs=1e-4)


def test_a_fixed_barrel_part_is_not_free_for_others() -> None:
    """4 stands at E but is D by a human's word: E gets nothing; 5 at D's place gets nothing either."""
    arena = line(half("D", 20, 0), half("E", 26, 0))
    parts = line_arcs(arc(4, 26, 0, fixed_id="D"), arc(5, 20, 0))

    assigned = names(arena, register(parts, arena, CONTINUOUS), parts)

    assert assigned == {"A": 1, "B": 2, "C": 3, "D": 4}


def test_a_dash_takes_an_arc_out() -> None:
    """No part, however well it fits."""
    arena, parts = line(half("D", 20, 0)), line_arcs(arc(4, 20, 0, fixed_id="-"))

    assert "D" not in names(arena, register(parts, arena, CONTINUOUS), parts)


# arenas without positions, empty maps, start poses, mirrors, scale


def unplaced(arena: Arena) -> Arena:
    return replace(arena, parts=tuple(replace(p, x_m=None, y_m=None) for p in arena.parts))


def test_without_positions_a_human_names_the_parts() -> None:
    """No transform; what has no id stays out."""
    arena, parts = unplaced(line()), (arc(1, 3, 3, fixed_id="B"), arc(2, 0, 0))

    result = register(parts, arena, CONTINUOUS)

    assert result.barrel_of == (None, 0, None)
    assert result.fixed == (False, True, False)
    assert result.transform is None


@pytest.mark.parametrize("fixed_id", [None, "-"])
def test_without_positions_and_names_one_sentence_says_what_is_missing(fixed_id: str | None) -> None:
    """Exactly this text."""
    arena = unplaced(line())

    with pytest.raises(ArenaFileError) as caught:
        register((arc(1, 3, 3, fixed_id=fixed_id),), arena, CONTINUOUS)

    assert str(caught.value) == (
        "<memory>: no part has a position, so nothing can be assigned by itself: give x_m and y_m for every part, "
        "or put the two halves on each wall into a group with distance_m, or name the parts in the id column of a "
        "points file (--points)"
    )


@pytest.mark.parametrize("parts", [(), (arc(1, 0, 0, drawn=1.0),)])
def test_a_map_without_usable_arcs(parts: tuple[BarrelPart, ...]) -> None:
    """Nothing assigned, no transform, no finding."""
    result = register(parts, line(), CONTINUOUS)

    assert result == Assignment((None,) * 3, (False,) * 3, None, 0.0, 0.0)


def test_an_arena_kilometres_wide_takes_no_gigabytes() -> None:
    """The look-up field gets coarser, not larger."""
    arena = arena_of(half("A", 0, 0), half("B", 2_000_000, 0), half("C", 0, 2_000_000))

    assert found(arena, drawn(arena)) == {"A": 1, "B": 2, "C": 3}


def ring(count: int) -> Arena:
    """Parts on a circle, facing outwards: turning by one place fits as well."""
    angles = [2 * math.pi * k / count for k in range(count)]
    return arena_of(*(half(f"{k}", 5 * math.cos(a), 5 * math.sin(a), a) for k, a in enumerate(angles)))


def test_a_start_pose_limits_the_search() -> None:
    """The map's origin stands turned by two places: of six equal placements that one is taken."""
    arena = ring(6)
    parts = drawn(arena)

    result = register(parts, arena, CONTINUOUS, StartPose(Pose2(0, 0, 2 * math.pi / 3)))

    assert result.barrel_of == (4, 5, 0, 1, 2, 3)
    assert result.value == pytest.approx(6, abs=1e-4)


def test_outside_of_three_sigma_nothing_is_searched() -> None:
    """The best placement is 1.4 m away: found with sigma 0.5; with 0.4 the map stays 0.2 m short of it."""
    arena = pairs_arena()
    parts = drawn(arena, Transform(0, 1.4, 0))

    near = register(parts, arena, CONTINUOUS, StartPose(Pose2(), 0.5))
    far = register(parts, arena, CONTINUOUS, StartPose(Pose2(), 0.4, 1e-6))

    assert near.value == pytest.approx(10, abs=1e-4)
    assert far.value == pytest.approx(10 * (1 - 0.2 / 1.2), abs=0.01)
    assert far.transform is not None
    assert math.hypot(far.transform.tx_m, far.transform.ty_m) <= 3 * 0.4


@pytest.mark.parametrize("sigma_yaw", [1e-6, 0.05])
def test_at_the_edge_of_a_start_pose_the_proof_holds(sigma_yaw: float) -> None:
    """The maximum lies on the limit, where no climb ends: all the same within 0.1 %; a little turn makes it better."""
    arena = pairs_arena()

    result = register(drawn(arena, Transform(0, 1.4, 0)), arena, CONTINUOUS, StartPose(Pose2(), 0.4, sigma_yaw))

    assert result.upper_bound is not None
    assert 10 * (1 - 0.2 / 1.2) - 1e-6 <= result.value <= result.upper_bound <= result.value * 1.001 + 1e-6


@pytest.mark.parametrize("profile", [CONTINUOUS, SSRR2011])
def test_mirrored_maps_are_opt_in(profile: Settings) -> None:
    """Only with `mirror` is the map turned over; facings are turned over too."""
    arena = pairs_arena()
    parts = drawn(arena, Transform(0.8, 3, 1, mirrored=True))

    plain = register(parts, arena, profile)
    mirrored = register(parts, arena, replace(profile, mirror=True))

    assert plain.value < 9
    assert names(arena, mirrored, parts) == ALL
    assert mirrored.transform is not None
    assert mirrored.transform.mirrored
    assert mirrored.value == pytest.approx(10, abs=1e-4)


def test_a_map_that_is_not_mirrored_stays_so() -> None:
    """Also where mirroring is allowed."""
    arena = pairs_arena()

    result = register(drawn(arena), arena, replace(CONTINUOUS, mirror=True))

    assert result.transform is not None
    assert not result.transform.mirrored


def test_scale_is_free_only_with_a_similarity_and_within_its_range() -> None:
    """A map drawn at 1.25: rigid stays at 1; a similarity finds 0.8, or its limit."""
    arena = pairs_arena()
    parts = drawn(arena, Transform(0.3, 1, 1, 1.25))
    scales, values = [], []
    for profile in (
        CONTINUOUS,
        replace(CONTINUOUS, transform="similarity", scale_range=(0.7, 1.3)),
        replace(CONTINUOUS, transform="similarity", scale_range=(0.9, 1.1)),
    ):
        result = register(parts, arena, profile)
        assert result.transform is not None
        scales.append(result.transform.scale)
        values.append(result.value)

    assert scales == pytest.approx([1, 0.8, 0.9], abs=1e-3)
    assert values[1] == pytest.approx(10, abs=1e-3)
    assert values[0] < values[2] < values[1]


# equal optima and order


def test_of_equal_optima_the_one_that_turns_least() -> None:
    """A ring of six fits six ways: the map drawn straight stays straight, one turned by 50 degrees goes 10 on."""
    arena = ring(6)

    straight = register(drawn(arena), arena, CONTINUOUS)
    turned = register(drawn(arena, Transform(math.radians(50))), arena, CONTINUOUS)

    assert straight.barrel_of == (0, 1, 2, 3, 4, 5)
    assert turned.transform is not None
    assert math.degrees(turned.transform.rotation) == pytest.approx(10, abs=0.01)


def test_a_flat_maximum_ends_at_the_least_squares() -> None:
    """Two parts 1 m too far apart: every share of the error gives the same sum, equal shares the least squares."""
    arena, parts = arena_of(half("A", 0, 0, None), half("B", 5, 0, None)), (arc(1, 0, 0, None), arc(2, 6, 0, None))

    result = register(parts, arena, CONTINUOUS)

    assert result.transform is not None
    errors = np.abs(apply(result.transform, np.array([[0, 0], [6.0, 0]])) - [[0, 0], [5, 0]])
    assert errors[:, 0] == pytest.approx([0.5, 0.5], abs=0.01)


@pytest.mark.parametrize("arena", [pairs_arena(), ring(6)], ids=["pairs", "ring"])
@pytest.mark.parametrize("profile", [CONTINUOUS, SSRR2011], ids=["continuous", "ssrr2011"])
def test_the_order_of_inputs_changes_nothing(arena: Arena, profile: Settings) -> None:
    """Barrel parts and fiducial parts shuffled: the same pairs, the same transform to the last bit."""
    parts = (*drawn(arena, Transform(0.4, 1, 2), noise_m=0.1), arc(90, 3, 3), arc(91, 3, 3, 1.0))
    first = register(parts, arena, profile)
    random = Random(5)
    for _ in range(2 if profile is CONTINUOUS else 1):
        mixed, others = list(parts), list(arena.parts)
        random.shuffle(mixed)
        random.shuffle(others)
        turned = replace(arena, parts=tuple(others))
        again = register(tuple(mixed), turned, profile)
        assert names(turned, again, mixed) == names(arena, first, parts)
        assert (again.transform, again.value, again.findings) == (first.transform, first.value, first.findings)


def test_the_same_input_gives_the_same_answer() -> None:
    """To the last bit."""
    arena = ring(4)
    parts = drawn(arena, noise_m=0.3)

    assert register(parts, arena, SSRR2011) == register(parts, arena, SSRR2011)


part_strategy = st.tuples(st.floats(-3, 9), st.floats(-3, 9), st.floats(-3.1, 3.1))


@settings(derandomize=True, deadline=None, max_examples=3)
@given(extra=st.lists(part_strategy, max_size=3), seed=st.integers(0, 99), gone=st.integers(0, 9))
def test_removing_a_barrel_part_never_raises_the_value(
    extra: list[tuple[float, float, float]], seed: int, gone: int
) -> None:
    """Less to assign is never worth more."""
    arena = pairs_arena()
    parts = (*drawn(arena, Transform(0.7, 1, 1), 0.25, seed), *(arc(20 + k, *one) for k, one in enumerate(extra)))

    whole = register(parts, arena, CONTINUOUS)
    less = register(parts[:gone] + parts[gone + 1 :], arena, CONTINUOUS)

    assert less.value <= whole.value + 1e-6
    assert whole.value <= less.value + 1 + 1e-6


@settings(derandomize=True, deadline=None, max_examples=3)
@given(seed=st.integers(0, 999), noise_m=st.floats(0, 0.5))
def test_never_worse_than_the_truth(seed: int, noise_m: float) -> None:
    """The true move with the true parts is one of the candidates, so the maximum is at least its value."""
    arena = pairs_arena()
    noisy = drawn(arena, noise_m=noise_m, seed=seed)
    away = [math.hypot(p.x_m - (f.x_m or 0), p.y_m - (f.y_m or 0)) for p, f in zip(noisy, arena.parts, strict=True)]
    truth = sum(1 - min(d, 1.2) / 1.2 for d in away)

    result = register(noisy, arena, CONTINUOUS)

    assert truth - 1e-6 <= result.value <= 10 + 1e-9


# cases with certified optima

HARD = (9, 34, 38, 54, 82, 101, 129, 211, 214)
CERTIFIED = (18, 22, 48, 149, 163, *(pytest.param(k, marks=pytest.mark.slow) for k in HARD))


def certified(number: int) -> tuple[Arena, tuple[BarrelPart, ...], dict[str, float | None]]:
    cases = json.loads(real_data("registration", "cases.json").read_text(encoding="utf-8"))
    case = next(c for c in cases if c["id"] == number)
    fiducials = [FiducialPart(f"{k:03d}", x, y) for k, (x, y) in enumerate(case["fiducial_parts_xy"])]
    arena = Arena(str(number), case["radius"], tuple(fiducials))
    return arena, tuple(BarrelPart(n, x, y) for n, (x, y) in enumerate(case["barrel_parts_xy"], 1)), case["best"]


@pytest.mark.parametrize("number", CERTIFIED)
def test_certified_optima(number: int) -> None:
    """Within 0.1 % of the optimum and proven so; never above the known bound, nor ours below the known optimum."""
    arena, parts, best = certified(number)

    result = register(parts, arena, CONTINUOUS)

    assert best["rigid"] * 0.999 <= result.value <= best["rigid_upper_bound"] + 1e-6
    assert result.upper_bound is not None
    assert best["rigid"] - 1e-6 <= result.upper_bound <= result.value * 1.001 + 1e-6


@pytest.mark.parametrize("number", CERTIFIED)
def test_certified_optima_with_steps(number: int) -> None:
    """Distances stepped to the radius: exact, and proven so."""
    arena, parts, best = certified(number)

    result = register(parts, arena, SSRR2011)

    assert result.value == pytest.approx(best["rigid_discretised_nearest"], abs=1e-6)
    assert result.upper_bound == pytest.approx(result.value, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("number", CERTIFIED)
def test_certified_similarities(number: int) -> None:
    """Scales of 0.9 to 1.1."""
    arena, parts, best = certified(number)
    if best["similarity"] is None:
        pytest.skip("no optimum known")

    result = register(parts, arena, replace(CONTINUOUS, transform="similarity"))

    assert best["similarity"] * 0.999 <= result.value <= best["similarity_upper_bound"] + 1e-6
    assert result.upper_bound is not None
    assert best["similarity"] - 1e-6 <= result.upper_bound <= result.value * 1.001 + 1e-6
