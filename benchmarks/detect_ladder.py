"""The same artificial mazes in cells of four sizes and with pose errors of several: how exact centres are, and why."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import numpy as np

from benchmarks.counting import Verdict, average_precision, rates
from benchmarks.detect_maps import Job, Tried
from benchmarks.detect_tables import rms_and_median, rms_mm, sure, three, to_goal, unit_variances
from benchmarks.page import table
from benchmarks.plot import write_points
from fidmap.synth.suite import Split

RESOLUTIONS_M = (0.02, 0.025, 0.05, 0.10)
FIRST = 20_000  # index of the first maze
# what a tier's pose errors are multiplied by; the last of each leaves about the floor of the maps of the goals
POSE_ERRORS = {"clean": (1.0, 0.5), "noisy": (1.0, 0.6, 0.3)}
GOAL_FLOOR_MM = {"clean": 1.2, "noisy": 5.0}
F1_GOAL = {("clean", 0.10): 0.92, ("noisy", 0.10): 0.82}
RMSE_GOAL_MM = {
    "clean": {0.02: 3, 0.025: 4, 0.05: 7, 0.10: 20},
    "noisy": {0.02: 9, 0.025: 9, 0.05: 13, 0.10: 28},
}
RASTER_MM = {0.02: 0.7, 0.025: 1.3, 0.05: 4.1, 0.10: 14.9}  # of a noise-free raster half circle
COLOURS = {0.02: "#0072b2", 0.025: "#009e73", 0.05: "#d55e00", 0.10: "#cc79a7"}
TEXT = """The same mazes, drives and mappers in four sizes of cells, R = 0.30 m, with a tier's errors of the poses and
with smaller ones (`fidmap synth map --pose-errors`). Truth is where a map draws a part: the circle through the points
that beams hit, where the map still shows them, weighed by what the mapper remembers. Somebody else may call the mean of
what all its scans say the truth; the detector learned from both (docs/decisions, 0037). No map tells which of the two
is meant, so what lies between them is what the poses alone leave open, their floor; the raster's is what is left of a
half circle's centre by a noise-free one. The goals were set on other maps, whose poses are said to leave 1.2 mm (clean)
and 5 mm (noisy): what compares with these are the rows with the smallest pose errors, whose factors were chosen on the
tune split for their floor alone. A tier as `fidmap synth suite` makes it has twice as much and more.
"""
PICTURE = "![Centre errors over the floor of the poses](images/detect-centres.svg)\n"
Rung = tuple[str, float, float]


def jobs(mazes: int, split: Split) -> list[Job]:
    """The same mazes at every resolution, with all errors of their poses."""
    rungs = [(tier, k, r) for tier, factors in POSE_ERRORS.items() for k in factors for r in RESOLUTIONS_M]
    return [Job(t, FIRST + n, resolution_m=r, pose_errors=k, split=split) for t, k, r in rungs for n in range(mazes)]


def section(tried: Sequence[Tried], picture: Path | None) -> str:
    """Table and, unless in haste, picture."""
    rungs = _rungs(tried)
    text = f"### By resolution\n\n{TEXT}\n{_table(rungs)}\n"
    if picture is None:
        return text
    _write_picture(picture, rungs)
    return f"{text}{PICTURE}\n"


def _rungs(tried: Sequence[Tried]) -> dict[Rung, list[Tried]]:
    """The maps by tier, errors of the poses (largest first) and cell."""
    made = [t for t in tried if t.job.resolution_m is not None]

    def key(t: Tried) -> Rung:
        return t.job.group, -t.job.pose_errors, t.resolution_m

    return {(tier, -less, r): list(maps) for (tier, less, r), maps in groupby(sorted(made, key=key), key)}


def _table(rungs: dict[Rung, list[Tried]]) -> str:
    rows = []
    for (tier, poses, resolution), maps in rungs.items():
        counts, true = [t.count for t in maps], sure(maps)
        at = rates(counts)
        found, floor = _from_scans(maps)
        rows.append(
            [
                tier, f"{poses:g}", f"{resolution:g}", len(maps), at.drawn,
                to_goal(at.f1, F1_GOAL.get((tier, resolution))), three(average_precision(counts)),
                rms_and_median([v.error_m for v in true]), RMSE_GOAL_MM[tier][resolution], rms_and_median(found),
                f"{unit_variances(true)[0]:.2f}", rms_and_median(floor), RASTER_MM[resolution],
            ]
        )  # fmt: skip
    head = [
        "tier", "pose errors, times", "cell, m", "maps", "drawn parts", "F1", "AP", "centre RMSE (median), mm",
        "goal, mm", "to the scans' mean, mm", "sigma: mean (1)", "floor of the poses, mm", "of the raster, mm",
    ]  # fmt: skip
    return table(head, rows)


def _from_scans(maps: Sequence[Tried]) -> tuple[list[float], list[float]]:
    """How far true detections, and their truths, lie from where the scans put their parts on average; metres."""
    away = [_from_mean(v, t) for t in maps for v in sure([t])]
    return [a for a, _ in away], [b for _, b in away]


def _from_mean(verdict: Verdict, tried: Tried) -> tuple[float, float]:
    assert verdict.part is not None
    truth, found = tried.truths[verdict.part.id], verdict.detection
    mean = np.array([truth.voted_x_m, truth.voted_y_m], float)
    place = np.array([truth.drawn_x_m, truth.drawn_y_m], float)
    return float(np.hypot(*(mean - [found.x_m, found.y_m]))), float(np.hypot(*(mean - place)))


def _write_picture(path: Path, rungs: dict[Rung, list[Tried]]) -> None:
    """Centre errors over the floor, a curve for each cell, and the goals where they were set."""
    curves = []
    for resolution, colour in COLOURS.items():
        points = [
            (rms_mm(_from_scans(maps)[1]), rms_mm([v.error_m for v in sure(maps)]))
            for (_, _, r), maps in rungs.items()
            if r == resolution
        ]
        goals = [(floor, float(RMSE_GOAL_MM[tier][resolution])) for tier, floor in GOAL_FLOOR_MM.items()]
        curves.append((f"{100 * resolution:g} cm", colour, sorted(points), goals))
    write_points(path, curves, "floor of the poses, mm", "centre RMSE, mm, by cell; squares: goals")
