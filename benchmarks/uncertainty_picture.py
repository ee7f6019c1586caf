"""How often intervals hold the truth, as a small SVG: a dot per cell, attribute and kind of interval."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fidmap.report.svg import tag, text

WIDE, HIGH, EDGE, GAP = 300, 220, 46, 30
LEAST = 0.8
SIZES = (10, 20, 50, 200)
COLOURS = {
    "coverage": "#009e73", "relative_accuracy": "#0072b2", "global_accuracy": "#56b4e9", "consistency": "#e69f00",
    "overall": "#d55e00",
}  # fmt: skip
Point = tuple[int, str, float]


def write_coverage(path: Path, panels: Sequence[tuple[str, Sequence[Point]]]) -> None:
    """One panel per kind of interval; points are (parts, attribute, share that holds the truth)."""
    width, height = len(panels) * (WIDE + GAP) + EDGE, HIGH + 2 * EDGE + 16
    content = [tag("rect", width=width, height=height, fill="white")]
    for k, (name, points) in enumerate(panels):
        content += _panel(EDGE + k * (WIDE + GAP), name, points)
    for k, (name, colour) in enumerate(COLOURS.items()):
        x = EDGE + k * 120
        content.append(tag("circle", cx=x, cy=height - 14, r=4, fill=colour))
        content.append(text(name.replace("_", " "), x + 8, height - 10, 11))
    drawing = tag(
        "svg", content, xmlns="http://www.w3.org/2000/svg", viewBox=f"0 0 {width} {height}", width=width, height=height,
        font_family="sans-serif",
    )  # fmt: skip
    path.write_text(drawing + "\n", encoding="utf-8")


def _panel(left: float, name: str, points: Sequence[Point]) -> list[str]:
    parts = [
        tag("rect", x=left, y=_y(0.97), width=WIDE, height=_y(0.93) - _y(0.97), fill="#e8f3ea"),
        tag("line", x1=left, x2=left + WIDE, y1=_y(0.95), y2=_y(0.95), stroke="#888", stroke_dasharray="4 4"),
        tag("rect", x=left, y=EDGE, width=WIDE, height=HIGH, fill="none", stroke="#888"),
        text(f"{name}: percent of intervals that hold the truth", left, EDGE - 10, 12),
    ]
    parts += [text(f"{100 * v:.0f}", left - 5, _y(v) + 4, 11, text_anchor="end") for v in (0.8, 0.85, 0.9, 0.95, 1.0)]
    step = WIDE / len(SIZES)
    for k, size in enumerate(SIZES):
        parts.append(text(f"N = {size}", left + (k + 0.5) * step, EDGE + HIGH + 15, 11, text_anchor="middle"))
        for column, (attribute, colour) in enumerate(COLOURS.items()):
            x = left + k * step + (column + 1) * step / (len(COLOURS) + 1)
            shares = [share for parts_, one, share in points if (parts_, one) == (size, attribute)]
            parts += [tag("circle", cx=x, cy=_y(max(LEAST, s)), r=3, fill=colour, fill_opacity=0.75) for s in shares]
    return parts


def _y(share: float) -> float:
    return EDGE + HIGH * (1 - share) / (1 - LEAST)
