"""The frame of a map: margins, rays that left it, and a resolution that a map saver may have rounded."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fidmap.model import Finding, Grid, Label

Box = tuple[int, int, int, int]
THIN, STRAY_SHARE = 0.03, 0.05
"""Rows with less than this share of the fullest row are no map proper; nor is it one when they hold more than that."""


def known_box(labels: npt.NDArray[np.uint8]) -> Box:
    """First row, last row + 1, first column, last column + 1 of what is free or occupied."""
    known = labels != Label.UNKNOWN
    rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    return int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1


def proper_box(labels: npt.NDArray[np.uint8]) -> Box:
    """The same without the thin rows and columns at each side; all of it where these hold more than single rays."""
    known = labels != Label.UNKNOWN
    ends, beyond = [], 0
    for axis in (1, 0):
        counts = known.sum(axis=axis, dtype=np.int64)
        full = np.flatnonzero(counts >= THIN * counts.max())
        ends += [int(full[0]), int(full[-1]) + 1]
        beyond += int(counts[: full[0]].sum() + counts[full[-1] + 1 :].sum())
    if beyond > STRAY_SHARE * np.count_nonzero(known):
        return known_box(labels)
    return ends[0], ends[1], ends[2], ends[3]


def area(box: Box) -> int:
    """Cells of a box."""
    return (box[1] - box[0]) * (box[3] - box[2])


def frame_findings(grid: Grid, labels: npt.NDArray[np.uint8]) -> tuple[Finding, ...]:
    """`stray-rays`, `empty-margins` and `resolution-rounded`, where they apply."""
    known, proper = known_box(labels), proper_box(labels)
    found = []
    if area(proper) < 0.5 * area(known):
        found.append(_stray(area(proper) / area(known)))
    if area(known) < 0.1 * labels.size:
        share = area(known) / labels.size
        text = (
            f"what was mapped fills {share:.1%} of the map, the rest is unknown margin: no score changes, but every "
            "step takes longer"
        )
        found.append(Finding("note", "empty-margins", text, "fidmap inspect --fix"))
    if _looks_rounded(grid.resolution_m):
        found.append(_rounded(grid.resolution_m))
    return tuple(found)


def _stray(share: float) -> Finding:
    text = (
        f"nearly all that was mapped lies in {share:.0%} of the mapped frame: single rays went through an opening or a "
        "glass wall; no score changes, but pictures get small and every step takes longer"
    )
    return Finding("note", "stray-rays", text, "fidmap inspect --fix")


def _looks_rounded(resolution_m: float) -> bool:
    """At most three decimals, as nav2's map saver writes them, and none of the sides that people choose."""
    millimetres = resolution_m * 1000
    whole = round(millimetres)
    return abs(millimetres - whole) < 1e-6 and whole > 10 and whole % 5 != 0 and whole not in {12, 16, 24, 36, 48}


def _rounded(resolution_m: float) -> Finding:
    off = 0.0005 / resolution_m
    text = (
        f"the resolution {resolution_m:g} m has three decimals, to which some map savers round: the true one may "
        f"differ by {off:.1%}, and with it all distances; a profile with transform: similarity shows the scale"
    )
    return Finding("note", "resolution-rounded", text, "--resolution M_PER_CELL")
