"""From grey values to a grid: what each of the 256 values means under the map_server's rules.

Source: nav2_map_server, `map_io.cpp` (navigation2 main, a3a97043). Its image is float32 and its comparisons
convert the thresholds to the image's type, so everything here is float32 too: 153 is p = 0.4 at either end.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from fidmap.maps.images import Channels, Raster
from fidmap.maps.tables import look_up
from fidmap.model import Grid, Label, Pose2, Source

Mode = Literal["trinary", "scale", "raw"]
MODES: tuple[Mode, ...] = get_args(Mode)
Flavour = Literal["nav2", "nav2-old", "ros1"]
FLAVOURS: tuple[Flavour, ...] = get_args(Flavour)


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
    flavour: Flavour = "nav2"

    @property
    def channels(self) -> Channels:
        """How a colour becomes one number: by brightness, or as the mean of its channels, in trinary with alpha."""
        if self.flavour == "nav2":
            return "brightness"
        return "mean-with-alpha" if self.mode == "trinary" else "mean"

    @property
    def hides_transparent(self) -> bool:
        """Whether a cell that is not opaque is unknown whatever its grey."""
        return self.mode == "scale" if self.flavour == "nav2-old" else self.flavour == "nav2" and self.mode != "raw"


@dataclass(frozen=True, eq=False)
class CodeTable:
    """Per code: occupancy (N,) float32 with NaN for unknown, and label (N,) uint8.

    Codes are grey values 0 to 255, or sums of `parts` channels, 0 to 255 * parts.
    """

    occupancy: npt.NDArray[np.float32]
    labels: npt.NDArray[np.uint8]


def code_table(meaning: Meaning, parts: int = 1) -> CodeTable:
    """The table of a flavour for codes that are sums of `parts` channels."""
    return _nav2(meaning) if meaning.flavour == "nav2" else _averaging(meaning, parts)


def _nav2(meaning: Meaning) -> CodeTable:
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


def _averaging(meaning: Meaning, parts: int) -> CodeTable:
    """ROS 1 and older nav2: in double precision, strict comparisons, occupied wins.

    Sources: navigation `image_loader.cpp` (noetic), nav2_map_server `map_io.cpp` (humble). What lies between the
    thresholds in scale mode is trunc(1 + 98 ratio) there, so never free or occupied, and round(100 ratio) here.
    """
    mean = np.arange(255 * parts + 1) / parts
    if meaning.mode == "raw":
        value = np.trunc(255 - mean if meaning.negate else mean) if meaning.flavour == "ros1" else np.rint(mean)
        p = np.where(value <= 100, value / 100, np.nan)
    elif meaning.flavour == "ros1":
        p = (mean if meaning.negate else 255 - mean) / 255
    else:
        p = mean / 255 if meaning.negate else 1 - mean / 255
    free, occupied = meaning.free_thresh, meaning.occupied_thresh
    labels = np.full(len(p), Label.UNKNOWN, np.uint8)
    labels[p < free] = Label.FREE
    labels[p > occupied] = Label.OCCUPIED
    between = (p >= free) & (p <= occupied)
    if meaning.mode == "scale" and meaning.flavour == "nav2-old" and occupied > free:
        ratio = (p[between] - free) / (occupied - free)
        labels[between] = np.select(
            [np.rint(100 * ratio) == 0, np.rint(100 * ratio) == 100], [Label.FREE, Label.OCCUPIED], Label.UNKNOWN
        ).astype(np.uint8)
    return CodeTable(p.astype(np.float32), labels)


def to_grid(raster: Raster, meaning: Meaning, table: CodeTable, source: Source) -> Grid:
    """Turn an image into a grid: its lowest row becomes row 0, cells that are not opaque become unknown.

    Raw mode ignores transparency, as nav2_map_server does. Labels are only kept where p and the thresholds do
    not give them: in scale mode, and for flavours that compare strictly.
    """
    upwards = raster.grey[::-1]
    occupancy = look_up(table.occupancy, upwards)
    labels = look_up(table.labels, upwards) if meaning.mode == "scale" or meaning.flavour != "nav2" else None
    if raster.transparent is not None and meaning.hides_transparent:
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
