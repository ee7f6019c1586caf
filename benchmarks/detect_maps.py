"""One map of the detection benchmark: made or read, searched, counted; what a worker process does."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.counting import Count, DrawnPart, count
from benchmarks.slam_challenge import read_drawn_parts, real_data_root
from fidmap.detect import find_barrel_parts
from fidmap.grid import metres_to_cells, trinarize
from fidmap.maps import read_map
from fidmap.model import BarrelPart, Pose2, TrinaryGrid
from fidmap.synth.poses import Tier
from fidmap.synth.suite import Split, case_rng, make_case, random_spec, with_radius
from fidmap.synth.truth import PartTruth

SEED = 3000
LEAST_DRAWN = math.radians(120) - 1e-9
WINDOW = 3.0  # radii around a fault that its picture shows
Truths = dict[str, PartTruth]


@dataclass(frozen=True)
class Job:
    """An artificial map (tier and index of a split) or a real one (its name); labels go to `folder`.

    resolution_m: None draws it at random, and the radius; else barrels of 0.30 m in cells of this side, so that maps
    of one index differ by their cells alone. pose_errors: what those of the tier are multiplied by.
    """

    group: str
    index: int = 0
    real: str | None = None
    resolution_m: float | None = None
    pose_errors: float = 1.0
    folder: Path | None = None
    split: Split = "test"


@dataclass(frozen=True, eq=False)
class Fault:
    """A miss or a false find with the map around it: labels with row 0 lowest, centre and facings in the window.

    best: of a miss, the confidence of the best detection that would have been right, 0 without one.
    """

    kind: str
    map: str
    weight: float
    best: float
    labels: npt.NDArray[np.uint8]
    centre_rc: tuple[float, float]
    radius: float
    facing: float | None
    resolution_m: float


@dataclass(frozen=True, eq=False)
class Tried:
    """What came out on one map; `seconds` are of one thread's CPU.

    truths: of an artificial map.
    """

    job: Job
    name: str
    radius_m: float
    resolution_m: float
    origin: Pose2
    cells: int
    seconds: float
    parts: tuple[DrawnPart, ...]
    count: Count
    faults: tuple[Fault, ...] = field(default=())
    truths: Truths = field(default_factory=dict)


def attempt(job: Job) -> Tried:
    """Make or read the map, find the parts, count them."""
    grid, radius_m, parts, truths, name = _real(job.real) if job.real else _artificial(job)
    find_barrel_parts(_corner(grid), radius_m)  # first calls set things up
    start = time.process_time()
    found = find_barrel_parts(grid, radius_m)
    seconds = time.process_time() - start
    counted = count([part for part in found if part.drawn >= LEAST_DRAWN], parts, radius_m)
    if job.folder is not None:
        np.save(job.folder / f"{name}.npy", grid.labels)
    faults = () if job.real else tuple(_faults(grid, radius_m, counted, truths, name))
    return Tried(
        job, name, radius_m, grid.resolution_m, grid.origin, grid.labels.size, seconds, parts, counted, faults, truths
    )  # fmt: skip


def died(job: Job) -> Tried:
    """A worker that died leaves nothing to count."""
    raise MemoryError(f"the process that worked on {job} died; run the benchmark with more memory")


def _artificial(job: Job) -> tuple[TrinaryGrid, float, tuple[DrawnPart, ...], Truths, str]:
    tier: Tier = job.group  # type: ignore[assignment]
    rng = case_rng(job.split, SEED, tier, job.index)
    spec, name = random_spec(rng, tier), f"{tier}-{job.index:03d}"
    if job.resolution_m is not None:
        spec = with_radius(replace(spec, resolution_m=job.resolution_m, noise=spec.noise.times(job.pose_errors)), 0.3)
        name += f"-{job.resolution_m:g}m-{job.pose_errors:g}"
    case = make_case(rng, spec, tier=tier)
    parts = tuple(drawn_part(truth) for truth in case.truths)
    return trinarize(case.grid), case.arena.arena.radius_m, parts, {t.id: t for t in case.truths}, name


def drawn_part(truth: PartTruth) -> DrawnPart:
    """An artificial map's truth in the words of the counting."""
    return DrawnPart(truth.id, truth.drawn_x_m, truth.drawn_y_m, truth.drawn_facing, truth.drawn, truth.copies)


def _real(name: str) -> tuple[TrinaryGrid, float, tuple[DrawnPart, ...], Truths, str]:
    folder = real_data_root() / "slam_challenge"
    grid = trinarize(read_map(folder / "maps" / f"{name}.yaml"))
    return grid, 0.3, read_drawn_parts(folder, name), {}, f"real-{name}"


def _corner(grid: TrinaryGrid) -> TrinaryGrid:
    return TrinaryGrid(np.ascontiguousarray(grid.labels[:100, :100]), grid.resolution_m)


def _faults(grid: TrinaryGrid, radius_m: float, counted: Count, truths: Truths, name: str) -> list[Fault]:
    """Misses, those drawn best first to be shown, and false finds by their confidence."""
    sure = counted.above(0.5)
    late = {v.part.id: v.detection.confidence for v in counted.of("true") if v.part is not None}
    missed = [
        (BarrelPart(0, part.x_m, part.y_m, part.facing), "miss", (_clear(truths[part.id]), late.get(part.id, 0.0)))
        for part in sure.missed
        if part.x_m is not None and part.y_m is not None
    ]
    false = [(find, "false", (find.confidence, find.confidence)) for find in sure.false]
    return [_fault(grid, radius_m, at, name, kind, numbers) for at, kind, numbers in missed + false]


def _clear(truth: PartTruth) -> float:
    """The share of a part's opening that a map draws without anything before it."""
    return (truth.support - truth.clutter) / truth.opening


def _fault(
    grid: TrinaryGrid, radius_m: float, at: BarrelPart, name: str, kind: str, numbers: tuple[float, float]
) -> Fault:
    """Cut the window; cells beyond the map are unknown."""
    radius = radius_m / grid.resolution_m
    row, column = metres_to_cells(np.array([[at.x_m, at.y_m]]), grid.resolution_m, grid.origin)[0]
    reach = math.ceil(WINDOW * radius)
    first = int(row) - reach, int(column) - reach
    window = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    rows, columns = (slice(max(0, f), max(0, f + 2 * reach + 1)) for f in first)
    inside = grid.labels[rows, columns]
    top, left = max(0, -first[0]), max(0, -first[1])
    window[top : top + inside.shape[0], left : left + inside.shape[1]] = inside
    facing = None if at.facing is None else at.facing - grid.origin.yaw
    centre = (float(row) - first[0], float(column) - first[1])
    return Fault(kind, name, *numbers, window, centre, radius, facing, grid.resolution_m)
