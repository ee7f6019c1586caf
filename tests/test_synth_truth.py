from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from fidmap.detect import find_barrel_parts
from fidmap.grid import trinarize
from fidmap.model import FiducialPart, FloatArray, Pose2
from fidmap.synth.arena import ArenaSpec, SynthArena
from fidmap.synth.laser import Scans, scan
from fidmap.synth.mappers import MAPPERS, draw_map
from fidmap.synth.poses import PoseNoise, estimated_poses
from fidmap.synth.suite import CaseSpec, make_case
from fidmap.synth.truth import part_truths
from test_synth_laser import EXACT, room

AROUND = np.array([[2.0 + 1.5 * math.cos(a), 2.0 + 1.5 * math.sin(a), 0.0] for a in np.linspace(0.8, 5.5, 40)])


def test_exact_poses_draw_parts_where_they_are():
    """In the arena's own frame drawn centres and facings are the true ones; nearly all parts are drawn."""
    maze = ArenaSpec(pairs=4, void_pairs=1, wholes=1, wall_m=0.03)
    case = make_case(np.random.default_rng(1), CaseSpec(maze, laser=EXACT))

    assert len(case.truths) == len(case.arena.arena.parts)
    for truth, part in zip(case.truths, case.arena.arena.parts, strict=True):
        assert truth.id == part.id
        assert (truth.drawn_x_m, truth.drawn_y_m) == pytest.approx((part.x_m, part.y_m), abs=1e-5)  # ranges are singles
        assert truth.drawn_facing == (None if part.facing is None else pytest.approx(part.facing))
        assert (truth.voted_x_m, truth.voted_y_m) == pytest.approx((part.x_m, part.y_m), abs=1e-9)
        assert truth.copies == ()
    assert sum(truth.drawn == "yes" for truth in case.truths) >= 0.8 * len(case.truths)


def test_a_moved_frame_moves_the_drawn_parts():
    """The drawn centre is the true one seen from the map's frame, the facing is turned along."""
    scans = scan(room(), AROUND, EXACT, np.random.default_rng(0))
    poses = estimated_poses(AROUND, PoseNoise(), np.random.default_rng(0), Pose2(10.0, 20.0, math.pi / 2))

    (truth,) = part_truths(room(), scans, poses, draw_map(scans, poses, MAPPERS["hits"], 0.05))

    assert (truth.drawn_x_m, truth.drawn_y_m) == pytest.approx((10.0 - 2.0, 20.0 + 4.0))
    assert truth.drawn_facing == pytest.approx(-math.pi / 2)
    assert truth.drawn == "yes"
    assert truth.support == pytest.approx(math.pi, abs=0.2)


def test_scans_from_another_pose_make_a_copy():
    """A third of the scans half a metre off: the part is drawn twice, first where most scans put it."""
    scans = scan(room(), AROUND, EXACT, np.random.default_rng(0))
    poses = AROUND.copy()
    poses[13:26, 1] += 0.5

    (truth,) = part_truths(room(), scans, poses)

    assert (truth.drawn_x_m, truth.drawn_y_m) == pytest.approx((4.0, 2.0))
    assert truth.copies == (pytest.approx((4.0, 2.5)),)


def twice_round(away_m: float) -> tuple[Scans, FloatArray]:
    """The part seen on two rounds, the second of which the map believes to be so far towards +y."""
    scans = scan(room(), np.concatenate([AROUND, AROUND]), EXACT, np.random.default_rng(0))
    poses = np.array(scans.poses)
    poses[len(AROUND) :, 1] += away_m
    return scans, poses


def test_a_counting_mapper_draws_the_middle():
    """Two rounds 6 cm apart: hits of both count the same."""
    scans, poses = twice_round(0.06)
    grid = draw_map(scans, poses, MAPPERS["hits"], 0.02)

    (truth,) = part_truths(room(), scans, poses, grid, MAPPERS["hits"])

    assert (truth.drawn_x_m, truth.drawn_y_m) == pytest.approx((4.0, 2.03), abs=0.003)


@pytest.mark.parametrize(("mapper", "most_m"), [("coreslam", 0.003), ("log_odds", 0.02)])
def test_a_mapper_that_forgets_draws_what_it_saw_last(mapper, most_m):
    """Two rounds 6 cm apart: the truth is nearer to the second, and there the detector finds the part too."""
    scans, poses = twice_round(0.06)
    grid = draw_map(scans, poses, MAPPERS[mapper], 0.02)

    (truth,) = part_truths(room(), scans, poses, grid, MAPPERS[mapper])
    (found,) = find_barrel_parts(trinarize(grid), 0.3)

    assert (truth.drawn_x_m, truth.drawn_y_m) == pytest.approx((4.0, 2.06), abs=most_m)
    assert (found.x_m, found.y_m) == pytest.approx((truth.drawn_x_m, truth.drawn_y_m), abs=0.02)


def test_hits_that_the_map_does_not_show_draw_nothing():
    """One scan in eight puts the part 8 cm nearer; the others' beams pass there and clear these cells."""
    scans = scan(room(), AROUND, EXACT, np.random.default_rng(0))
    poses = np.array(scans.poses)
    poses[::8, 0] -= 0.08
    grid = draw_map(scans, poses, MAPPERS["half_hits"], 0.02)

    (blind,) = part_truths(room(), scans, poses, mapper=MAPPERS["half_hits"])
    (truth,) = part_truths(room(), scans, poses, grid, MAPPERS["half_hits"])

    assert blind.drawn_x_m < 3.993
    assert (truth.drawn_x_m, truth.drawn_y_m) == pytest.approx((4.0, 2.0), abs=0.002)


def test_beams_that_a_mapper_does_not_use_draw_nothing():
    """A mapper that believes 20 cm has not seen the part."""
    scans = scan(room(), AROUND, EXACT, np.random.default_rng(0))

    (truth,) = part_truths(room(), scans, scans.poses, mapper=replace(MAPPERS["hits"], usable_m=0.2))

    assert (truth.drawn, truth.drawn_x_m) == ("no", None)


def test_a_part_never_seen_has_no_place():
    """A robot that looks away."""
    scans = scan(room(), np.array([[2.0, 2.0, math.pi]]), replace(EXACT, fov=1.0), np.random.default_rng(0))

    (truth,) = part_truths(room(), scans, scans.poses)

    assert (truth.drawn, truth.drawn_x_m, truth.scans) == ("no", None, 0)


def test_half_an_arc_is_partly_drawn():
    """From one place in the corner about a half of the half circle is seen."""
    scans = scan(room(), np.array([[3.7, 0.5, 1.0]]), EXACT, np.random.default_rng(0))

    (truth,) = part_truths(room(), scans, scans.poses)

    assert math.pi / 3 < truth.seen < math.pi / 2 + 0.3  # up to the beam that touches its far side
    assert truth.drawn in {"partly", "no"}


def whole_in_the_open(radius_m: float) -> SynthArena:
    """A whole barrel in the middle of the room."""
    empty = room(6.0)
    arcs = np.array([[3.0, 3.0, radius_m, 0.0, 2 * math.pi]])
    arena = replace(empty.arena, radius_m=radius_m, parts=(FiducialPart("1", 3.0, 3.0),))
    return replace(empty, arena=arena, arcs=arcs)


@pytest.mark.parametrize(("way", "drawn"), [(1.5 * math.pi, "yes"), (0.9, "yes"), (0.05, "partly")])
def test_half_of_a_whole_barrel_is_enough(way, drawn):
    """180 degrees are 'yes', 120 'partly': from one place at 2 m one sees 163 degrees, along an arc more."""
    angle = np.linspace(-way / 2, way / 2, 30)
    poses = np.column_stack([3 + 2 * np.cos(angle), 3 + 2 * np.sin(angle), angle + math.pi])
    arena = whole_in_the_open(0.3)
    scans = scan(arena, poses, EXACT, np.random.default_rng(0))

    (truth,) = part_truths(arena, scans, poses, draw_map(scans, poses, MAPPERS["hits"], 0.025))

    assert truth.drawn == drawn


@pytest.mark.parametrize(("radius_m", "resolution_m"), [(0.12, 0.04), (0.15, 0.05), (0.30, 0.10), (0.45, 0.10)])
def test_three_cells_per_radius_are_enough(radius_m, resolution_m):
    """On exact maps all parts that are seen well are drawn, at coarse cells and small radii too."""
    maze = ArenaSpec(5, 4, pairs=4, wholes=1, radius_m=radius_m, pallet_m=1.6, openness=0.3)
    case = make_case(np.random.default_rng(2), CaseSpec(maze, resolution_m=resolution_m))
    seen = [truth for truth in case.truths if truth.seen > 0.85 * truth.opening]

    assert len(seen) >= 6
    assert sum(truth.drawn == "yes" for truth in seen) >= 0.9 * len(seen)


def test_gaps_of_one_cell_are_no_gaps():
    """Beams of 3 degrees hit a small barrel every 8 degrees; its cells cover 19 degrees each."""
    arena = whole_in_the_open(0.15)
    angle = np.linspace(0, 2 * math.pi, 24, endpoint=False)
    poses = np.column_stack([3 + 1.2 * np.cos(angle), 3 + 1.2 * np.sin(angle), angle + math.pi])
    scans = scan(arena, poses, replace(EXACT, step=math.radians(3)), np.random.default_rng(0))

    (truth,) = part_truths(arena, scans, poses, draw_map(scans, poses, MAPPERS["hits"], 0.05))

    assert truth.seen == pytest.approx(2 * math.pi)
    assert truth.drawn == "yes"
