"""Ranks of the metric against ranks of a human judge: one panel per attribute, as SVG."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from fidmap.output_file import write_whole
from fidmap.ranking import Agreement, Rank
from fidmap.report.fonts import svg_to_png
from fidmap.report.svg import tag, text
from fidmap.report.wording import attribute_title, clean, shortened

SIDE, EDGE, GAP = 230, 56, 56
MOST_TICKS = 10
COLUMNS = 2
Ranks = Sequence[Rank | None]


def draw_ranks(
    maps: Sequence[str], ours: Mapping[str, Ranks], theirs: Mapping[str, Ranks], agreements: Mapping[str, Agreement]
) -> str:
    """A dot per map, its name beside it, and the diagonal on which both agree; shared ranks at their middle."""
    names = list(theirs)
    width, height = _size(len(names))
    content = [tag("rect", width=width, height=height, fill="white")]
    for k, name in enumerate(names):
        left, top = EDGE + (k % COLUMNS) * (SIDE + GAP), EDGE + (k // COLUMNS) * (SIDE + GAP + 24)
        content += _panel(left, top, _title(name, agreements[name]), maps, ours[name], theirs[name])
    return tag(
        "svg", content, xmlns="http://www.w3.org/2000/svg", viewBox=f"0 0 {width} {height}", width=width, height=height,
        font_family="DejaVu Sans, sans-serif",
    )  # fmt: skip


def write_ranks(
    path: Path,
    maps: Sequence[str],
    ours: Mapping[str, Ranks],
    theirs: Mapping[str, Ranks],
    agreements: Mapping[str, Agreement],
) -> None:
    """The drawing as a file, SVG or PNG by its ending.

    Raises:
        OutputError: the file cannot be written.
    """
    svg = draw_ranks(maps, ours, theirs, agreements)
    if path.suffix.lower() == ".png":
        width, height = _size(len(theirs))
        write_whole(path, svg_to_png(svg, 2 * width, 2 * height))
    else:
        write_whole(path, f"{svg}\n".encode())


def _size(panels: int) -> tuple[int, int]:
    rows = max(1, math.ceil(panels / COLUMNS))
    return EDGE + COLUMNS * (SIDE + GAP), EDGE + rows * (SIDE + GAP + 24)


def _title(name: str, found: Agreement) -> str:
    value, p_value = found.spearman.value.value, found.spearman.p_value.value
    told = "" if value is None or p_value is None else f": rho {value:.2f}, p {p_value:.3f}, n {found.n}"
    return attribute_title(name) + told


def _panel(left: float, top: float, title: str, maps: Sequence[str], ours: Ranks, theirs: Ranks) -> list[str]:
    last = max([2.0, *(rank.last for rank in (*ours, *theirs) if rank)])

    def at(rank: float) -> float:
        return SIDE * (rank - 0.5) / last

    parts = [
        tag("rect", x=left, y=top, width=SIDE, height=SIDE, fill="none", stroke="#888"),
        tag("line", x1=left, y1=top, x2=left + SIDE, y2=top + SIDE, stroke="#bbb", stroke_dasharray="4 4"),
        text(title, left, top - 8, 12, font_weight="bold"),
        text("rank of the metric", left + SIDE / 2, top + SIDE + 30, 11, text_anchor="middle"),
        text("rank of the judge", 0, 0, 11, text_anchor="middle",
             transform=f"translate({left - 26:.0f} {top + SIDE / 2:.0f}) rotate(-90)"),
    ]  # fmt: skip
    for rank in range(1, round(last) + 1, max(1, math.ceil((last - 1) / MOST_TICKS))):
        parts.append(text(str(rank), left + at(rank), top + SIDE + 14, 11, text_anchor="middle"))
        parts.append(text(str(rank), left - 6, top + at(rank) + 4, 11, text_anchor="end"))
    shown: dict[tuple[float, float], list[str]] = {}
    for name, one, other in zip(maps, ours, theirs, strict=True):
        if one and other:
            shown.setdefault((at(one.middle), at(other.middle)), []).append(shortened(clean(name), 14))
    for (x, y), names in shown.items():
        right = x < SIDE * 0.7
        parts.append(tag("circle", cx=left + x, cy=top + y, r=4, fill="#0072b2"))
        parts.append(text(", ".join(names), left + x + (7 if right else -7), top + y + 4, 10,
                          text_anchor="start" if right else "end"))  # fmt: skip
    return parts
