"""Marks drawn over a rescue map, as teams' programs draw them: for tests and the benchmark of formats."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.grid import trinarize
from fidmap.maps.robocup.palette import BAR, FACTOR
from fidmap.maps.robocup.write import PALETTE, picture
from fidmap.model import Grid, Label

Picture = npt.NDArray[np.uint8]
VICTIM, PATH, ARROW, TEXT, GRID = (240, 10, 10), (120, 0, 240), (255, 200, 0), (0, 44, 207), (190, 190, 191)
HAZARD, LABEL = (255, 100, 30), (10, 10, 240)


def clean_picture(grid: Grid) -> Picture:
    """(3 W, 3 H, 3) colours without any mark, +x up."""
    colours: Picture = PALETTE[picture(trinarize(grid).labels, grid.resolution_m)]
    return colours


def marked_picture(grid: Grid, victims: int = 12, seed: int = 0) -> Picture:
    """The same with grid lines, a path, an arrow, discs and diamonds, text, and a scale bar with axes."""
    colours = clean_picture(grid)
    metre = FACTOR / grid.resolution_m
    rng = np.random.default_rng(seed)
    _grid_lines(colours, metre)
    free = np.argwhere((trinarize(grid).labels.T[::-1, ::-1]) == Label.FREE) * FACTOR + 1
    way = _way(free, rng)
    cv2.polylines(colours, [way[:, ::-1].astype(np.int32)], False, PATH, 3)
    _arrow(colours, way[0], metre)
    for number, place in enumerate(free[rng.choice(len(free), victims + 3, replace=False)]):
        x, y = int(place[1]), int(place[0])
        if number < victims:
            cv2.circle(colours, (x, y), round(0.175 * metre), VICTIM, -1, cv2.LINE_AA)
        else:
            side = round(0.21 * metre)
            cv2.fillPoly(colours, [np.array([(x - side, y), (x, y - side), (x + side, y), (x, y + side)])], HAZARD)
        cv2.putText(colours, str(number), (x - 6, y + 4), cv2.FONT_HERSHEY_PLAIN, 0.8, (255, 255, 255), 1, cv2.LINE_AA)
    cv2.putText(colours, "RoboCup 2026 team", (int(metre), int(0.8 * metre)), 0, 0.6, TEXT, 1, cv2.LINE_AA)
    _scale_bar(colours, metre)
    return colours


def _way(free: npt.NDArray[np.int64], rng: np.random.Generator) -> npt.NDArray[np.int64]:
    """A polyline through free cells that crosses walls and barrels too: harder than any robot's path."""
    return free[rng.choice(len(free), 25)]


def _grid_lines(colours: Picture, metre: float) -> None:
    """Lines of one pixel, each half metre, over free space alone."""
    white = (colours == 255).all(axis=2)
    for at in np.arange(0, max(colours.shape), metre / 2).astype(int):
        for line, mask in (
            (colours[at : at + 1], white[at : at + 1]),
            (colours[:, at : at + 1], white[:, at : at + 1]),
        ):
            line[mask] = GRID


def _arrow(colours: Picture, at: npt.NDArray[np.int64], metre: float) -> None:
    tip = 0.3 * metre
    corners = np.array([[tip, 0], [-tip / 2, -tip / 2], [0, 0], [-tip / 2, tip / 2]]) + at[::-1]
    cv2.fillPoly(colours, [corners.astype(np.int32)], ARROW, cv2.LINE_AA)


def _scale_bar(colours: Picture, metre: float) -> None:
    """A bar of one metre with caps, and two axes of one metre with arrow heads, in the lower right corner."""
    m, (h, w) = round(metre), colours.shape[:2]
    y, cap, head = h - m // 2, m // 10, round(0.15 * metre)
    lines = [
        ((w - 2 * m, y), (w - m, y)),
        ((w - 2 * m, y - cap), (w - 2 * m, y + cap)),
        ((w - m, y - cap), (w - m, y + cap)),
    ]
    corner, top, left = (w - 2 * m, h - m), (w - 2 * m, h - 2 * m), (w - 3 * m, h - m)
    lines += [
        (corner, top),
        (corner, left),
        (top, (top[0] - head, top[1] + head)),
        (top, (top[0] + head, top[1] + head)),
    ]
    lines += [(left, (left[0] + head, left[1] - head)), (left, (left[0] + head, left[1] + head))]
    for start, end in lines:
        cv2.line(colours, start, end, BAR, 1)
    for text, place in (
        ("1m", (w - 2 * m, y + cap + 4)),
        ("x", (w - 2 * m + 5, h - 2 * m)),
        ("y", (w - 3 * m, h - m - 4)),
    ):
        cv2.putText(colours, text, place, 0, 0.5, BAR, 1)
