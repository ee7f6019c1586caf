"""The sheet around a drawing: heading, coordinates in metres along the edges, scale bar, legend."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from fidmap.model import Label
from fidmap.report import fonts, svg
from fidmap.report.overlay_style import SAMPLE_SIZE, hex_grey
from fidmap.report.view import View

MARGIN = 20.0
HEADING = 78.0
TICK_ROOM = 26.0
TEXT_SIZE = 15.0
ROW_HEIGHT = 30.0
LEAST_WIDTH = 640.0
INK, SOFT_INK = "#1b1f24", "#57606a"

LegendRow = list[tuple[float, str, str]]


def legend_rows(entries: Iterable[tuple[str, str]], width: float) -> list[LegendRow]:
    """Break legend entries (sample, text) into rows that fit; each entry gets its x."""
    rows: list[LegendRow] = [[]]
    x = 0.0
    for sample, text in entries:
        needed = (SAMPLE_SIZE + 10 if sample else 0) + fonts.text_width(text, TEXT_SIZE) + 28
        if rows[-1] and x + needed > max(width, LEAST_WIDTH):
            rows.append([])
            x = 0.0
        rows[-1].append((x, sample, text))
        x += needed
    return [row for row in rows if row]


def nice_length(longest: float) -> float:
    """The greatest of 1, 2, 5 times a power of ten that is not longer."""
    power = 10.0 ** math.floor(math.log10(longest))
    return max(factor * power for factor in (0.5, 1.0, 2.0, 5.0) if factor * power <= longest * (1 + 1e-9))


def _label(metres: float, step: float) -> str:
    digits = max(0, -math.floor(math.log10(step) + 1e-9))
    text = f"{metres:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0 else text.replace("-", "−")


@dataclass(frozen=True)
class Sheet:
    """A drawing's page: where the map's panel lies and how large everything is."""

    view: View
    width: float
    height: float
    legend: list[LegendRow]

    def document(self, title: str, parts: Iterable[str]) -> str:
        """The whole SVG document."""
        attributes = {
            "viewBox": f"0 0 {svg.number(self.width)} {svg.number(self.height)}",
            "xmlns": "http://www.w3.org/2000/svg",
            "xmlns:xlink": "http://www.w3.org/1999/xlink",
            "role": "img",
        }
        paper = svg.tag("rect", width=self.width, height=self.height, fill="#fff")
        content = [svg.tag("title", svg.escaped(title)), paper, *parts]
        return svg.tag("svg", content, **attributes, font_family=fonts.FAMILY, fill=INK)

    def heading(self, name: str, about: str, score: str) -> str:
        """The map's name and its overall score in one line, what it was scored against below."""
        room = self.width - 2 * MARGIN - fonts.text_width(score, 24, bold=True) - 30
        while len(name) > 4 and fonts.text_width(name, 24, bold=True) > room:
            name = "…" + name[2:]
        bold = {"font_weight": "bold"}
        end = self.width - MARGIN
        return (
            svg.text(name, MARGIN, 38, 24, **bold)
            + svg.text(score, end, 38, 24, text_anchor="end", **bold)
            + svg.text(about, MARGIN, 62, TEXT_SIZE, fill=SOFT_INK)
        )

    def panel(self, base: str, has_map: bool) -> str:
        """The map on its ground: what lies beyond its cells is as unknown as its unknown cells."""
        left, top, _, _ = self.view.bounds
        ground = hex_grey(Label.UNKNOWN) if has_map else "#fff"
        box = {"x": left, "y": top, "width": self.view.width, "height": self.view.height}
        return svg.tag("rect", fill=ground, **box) + base

    def frame(self) -> str:
        """The panel's edge with coordinates of the map's frame, in metres, as a points file has them."""
        left, top, _, _ = self.view.bounds
        edge = svg.tag(
            "rect",
            x=left,
            y=top,
            width=self.view.width,
            height=self.view.height,
            fill="none",
            stroke=SOFT_INK,
        )
        if abs(math.sin(self.view.origin.yaw)) > 1e-9 or math.cos(self.view.origin.yaw) < 0:
            return edge + self._axes()
        ticks = [self._tick(axis, value, step) for axis in (0, 1) for value, step in self.ticks(axis)]
        return edge + svg.tag("g", ticks, font_size=13, fill=SOFT_INK)

    def ticks(self, axis: int) -> list[tuple[float, float]]:
        """Round coordinates in metres along x (0) or y (1), with their step."""
        view = self.view
        start_cells, length = (view.left_column, view.width) if axis == 0 else (view.bottom_row, view.height)
        start = (view.origin.x_m, view.origin.y_m)[axis] + start_cells * view.resolution_m
        span = length / view.units_per_metre
        step = nice_length(max(span * 110 / length, span / 12))
        first = math.ceil(start / step + 1e-9)
        last = math.floor((start + span) / step - 1e-9)
        return [(index * step, step) for index in range(first, min(last, first + 40) + 1)]

    def _tick(self, axis: int, value: float, step: float) -> str:
        left, _, _, bottom = self.view.bounds
        x, y = self.view.to_drawing(np.array([value, value]))
        label = f"{_label(value, step)} m"
        if axis == 0:
            line = f"M{svg.number(x)} {svg.number(bottom)}v6"
            return svg.tag("path", d=line, stroke=SOFT_INK) + svg.text(label, x, bottom + 20, 13, text_anchor="middle")
        line = f"M{svg.number(left)} {svg.number(y)}h-6"
        return svg.tag("path", d=line, stroke=SOFT_INK) + svg.text(label, left - 9, y + 4.5, 13, text_anchor="end")

    def _axes(self) -> str:
        """Where x and y of the map's frame point, for a map whose origin is turned."""
        left, _, _, bottom = self.view.bounds
        start = np.array([left + 40.0, bottom - 40.0])
        parts = []
        for name, angle in (("x", 0.0), ("y", math.pi / 2)):
            turned = self.view.direction(angle)
            along = np.array([math.cos(turned), -math.sin(turned)])
            path = svg.arrow_path(start, start + 28 * along, head=7)
            parts += [svg.tag("path", d=path, stroke="#fff", stroke_width=6, fill="none")]
            parts += [svg.tag("path", d=path, stroke=INK, stroke_width=2, fill="none")]
            at = start + 37 * along
            halo: dict[str, svg.Attribute] = {
                "stroke": "#fff",
                "stroke_width": 4,
                "paint_order": "stroke",
                "text_anchor": "middle",
            }
            parts.append(svg.text(name, at[0], at[1] + 5, TEXT_SIZE, **halo))
        return "".join(parts)

    def footer(self) -> str:
        """The scale bar, and below it the legend."""
        left, _, _, bottom = self.view.bounds
        y = bottom + TICK_ROOM + 22
        length = nice_length(max(180.0, 0.15 * self.view.width) / self.view.units_per_metre)
        end = left + length * self.view.units_per_metre
        start = svg.number(left)
        bar = f"M{start} {svg.number(y - 6)}v12M{start} {svg.number(y)}H{svg.number(end)}m0 -6v12"
        parts = [svg.tag("path", d=bar, stroke=INK, stroke_width=2.5, fill="none")]
        parts.append(svg.text(f"{length:.6g} m", end + 12, y + 5, TEXT_SIZE))
        for row_index, row in enumerate(self.legend):
            row_y = y + 36 + row_index * ROW_HEIGHT
            parts += [_entry(left + x, row_y, sample, text) for x, sample, text in row]
        return "".join(parts)


def _entry(x: float, y: float, sample: str, text: str) -> str:
    shift = SAMPLE_SIZE + 10 if sample else 0.0
    place = f"translate({svg.number(x + SAMPLE_SIZE / 2)} {svg.number(y)})"
    picture = svg.tag("g", sample, transform=place) if sample else ""
    return picture + svg.text(text, x + shift, y + 5, TEXT_SIZE)


def sheet_around(window: View, legend: list[LegendRow]) -> Sheet:
    """Lay out the page around a window of the map."""
    probe = Sheet(window, 0, 0, [])
    labels = [f"{_label(value, step)} m" for value, step in probe.ticks(1)]
    left = MARGIN + 14 + max((fonts.text_width(label, 13) for label in labels), default=0.0)
    width = max(LEAST_WIDTH, window.width) + left + MARGIN
    view = replace(window, left=left, top=HEADING)
    height = HEADING + window.height + TICK_ROOM + 34 + 36 + len(legend) * ROW_HEIGHT
    return Sheet(view, width, height, legend)
