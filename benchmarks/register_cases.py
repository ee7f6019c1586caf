"""Registration problems with known or without known optima: the 60 given ones, and our own with facings."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.slam_challenge import real_data_root
from fidmap.model import Arena, BarrelPart, FiducialPart, FloatArray, Group

RADIUS = 0.3


@dataclass(frozen=True)
class Case:
    """An arena, the arcs of a map of it, the true pairs (index or -1 per arc) and the known optima, if any."""

    name: str
    arena: Arena
    parts: tuple[BarrelPart, ...]
    true_part_of: tuple[int, ...]
    best: dict[str, float | None]

    def fixed(self) -> tuple[BarrelPart, ...]:
        """The arcs as a human would name them; false arcs are nobody's."""
        ids = [self.arena.parts[k].id if k >= 0 else "-" for k in self.true_part_of]
        return tuple(replace(p, fixed_id=name) for p, name in zip(self.parts, ids, strict=True))


def given(faced: bool = False) -> list[Case]:
    """The 60 cases beside the checkout; with facings the halves of a pair face apart, singles as a seed says."""
    path = real_data_root() / "registration" / "cases.json"
    if not path.is_file():
        return []
    return [_given(case, faced) for case in json.loads(path.read_text(encoding="utf-8"))]


def _given(case: dict[str, object], faced: bool) -> Case:
    truth, seen = (np.array(case[key], float) for key in ("fiducial_parts_xy", "barrel_parts_xy"))
    pair, true_of = np.array(case["pair"]), np.array(case["true_part_of"])
    random = np.random.default_rng(int(str(case["id"])))
    out = np.full(len(truth), math.nan)
    if faced:
        out = np.array([_outward(truth, pair, k, random) for k in range(len(truth))])
    shown = np.where(true_of >= 0, out[true_of] - _turn(truth, seen, true_of), random.uniform(-3, 3, len(seen)))
    names = [f"{k:03d}" for k in range(len(truth))]
    groups = [tuple(names[k] for k in np.flatnonzero(pair == one)) for one in np.unique(pair)]
    arena = Arena(
        str(case["id"]), RADIUS,
        tuple(_part(name, xy, facing) for name, xy, facing in zip(names, truth, out, strict=True)),
        tuple(Group(str(k), both, "short") for k, both in enumerate(groups) if len(both) == 2),
    )  # fmt: skip
    arcs = tuple(_arc(n, xy, f if faced else math.nan) for n, (xy, f) in enumerate(zip(seen, shown, strict=True), 1))
    best = case["best"]
    assert isinstance(best, dict)
    return Case(arena.name, arena, arcs, tuple(int(k) for k in true_of), best)


def _part(name: str, xy: FloatArray, facing: float) -> FiducialPart:
    return FiducialPart(name, float(xy[0]), float(xy[1]), None if math.isnan(facing) else float(facing), math.pi)


def _arc(n: int, xy: FloatArray, facing: float) -> BarrelPart:
    return BarrelPart(n, float(xy[0]), float(xy[1]), None if math.isnan(facing) else float(facing), math.pi)


def _outward(truth: FloatArray, pair: FloatArray, k: int, random: np.random.Generator) -> float:
    """Away from the other half on the same wall; without one along an axis."""
    single = int(random.integers(4)) * math.pi / 2
    for other in np.flatnonzero(pair == pair[k]):
        away = truth[k] - truth[other]
        if other != k and np.hypot(*away) < 0.5:
            return math.atan2(away[1], away[0])
    return single


def _turn(truth: FloatArray, seen: FloatArray, true_of: FloatArray) -> float:
    """The rotation of the map, by least squares on the true pairs."""
    known = true_of >= 0
    if known.sum() < 2:
        return 0.0
    p, q = truth[true_of[known]] @ [1, 1j], seen[known] @ [1, 1j]
    return float(np.angle(((q - q.mean()).conj() * (p - p.mean())).sum()))


def own(seed: int) -> Case:
    """Halves on walls of a pallet grid with their facings, drawn with noise, some missing, some false, turned."""
    random = np.random.default_rng(seed)
    pairs, side = int(random.choice([3, 5, 8, 12, 20])), 1.2
    spots = random.permutation(49)[:pairs]
    places = np.stack([spots % 7, spots // 7], axis=1) * side
    facing = random.integers(4, size=pairs) * math.pi / 2
    step = 0.05 * np.stack([np.cos(facing), np.sin(facing)], axis=1)
    truth = np.concatenate([places + step, places - step])
    out = np.concatenate([facing, facing + math.pi])
    names = [f"{k}{half}" for half in "AB" for k in range(pairs)]
    arena = Arena(
        f"own {seed}", RADIUS, tuple(_part(*one) for one in zip(names, truth, out, strict=True)),
        tuple(Group(f"{k}", (f"{k}A", f"{k}B"), "short") for k in range(pairs)),
    )  # fmt: skip
    noise, missing, false = random.choice([0.02, 0.1, 0.3]), random.uniform(0, 0.5), random.uniform(0, 0.4)
    kept = np.flatnonzero(random.random(2 * pairs) >= missing)
    extra = int(false * len(kept))
    turn = random.uniform(-math.pi, math.pi)
    places = np.concatenate([truth[kept] + random.normal(0, noise, (len(kept), 2)), random.uniform(0, 8, (extra, 2))])
    seen = places @ [1, 1j] * np.exp(1j * turn) + complex(*random.uniform(-20, 20, 2))
    shown = np.concatenate([out[kept] + turn + random.normal(0, 0.1, len(kept)), random.uniform(-3, 3, extra)])
    arcs = tuple(_arc(n, np.array([z.real, z.imag]), f) for n, (z, f) in enumerate(zip(seen, shown, strict=True), 1))
    return Case(arena.name, arena, arcs, (*kept.tolist(), *(-1,) * extra), {})
