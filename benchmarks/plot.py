"""Plots of the benchmarks as small SVGs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain
from pathlib import Path

from fidmap.report.svg import tag, text

SIDE, EDGE = 260, 40
LINE = 13  # between names
Row = tuple[int, float, float]
Point = tuple[float, float]


def write_calibration(path: Path, curves: Sequence[tuple[str, str, Sequence[Row]]]) -> None:
    """Share of true detections over confidence, one curve per (name, colour, rows); dots grow with their number."""
    content = [*_axes("confidence", "share of true detections", 1.0)]
    content.append(tag("line", x1=_x(0), y1=_y(0), x2=_x(1), y2=_y(1), stroke="#888", stroke_dasharray="4 4"))
    for n, (name, colour, rows) in enumerate(curves):
        points = [(_x(c), _y(t), 2 + min(6.0, row_n**0.5 / 6)) for row_n, c, t in rows if row_n]
        content += _curve(points, colour)
        content.append(text(name, EDGE + 10, EDGE + 16 * (n + 1), 12, fill=colour))
    _write(path, content)


def write_lines(path: Path, curves: Sequence[tuple[str, str, Sequence[Point]]], across: str, up: str) -> None:
    """Values in [0, 1] over x from 0, one curve per (name, colour, points)."""
    most = max(x for _, _, points in curves for x, _ in points)
    content = _axes(across, up, most)
    for n, (name, colour, points) in enumerate(curves):
        content += _curve([(_x(x / most), _y(y), 2.5) for x, y in points], colour)
        content.append(text(name, EDGE + SIDE - 10, EDGE + 16 * (n + 1), 12, fill=colour, text_anchor="end"))
    _write(path, content)


def write_points(
    path: Path, curves: Sequence[tuple[str, str, Sequence[Point], Sequence[Point]]], across: str, up: str
) -> None:
    """Two lengths from 0 against each other, one curve per (name, colour, points, goals); goals are hollow squares.

    Curves come lowest first; each has its name at its right end.
    """
    right, top = (5 * math.ceil(max(p[k] for _, _, *both in curves for p in chain(*both)) / 5) for k in (0, 1))
    content = _axes(across, up, right, top)
    lowest = _y(0) + LINE
    for name, colour, points, goals in curves:
        content += _curve([(_x(x / right), _y(y / top), 2.5) for x, y in points], colour)
        content += [
            tag("rect", x=_x(x / right) - 4, y=_y(y / top) - 4, width=8, height=8, fill="none", stroke=colour)
            for x, y in goals
        ]
        lowest = min(lowest - LINE, _y(points[-1][1] / top))
        content.append(text(name, EDGE + SIDE + 3, lowest + 4, 11, fill=colour))
    _write(path, content)


def _curve(points: Sequence[tuple[float, float, float]], colour: str) -> list[str]:
    """A line through (x, y, size of dot)."""
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y, _ in points)
    dots = [tag("circle", cx=x, cy=y, r=r, fill=colour) for x, y, r in points]
    return [tag("polyline", points=line, fill="none", stroke=colour, stroke_width=1.5), *dots]


def _write(path: Path, content: list[str]) -> None:
    size = SIDE + 2 * EDGE
    drawing = tag(
        "svg", [tag("rect", width=size, height=size, fill="white"), *content], xmlns="http://www.w3.org/2000/svg",
        viewBox=f"0 0 {size} {size}", width=size, height=size, font_family="sans-serif",
    )  # fmt: skip
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(drawing + "\n", encoding="utf-8")


def _axes(across: str, up: str, most: float, top: float = 1.0) -> list[str]:
    """Frame and labels: x from 0 to `most`, y from 0 to `top`."""
    parts = [
        tag("rect", x=EDGE, y=EDGE, width=SIDE, height=SIDE, fill="none", stroke="#888"),
        text(across, EDGE + SIDE / 2, EDGE + SIDE + 32, 12, text_anchor="middle"),
        text(up, EDGE, EDGE - 10, 12),
    ]
    for value in (0.0, 0.5, 1.0):
        parts.append(text(f"{value * most:.2g}", _x(value), EDGE + SIDE + 15, 11, text_anchor="middle"))
        parts.append(text(f"{value * top:g}", EDGE - 5, _y(value) + 4, 11, text_anchor="end"))
    return parts


def _x(value: float) -> float:
    return EDGE + SIDE * value


def _y(value: float) -> float:
    return EDGE + SIDE * (1 - value)
