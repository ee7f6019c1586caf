"""The figures on real maps that must not get worse; `./run bench real` shows them all."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.counting import count
from benchmarks.real import HALF_OPENING, counted
from benchmarks.slam_challenge import TUNED_ON, read_drawn_parts
from scipy.optimize import linear_sum_assignment

from fidmap.arena import read_arena
from fidmap.detect import find_barrel_parts
from fidmap.evaluate import evaluate
from fidmap.grid import trinarize
from fidmap.maps import read_map
from real_data import real_data


def test_the_playpen_has_nine_barrels_and_nothing_else() -> None:
    """Nine of nine are assigned at half an opening, to centimetres, and nothing else counts as a barrel."""
    folder = real_data("playpen")
    arena = read_arena(folder / "arena.yaml")

    report = evaluate(read_map(folder / "playpen_map.yaml"), arena, HALF_OPENING)

    parts = report.attributes.parts
    assert all(part.barrel is not None for part in parts)
    assert np.mean([part.global_error_m for part in parts]) <= 0.07
    assert np.mean([part.relative_error_m for part in parts]) <= 0.02
    assert len(counted(report.detections)) == 9


@pytest.mark.parametrize(
    "name",
    ["1r_ws_turtlebot3_world", "2006wu_turtlebot3_world", "ros_navigation_tb3_sandbox", "tiryoh_turtlebot3_world"],
)
def test_pillars_of_three_cells_are_found(name: str) -> None:
    """All nine pillars of 0.15 m, with residuals of millimetres."""
    folder = real_data("tb3_world")

    report = evaluate(read_map(folder / f"{name}.yaml"), read_arena(folder / "arena.yaml"), HALF_OPENING)

    errors = [part.relative_error_m for part in report.attributes.parts if part.relative_error_m is not None]
    assert len(errors) == 9
    assert np.mean(errors) <= 0.010


def test_a_black_and_white_map_without_scale_gives_its_half_barrels() -> None:
    """At least 15 of 18 halves and the whole barrel within two pixels; the smaller round object is not taken."""
    folder = real_data("robocup2010")
    hand = json.loads((folder / "circles_by_hand.json").read_text(encoding="utf-8"))
    grid = trinarize(read_map(folder / "singa.png", resolution_m=0.05))

    parts = counted(find_barrel_parts(grid, 0.3))

    height = grid.labels.shape[0]
    places = np.array([(p.x_m / 0.05 - 0.5, height - 0.5 - p.y_m / 0.05) for p in parts])
    known = [b[k] for b in hand["barrels"] for k in ("A", "B", "half") if k in b]
    whole = next(b["whole"] for b in hand["barrels"] if "whole" in b)
    away = np.linalg.norm(np.array(known)[:, None] - places[None], axis=2)
    i, j = linear_sum_assignment(np.minimum(away, 50))
    assert (away[i, j] <= 2).sum() >= 15
    assert np.hypot(*(places - whole).T).min() <= 2
    assert np.hypot(*(places - hand["hard_negatives"][0]["at"]).T).min() > 4


def test_the_tune_split_of_real_slam_maps_is_found() -> None:
    """Recall and precision over the maps that the detector was tuned on."""
    folder = real_data("slam_challenge")
    true = false = missed = 0
    for name in TUNED_ON:
        grid = trinarize(read_map(folder / "maps" / f"{name}.yaml"))
        found = count(counted(find_barrel_parts(grid, 0.3)), read_drawn_parts(folder, name))
        true, false, missed = true + found.true, false + len(found.false), missed + len(found.missed)

    assert true / (true + missed) >= 0.95
    assert true / (true + false) >= 0.95


def test_a_map_turned_by_its_origin_gives_the_same_scores() -> None:
    """The yaw of the origin turns barrels and facings alike."""
    folder = real_data("slam_challenge")
    grid, arena = read_map(folder / "maps" / "m29.yaml"), read_arena(folder / "A2.arena.yaml")
    turned = replace(grid, origin=replace(grid.origin, yaw=math.radians(40), x_m=3.0))

    scores = [evaluate(g, arena).attributes.by_name for g in (grid, turned)]

    for name in ("coverage", "relative_accuracy", "consistency", "resolution_quality"):
        assert scores[0][name].value == pytest.approx(scores[1][name].value, abs=1e-6)
