from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from fidmap.synth.arena import SynthArena
from fidmap.synth.draws import random_field_spec, random_office_spec, random_radius
from fidmap.synth.drive import CELL_M, FreeSpace
from fidmap.synth.field import FieldSpec, make_field
from fidmap.synth.floor import LEFT, RIGHT, Floor, Wall
from fidmap.synth.joinery import Joinery, add_door, add_niche, put_on_wall
from fidmap.synth.laser import Laser, cast, scan
from fidmap.synth.office import OfficeSpec, make_office
from fidmap.synth.suite import random_spec, suite
from fidmap.synth.trajectory import drive

PLAIN = Joinery(frame_m=0.1, proud_m=0.0, both=True, leaves=0.0)


def look(floor: Floor, x: float, y: float, yaw: float) -> float:
    """Range of one beam on a floor."""
    return float(cast(*floor.outline(), np.array([[x, y, yaw, 0.1]]), 1)[0][0, 0])


def built(wall: Wall, floor: Floor) -> Floor:
    """The floor with the wall drawn."""
    wall.build(floor)
    return floor


def test_a_wall_is_as_thick_as_asked_for_and_open_in_its_gaps():
    """A wall on y = 0 of 0.2 m: seen from above at y = 0.1, from below at -0.1; one looks through the gap."""
    wall = Wall((0.0, 0.0), (4.0, 0.0), 0.2)
    wall.gaps.append((1.0, 2.0))
    floor = built(wall, Floor(0.3))

    assert look(floor, 3.0, 2.0, -math.pi / 2) == pytest.approx(1.9)
    assert look(floor, 3.0, -2.0, math.pi / 2) == pytest.approx(1.9)
    assert look(floor, 1.5, 2.0, -math.pi / 2) == math.inf


def test_halves_of_a_pair_stand_back_to_back_on_their_walls_surfaces():
    """Centres one thickness apart, facings opposite and away from the wall, at any direction of the wall."""
    floor, wall = Floor(0.3), Wall((1.0, 1.0), (3.0, 4.0), 0.25)

    assert put_on_wall(np.random.default_rng(0), floor, wall, (LEFT, RIGHT))

    (ax, ay, _, a, _), (bx, by, _, b, _) = floor.arcs
    assert math.dist((ax, ay), (bx, by)) == pytest.approx(0.25)
    assert abs(math.remainder(a - b, 2 * math.pi)) == pytest.approx(math.pi)
    assert (ax - bx) * math.cos(a) + (ay - by) * math.sin(a) == pytest.approx(0.25)
    assert not put_on_wall(np.random.default_rng(0), floor, Wall((1.0, 1.0), (1.2, 1.3), 0.25), (LEFT,))


def test_doors_are_wide_enough_and_shut_ones_are_shut():
    """One looks through an open door and at the leaf of a shut one, at most half a thickness away."""
    for closed in (False, True):
        floor, wall = Floor(0.3), Wall((0.0, 0.0), (4.0, 0.0), 0.2)
        before, behind = add_door(np.random.default_rng(1), floor, wall, 2.0, PLAIN, inside=LEFT, closed=closed)
        wall.build(floor)

        assert (before[1], behind[1]) == (pytest.approx(-0.8), pytest.approx(0.8))
        assert look(floor, 2.0, 2.0, -math.pi / 2) == (pytest.approx(2.0, abs=0.1) if closed else math.inf)
        assert look(floor, 1.9, 0.0, 0.0) >= 0.4


def test_frames_stick_out_of_the_wall():
    """A frame of 0.1 m beside the opening is met 0.12 m before the wall."""
    floor, wall = Floor(0.3), Wall((0.0, 0.0), (4.0, 0.0), 0.2)
    add_door(np.random.default_rng(1), floor, wall, 2.0, replace(PLAIN, proud_m=0.12), inside=LEFT)
    edge = wall.gaps[0][1]
    wall.build(floor)

    assert look(floor, edge + 0.05, 2.0, -math.pi / 2) == pytest.approx(2.0 - 0.1 - 0.12)
    assert look(floor, edge + 0.15, 2.0, -math.pi / 2) == pytest.approx(1.9)


def test_a_niche_is_closed_at_its_back():
    """No beam passes; from the open side it goes farther than the wall's surface."""
    floor, wall = Floor(0.3), Wall((0.0, 0.0), (6.0, 0.0), 0.1, (LEFT,))

    assert add_niche(np.random.default_rng(2), floor, wall)

    wall.build(floor)
    deep = look(floor, sum(wall.gaps[0]) / 2, 1.0, -math.pi / 2)
    assert 1.0 < deep < 1.36
    assert look(floor, sum(wall.gaps[0]) / 2, -1.0, math.pi / 2) <= 0.95


def two_rooms(door_m: float) -> FreeSpace:
    """Rooms of 3 x 3 m side by side; the wall between them is open from y = 1 upwards."""
    floor = Floor(0.3)
    wall = Wall((3.0, 0.0), (3.0, 3.0), 0.1)
    wall.gaps.append((1.0, 1.0 + door_m))
    wall.build(floor)
    return FreeSpace(*floor.outline(), (6.0, 3.0))


def test_a_robot_goes_through_doors_only():
    """The way from room to room leads through a door of 0.9 m; one of 0.4 m is too narrow."""
    goals = [(0.7, 2.5), (5.3, 2.5)]
    way = two_rooms(0.9).tour(goals)
    at_wall = np.interp(3.0, way[:, 0], way[:, 1])

    assert 1.2 < at_wall < 1.7
    assert math.dist(way[-1], goals[1]) < CELL_M
    assert two_rooms(0.9).distance_m(*goals) > 4.8
    assert len({x < 3 for x in two_rooms(0.4).centres[:, 0]}) == 1


@pytest.fixture(scope="module")
def offices() -> list[SynthArena]:
    """Random offices of all sizes."""
    rngs = [np.random.default_rng(seed) for seed in range(8)]
    return [make_office(rng, random_office_spec(rng, random_radius(rng, 0.05))) for rng in rngs]


def test_offices_have_all_that_was_asked_for_as_far_as_there_is_room(offices):
    """Most have pairs; every group is a pair of halves; things that are no fiducials have other radii."""
    assert sum(len(office.arena.groups) >= 2 for office in offices) >= 6
    for office in offices:
        clutter = office.arcs[office.arc_part < 0]
        rounds = clutter[clutter[:, 4] > 3]  # counters and rounded corners are less than half a circle
        assert np.all(np.abs(rounds[:, 2] / office.arena.radius_m - 1) > 0.15)
        assert all(len(group.parts) == 2 and group.walking_pallets > 0 for group in office.arena.groups)


def test_the_robot_never_drives_through_things(offices):
    """Its ways keep 26 cm from walls and rounds, of which smoothing leaves at least 5."""
    for office in offices:
        poses = drive(office, np.random.default_rng(0), spacing_m=0.5)
        fans = np.column_stack([poses[:, :2], np.zeros(len(poses)), np.full(len(poses), math.radians(10))])
        nearest = cast(office.walls, office.arcs, fans, 36)[0].min(axis=1)

        assert len(poses) > 20
        assert nearest.min() > 0.05


def test_people_come_and_go():
    """The first half of a drive sees nobody, the second half somebody a metre ahead, who is no fiducial."""
    arena = make_field(np.random.default_rng(0), FieldSpec(wholes=0, walls=0, things=0, pairs=0, people=0))
    somebody = np.array([[7.1, 6.0, 0.1, 0.0, 2 * math.pi]])
    arena = replace(arena, crowds=(np.zeros((0, 5)), somebody))
    exact = Laser(noise_m=0, mixed=0, dropout=0)

    scans = scan(arena, np.tile([6.0, 6.0, 0.0], (4, 1)), exact, np.random.default_rng(0))

    assert scans.ranges[:, len(scans.bearings) // 2] == pytest.approx([5.95, 5.95, 1.0, 1.0])
    assert (scans.parts == -1).all()


def test_a_silent_laser_returns_nothing_from_afar():
    """Beams beyond reach are NaN instead of inf."""
    arena = make_field(np.random.default_rng(0), FieldSpec(wholes=0, walls=0, things=0, pairs=0, people=0))
    laser = Laser(max_range_m=3.0, dropout=0)

    for silent in (False, True):
        ranges = scan(
            arena, np.array([[6.0, 6.0, 0.0]]), replace(laser, silent=silent), np.random.default_rng(0)
        ).ranges
        assert np.isnan(ranges).all() == silent


def test_a_one_sided_drive_stays_on_its_side():
    """In the lower third of a field of 12 m, and half of the field's barrels are above it."""
    field = make_field(np.random.default_rng(3), FieldSpec(one_sided=True, pattern="row", people=0))

    assert field.way[:, 1].max() < 0.4 * 12
    assert min(part.y_m for part in field.arena.parts if part.facing is None) > 0.4 * 12


def test_rows_and_grids_of_a_field_are_regular():
    """In a row of five the steps from barrel to barrel are equal within the unevenness."""
    spec = FieldSpec(size_m=30, wholes=5, pattern="row", pairs=0)
    parts = make_field(np.random.default_rng(4), spec).arena.parts
    steps = np.hypot(*np.diff([(p.x_m, p.y_m) for p in parts], axis=0).T)

    assert len(parts) == 5
    assert steps == pytest.approx(np.full(4, steps.mean()), rel=0.2)


@pytest.mark.parametrize("make", [make_office, make_field])
def test_the_same_seed_gives_the_same_place(make):
    """All randomness comes from the generator."""
    first, again = (make(np.random.default_rng(9)) for _ in range(2))

    assert first.arena == again.arena
    assert np.array_equal(first.walls, again.walls)
    assert np.array_equal(first.way, again.way)


def test_impossible_places_are_refused():
    """Too small for corridors and rooms, or for any barrel."""
    with pytest.raises(ValueError, match="1 or 2 corridors, 8 m of width, and 7 or 11 m of depth"):
        make_office(np.random.default_rng(0), OfficeSpec(depth_m=8, corridors=2))
    with pytest.raises(ValueError, match="a field needs 5 m or more"):
        make_field(np.random.default_rng(0), FieldSpec(size_m=4))


@pytest.mark.parametrize("tier", ["office", "field"])
def test_offices_and_fields_come_as_suites(tier):
    """Maps with most of their parts seen, the same again for the same seed, at few enough cells."""
    first, again = next(suite("tune", 3, 1, tier)), next(suite("tune", 3, 2, tier))

    assert np.array_equal(first.grid.occupancy, again.grid.occupancy, equal_nan=True)
    assert first.truths == again.truths
    assert any(truth.drawn_x_m is not None for truth in first.truths)


@pytest.mark.parametrize("tier", ["clean", "broken", "large", "office", "field"])
def test_six_of_ten_cases_have_robocups_radius(tier):
    """The others 0.12 to 0.45 m and at least 2.8 cells; mazes leave a way beside wide barrels."""
    specs = [random_spec(np.random.default_rng(seed), tier) for seed in range(200)]
    radii = np.array([spec.arena.radius_m for spec in specs])

    assert 0.5 < np.mean(radii == 0.30) < 0.7
    assert radii.min() >= 0.12
    assert radii.max() <= 0.45
    assert all(spec.arena.radius_m >= 2.8 * spec.resolution_m for spec in specs)
    if tier not in {"office", "field"}:
        assert all(2 * spec.arena.radius_m <= 0.6 * spec.arena.pallet_m for spec in specs)


def test_random_specs_can_all_be_built():
    """No draw of an office or a field is refused."""
    for seed in range(10):
        rng = np.random.default_rng(seed)
        assert len(make_field(rng, random_field_spec(rng, 0.2)).way) > 1
