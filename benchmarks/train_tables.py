"""What the detector's networks learn from: windows and fits on maps of the tune split and of run A2, with the truth.

Labels are -1 (counts neither way), 0 and 1; targets are lengths along and across a facing, turns, and 1 for wholes.
"""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from benchmarks.counting import NEAR_ANGLE, DrawnPart
from benchmarks.detect_maps import drawn_part
from benchmarks.slam_challenge import read_drawn_parts, real_data_root
from fidmap.detect import half_circles
from fidmap.detect.arcs import Arcs, difference, spotted
from fidmap.detect.coarse import coarser, factor
from fidmap.detect.fits import circles
from fidmap.detect.measure import sizes
from fidmap.detect.network import JUDGE_ANGLES, JUDGE_STEPS, SPOT_ANGLES, SPOT_STEPS
from fidmap.detect.polar import INNERMOST, OUTERMOST, Windower
from fidmap.detect.strips import strips
from fidmap.detect.votes import centre_candidates
from fidmap.grid import cells_to_metres, metres_to_cells, trinarize
from fidmap.maps import read_map
from fidmap.model import FloatArray, Label, TrinaryGrid
from fidmap.synth.poses import Tier
from fidmap.synth.suite import case_rng, make_case, random_spec

SEED = 1
SUITES: dict[Tier, int] = {"clean": 223, "noisy": 416, "broken": 419, "office": 434, "field": 314, "exact": 60}
FINE: dict[Tier, int] = {"clean": 700, "noisy": 830, "broken": 120, "field": 120}  # in cells of 2 to 2.5 cm
FIRST_FINE = 5000  # their first index
IDEAL = 400
A2 = (28, 29, 30, 31, 32, 33, 34, 35, 36, 54, 55, 57, 58, 59, 68, 69)
MOST_WINDOWS = 300  # per map; more come from a few crowded maps
BIN = 2 * np.pi / SPOT_ANGLES
Table = tuple[npt.NDArray[np.generic], ...]


@dataclass(frozen=True, eq=False)
class Drawn:
    """A map with what it draws; `number` seeds whatever is drawn at random from it.

    shown: its parts where it shows them. parts: the same where its scans put them on average, where that is known.
    """

    grid: TrinaryGrid
    radius_m: float
    shown: tuple[DrawnPart, ...]
    parts: tuple[DrawnPart, ...]
    number: int

    @property
    def radius(self) -> float:
        """Cells."""
        return self.radius_m / self.grid.resolution_m

    def place(self, x: float, y: float) -> FloatArray:
        """(row, column) of a place in the map's frame."""
        return np.asarray(metres_to_cells(np.array([[x, y]]), self.grid.resolution_m, self.grid.origin)[0])

    def worn(self, random: np.random.Generator) -> Drawn:
        """The map as programs and people may hand it on: black and white, with thicker walls or holes in them."""
        labels, origin = np.array(self.grid.labels), self.grid.origin
        if random.random() < 0.15:
            labels[labels == Label.UNKNOWN] = Label.FREE
        if random.random() < 0.12:
            black = (labels == Label.OCCUPIED).astype(np.uint8)
            labels[cv2.dilate(black, np.ones((2, 2), np.uint8)) > 0] = Label.OCCUPIED
            x, y = cells_to_metres(np.array([[-0.5, -0.5]]), self.grid.resolution_m, origin)[0]
            origin = replace(origin, x_m=float(x), y_m=float(y))  # the walls' middles have moved by half a cell
        if random.random() < 0.25:
            holes = (labels == Label.OCCUPIED) & (random.random(labels.shape) < random.uniform(0.03, 0.2))
            labels[holes] = random.choice([Label.FREE, Label.UNKNOWN])
        return replace(self, grid=replace(self.grid, labels=labels, origin=origin))


def make_maps(folder: Path) -> list[Path]:
    """The artificial maps, one file each; those that are there already are kept."""
    folder.mkdir(parents=True, exist_ok=True)
    jobs = [(tier, k, folder / f"{tier}-{k:04d}.pickle") for tier, number in SUITES.items() for k in range(number)]
    jobs += [
        (tier, FIRST_FINE + k, folder / f"fine-{tier}-{k:04d}.pickle") for tier, n in FINE.items() for k in range(n)
    ]
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(_make_map, [job for job in jobs if not job[2].exists()], chunksize=4))
    return [path for _, _, path in jobs]


def _make_map(job: tuple[Tier, int, Path]) -> None:
    tier, index, path = job
    rng = case_rng("tune", SEED, tier, index)
    spec = random_spec(rng, tier)
    if index >= FIRST_FINE:
        spec = replace(spec, resolution_m=0.02 if index % 2 else 0.025)
    if tier == "exact":  # what drawings by hand and simulators without noise look like
        spec = replace(spec, laser=replace(spec.laser, noise_m=0.0, mixed=0.0, skew=0.0, tilt=0.0))
    case = make_case(rng, spec, tier=tier)
    shown = tuple(drawn_part(truth) for truth in case.truths)
    voted = tuple(replace(p, x_m=t.voted_x_m, y_m=t.voted_y_m) for p, t in zip(shown, case.truths, strict=True))
    drawn = Drawn(trinarize(case.grid), case.arena.arena.radius_m, shown, voted, int(rng.integers(2**31)))
    path.write_bytes(pickle.dumps(drawn))


def ideal_drawing(number: int) -> Drawn:
    """A wall with halves at exact places and whole barrels beside it: what people and plans draw."""
    random = np.random.default_rng([SEED, number])
    radius, angle, thick = 2.8 + 15 * random.random() ** 2, random.uniform(0, 2 * np.pi), random.uniform(0, 3)
    side = int(12 * radius)
    labels = np.full((side, side), Label.FREE, np.uint8)
    out = np.array([np.cos(angle), np.sin(angle)])  # x, y of the wall's side A
    aside = np.array([-out[1], out[0]])
    wall = side / 2 + random.uniform(-1, 1, 2)
    walls = [wall + sign * thick / 2 * out + np.linspace(-side, side, 8 * side)[:, None] * aside for sign in (1, -1)]
    arcs: list[tuple[FloatArray, float | None]] = []
    for sign in (1, -1):
        facing = float(angle + (0 if sign > 0 else np.pi))
        places = [wall + sign * thick / 2 * out + k * radius * aside for k in (-3, 0, 3)]
        arcs += [(place, facing) for place in places if random.random() < 0.6]
        loose = wall + radius * (sign * random.uniform(3, 4) * out + random.uniform(-3, 3) * aside)
        arcs += [(loose, None)] if random.random() < 0.4 else []
    for place, towards in arcs:
        _fill(labels, place, towards, radius)
    points = walls + [_curve(place, facing, radius) for place, facing in arcs]
    x, y = np.floor(np.concatenate(points)).astype(int).T
    inside = (x >= 0) & (y >= 0) & (x < side) & (y < side)
    labels[y[inside], x[inside]] = Label.OCCUPIED
    parts = [
        DrawnPart(str(n), float(place[0]) * 0.3 / radius, float(place[1]) * 0.3 / radius, facing, "yes", ())
        for n, (place, facing) in enumerate(arcs)
    ]
    return Drawn(TrinaryGrid(labels, 0.3 / radius), 0.3, tuple(parts), tuple(parts), number)


def _fill(labels: npt.NDArray[np.uint8], place: FloatArray, facing: float | None, radius: float) -> None:
    """Nobody saw what is inside of a barrel."""
    y, x = np.mgrid[0 : len(labels), 0 : labels.shape[1]] + 0.5 - place[::-1, None, None]
    ahead = 1.0 if facing is None else x * np.cos(facing) + y * np.sin(facing)
    labels[(np.hypot(x, y) < radius) & (ahead > 0)] = Label.UNKNOWN


def _curve(place: FloatArray, facing: float | None, radius: float) -> FloatArray:
    """Points of a half circle, or of a whole one."""
    reach = np.pi if facing is None else np.pi / 2
    turn = np.linspace(-reach, reach, 4000) + (facing or 0.0)
    return np.asarray(place + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1))


def real_maps() -> list[Drawn]:
    """Run A2."""
    folder = real_data_root() / "slam_challenge"
    parts = {n: read_drawn_parts(folder, f"m{n}") for n in A2}
    return [Drawn(trinarize(read_map(folder / "maps" / f"m{n}.yaml")), 0.3, parts[n], parts[n], n) for n in A2]


def tables(make, paths: Sequence[Path], copies: int, worn: int) -> list[npt.NDArray[np.generic]]:  # type: ignore[no-untyped-def]
    """The rows that `make` finds on artificial and on real maps, each so many times, and on ideal drawings."""
    with ProcessPoolExecutor(2) as pool:
        drawn = (pickle.loads(path.read_bytes()) for path in paths)
        rows = list(pool.map(make, (again for one in drawn for again in _again(one, worn)), chunksize=4))
        rows += pool.map(make, (ideal_drawing(k) for k in range(IDEAL)), chunksize=4)
    rows += [make(again) for drawn in real_maps() for again in _again(drawn, copies)]
    return [np.concatenate(column) for column in zip(*rows, strict=True)]


def _again(drawn: Drawn, copies: int) -> list[Drawn]:
    """The same map with other random numbers."""
    return [replace(drawn, number=drawn.number + 1000 * k) for k in range(copies)]


def spot_table(drawn: Drawn) -> Table:
    """Windows (M, A, steps) of candidates, labels (M, A) and targets (M, A, 4) of every direction, radii (M,)."""
    random = np.random.default_rng(drawn.number)
    windower, drawn = _coarse(drawn.worn(random))
    places = _few(centre_candidates(drawn.grid.labels, windower.radius, 0.33), random)
    places = places + random.normal(0, 0.05 * windower.radius, places.shape)
    start = random.uniform(0, BIN)
    windows = windower.cut(places, np.full(len(places), start), SPOT_ANGLES, SPOT_STEPS)
    theta = np.tile(start + np.arange(SPOT_ANGLES) * BIN, (len(places), 1))
    labels, targets = label(windower, drawn, places, theta, near=0.65, turn=np.radians(13))
    return windows, labels, targets, np.full(len(places), windower.radius, np.float32)


def judge_table(drawn: Drawn) -> Table:
    """Windows (M, A, steps) of half circles as `spotted` finds them, labels (M,), targets (M, 4), radii (M,)."""
    random = np.random.default_rng(drawn.number + 1)
    windower, drawn = _coarse(drawn.worn(random))
    arcs = spotted(windower, centre_candidates(drawn.grid.labels, windower.radius), least=0.0075)
    arcs = arcs.take(_few(np.arange(len(arcs.sure)), random))
    centres = np.concatenate(
        [arcs.centres, arcs.centres + random.normal(0, 0.05 * windower.radius, arcs.centres.shape)]
    )
    facings = np.concatenate([arcs.facings, arcs.facings + random.normal(0, np.radians(6), arcs.facings.shape)])
    windows = windower.cut(centres, facings, JUDGE_ANGLES, JUDGE_STEPS)
    labels, targets = label(windower, drawn, centres, facings[:, None], near=0.4, turn=np.radians(35))
    return windows, labels[:, 0], targets[:, 0], np.full(len(centres), windower.radius, np.float32)


def vote_table(drawn: Drawn) -> Table:
    """Strips (K, D, S), directions (K, D), sizes (K, 4), confidences (K,) of a map's arcs, and what is to be learned.

    That is what is left to their centres (K, 2, 2) in cells, where the map shows them and where its scans put them, NaN
    where they are no parts. Last, the map's first arc (K,).
    """
    random = np.random.default_rng(drawn.number + 2)
    drawn = drawn.worn(random) if random.random() < 0.3 else drawn
    arcs = half_circles(drawn.grid.labels, drawn.radius)
    arcs = arcs.take(arcs.sure >= 0.1)
    at = circles(drawn.grid.labels, arcs, drawn.radius).centres
    at = at + random.normal(0, 0.1, at.shape)
    left = np.stack([_left(drawn, parts, arcs, at) for parts in (drawn.shown, drawn.parts)], axis=1)
    seen = strips(drawn.grid.labels, at, arcs.facings, arcs.reach, drawn.radius)
    first = np.arange(len(at)) == 0
    return seen.labels, seen.relative, sizes(arcs, drawn.radius, drawn.grid.resolution_m), arcs.sure, left, first


def _left(drawn: Drawn, parts: Iterable[DrawnPart], arcs: Arcs, at: FloatArray) -> FloatArray:
    """What is left from places (K, 2) to the parts of the arcs there, along their facings and across, in cells."""
    left = np.full(at.shape, np.nan)
    for part in _yes(parts):
        away = drawn.place(part.x_m, part.y_m) - at  # type: ignore[arg-type]
        turned = np.abs(_turn(part, drawn, arcs.facings))
        fits = (np.hypot(*away.T) < 0.5 * drawn.radius) & (turned < NEAR_ANGLE)
        if fits.any():
            k = int(np.argmax(np.where(fits, arcs.sure, -1)))
            left[k] = np.stack(_along(away[k], arcs.facings[k]))
    return left


def label(
    windower: Windower, drawn: Drawn, centres: FloatArray, facings: FloatArray, near: float, turn: float
) -> tuple[npt.NDArray[np.int8], npt.NDArray[np.float32]]:
    """Labels (M, F) and targets (M, F, 4) of half circles at centres (M, 2), facings (M, F): the nearest part."""
    labels, targets = np.zeros(facings.shape, np.int8), np.zeros((*facings.shape, 4), np.float32)
    nearest = np.full(facings.shape, np.inf)
    for part in drawn.parts:
        for copy in part.copies:
            away = np.hypot(*(centres - drawn.place(*copy)).T) / windower.radius
            labels[(away < 0.75)[:, None] & (labels == 0)] = -1
        if part.x_m is None or part.y_m is None:
            continue
        shift = (drawn.place(part.x_m, part.y_m) - centres) / windower.radius
        away, turned = np.hypot(*shift.T)[:, None], _turn(part, drawn, facings)
        if part.facing is None:  # only facings that see its ring
            turned = np.where(_standing(windower, drawn.place(part.x_m, part.y_m), facings), 0.0, np.pi)
        labels[(away < max(0.67, 1.5 * near)) & (np.abs(turned) < np.radians(55)) & (labels == 0)] = -1
        if part.drawn == "yes":
            true = (away < near) & (np.abs(turned) < turn) & (away < nearest)
            nearest = np.where(true, away, nearest)
            labels[true] = 1
            whole = np.full(facings.shape, float(part.facing is None))
            targets[true] = np.stack([*_along(shift[:, None], facings), turned, whole], axis=-1)[true]
    return labels, targets


def _coarse(drawn: Drawn) -> tuple[Windower, Drawn]:
    """The map in the cells that the detector looks at."""
    times = factor(drawn.radius)
    grid = replace(drawn.grid, labels=coarser(drawn.grid.labels, times), resolution_m=drawn.grid.resolution_m * times)
    return Windower(grid.labels, drawn.radius / times), replace(drawn, grid=grid)


def _yes(parts: Iterable[DrawnPart]) -> list[DrawnPart]:
    return [part for part in parts if part.drawn == "yes" and part.x_m is not None]


def _few(rows: npt.NDArray[np.generic], random: np.random.Generator) -> npt.NDArray:  # type: ignore[type-arg]
    """At most so many rows, drawn at random, in their order."""
    return rows[np.sort(random.permutation(len(rows))[:MOST_WINDOWS])]


def _turn(part: DrawnPart, drawn: Drawn, facings: FloatArray) -> FloatArray:
    """How far facings must turn to agree with a part's; 0 where it has none."""
    if part.facing is None:
        return np.zeros(facings.shape)
    return difference(np.array(part.facing - drawn.grid.origin.yaw), facings)


def _along(shift: FloatArray, facing: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Parts of (..., 2) (row, column) shifts along facings and across them."""
    s, c = np.sin(facing), np.cos(facing)
    return shift[..., 0] * s + shift[..., 1] * c, shift[..., 0] * c - shift[..., 1] * s


def _standing(windower: Windower, centre: FloatArray, facings: FloatArray) -> npt.NDArray[np.bool_]:
    """Which facings see about as much of a whole barrel's ring as the best one: it may be drawn on one side only."""
    window = windower.cut(centre[None], np.zeros(1), SPOT_ANGLES, SPOT_STEPS)[0]
    away = np.abs(np.linspace(INNERMOST, OUTERMOST, SPOT_STEPS) - 1)
    black = ((window == Label.OCCUPIED) & (away <= max(0.2, 1.3 / windower.radius))).any(axis=1)
    half = np.sum([np.roll(black, k) for k in range(-SPOT_ANGLES // 4, SPOT_ANGLES // 4 + 1)], axis=0)
    return np.asarray((half >= half.max() - 2)[np.rint(facings / BIN).astype(int) % SPOT_ANGLES])
