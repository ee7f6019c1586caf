"""What is odd about a map: findings that say what the oddity does to the score and which option mends it.

Each rule is sharp: it stays silent on ordinary maps, because a warning on every map is read by nobody.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.maps.cells import CodeTable, Meaning
from fidmap.maps.images import Raster
from fidmap.maps.tables import histogram, look_up
from fidmap.model import Finding, Label, Pose2

UNKNOWN_GREY = 205
"""What the ROS map savers write for unknown cells."""


@dataclass(frozen=True, eq=False)
class Census:
    """How often each grey value occurs (256,), and how many cells carry each label."""

    counts: npt.NDArray[np.int64]
    free: int
    unknown: int
    occupied: int

    @property
    def cells(self) -> int:
        """All cells."""
        return self.free + self.unknown + self.occupied


def oddities(raster: Raster, meaning: Meaning, table: CodeTable) -> tuple[Finding, ...]:
    """All findings about one map as it loads, the gravest first."""
    raster, table = in_greys(raster, table)
    census = take_census(raster, meaning, table)
    found = [
        _thresholds(meaning),
        _inverted(raster, census, meaning, table),
        _unknown_loads_as_free(census, meaning, table),
        _nothing_occupied(census, meaning),
    ]
    findings = tuple(finding for finding in found if finding)
    if any(finding.code == "unknown-loads-as-free" for finding in findings):
        return findings
    return (*findings, *_no_unknown(census))


def odd_keys(meaning: Meaning, table: CodeTable) -> tuple[Finding, ...]:
    """What is odd about thresholds and negate alone, where there is no image to count greys in."""
    found = [_thresholds(meaning)]
    label = None if meaning.mode == "raw" else table.labels[UNKNOWN_GREY]
    grey = f"grey {UNKNOWN_GREY}, which map savers write for unknown"
    if label == Label.FREE:
        text = (
            f"free_thresh {meaning.free_thresh:g} would load {grey}, as free: arcs are then also looked for where "
            "nothing was mapped"
        )
        mend = math.floor(float(table.occupancy[UNKNOWN_GREY]) * 1000) / 1000
        found.append(Finding("warning", "unknown-loads-as-free", text, f"--free-thresh {mend:g}"))
    if label == Label.OCCUPIED and meaning.negate:
        text = f"negate is set and would load {grey}, as occupied and black as free: was the image saved inverted?"
        found.append(Finding("note", "inverted", text))
    return tuple(finding for finding in found if finding)


def in_greys(raster: Raster, table: CodeTable) -> tuple[Raster, CodeTable]:
    """The same with codes of 0 to 255: means of channels are rounded down."""
    if raster.parts == 1:
        return raster, table
    codes = np.arange(256) * raster.parts
    grey = look_up((np.arange(255 * raster.parts + 1) // raster.parts).astype(np.uint8), raster.grey)
    return Raster(grey, raster.transparent), CodeTable(table.occupancy[codes], table.labels[codes])


def take_census(raster: Raster, meaning: Meaning, table: CodeTable) -> Census:
    """Count greys and labels; transparent cells are unknown, but in raw mode, which ignores alpha."""
    counts = histogram(raster.grey, raster.transparent if meaning.hides_transparent else None)
    free, unknown, occupied = (int(counts[table.labels == label].sum()) for label in Label)
    return Census(counts, free, unknown + raster.grey.size - int(counts.sum()), occupied)


def _thresholds(meaning: Meaning) -> Finding | None:
    free, occupied = meaning.free_thresh, meaning.occupied_thresh
    if free >= occupied:
        text = (
            f"free_thresh {free:g} is not below occupied_thresh {occupied:g}: no grey is unknown and free "
            "wins, so walls may be lost to the score"
        )
        return Finding("warning", "thresholds", text, "--free-thresh 0.196 --occupied-thresh 0.65")
    if free < 0 or occupied > 1:
        text = (
            f"free_thresh {free:g} and occupied_thresh {occupied:g} reach beyond 0 to 1, the range of "
            f"occupancy: no cell can be {'free' if free < 0 else 'occupied'}, which the score misses"
        )
        return Finding("warning", "thresholds", text, "--free-thresh 0.196 --occupied-thresh 0.65")
    return None


def _unknown_loads_as_free(census: Census, meaning: Meaning, table: CodeTable) -> Finding | None:
    """A peak at the savers' 205, or the middle of just three greys, that loads as free."""
    grey = UNKNOWN_GREY if _peak(census.counts, UNKNOWN_GREY) else _middle_of_three(census.counts)
    if meaning.mode == "raw" or grey is None or table.labels[grey] != Label.FREE:
        return None
    share = census.counts[grey] / census.cells
    mend = math.floor(float(table.occupancy[grey]) * 1000) / 1000
    why = "which map savers write for unknown" if grey == UNKNOWN_GREY else "the middle one of three greys"
    text = (
        f"{share:.0%} of the cells are grey {grey}, {why}, but free_thresh "
        f"{meaning.free_thresh:g} loads them as free: arcs are then also looked for where nothing was mapped"
    )
    return Finding("warning", "unknown-loads-as-free", text, f"--free-thresh {mend:g}")


def _peak(counts: npt.NDArray[np.int64], grey: int) -> bool:
    """Whether a grey stands out, unlike in a smooth histogram: 2 % of the cells, 5 times its neighbours."""
    around = max(counts[grey - 1], counts[grey + 1])
    return bool(counts[grey] >= max(1, 0.02 * counts.sum(), 5 * around))


def _middle_of_three(counts: npt.NDArray[np.int64]) -> int | None:
    """The middle grey of an image of just three, well apart: savers of other programs pick another grey."""
    greys = np.flatnonzero(counts)
    if len(greys) != 3 or np.diff(greys).min() < 32 or counts[greys[1]] < 0.02 * counts.sum():
        return None
    return int(greys[1])


def _no_unknown(census: Census) -> tuple[Finding, ...]:
    if census.unknown:
        return ()
    text = (
        "no cell is unknown: every cell is free or occupied, so the inside of a barrel counts as free like "
        "the space around it"
    )
    return (Finding("note", "no-unknown", text),)


def _nothing_occupied(census: Census, meaning: Meaning) -> Finding | None:
    if census.occupied:
        return None
    text = "no cell is occupied, so no barrel part can be found and the coverage is 0"
    mend = "--occupied-thresh 0.65" if meaning.occupied_thresh > 0.65 else None
    return Finding("warning", "nothing-occupied", text, mend)


def yaw_ignored(origin: Pose2) -> tuple[Finding, ...]:
    """A turned origin in the file: applied here, ignored by nav2's costmap_2d and AMCL."""
    if origin.yaw == 0:
        return ()
    text = (
        f"the origin's yaw is {math.degrees(origin.yaw):.4g} degrees and is applied here, while ROS costmaps "
        "and AMCL ignore it: global accuracy may differ from what the robot saw"
    )
    return (Finding("warning", "yaw-ignored-by-ros", text, "--origin X_M,Y_M,0"),)


def _inverted(raster: Raster, census: Census, meaning: Meaning, table: CodeTable) -> Finding | None:
    """Black and white swapped: much occupied in thick areas, and the little that is free only in thin lines.

    A floor plan with a solid outside stays silent: its free rooms are thick.
    """
    if meaning.mode == "raw" or census.free == 0 or census.occupied < 4 * census.free:
        return None
    labels = look_up(table.labels, raster.grey)
    if _thickness(labels, Label.FREE) > 0.2 or _thickness(labels, Label.OCCUPIED) < 0.8:
        return None
    text = (
        f"{census.occupied / census.cells:.0%} of the cells are occupied and free space is drawn in thin "
        "lines: black and white look swapped, so every score is meaningless; invert the image or change "
        "`negate:` in its YAML"
    )
    return Finding("warning", "inverted", text)


def _thickness(labels: npt.NDArray[np.uint8], label: Label) -> float:
    """Share of a label's cells whose four neighbours carry it too; the map's rim is left out."""
    here = labels == label
    core = here[1:-1, 1:-1]
    inner = core & here[:-2, 1:-1] & here[2:, 1:-1] & here[1:-1, :-2] & here[1:-1, 2:]
    return float(inner.sum() / max(1, core.sum()))


def label_oddities(free: int, unknown: int, occupied: int) -> tuple[Finding, ...]:
    """The findings that need no image: how many cells of a map carry each label."""
    census = Census(np.zeros(256, np.int64), free, unknown, occupied)
    nothing = _nothing_occupied(census, Meaning(1.0))
    return (*((nothing,) if nothing else ()), *_no_unknown(census))
