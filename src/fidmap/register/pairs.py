"""Arenas without positions: the halves on one wall find each other by facing apart, the wall between them.

Local consistencies need no more than 'the thickness of the walls' (SSRR 2011, V). Which pair is which group stays
unknown.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array
from scipy.spatial import cKDTree

from fidmap.geometry import ComplexArray, angle_between
from fidmap.model import Arena, ArenaFileError, Assignment, BarrelPart, Finding, FloatArray, Group, Settings
from fidmap.register.problem import FACING_SLACK, OPENING_SLACK
from fidmap.scoring import clipped_loss

# the halves stand on one wall, or on two with a pallet between; groups further apart need ids
WALL_RADII = 6.0
MOST_NODES = 10_000
# the solver's tolerances are absolute: ties are told apart at 1e-10 of a pair
UNIT = 1e6

Pairs = npt.NDArray[np.intp]


@dataclass(frozen=True)
class _Wall:
    """Two parts that stand back to back, and the groups that compare them (of several classes, say)."""

    parts: tuple[str, str]
    groups: tuple[Group, ...]
    openings: tuple[float, float]
    held: int | None = None

    def kind(self, limit: float) -> tuple[object, ...]:
        """Walls of one kind can stand for each other."""
        classes = sorted((group.resolved_class(limit), group.distance_m) for group in self.groups)
        return (tuple(classes), self.openings, self.held)


def pairable(arena: Arena) -> tuple[tuple[str, str], ...]:
    """The pairs of parts that need no ids: both in no other group, on one wall.

    They are on one wall where `distance_m` is at most six radii and both are halves; below two radii they cannot
    be anything else, whatever their opening is said to be.
    """
    return tuple(wall.parts for wall in _walls(arena))


def without_positions(parts: tuple[BarrelPart, ...], arena: Arena, settings: Settings) -> Assignment:
    """What a human said, and the pairs of halves of greatest value among the rest; there is no transform.

    Value is the sum over groups of 1 - min(q(|d - distance_m|), D)/D with the D of consistency.

    Raises:
        ArenaFileError: no part was fixed, and no group can be paired by itself.
    """
    barrel_of = {str(part.fixed_id): j for j, part in enumerate(parts) if part.fixed_id not in {None, "-"}}
    walls = [_holding(wall, barrel_of) for wall in _walls(arena) if not barrel_of.keys() >= set(wall.parts)]
    if not barrel_of and not walls:
        raise ArenaFileError(f"{arena.path}: {nothing_to_go_by()}")
    findings: tuple[Finding, ...] = ()
    if walls:
        found = _paired(parts, walls, arena, settings)
        for wall, pair in found:
            barrel_of |= dict(zip(wall.parts, pair, strict=True))
        findings = _told(len(found), walls, arena.radius_m, settings.long_if_walking_pallets_over)
    fixed = tuple(part.id in barrel_of and parts[barrel_of[part.id]].fixed_id is not None for part in arena.parts)
    return Assignment(tuple(barrel_of.get(part.id) for part in arena.parts), fixed, None, 0.0, findings=findings)


def nothing_to_go_by() -> str:
    """What an arena lacks in which nothing can be assigned."""
    return (
        "no part has a position, so nothing can be assigned by itself: give x_m and y_m for every part, or put the "
        "two halves on each wall into a group with distance_m, or name the parts in the id column of a points file "
        "(--points)"
    )


def _walls(arena: Arena) -> list[_Wall]:
    opening = {part.id: part.opening for part in arena.parts}
    by_pair: dict[frozenset[str], list[Group]] = {}
    for group in arena.groups:
        by_pair.setdefault(frozenset(group.parts), []).append(group)
    walls = []
    for names, groups in by_pair.items():
        alone = not any(names & others for others in by_pair if others != names)
        if alone and all(_on_one_wall(group, opening, arena.radius_m) for group in groups):
            a, b = groups[0].parts
            walls.append(_Wall((a, b), tuple(groups), (min(opening[a], math.pi), min(opening[b], math.pi))))
    return sorted(walls, key=lambda wall: (wall.groups[0].id, wall.parts))


def _on_one_wall(group: Group, opening: dict[str, float], radius_m: float) -> bool:
    if len(group.parts) != 2 or group.distance_m is None:
        return False
    halves = all(opening[name] < 2 * math.pi - 1e-9 for name in group.parts)
    return group.distance_m < 2 * radius_m or (halves and group.distance_m <= WALL_RADII * radius_m)


def _holding(wall: _Wall, barrel_of: dict[str, int]) -> _Wall:
    """A wall one half of which a human named: that part first, with its arc."""
    (a, b), (one, other) = wall.parts, wall.openings
    if a in barrel_of:
        return _Wall((a, b), wall.groups, (one, other), barrel_of[a])
    return _Wall((b, a), wall.groups, (other, one), barrel_of[b]) if b in barrel_of else wall


def _paired(
    parts: tuple[BarrelPart, ...], walls: Sequence[_Wall], arena: Arena, settings: Settings
) -> list[tuple[_Wall, tuple[int, int]]]:
    """Walls with the arcs of their two parts: an exact matching, walls of one kind in the order of arcs and ids."""
    kinds: dict[tuple[object, ...], list[_Wall]] = {}
    for wall in walls:
        kinds.setdefault(wall.kind(settings.long_if_walking_pallets_over), []).append(wall)
    apart = _facing_apart(parts, settings, arena.radius_m, max(g.distance_m or 0.0 for w in walls for g in w.groups))
    choices = [_choices(parts, apart, alike[0], settings) for alike in kinds.values()]
    gains = [
        _gain(parts, pairs, alike[0], arena, settings) for pairs, alike in zip(choices, kinds.values(), strict=True)
    ]
    taken = _match(choices, gains, [len(alike) for alike in kinds.values()], len(parts))
    return [
        (wall, (int(a), int(b)))
        for pairs, alike in zip(taken, kinds.values(), strict=True)
        for wall, (a, b) in zip(alike, pairs, strict=False)
    ]


def _facing_apart(parts: tuple[BarrelPart, ...], settings: Settings, radius_m: float, thickest_m: float) -> Pairs:
    """(K, 2) arcs that may be the two halves on a wall: near enough, facing apart, and not face to face.

    Face to face, with free space between them, one stands in front of the other; a wall drawn twice may put it
    there by less than a radius.
    """
    known = [j for j, part in enumerate(parts) if part.facing is not None and part.fixed_id != "-"]
    if len(known) < 2:
        return np.empty((0, 2), np.intp)
    places = np.array([(parts[j].x_m, parts[j].y_m) for j in known])
    reach = settings.d_max("consistency", radius_m) + thickest_m
    near = np.array(sorted(cKDTree(places).query_pairs(reach)), np.intp).reshape(-1, 2)
    pairs = np.array(known, np.intp)[near]
    facing = np.array([parts[j].facing or 0.0 for j in range(len(parts))])
    opposite = angle_between(facing[pairs[:, 0]], facing[pairs[:, 1]] + math.pi)
    away, outward = _away(parts, pairs)
    good = (opposite < settings.facing_tolerance - FACING_SLACK) & ((away * outward.conj()).real >= -radius_m)
    return np.asarray(pairs[good])


def _away(parts: tuple[BarrelPart, ...], pairs: Pairs) -> tuple[ComplexArray, ComplexArray]:
    """(K,) from the second arc of pairs to the first, x + iy metres, and the direction in which the first faces."""
    places = np.array([complex(part.x_m, part.y_m) for part in parts])
    facing = np.array([np.exp(1j * (part.facing or 0.0)) for part in parts])
    a, b = pairs.T
    outward = facing[a] - facing[b]
    return places[a] - places[b], outward / np.maximum(np.abs(outward), 1e-9)


def _choices(parts: tuple[BarrelPart, ...], apart: Pairs, wall: _Wall, settings: Settings) -> Pairs:
    """(K, 2) arcs for the first and the second part of a wall."""
    both = np.concatenate([apart, apart[:, ::-1]])
    good = np.ones(len(both), bool)
    for side, opening in enumerate(wall.openings):
        least = settings.min_opening * opening - OPENING_SLACK
        free = np.array([_is_free(part, least, settings.min_confidence) for part in parts], bool)
        good &= both[:, side] == wall.held if side == 0 and wall.held is not None else free[both[:, side]]
    kept = both[good]
    _, first = np.unique(np.sort(kept, axis=1), axis=0, return_index=True)  # one way round is enough
    return kept[np.sort(first)]


def _is_free(part: BarrelPart, least: float, least_confidence: float) -> bool:
    return part.fixed_id is None and part.drawn >= least and part.confidence >= least_confidence


def _gain(parts: tuple[BarrelPart, ...], pairs: Pairs, wall: _Wall, arena: Arena, settings: Settings) -> FloatArray:
    """(K,) value, then the number of pairs, then closeness; 0 where a half is D or more off from behind the other."""
    away, outward = _away(parts, pairs)
    distance = np.abs(away)
    d_max = settings.d_max("consistency", arena.radius_m)
    gain = np.zeros(len(pairs))
    near = np.ones(len(pairs), bool)
    for group in wall.groups:
        error = np.abs(distance - (group.distance_m or 0.0))
        closeness = 1 - np.minimum(error, d_max) / d_max
        gain += 1 - clipped_loss(error, settings.rounding, arena.radius_m, d_max) + 1e-7 + 1e-10 * closeness
        near &= np.abs(away - (group.distance_m or 0.0) * outward) < d_max
    return np.where(near, gain, 0.0)


def _match(choices: list[Pairs], gains: list[FloatArray], counts: list[int], arcs: int) -> list[Pairs]:
    """Per kind of wall the chosen pairs, in order: each arc serves once, each kind as often as it has walls."""
    kept = [pairs[gain > 0] for pairs, gain in zip(choices, gains, strict=True)]
    gain = np.concatenate([one[one > 0] for one in gains])
    if len(gain) == 0:
        return kept
    kind = np.repeat(np.arange(len(kept)), [len(pairs) for pairs in kept])
    rows = np.concatenate([np.concatenate(kept).T.ravel(), arcs + kind])
    columns = np.tile(np.arange(len(gain)), 3)
    once = coo_array((np.ones(len(rows)), (rows, columns)), shape=(arcs + len(kept), len(gain)))
    limits = LinearConstraint(once.tocsc(), -np.inf, np.concatenate([np.ones(arcs), counts]))
    solved = milp(
        -UNIT * gain, integrality=np.ones(len(gain)), bounds=Bounds(0, 1), constraints=limits,
        options={"mip_rel_gap": 0.0, "node_limit": MOST_NODES},
    )  # fmt: skip
    used = np.zeros(len(gain), bool) if solved.x is None else solved.x > 0.5
    found = [pairs[used[kind == k]] for k, pairs in enumerate(kept)]
    return [pairs[np.lexsort(np.sort(pairs, axis=1).T[::-1])] for pairs in found]


def _told(found: int, walls: Sequence[_Wall], radius_m: float, limit: float) -> tuple[Finding, ...]:
    """`interchangeable`, and `class-unknown` where pairs of several classes could change places."""
    note = Finding(
        "note", "interchangeable",
        f"the arena has no positions: {found} of {len(walls)} pairs of halves were found by facing apart and by their "
        "distance alone, each given to a group that it fits; ids of groups alike, and of the two halves of a group, "
        "could change places",
        "--points points.csv",
    )  # fmt: skip
    free = [
        ({group.resolved_class(limit) for group in wall.groups}, wall.groups[0].distance_m or 0.0)
        for wall in walls
        if wall.held is None
    ]
    mixed = {name for one, d in free for other, e in free if one != other and abs(d - e) < radius_m for name in one}
    if not mixed:
        return (note,)
    warning = Finding(
        "warning", "class-unknown",
        f"pairs of the classes {' and '.join(sorted(mixed))} have nearly the same distance_m, so which pair is of "
        "which class is not known, and the scores of these classes are one possibility among several; name the parts",
        "--points points.csv",
    )  # fmt: skip
    return (note, warning)
