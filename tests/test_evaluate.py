"""The whole story on artificial maps: what was drawn with exact poses scores well, and the steps agree."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from fidmap import __version__, find_barrel_parts, trinarize
from fidmap.evaluate import evaluate, evaluate_points
from fidmap.model import CONTINUOUS, SSRR2011, Finding, Grid, Pose2, Source, StartPose
from fidmap.register import register
from fidmap.synth.arena import ArenaSpec
from fidmap.synth.poses import PoseNoise
from fidmap.synth.suite import CaseSpec, SynthCase, make_case
from fiducials import arc, pairs_arena

NOTED = Finding("note", "odd", "something odd about the file")


def case_of(seed: int, sigma_m: float = 0.0) -> SynthCase:
    """A small arena, driven through completely, its frame a metre and a third of a turn away."""
    spec = CaseSpec(
        arena=ArenaSpec(columns=5, rows=4, pairs=4, void_pairs=0, openness=0.25),
        noise=PoseNoise(sigma_m),
        frame=Pose2(1.0, -0.5, 2.1),
    )
    return make_case(np.random.default_rng(seed), spec)


@pytest.fixture(scope="module")
def exact() -> SynthCase:
    return case_of(1)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_exact_poses_score_nearly_everything(seed: int) -> None:
    """Every part that the map draws is assigned, and lies within centimetres of its place."""
    case = case_of(seed)
    wanted = {t.id for t in case.truths if t.drawn == "yes"}

    report = evaluate(case.grid, case.arena.arena)

    values = {name: value.value or 0 for name, value in report.attributes.by_name.items()}
    assert wanted <= {part.id for part in report.attributes.parts if part.barrel is not None}
    assert values["relative_accuracy"] > 0.97
    assert report.findings == ()


def test_coverage_is_complete_where_all_is_drawn(exact: SynthCase) -> None:
    """Coverage and accuracy of the first case, with and without steps."""
    for settings in (CONTINUOUS, SSRR2011):
        report = evaluate(exact.grid, exact.arena.arena, settings)
        assert report.attributes.by_name["coverage"].value == 1
        assert (report.attributes.by_name["relative_accuracy"].value or 0) > 0.97


def test_the_transform_is_the_frame_of_the_map(exact: SynthCase) -> None:
    """The arena seen from the map: turned by 2.1 radians, so the registration turns back."""
    found = evaluate(exact.grid, exact.arena.arena).assignment.transform

    assert found is not None
    assert abs(math.remainder(abs(found.rotation) - 2.1, 2 * math.pi)) < 0.02


def test_the_same_map_and_settings_give_the_same_report(exact: SynthCase) -> None:
    """Value for value."""
    one, other = (evaluate(exact.grid, exact.arena.arena) for _ in range(2))

    assert one.attributes == other.attributes
    assert one.assignment == other.assignment
    assert one.detections == other.detections


def test_the_report_carries_what_it_was_made_from(exact: SynthCase) -> None:
    """The map's source and its findings, arena, settings, start pose and version."""
    grid = replace(exact.grid, source=Source("m.yaml", "abc", "map_server", (NOTED,)))
    frame = evaluate(exact.grid, exact.arena.arena).assignment.transform
    assert frame is not None
    start = StartPose(Pose2(frame.tx_m, frame.ty_m, frame.rotation))

    report = evaluate(grid, exact.arena.arena, SSRR2011, start)

    assert report.map == grid.source
    assert report.findings[0] == NOTED
    assert (report.settings, report.start_pose, report.version) == (SSRR2011, start, __version__)
    assert report.attributes.by_name["coverage"].value == 1


def test_evaluate_is_its_steps(exact: SynthCase) -> None:
    """Trinarize, find, register: the same assignment of the same parts."""
    arena = exact.arena.arena
    report = evaluate(exact.grid, arena)

    parts = find_barrel_parts(trinarize(exact.grid), arena.radius_m)
    step = register(report.detections, arena, CONTINUOUS)

    assert set(report.detections) <= set(parts)
    assert step == report.assignment


def test_parts_given_back_score_the_same(exact: SynthCase) -> None:
    """Detections as points, with their map: all attributes; without it all but resolution quality."""
    arena = exact.arena.arena
    report = evaluate(exact.grid, arena)
    bare = [replace(part, spread_m=None) for part in report.detections]

    with_map = evaluate_points(bare, arena, grid=exact.grid)
    without = evaluate_points(bare, arena, source=Source("points.csv"))

    assert with_map.attributes == report.attributes
    assert without.map.name == "points.csv"
    assert without.attributes.by_name["resolution_quality"].value is None
    assert without.attributes.by_name["relative_accuracy"] == report.attributes.by_name["relative_accuracy"]


def test_a_human_has_the_last_word(exact: SynthCase) -> None:
    """One part taken out, another one renamed: coverage falls by one part, the fixed one is far off."""
    arena = exact.arena.arena
    report = evaluate(exact.grid, arena)
    first, second = (part.barrel for part in report.attributes.parts[:2])
    assert first is not None
    assert second is not None
    edited = [
        replace(p, fixed_id="-") if p.n == first.n else replace(p, fixed_id=arena.parts[0].id) if p.n == second.n else p
        for p in report.detections
    ]

    again = evaluate_points(edited, arena, grid=exact.grid)

    results = {part.id: part.barrel and part.barrel.n for part in again.attributes.parts}
    assert results[arena.parts[0].id] == second.n
    assert results[arena.parts[1].id] is None
    assert again.attributes.by_name["coverage"].value == pytest.approx(1 - 1 / len(arena.parts))


def test_an_empty_map_scores_zero() -> None:
    """Nothing drawn, nothing assigned: overall 0, the rest with its reason."""
    grid = Grid(np.full((80, 90), np.nan, np.float32), 0.05)

    report = evaluate(grid, pairs_arena())

    assert report.attributes.overall.value == 0
    assert report.attributes.by_name["relative_accuracy"].value is None
    assert report.detections == ()


def test_only_arcs_worth_showing_are_reported() -> None:
    """Points are taken as they are, however unsure."""
    parts = [arc(1, 0, 0, confidence=0.01)]

    assert evaluate_points(parts, pairs_arena()).detections == tuple(parts)
