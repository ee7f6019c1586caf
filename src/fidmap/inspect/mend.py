"""A mended copy of a map: what its findings name, put right as far as a program can know it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fidmap.grid import cells_to_metres, trinarize
from fidmap.inspect.frame import Box, known_box, proper_box
from fidmap.inspect.picture import enlarged
from fidmap.model import Finding, Grid, Pose2

RIM = 10
"""Unknown cells that are kept around what was mapped."""
CROPPED = {"empty-margins", "stray-rays"}


def mended(grid: Grid, findings: tuple[Finding, ...]) -> tuple[Grid, tuple[str, ...]]:
    """The mended grid and the codes of the findings that were mended.

    Thresholds are those that the findings' options name; black and white are swapped back; repeated cells are put
    together; margins and stray rays are cut off. Nothing is done about what only a new run of the mapping program
    mends.
    """
    codes = {finding.code for finding in findings}
    done = []
    for finding in findings:
        if finding.code in {"unknown-loads-as-free", "thresholds"} and finding.option is not None:
            grid = _with_thresholds(grid, finding.option.split())
            done.append(finding.code)
    if "inverted" in codes:
        grid = replace(grid, occupancy=1 - grid.occupancy, labels=None)
        done.append("inverted")
    if "upscaled" in codes:
        grid = _reduced(grid, enlarged(trinarize(grid).labels))
        done.append("upscaled")
    if codes & CROPPED:
        labels = trinarize(grid).labels
        grid = _cropped(grid, proper_box(labels) if "stray-rays" in codes else known_box(labels))
        done += sorted(codes & CROPPED)
    return grid, tuple(done)


def _with_thresholds(grid: Grid, words: list[str]) -> Grid:
    """`--free-thresh 0.196 --occupied-thresh 0.65` over the grid's own."""
    said = dict(zip(words[::2], words[1::2], strict=True))
    free, occupied = said.get("--free-thresh"), said.get("--occupied-thresh")
    return replace(
        grid,
        free_thresh=grid.free_thresh if free is None else float(free),
        occupied_thresh=grid.occupied_thresh if occupied is None else float(occupied),
        labels=None,
    )


def _reduced(grid: Grid, factor: int) -> Grid:
    """One cell for each factor x factor block; edges lie on the raster, so a block holds one value."""
    counts = []
    walls = trinarize(grid).labels == 2
    for axis in (0, 1):
        along = walls if axis == 0 else walls.T
        edges = np.concatenate([[0], (along[1:] != along[:-1]).sum(axis=1)])
        counts.append(int(np.bincount(np.arange(len(edges)) % factor, edges, minlength=factor).argmax()))
    rows, columns = slice(counts[0], None, factor), slice(counts[1], None, factor)
    corner = _corner(grid, counts[0], counts[1])
    labels = None if grid.labels is None else np.ascontiguousarray(grid.labels[rows, columns])
    occupancy = np.ascontiguousarray(grid.occupancy[rows, columns])
    return replace(grid, occupancy=occupancy, labels=labels, resolution_m=grid.resolution_m * factor, origin=corner)


def _cropped(grid: Grid, box: Box) -> Grid:
    """The cells of a box and a rim around it."""
    top, left = max(0, box[0] - RIM), max(0, box[2] - RIM)
    rows, columns = slice(top, box[1] + RIM), slice(left, box[3] + RIM)
    labels = None if grid.labels is None else np.ascontiguousarray(grid.labels[rows, columns])
    occupancy = np.ascontiguousarray(grid.occupancy[rows, columns])
    return replace(grid, occupancy=occupancy, labels=labels, origin=_corner(grid, top, left))


def _corner(grid: Grid, row: int, column: int) -> Pose2:
    """The pose of another cell's corner."""
    x, y = cells_to_metres(np.array([[row, column]], float), grid.resolution_m, grid.origin)[0]
    return Pose2(float(x), float(y), grid.origin.yaw)
