"""The drawing of one scored map: arcs as they were fitted, parts that are missing, errors as arrows.

`marks` says what to draw; this file says how. Arcs are drawn at their true place and, unless they would
vanish, size; short error arrows are enlarged by the factor that the legend names.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fidmap.model import Label, Report, TrinaryGrid
from fidmap.report import fonts, svg
from fidmap.report.overlay_frame import Sheet, legend_rows, sheet_around
from fidmap.report.overlay_scene import LABELLED_UP_TO, Arrows, Scene, shown_radius
from fidmap.report.overlay_style import STYLES, arrow_sample, mending_sample, sample, swatch
from fidmap.report.states import Mark, State, marks
from fidmap.report.view import View, make_view, picture
from fidmap.report.wording import clean, percent

PNG_LONG_SIDE = 1400  # labels stay readable; encoding is most of the time that a picture takes
DRAWN_UP_TO = 1500  # arcs; a noise map may hold many more and would make the page heavy
SMOOTH_BELOW = 1.5  # units per cell under which cells are averaged, so that thin walls do not drop out


@dataclass(frozen=True)
class Overlay:
    """The drawing of one scored map, ready to be written as SVG or PNG.

    over: what lies on the map, from the arcs to the legend. around: the heading.
    """

    title: str
    sheet: Sheet
    around: str
    over: tuple[str, ...]
    grid: TrinaryGrid | None

    def svg(self) -> str:
        """One SVG document without outside references.

        All text in it is escaped, so it may stand inside an HTML page as it is.
        """
        return self._document(math.inf)

    def png(self) -> bytes:
        """The same as pixels, 1400 on the long side, alike on machines with and without fonts."""
        zoom = PNG_LONG_SIDE / max(self.sheet.width, self.sheet.height)
        width, height = (max(1, round(side * zoom)) for side in (self.sheet.width, self.sheet.height))
        return fonts.svg_to_png(self._document(zoom), width, height)

    def _document(self, pixels_per_unit: float) -> str:
        base = "" if self.grid is None else _base(self.grid, self.sheet.view, pixels_per_unit)
        panel = self.sheet.panel(base, has_map=self.grid is not None)
        return self.sheet.document(self.title, [self.around, panel, *self.over])


def draw_overlay(report: Report, grid: TrinaryGrid | None) -> Overlay:
    """Draw one scored map.

    Args:
        report: what the evaluation found.
        grid: the trinarized map, None where only points were given.
    """
    found = marks(report)
    drawn = found[max(0, len(found) - DRAWN_UP_TO) :]
    ends = [mark.expected_xy for mark in drawn if mark.expected_xy is not None]
    points = np.array([(mark.x_m, mark.y_m) for mark in drawn] + ends, float).reshape(-1, 2)
    window = make_view(grid, points, report.arena.radius_m)
    arrows = Arrows.of(drawn, window)
    legend = _legend(found, arrows, report, window, grid is not None)
    sheet = sheet_around(window, legend_rows(legend, window.width))
    scene = Scene(drawn, sheet.view, arrows, report.arena.radius_m)
    over = (*scene.elements(), sheet.frame(), sheet.footer())
    return Overlay(f"Overlay of {clean(report.map.name)}", sheet, sheet.heading(*_headings(report)), over, grid)


def _headings(report: Report) -> tuple[str, str, str]:
    overall = report.attributes.overall.value
    score = "overall not computable" if overall is None else f"overall {percent(overall)}"
    return (
        clean(report.map.name),
        f"arena {clean(report.arena.name)} · {clean(report.settings.profile)}",
        score,
    )


def _base(grid: TrinaryGrid, view: View, pixels_per_unit: float) -> str:
    """The map itself, embedded; empty where the window shows nothing of it."""
    base = picture(grid, view, pixels_per_unit)
    if base is None:
        return ""
    # An averaged picture already has the drawing's own pixels.
    is_smooth = pixels_per_unit == math.inf and view.scale * base.cells_per_pixel < SMOOTH_BELOW
    return svg.tag(
        "image",
        x=view.left + (base.left_column - view.left_column) * view.scale,
        y=view.top + (view.top_row - base.top_row) * view.scale,
        width=(base.right_column - base.left_column) * view.scale,
        height=(base.top_row - base.bottom_row) * view.scale,
        preserveAspectRatio="none",
        image_rendering=None if is_smooth else "optimizeSpeed",
        style=None if is_smooth else "image-rendering:pixelated",
        **{"xlink:href": base.data_uri},
    )


def _legend(found: Sequence[Mark], arrows: Arrows, report: Report, view: View, has_map: bool) -> list[tuple[str, str]]:
    """Sample and text of each state that occurs, with its count; then what else needs a word."""
    counts = Counter(mark.state for mark in found)
    lost = sum(part.barrel is None for part in report.attributes.parts) - counts[State.MISSING]
    rows = [(sample(state), f"{style.text}: {counts[state]}") for state, style in STYLES.items() if counts[state]]
    if lost:
        rows.append(("", f"missing, place unknown: {lost}"))
    if arrows.factor is not None:
        true = arrows.factor == 1
        words = "arrow to where the part should be" if true else f"position error, drawn {arrows.factor} times as long"
        rows.append((arrow_sample(), words))
    if counts[State.DISPLACED]:
        rows.append((mending_sample(), "second move that would mend the map"))
    if shown_radius(report.arena.radius_m, view) > report.arena.radius_m * view.units_per_metre:
        rows.append(("", "arcs larger than true"))
    if has_map:
        greys = {Label.FREE: "free", Label.UNKNOWN: "unknown", Label.OCCUPIED: "occupied"}
        rows += [(swatch(label), word) for label, word in greys.items()]
    unsaid = {"not drawn": DRAWN_UP_TO, "without label": LABELLED_UP_TO}
    rows += [("", f"{word}: {len(found) - limit}") for word, limit in unsaid.items() if len(found) > limit]
    return rows
