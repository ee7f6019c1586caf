"""From grey values to a grid: what each of the 256 values means under the map_server's rules.

Source: nav2_map_server, `map_io.cpp` (navigation2 main, a3a97043). Its image is float32 and its comparisons
convert the thresholds to the image's type, so everything here is float32 too: 153 is p = 0.4 at either end.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from fidmap.maps.images import Raster
from fidmap.maps.tables import look_up
from fidmap.model import Grid, Label, Pose2, Source

Mode = Literal["trinary", "scale", "raw"]
MODES: tuple[Mode, ...] = ("trinary", "scale", "raw")


@dataclass(frozen=True)
class Meaning:
    """How an image is to be read: the map_server's keys; the defaults are those of a plain image.

    resolution_m: side of a cell. origin: pose of the lower-left corner of the image's lower-left pixel.
    """

    resolution_m: float
    origin: Pose2 = field(default_factory=Pose2)
    negate: bool = False
    free_thresh: float = 0.196
    occupied_thresh: float = 0.65
    mode: Mode = "trinary"


@dataclass(frozen=True, eq=False)
class CodeTable:
    """Per grey value 0 to 255: occupancy (256,) float32 with NaN for unknown, and label (256,) uint8."""

    occupancy: npt.NDArray[np.float32]
    labels: npt.NDArray[np.uint8]


def code_table(meaning: Meaning) -> CodeTable:
    """Tabulate the map_server's formulas: s = grey / 255, p = s if negated else 1 - s; raw: p = grey / 100.

    p >= occupied_thresh is occupied, p <= free_thresh is free and wins. In scale mode the loaded value
    decides: 0 is free, 100 is occupied, and values between them round half away from zero to whole percent.
    """
    grey = np.arange(256, dtype=np.float32)
    free, occupied = np.float32(meaning.free_thresh), np.float32(meaning.occupied_thresh)
    if meaning.mode == "raw":
        p = np.where(grey <= 100, grey / np.float32(100), np.float32(np.nan))
    else:
        share = grey / np.float32(255)
        p = share if meaning.negate else np.float32(1) - share
    labels = np.full(256, Label.UNKNOWN, np.uint8)
    labels[p >= occupied] = Label.OCCUPIED
    labels[p <= free] = Label.FREE
    between = (p > free) & (p < occupied)
    if meaning.mode == "scale" and between.any():
        span = np.float32(meaning.occupied_thresh - meaning.free_thresh)
        percent = (p[between] - free) / span * np.float32(100)
        labels[between] = np.select(
            [percent < 0.5, percent >= 99.5], [Label.FREE, Label.OCCUPIED], Label.UNKNOWN
        ).astype(np.uint8)
    return CodeTable(p.astype(np.float32), labels)


def to_grid(raster: Raster, meaning: Meaning, table: CodeTable, source: Source) -> Grid:
    """Turn an image into a grid: its lowest row becomes row 0, cells that are not opaque become unknown.

    Raw mode ignores transparency, as nav2_map_server does. Labels are only kept in scale mode, where p and
    the thresholds do not give them.
    """
    upwards = raster.grey[::-1]
    occupancy = look_up(table.occupancy, upwards)
    labels = look_up(table.labels, upwards) if meaning.mode == "scale" else None
    if raster.transparent is not None and meaning.mode != "raw":
        hidden = raster.transparent[::-1]
        occupancy[hidden] = np.nan
        if labels is not None:
            labels[hidden] = Label.UNKNOWN
    return Grid(
        occupancy,
        meaning.resolution_m,
        meaning.origin,
        meaning.free_thresh,
        meaning.occupied_thresh,
        labels,
        source,
    )
