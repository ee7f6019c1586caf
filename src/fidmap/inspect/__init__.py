"""The map doctor: what a map is, and what is odd about it, with what that does to the score and what mends it.

Readers find what their format gets wrong (`Grid.source.findings`); here is what any grid can show. A rule is sharp or
it is a note: docs/formats.md lists them all, and on which maps each one was tried.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fidmap.grid import trinarize
from fidmap.inspect.frame import frame_findings
from fidmap.inspect.picture import picture_findings
from fidmap.inspect.walls import wall_findings
from fidmap.model import Finding, Grid, Label

__all__ = ["Inspection", "findings_of", "inspect", "with_findings"]


@dataclass(frozen=True, eq=False)
class Inspection:
    """What a map is: shares of the labels, and how often each whole percent of occupancy occurs.

    percent: (101,) cells whose p rounds to that percent. no_value: cells without p, which are unknown.
    """

    grid: Grid
    share: dict[Label, float]
    percent: npt.NDArray[np.int64]
    no_value: int
    findings: tuple[Finding, ...]


def inspect(grid: Grid, more: tuple[Finding, ...] = ()) -> Inspection:
    """Inspect a map; `more` are findings that something else than the map alone told (see `against`)."""
    labels = trinarize(grid).labels
    counts = np.bincount(labels.ravel(), minlength=3)
    percent, no_value = _histogram(grid.occupancy)
    share = {label: float(counts[label] / labels.size) for label in Label}
    found = (*grid.source.findings, *findings_of(grid, labels), *more)
    return Inspection(grid, share, percent, no_value, found)


def findings_of(grid: Grid, labels: npt.NDArray[np.uint8]) -> tuple[Finding, ...]:
    """What the cells show, in a few passes over the map, the gravest first."""
    if not (labels == Label.OCCUPIED).any():
        return ()
    picture = picture_findings(grid, labels)
    walls = () if picture else wall_findings(grid, labels)  # walls of an altered picture say little
    found = (*walls, *picture, *frame_findings(grid, labels))
    return tuple(sorted(found, key=lambda finding: finding.level != "warning"))


def with_findings(grid: Grid) -> Grid:
    """The grid whose source also tells what its cells show."""
    found = (*grid.source.findings, *findings_of(grid, trinarize(grid).labels))
    return replace(grid, source=replace(grid.source, findings=found))


def _histogram(occupancy: npt.NDArray[np.float32]) -> tuple[npt.NDArray[np.int64], int]:
    """Counts of whole percents, a strip at a time, and the number of cells without a value."""
    percent, no_value = np.zeros(101, np.int64), 0
    for top in range(0, len(occupancy), 256):
        strip = occupancy[top : top + 256]
        known = strip[~np.isnan(strip)]
        no_value += strip.size - known.size
        percent += np.bincount(np.clip(np.rint(100 * known), 0, 100).astype(np.intp), minlength=101)
    return percent, no_value
