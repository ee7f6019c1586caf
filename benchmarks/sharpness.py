"""`./run bench sharpness [--quick]`: does resolution quality follow the jitter of poses, whatever the cells?

Arenas of the test split, mapped with exact headings and positions that jitter; evaluated where the parts truly are.
Writes its section of docs/benchmarks.md and its picture. `--quick` takes few levels of the tune split, writes nothing.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import spearmanr

from benchmarks.page import PAGE, table, write_section
from benchmarks.plot import write_lines
from fidmap.detect import with_spreads
from fidmap.grid import cells_to_metres, trinarize
from fidmap.model import BarrelPart, FloatArray, Label, TrinaryGrid
from fidmap.study.pool import run
from fidmap.synth.arena import ArenaSpec
from fidmap.synth.laser import Laser
from fidmap.synth.mappers import MAPPERS
from fidmap.synth.poses import PoseNoise
from fidmap.synth.suite import CaseSpec, Split, SynthCase, case_rng, make_case

RADIUS_M = 0.3
RESOLUTIONS_M = (0.02, 0.025, 0.05, 0.10)
LEVELS = 20
ANCHORS_M = (0.0, RADIUS_M / 4, RADIUS_M / 2)
MOST_JITTER_M = 0.6 * RADIUS_M
LEAST_SCANS = 20
MAZES = 6
SEED = 78
COLOURS = ("#0072b2", "#009e73", "#d55e00", "#cc79a7")
ABOUT = f"""Mazes of the test split with 20 scans a part and more, exact headings, each scan's x and y off by
N(0, jitter), a mapper that counts hits, R = {RADIUS_M:g} m; quality where the parts truly stand, the median over parts.
The mean of {MAZES} mazes, and the lowest and highest of one; anchors in the first row. Cut: the same maps with a
third of every arc wiped out, to unknown.
"""


@dataclass(frozen=True)
class Job:
    """The maps of one maze and cell size: the same drive at every level of jitter, the first of them none."""

    maze: int
    resolution_m: float
    jitters_m: tuple[float, ...]
    split: Split


def qualities(job: Job) -> list[tuple[float, float]]:
    """Per level, resolution quality of all parts, and with a third of each arc's cells away."""
    exact = _case(job, 0.0)
    parts = [
        BarrelPart(n, t.drawn_x_m, t.drawn_y_m, t.drawn_facing)  # type: ignore[arg-type]
        for n, t in enumerate(exact.truths, start=1)
        if t.drawn_x_m is not None and t.drawn_facing is not None and t.scans >= LEAST_SCANS
    ]
    grids = [trinarize(_case(job, jitter).grid) for jitter in job.jitters_m]
    return [(_median(grid, parts), _median(cut(grid, parts), parts)) for grid in grids]


def _case(job: Job, jitter_m: float) -> SynthCase:
    spec = CaseSpec(
        arena=ArenaSpec(columns=6, rows=5, pairs=8, void_pairs=0, wall_m=0.02),
        laser=Laser(noise_m=0.005, step=math.radians(0.5)),
        noise=PoseNoise(jitter_m=jitter_m),
        mapper=MAPPERS["hits"],
        resolution_m=job.resolution_m,
        spacing_m=0.2,
    )
    return make_case(case_rng(job.split, SEED, "exact", job.maze), spec, tier="exact")


def _median(grid: TrinaryGrid, parts: Sequence[BarrelPart]) -> float:
    spreads = [part.spread_m for part in with_spreads(grid, parts, RADIUS_M) if part.spread_m is not None]
    return float(np.median([1 - min(1.0, s / (RADIUS_M / 2)) for s in spreads]))


def cut(grid: TrinaryGrid, parts: Sequence[BarrelPart]) -> TrinaryGrid:
    """The map with the first 60 degrees of every half's 180 wiped out."""
    labels = np.array(grid.labels)
    rows, columns = np.nonzero(labels == Label.OCCUPIED)
    places = cells_to_metres(np.stack([rows, columns], axis=1).astype(np.float64) + 0.5, grid.resolution_m, grid.origin)
    for part in parts:
        away = places - [part.x_m, part.y_m]
        turned = np.arctan2(away[:, 1], away[:, 0]) - (part.facing or 0.0)
        turned = (turned + math.pi) % (2 * math.pi) - math.pi
        gone = (np.hypot(*away.T) < 2 * RADIUS_M) & (turned > math.radians(30)) & (turned < math.pi / 2)
        labels[rows[gone], columns[gone]] = Label.UNKNOWN
    return replace(grid, labels=labels)


def died(job: Job) -> list[tuple[float, float]]:
    """A worker that died leaves nothing to report."""
    raise MemoryError(f"the process that worked on {job} died; run the benchmark with more memory")


def _table(found: FloatArray, jitters_m: Sequence[float]) -> str:
    """Qualities (cell sizes, mazes, levels, whole and cut) beside their anchors."""
    rows = []
    for resolution, mazes in zip(RESOLUTIONS_M, found, strict=True):
        at = [_mean_and_range(mazes[:, jitters_m.index(anchor), 0]) for anchor in ANCHORS_M]
        order = max(spearmanr(jitters_m, maze[:, 0]).statistic for maze in mazes)
        differs = 100 * np.abs(mazes[..., 0] - mazes[..., 1])
        rows.append([f"{resolution:g}", *at, f"{order:.3f}", f"{differs.mean():.1f} ({differs.max():.0f})"])
    head = ["cell, m", "exact (>= .95)", "R/4 (.45 to .55)", "R/2 (<= .10)"]
    head += [f"Spearman over {len(jitters_m)} levels, worst maze (<= -.95)", "cut: points of difference (most)"]
    return table(head, rows)


def _mean_and_range(values: FloatArray) -> str:
    return f"{values.mean():.2f} ({values.min():.2f} to {values.max():.2f})"


def _write_picture(found: FloatArray, jitters_m: Sequence[float]) -> None:
    """The mean of all mazes over the jitter."""
    radii = [jitter / RADIUS_M for jitter in jitters_m]
    curves = [
        (f"{resolution * 100:g} cm", colour, list(zip(radii, mazes[..., 0].mean(axis=0), strict=True)))
        for resolution, colour, mazes in zip(RESOLUTIONS_M, COLOURS, found, strict=True)
    ]
    write_lines(PAGE.parent / "images" / "sharpness.svg", curves, "jitter of poses, radii", "resolution quality")


def main() -> int:
    """Measure, print, and write unless in haste."""
    quick = "--quick" in sys.argv[1:]
    levels = () if quick else np.linspace(0, MOST_JITTER_M, LEVELS).tolist()
    split: Split = "tune" if quick else "test"
    jitters = tuple(sorted({*levels, *ANCHORS_M}))
    jobs = [Job(maze, resolution, jitters, split) for resolution in RESOLUTIONS_M for maze in range(MAZES)]
    found = np.array(list(run(jobs, qualities, died, 2))).reshape(len(RESOLUTIONS_M), MAZES, len(jitters), 2)
    text = f"## Resolution quality\n\n{ABOUT}\n{_table(found, jitters)}"
    if not quick:
        _write_picture(found, jitters)
        text += "\n![Resolution quality over the jitter of poses](images/sharpness.svg)\n"
        write_section("sharpness", text)
    sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
