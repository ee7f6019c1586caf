"""What a colour means in a rescue map: a table over all colours, by the nearest known one.

Sources of the colours: hector_geotiff (`geotiff_writer.cpp`) and crosbot (`geotiff.cpp`), which follow the league's
rules. Colours far from all of these, and mixtures of a mark with its surroundings, count as drawn over the map.
"""

from __future__ import annotations

from enum import IntEnum
from functools import cache

import cv2
import numpy as np
import numpy.typing as npt

Colour = tuple[int, int, int]
Bytes = npt.NDArray[np.uint8]


class Kind(IntEnum):
    """What a pixel shows; BAR is the colour of scale bar and axes, GREY that of free cells or of the margin."""

    FREE = 0
    UNKNOWN = 1
    WALL = 2
    OVER = 3
    BAR = 4
    GREY = 5


WHITE: Colour = (255, 255, 255)
TILES: tuple[Colour, Colour] = (226, 226, 227), (237, 237, 238)
WALL: Colour = (0, 40, 120)
BAR: Colour = (0, 50, 140)
MARKS: tuple[Colour, ...] = (
    (240, 10, 10),  # victim
    (240, 100, 10),  # victim, unconfirmed
    (255, 100, 30),  # hazard
    (30, 30, 255),  # hazard of crosbot
    (120, 0, 140),  # path of crosbot
    (120, 0, 240),  # path of hector
    (255, 200, 0),  # where the robot started
    (0, 44, 207),  # text
    (10, 10, 240),  # label of a QR code
)
SEARCHED: tuple[Colour, ...] = ((210, 230, 210), (180, 230, 180), (130, 230, 130))
GREYS: tuple[Colour, ...] = ((190, 190, 191), *((v, v, v) for v in range(140, 216, 15)))
MARGIN: Colour = (128, 128, 128)
DESCRIPTION_TAG = 270
FACTOR = 3
OURS = f"rescue map by fidmap, {FACTOR} pixels per cell"
"""TIFF's ImageDescription of what is written here: maps with few walls or none show neither colours nor raster."""
TOLERANCE = 45.0
"""Largest distance in RGB to the nearest known colour; JPEG blurs the colour of a line 3 pixels wide by about 30."""


def _known() -> list[tuple[Colour, Kind]]:
    """All colours with their kinds, and mixtures with what lies around them."""
    known = [(WHITE, Kind.FREE), (WALL, Kind.WALL), (BAR, Kind.BAR), (MARGIN, Kind.GREY), ((120, 120, 120), Kind.GREY)]
    known += [(colour, Kind.UNKNOWN) for colour in TILES]
    known += [(colour, Kind.FREE) for colour in (*SEARCHED, *GREYS)]
    known += [(colour, Kind.OVER) for colour in MARKS]
    for ground in (WHITE, *TILES[:1]):
        known += [(_mixed(WALL, ground, 0.75), Kind.WALL), (_mixed(WALL, ground, 0.5), Kind.WALL)]
        known.append((_mixed(WALL, ground, 0.25), Kind.FREE if ground == WHITE else Kind.UNKNOWN))
        known += [(_mixed(mark, ground, share), Kind.OVER) for mark in MARKS for share in (0.3, 0.5, 0.75)]
    return known


def _mixed(colour: Colour, ground: Colour, share: float) -> Colour:
    r, g, b = (round(share * c + (1 - share) * d) for c, d in zip(colour, ground, strict=True))
    return r, g, b


@cache
def table() -> Bytes:
    """(64 * 64 * 64,) kinds, indexed by the upper six bits of red, green and blue."""
    level = np.arange(64, dtype=np.float32) * 4 + 2
    nearest = np.full((64, 64, 64), TOLERANCE**2, np.float32)
    kinds = np.full((64, 64, 64), Kind.OVER, np.uint8)
    for colour, kind in _known():
        r, g, b = ((level - c) ** 2 for c in colour)
        distance = r[:, None, None] + g[None, :, None] + b[None, None, :]
        nearer = distance < nearest
        nearest[nearer], kinds[nearer] = distance[nearer], kind
    return kinds.ravel()


def kinds_of(colours: Bytes) -> Bytes:
    """(..., 3 or more) colours to (...) kinds; what comes after blue is left aside."""
    planes = cv2.split(colours.reshape(1, -1, colours.shape[-1]))[:3]
    index = np.zeros(planes[0].shape, np.uint32)
    for plane in planes:
        index <<= np.uint32(6)
        index |= np.asarray(plane, np.uint8) >> np.uint8(2)
    kinds: Bytes = table().take(index.reshape(colours.shape[:-1]), mode="clip")
    return kinds


def looks_like_one(kinds: Bytes, colours: Bytes) -> bool:
    """Whether a sample of pixels (N,), (N, 3) is of a rescue map: walls of its blue, and hardly any foreign colour.

    A map in greys has no blue; a photograph, a drawing or a costmap has other colours.
    """
    blue = colours[:, 2].astype(int) - colours[:, 0] > 60
    walls = (kinds == Kind.WALL) & blue
    foreign, ground = kinds == Kind.OVER, (kinds <= Kind.UNKNOWN) | (kinds == Kind.GREY)
    return bool(walls.mean() >= 5e-4 and foreign.mean() <= 0.15 and ground.mean() >= 0.3)
