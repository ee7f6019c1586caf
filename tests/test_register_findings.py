"""What a referee is told about a registration, and when nothing is said."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from fidmap.geometry import apply
from fidmap.model import CONTINUOUS, Arena, Assignment, BarrelPart, Finding, Settings, Transform
from fidmap.register import register
from fiducials import arc, arena_of, drawn, half, names, pairs_arena

RING = arena_of(
    *(half(f"{k}", 5 * math.cos(a), 5 * math.sin(a), a) for k, a in enumerate(math.pi / 3 * k for k in range(6)))
)


def finding(result: Assignment, code: str) -> Finding | None:
    return next((f for f in result.findings if f.code == code), None)


def line(*more: float) -> Arena:
    """Five parts on a line, and more."""
    return arena_of(*(half(f"P{k}", x, 0) for k, x in enumerate((0, 4, 9, 15, 22, *more))))


@pytest.mark.parametrize("count", [1, 2, 3])
def test_degenerate(count: int) -> None:
    """One or two parts fit nearly always; from three on nothing is said."""
    arena = line()

    result = register(drawn(arena)[:count], arena, CONTINUOUS)

    assert sum(j is not None for j in result.barrel_of) == count
    told = finding(result, "degenerate")
    assert (told is not None) == (count < 3)
    if told is not None:
        assert told.level == "warning"
        assert told.text.startswith(f"only {count} part(s) assigned")


@pytest.mark.parametrize(("away", "is_told"), [(0.59, False), (0.61, True)])
def test_doubtful_assignment(away: float, is_told: bool) -> None:
    """Named with its distance when it is more than half of D away."""
    arena = line()
    parts = list(drawn(arena))
    parts[2] = replace(parts[2], y_m=parts[2].y_m + away)

    told = finding(register(tuple(parts), arena, CONTINUOUS), "doubtful-assignment")

    assert (told is not None) == is_told
    if told is not None:
        assert f"P2 ({away:.2f} m)" in told.text
        assert told.option == "--points points.csv"


def test_what_a_human_fixed_is_not_doubted() -> None:
    """Only automatic pairs are named."""
    arena = line()
    parts = list(drawn(arena))
    parts[2] = replace(parts[2], y_m=parts[2].y_m + 1.1, fixed_id="P2")

    assert register(tuple(parts), arena, CONTINUOUS).findings == ()


# an agreed frame


def agreed(arena: Arena) -> Arena:
    return replace(arena, frame="map")


def test_a_symmetric_arena_takes_the_placement_nearest_to_the_agreed_frame() -> None:
    """A ring turned by 40 degrees fits best 20 degrees on; a little noise makes another turn better by a hair."""
    arena = agreed(RING)
    for seed in range(3):
        parts = drawn(arena, Transform(math.radians(8), 0.1, 0), 0.01, seed)
        result = register(parts, arena, CONTINUOUS)
        assert result.barrel_of == (0, 1, 2, 3, 4, 5)
        assert result.value > 5.8


def uneven_ring(further_m: float) -> tuple[Arena, tuple[BarrelPart, ...]]:
    """Part 0 of the ring stands further out, in the map it is the part one place on: turning by one place is exact."""
    out = 1 + further_m / 5
    x, y = RING.parts[1].x_m or 0, RING.parts[1].y_m or 0
    parts = list(drawn(RING))
    parts[1] = replace(parts[1], x_m=x * out, y_m=y * out)
    return agreed(replace(RING, parts=(replace(RING.parts[0], x_m=5 * out), *RING.parts[1:]))), tuple(parts)


def test_nearest_placement_says_so_when_it_is_not_the_best() -> None:
    """Turned by one place the six parts fit exactly; as drawn two of them are 2 cm off, which is within 1 %."""
    arena, parts = uneven_ring(0.02)

    result = register(parts, arena, CONTINUOUS)

    told = finding(result, "nearest-placement")
    assert result.barrel_of == (0, 1, 2, 3, 4, 5)
    assert result.value == pytest.approx(6 - 0.04 / 1.2, abs=0.005)
    assert told is not None
    assert told.level == "note"
    assert f"(6.000 against {result.value:.3f})" in told.text
    free = register(parts, replace(arena, frame="relative"), CONTINUOUS)
    assert (free.value, free.barrel_of) == (pytest.approx(6, abs=1e-4), (1, 2, 3, 4, 5, 0))


def test_a_better_placement_by_more_than_one_percent_wins() -> None:
    """The same with 10 cm: the placement that turns by one place is taken."""
    arena, parts = uneven_ring(0.1)

    result = register(parts, arena, CONTINUOUS)

    assert result.barrel_of == (1, 2, 3, 4, 5, 0)
    assert result.value == pytest.approx(6, abs=1e-4)
    assert finding(result, "nearest-placement") is None


def test_a_map_in_the_agreed_frame_has_nothing_to_tell() -> None:
    """No false alarm, noise or not."""
    arena = agreed(pairs_arena())

    assert register(drawn(arena), arena, CONTINUOUS).findings == ()
    assert register(drawn(arena, noise_m=0.05), arena, CONTINUOUS).findings == ()


@pytest.mark.parametrize(("shift", "is_told"), [(1.15, False), (1.25, True)])
def test_frame_mismatch(shift: float, is_told: bool) -> None:
    """When the best placement moves a part by more than D of global accuracy."""
    arena = agreed(pairs_arena())

    told = finding(register(drawn(arena, Transform(0, shift, 0)), arena, CONTINUOUS), "frame-mismatch")

    assert (told is not None) == is_told
    if told is not None:
        assert f"moves parts by up to {shift:.2f} m" in told.text


def test_a_relative_frame_is_never_mismatched() -> None:
    """Nobody agreed on one."""
    arena = pairs_arena()

    assert register(drawn(arena, Transform(1, 30, 30)), arena, CONTINUOUS).findings == ()


# broken maps

BROKEN_ARENA = arena_of(
    *(
        half(f"{k}{side}", x, y + (0.02 if side == "A" else -0.02), math.pi / 2 if side == "A" else -math.pi / 2)
        for k, (x, y) in enumerate(((0, 0), (3, 1), (6, 0), (1, 4), (5, 5), (9, 1), (10, 4), (12, 2)), 1)
        for side in "AB"
    )
)
PIECE = ("6A", "6B", "7A", "7B", "8A", "8B")


def broken(shift: tuple[float, float], turn: float, seed: int = 0, noise_m: float = 0.03) -> tuple[BarrelPart, ...]:
    """The map with its piece turned by `turn` about the piece's middle and shifted."""
    parts = drawn(BROKEN_ARENA, noise_m=noise_m, seed=seed)
    inside = [k for k, p in enumerate(BROKEN_ARENA.parts) if p.id in PIECE]
    points = np.array([(parts[k].x_m, parts[k].y_m) for k in inside])
    middle = points.mean(axis=0)
    moved = apply(Transform(turn), points - middle) + middle + shift
    out = list(parts)
    for k, (x, y) in zip(inside, moved, strict=True):
        out[k] = replace(parts[k], x_m=float(x), y_m=float(y), facing=(parts[k].facing or 0) + turn)
    return tuple(out)


@pytest.mark.parametrize("settings", [CONTINUOUS, replace(CONTINUOUS, rounding="nearest")])
def test_displaced_submap(settings: Settings) -> None:
    """A piece of six parts, 5 m to the upper right and turned by 20 degrees: told so, and unassigned."""
    parts = broken((4.0, 3.0), math.radians(20))

    result = register(parts, BROKEN_ARENA, settings)

    told = finding(result, "displaced-submap")
    assert sorted(names(BROKEN_ARENA, result, parts)) == [p.id for p in BROKEN_ARENA.parts if p.id not in PIECE]
    assert told is not None
    assert told.level == "warning"
    assert told.text.startswith("6A, 6B, 7A, 7B, 8A, 8B fit together, but lie ")
    shift = float(told.text.split(" lie ")[1].split(" m")[0])
    turn = float(told.text.split("turned by ")[1].split(" deg")[0])
    assert shift == pytest.approx(5, abs=0.15)
    assert turn == pytest.approx(20, abs=3)
    (piece,) = result.displaced
    assert piece.parts == PIECE
    home = apply(piece.home, apply(result.transform, np.array([(parts[j].x_m, parts[j].y_m) for j in piece.barrels])))
    truth = [(p.x_m, p.y_m) for p in BROKEN_ARENA.parts if p.id in PIECE]
    assert home == pytest.approx(np.array(truth, float), abs=0.2)


def test_the_shift_is_told_in_the_arenas_axes() -> None:
    """The whole map is drawn upside down: the shift against the rest stays what it is in the arena."""
    parts = broken((4.0, 3.0), math.radians(20), noise_m=0.0)
    flipped = tuple(replace(p, x_m=-p.x_m, y_m=-p.y_m, facing=(p.facing or 0) + math.pi) for p in parts)

    for shown in (parts, flipped):
        told = finding(register(shown, BROKEN_ARENA, CONTINUOUS), "displaced-submap")
        assert told is not None
        assert "lie 5.00 m (x +4.00, y +3.00 in the arena) from their places, turned by +20.0 degrees" in told.text


def test_two_parts_are_no_piece() -> None:
    """Two fit nearly always."""
    parts = broken((4.0, 3.0), math.radians(20))
    left = tuple(p for p, f in zip(parts, BROKEN_ARENA.parts, strict=True) if f.id not in {"7A", "7B", "8A", "8B"})

    assert register(left, BROKEN_ARENA, CONTINUOUS).findings == ()


def test_missing_parts_and_false_arcs_are_no_piece() -> None:
    """Six parts are not drawn and five arcs are false: no alarm."""
    for seed in range(2):
        random = np.random.default_rng(seed)
        true = [
            p
            for p, f in zip(drawn(BROKEN_ARENA, noise_m=0.05, seed=seed), BROKEN_ARENA.parts, strict=True)
            if f.id not in PIECE
        ]
        false = [arc(50 + k, *random.uniform(-2, 14, 2).tolist(), float(random.uniform(-3, 3))) for k in range(5)]
        result = register((*true, *false), BROKEN_ARENA, CONTINUOUS)
        assert finding(result, "displaced-submap") is None


def test_parts_drawn_twice_are_no_piece() -> None:
    """A second copy of assigned parts fits nothing that is unassigned."""
    parts = drawn(BROKEN_ARENA)
    copies = tuple(replace(p, n=p.n + 50, x_m=p.x_m + 2.0, y_m=p.y_m + 1.5) for p in parts[:6])

    assert finding(register((*parts, *copies), BROKEN_ARENA, CONTINUOUS), "displaced-submap") is None


def test_what_a_human_took_out_is_no_piece() -> None:
    """Arcs marked '-' are nobody's."""
    parts = tuple(
        replace(p, fixed_id="-") if f.id in PIECE else p
        for p, f in zip(broken((4.0, 3.0), 0.3), BROKEN_ARENA.parts, strict=True)
    )

    assert finding(register(parts, BROKEN_ARENA, CONTINUOUS), "displaced-submap") is None
