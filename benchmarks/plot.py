"""The calibration plot as a small SVG."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fidmap.report.svg import tag, text

SIDE, EDGE = 260, 40
Row = tuple[int, float, float]


def write_calibration(path: Path, curves: Sequence[tuple[str, str, Sequence[Row]]]) -> None:
    """Share of true detections over confidence, one curve per (name, colour, rows); dots grow with their number."""
    size = SIDE + 2 * EDGE
    content = [tag("rect", width=size, height=size, fill="white"), *_axes()]
    for n, (name, colour, rows) in enumerate(curves):
        kept = [row for row in rows if row[0]]
        points = [(_x(c), _y(t), 2 + min(6.0, row_n**0.5 / 6)) for row_n, c, t in kept]
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y, _ in points)
        content.append(tag("polyline", points=line, fill="none", stroke=colour, stroke_width=1.5))
        content += [tag("circle", cx=x, cy=y, r=r, fill=colour) for x, y, r in points]
        content.append(text(name, EDGE + 10, EDGE + 16 * (n + 1), 12, fill=colour))
    drawing = tag(
        "svg", content, xmlns="http://www.w3.org/2000/svg", viewBox=f"0 0 {size} {size}", width=size, height=size,
        font_family="sans-serif",
    )  # fmt: skip
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(drawing + "\n", encoding="utf-8")


def _axes() -> list[str]:
    """Frame, diagonal and labels."""
    parts = [
        tag("rect", x=EDGE, y=EDGE, width=SIDE, height=SIDE, fill="none", stroke="#888"),
        tag("line", x1=_x(0), y1=_y(0), x2=_x(1), y2=_y(1), stroke="#888", stroke_dasharray="4 4"),
        text("confidence", EDGE + SIDE / 2, EDGE + SIDE + 32, 12, text_anchor="middle"),
        text("share of true detections", EDGE, EDGE - 10, 12),
    ]
    for value in (0.0, 0.5, 1.0):
        parts.append(text(f"{value:g}", _x(value), EDGE + SIDE + 15, 11, text_anchor="middle"))
        parts.append(text(f"{value:g}", EDGE - 5, _y(value) + 4, 11, text_anchor="end"))
    return parts


def _x(value: float) -> float:
    return EDGE + SIDE * value


def _y(value: float) -> float:
    return EDGE + SIDE * (1 - value)
