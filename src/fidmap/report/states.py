"""What became of each fiducial part and each detection: decided once, for JSON, drawing and page alike."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from fidmap.geometry import apply, apply_inverse
from fidmap.model import FiducialPart, PartResult, Report, Transform


class State(Enum):
    """What became of a fiducial part or a barrel part."""

    ASSIGNED = "assigned"
    FIXED = "fixed"
    DOUBTFUL = "doubtful"
    MISSING = "missing"
    UNASSIGNED = "unassigned"
    DISPLACED = "displaced"


@dataclass(frozen=True)
class Mark:
    """One arc of the drawing, in the map's frame; angles in radians, `facing` None for a whole circle.

    label: part id, or the number n of a detection that is no part. n: the detection's number, None for a
    missing part. expected_xy: where the registration expects the part, or where the second move takes a displaced one;
    None where nobody knows.
    """

    state: State
    label: str
    x_m: float
    y_m: float
    facing: float | None
    drawn: float
    n: int | None = None
    expected_xy: tuple[float, float] | None = None
    error_m: float | None = None


def part_states(report: Report) -> dict[str, State]:
    """The state of each fiducial part by id; doubtful are automatic pairs that are more than D/2 apart."""
    limit = report.settings.d_max("relative_accuracy", report.arena.radius_m) / 2
    fixed = {part.id for part, is_fixed in zip(report.arena.parts, report.assignment.fixed, strict=True) if is_fixed}
    states = {}
    for part in report.attributes.parts:
        if part.barrel is None:
            states[part.id] = State.MISSING
        elif part.id in fixed:
            states[part.id] = State.FIXED
        elif part.relative_error_m is not None and part.relative_error_m > limit:
            states[part.id] = State.DOUBTFUL
        else:
            states[part.id] = State.ASSIGNED
    return states


def marks(report: Report) -> tuple[Mark, ...]:
    """Every arc worth drawing, the least important first: so that parts lie on top of loose detections."""
    states = part_states(report)
    taken = {part.barrel.n for part in report.attributes.parts if part.barrel is not None}
    surveyed = {part.id: part for part in report.arena.parts}
    displaced = _displaced_marks(report)
    taken |= {mark.n for mark in displaced if mark.n is not None}
    loose = [
        Mark(State.UNASSIGNED, f"#{arc.n}", arc.x_m, arc.y_m, arc.facing, arc.drawn, arc.n)
        for arc in sorted(report.detections, key=lambda arc: (arc.confidence, -arc.n))
        if arc.n not in taken
    ]
    placed = [
        _part_mark(part, states[part.id], surveyed[part.id], report.assignment.transform)
        for part in report.attributes.parts
    ]
    return (*loose, *(mark for mark in placed if mark is not None), *displaced)


def _displaced_marks(report: Report) -> list[Mark]:
    """The arcs of displaced pieces, named after the parts that they fit, with where the second move takes them."""
    move = report.assignment.transform
    if move is None:
        return []
    found = []
    for piece in report.assignment.displaced:
        for name, j in zip(piece.parts, piece.barrels, strict=True):
            arc = report.detections[j]
            seen = np.array([[arc.x_m, arc.y_m]])
            placed = apply(move, seen)
            home = apply(piece.home, placed)
            x, y = (float(v) for v in apply_inverse(move, home)[0])
            away = float(np.linalg.norm(home - placed))
            found.append(Mark(State.DISPLACED, name, arc.x_m, arc.y_m, arc.facing, arc.drawn, arc.n, (x, y), away))
    return found


def _part_mark(part: PartResult, state: State, surveyed: FiducialPart, transform: Transform | None) -> Mark | None:
    """The mark of one fiducial part: its arc where it is assigned, else the place where it should be."""
    expected = None
    if part.expected_x_m is not None and part.expected_y_m is not None:
        expected = (part.expected_x_m, part.expected_y_m)
    if part.barrel is not None:
        arc = part.barrel
        return Mark(state, part.id, arc.x_m, arc.y_m, arc.facing, arc.drawn, arc.n, expected, part.relative_error_m)
    if expected is None:
        return None
    facing = None if surveyed.facing is None else facing_in_map(surveyed.facing, transform)
    return Mark(state, part.id, *expected, facing, surveyed.opening)


def facing_in_map(facing: float, transform: Transform | None) -> float:
    """An arena direction as the map shows it: the inverse of T_truth_map's rotation and mirroring."""
    if transform is None:
        return facing
    turned = facing - transform.rotation
    return -turned if transform.mirrored else turned


def is_whole(facing: float | None, drawn: float) -> bool:
    """Whether an arc is drawn as a circle: it has no direction, or it closes."""
    return facing is None or drawn >= 2 * math.pi - 1e-6
