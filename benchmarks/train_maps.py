"""Maps that the detector's networks learn from, with their truth: artificial (tune split), ideal drawings, run A2."""

from __future__ import annotations

import pickle
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from benchmarks.counting import DrawnPart
from benchmarks.detect_maps import drawn_part
from benchmarks.slam_challenge import read_drawn_parts, real_data_root
from fidmap.grid import cells_to_metres, metres_to_cells, trinarize
from fidmap.maps import read_map
from fidmap.model import FloatArray, Label, TrinaryGrid
from fidmap.synth.poses import Tier
from fidmap.synth.suite import case_rng, make_case, random_spec

SEED = 1
FINE = 5_000  # from this index on cells are of 2 to 2.5 cm
STEADY = 10_000  # from this one on, most of them; and poses are better
LOTS: dict[int, dict[Tier, int]] = {  # how many maps, by their first index
    0: {"clean": 223, "noisy": 416, "broken": 419, "office": 434, "field": 314, "exact": 60},
    1_000: {"noisy": 300, "broken": 1500, "office": 300},
    FINE: {"clean": 700, "noisy": 830, "broken": 120, "field": 120},
    STEADY: {"clean": 900, "noisy": 900},
}
IDEAL = 400
A2 = (28, 29, 30, 31, 32, 33, 34, 35, 36, 54, 55, 57, 58, 59, 68, 69)


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


def make_maps(folder: Path, lots: Iterable[int]) -> list[Path]:
    """The artificial maps of some lots, one file each; those that are there already are kept."""
    folder.mkdir(parents=True, exist_ok=True)
    which = [(tier, first + k) for first in lots for tier, number in LOTS[first].items() for k in range(number)]
    jobs = [(tier, index, folder / f"{tier}-{index:05d}.pickle") for tier, index in which]
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(_make_map, [job for job in jobs if not job[2].exists()], chunksize=4))
    return [path for _, _, path in jobs]


def _make_map(job: tuple[Tier, int, Path]) -> None:
    tier, index, path = job
    rng = case_rng("tune", SEED, tier, index)
    spec = random_spec(rng, tier)
    if index >= FINE and (index < STEADY or index % 4):
        spec = replace(spec, resolution_m=0.02 if index % 2 else 0.025)
    if index >= STEADY:
        spec = replace(spec, noise=spec.noise.times(float(rng.uniform(0.2, 0.8))))
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
