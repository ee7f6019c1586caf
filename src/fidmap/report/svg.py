"""SVG as text: elements with escaped attributes and text, short numbers, arcs as arcs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from html import escape

import numpy as np

from fidmap.model import FloatArray

Attribute = str | float | int | None


def number(value: float) -> str:
    """A coordinate with hundredths: a drawing unit is about a pixel."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text in {"-0", ""} else text


def tag(name: str, content: str | Iterable[str] = "", /, **attributes: Attribute) -> str:
    """One element; `content` is markup made here, attribute values are escaped, None leaves one out.

    Underscores in attribute names stand for hyphens, a trailing one keeps a Python word usable (`class_`).
    """
    inside = content if isinstance(content, str) else "".join(content)
    written = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{_written(value)}"'
        for key, value in attributes.items()
        if value is not None
    )
    return f"<{name}{written}>{inside}</{name}>" if inside else f"<{name}{written}/>"


def _written(value: str | float) -> str:
    return number(value) if isinstance(value, int | float) else escape(value, quote=True)


def escaped(content: str) -> str:
    """Text made safe to stand between tags."""
    return escape(content, quote=True)


def text(content: str, x: float, y: float, size: float, /, **attributes: Attribute) -> str:
    """A line of text, escaped; `y` is its baseline."""
    return tag("text", escaped(content), x=x, y=y, font_size=size, **attributes)


def arc_path(centre: FloatArray, radius: float, middle: float, drawn: float) -> str:
    """The path of an arc from middle - drawn/2 to middle + drawn/2; angles counter-clockwise, y down.

    Args:
        centre: (2,) in drawing units.
        radius: in drawing units.
        middle: direction of the arc's middle as seen in the drawing, radians.
        drawn: the angle that the arc covers, below a full turn.
    """
    angles = middle + np.array([-drawn / 2, drawn / 2])
    ends = centre + radius * np.stack([np.cos(angles), -np.sin(angles)], axis=-1)
    large = int(drawn > math.pi)
    (x0, y0), (x1, y1) = ends
    r = number(radius)
    return f"M{number(x0)} {number(y0)}A{r} {r} 0 {large} 0 {number(x1)} {number(y1)}"


def arrow_path(start: FloatArray, end: FloatArray, head: float = 5.0) -> str:
    """The path of an arrow from start to end, (2,) each; the head shrinks with short arrows."""
    line = f"M{number(start[0])} {number(start[1])}L{number(end[0])} {number(end[1])}"
    along = end - start
    length = float(np.hypot(*along))
    if length < 1e-9:
        return line
    back = -along / length * min(head, length * 0.6)
    side = np.array([-back[1], back[0]]) * 0.6
    (ax, ay), (bx, by) = end + back + side, end + back - side
    return f"{line}M{number(ax)} {number(ay)}L{number(end[0])} {number(end[1])}L{number(bx)} {number(by)}"
