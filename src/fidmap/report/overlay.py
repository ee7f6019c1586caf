"""The drawing of one scored map: arcs as they were fitted, parts that are missing, errors as arrows.

`marks` says what to draw; this file says how. Arcs are drawn at their true place and size; only the error
arrows are enlarged, by the factor that the legend names, because a good map's errors are below a pixel.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from fidmap.model import Label, Report, TrinaryGrid
from fidmap.report import fonts, svg
from fidmap.report.overlay_frame import legend_rows, sheet_around
from fidmap.report.overlay_scene import LABELLED_UP_TO, Arrows, Scene
from fidmap.report.overlay_style import STYLES, arrow_sample, sample, swatch
from fidmap.report.states import Mark, State, marks
from fidmap.report.view import View, make_view, picture
from fidmap.report.wording import clean, percent

PNG_LONG_SIDE = 1600
DRAWN_UP_TO = 1500  # arcs; a noise map may hold many more and would make the page heavy
SMOOTH_BELOW = 1.5  # units per cell under which cells are averaged, so that thin walls do not drop out


def overlay_svg(report: Report, grid: TrinaryGrid | None) -> str:
    """Draw one scored map as a single SVG document without outside references.

    Args:
        report: what the evaluation found.
        grid: the trinarized map, None where only points were given.

    Returns:
        SVG text; all of it is escaped, so it may stand inside an HTML page as it is.
    """
    found = marks(report)
    drawn = found[max(0, len(found) - DRAWN_UP_TO) :]
    ends = [mark.expected_xy for mark in drawn if mark.expected_xy is not None]
    points = np.array([(mark.x_m, mark.y_m) for mark in drawn] + ends, float).reshape(-1, 2)
    window = make_view(grid, points, report.arena.radius_m)
    arrows = Arrows.of(drawn, window)
    legend = _legend(found, report, arrows, grid is not None)
    sheet = sheet_around(window, legend_rows(legend, window.width))
    scene = Scene(drawn, sheet.view, arrows, report.arena.radius_m)
    parts = [
        sheet.heading(*_headings(report)),
        sheet.panel(_base(grid, sheet.view), has_map=grid is not None),
        *scene.elements(),
        sheet.frame(),
        sheet.footer(),
    ]
    return sheet.document(f"Overlay of {clean(report.map.name)}", parts)


def overlay_png(drawing: str) -> bytes:
    """The same drawing as pixels, at most 1600 on the long side, alike on machines with and without fonts."""
    width, height = _size_of(drawing)
    zoom = PNG_LONG_SIDE / max(width, height)
    return fonts.svg_to_png(drawing, max(1, round(width * zoom)), max(1, round(height * zoom)))


def _size_of(drawing: str) -> tuple[float, float]:
    """Width and height from the viewBox that `Sheet.document` writes first."""
    start = drawing.index('viewBox="') + len('viewBox="')
    _, _, width, height = drawing[start : drawing.index('"', start)].split()
    return float(width), float(height)


def _headings(report: Report) -> tuple[str, str, str]:
    overall = report.attributes.overall.value
    score = "overall not computable" if overall is None else f"overall {percent(overall)}"
    return (
        clean(report.map.name),
        f"arena {clean(report.arena.name)} · {clean(report.settings.profile)}",
        score,
    )


def _base(grid: TrinaryGrid | None, view: View) -> str:
    """The map itself, embedded; empty where there is none."""
    base = None if grid is None else picture(grid, view)
    if base is None:
        return ""
    is_smooth = view.scale * base.cells_per_pixel < SMOOTH_BELOW
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


def _legend(found: Sequence[Mark], report: Report, arrows: Arrows, has_map: bool) -> list[tuple[str, str]]:
    """Sample and text of each state that occurs, with its count; then what else needs a word."""
    counts = Counter(mark.state for mark in found)
    lost = sum(part.barrel is None for part in report.attributes.parts) - counts[State.MISSING]
    rows = [
        (sample(state), f"{style.text}: {counts[state]}") for state, style in STYLES.items() if counts[state]
    ]
    if lost:
        rows.append(("", f"missing, place unknown: {lost}"))
    if arrows.factor is not None:
        true = arrows.factor == 1
        words = (
            "arrow to where the part should be"
            if true
            else f"position error, drawn {arrows.factor} times as long"
        )
        rows.append((arrow_sample(), words))
    if has_map:
        greys = {Label.FREE: "free", Label.UNKNOWN: "unknown", Label.OCCUPIED: "occupied"}
        rows += [(swatch(label), word) for label, word in greys.items()]
    unsaid = {"not drawn": DRAWN_UP_TO, "without label": LABELLED_UP_TO}
    rows += [("", f"{word}: {len(found) - limit}") for word, limit in unsaid.items() if len(found) > limit]
    return rows
