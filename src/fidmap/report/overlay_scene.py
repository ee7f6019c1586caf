"""What lies on the map: arcs, error arrows and labels, and how they keep out of each other's way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fidmap.model import FloatArray
from fidmap.report import fonts, svg
from fidmap.report.labels import Caption, Place, place_labels
from fidmap.report.overlay_style import MENDING, STYLES
from fidmap.report.states import Mark, State, is_whole
from fidmap.report.view import View
from fidmap.report.wording import clean, metres

LABEL_SIZE = 16.0
LABELLED_UP_TO = 300  # a noise map may hold thousands of arcs; numbers beyond help nobody
FACTORS = (1, 5, 10, 20, 50)
LEAST_RADIUS = 8.0  # drawing units
LONG_ARROW, MIDDLE_ARROW, LEAST_ARROW = 40.0, 30.0, 11.0  # drawing units


@dataclass(frozen=True)
class Arrows:
    """Error arrows: by how much they are enlarged, None where there is none to draw."""

    factor: int | None

    @classmethod
    def of(cls, drawn: Sequence[Mark], view: View) -> Arrows:
        """True to scale, so that arrows end where the parts should be, unless all of them would be tiny."""
        pairs = [(mark.x_m, mark.y_m, *mark.expected_xy) for mark in drawn if has_error(mark) and mark.expected_xy]
        if not pairs:
            return cls(None)
        ends = np.array(pairs, float)
        lengths = np.hypot(*(ends[:, 2:] - ends[:, :2]).T) * view.units_per_metre
        middle, longest = max(float(np.median(lengths)), 1e-9), max(float(lengths.max()), 1e-9)
        if longest > LONG_ARROW:
            return cls(1)
        wanted = min(MIDDLE_ARROW / middle, 2 * LONG_ARROW / longest)
        return cls(max((factor for factor in FACTORS if factor <= wanted), default=1))


def has_error(mark: Mark) -> bool:
    """Whether a mark is an assigned part whose place is known, so that its error can be drawn."""
    return mark.expected_xy is not None and mark.state not in {State.MISSING, State.UNASSIGNED, State.DISPLACED}


def has_arrow(mark: Mark) -> bool:
    """Whether an arrow starts at a mark: its error, or the move that would mend it."""
    return has_error(mark) or mark.state is State.DISPLACED


def shown_radius(radius_m: float, view: View) -> float:
    """Radius of the arcs in drawing units: true, but on maps of whole buildings large enough to be seen."""
    return max(LEAST_RADIUS, radius_m * view.units_per_metre)


@dataclass(frozen=True)
class Scene:
    """The arcs, arrows and labels of one drawing."""

    drawn: tuple[Mark, ...]
    view: View
    arrows: Arrows
    radius_m: float

    @property
    def radius(self) -> float:
        """Radius of the arcs in drawing units."""
        return shown_radius(self.radius_m, self.view)

    def elements(self) -> list[str]:
        """Arcs lowest, then arrows, labels on top: what is read must not be covered."""
        places = self.places()
        arcs = svg.tag("g", [self.arc(mark) for mark in self.drawn], fill="none", stroke_linecap="butt")
        arrows = svg.tag("g", [self.arrow(mark) for mark in self.drawn if has_arrow(mark)], fill="none")
        labels = [self.label(mark, place) for mark, place in places if place is not None]
        return [arcs, arrows, svg.tag("g", labels, font_weight="bold", stroke_linejoin="round")]

    def centre(self, mark: Mark) -> FloatArray:
        """Centre (2,) of an arc in drawing units."""
        return self.view.to_drawing(np.array([mark.x_m, mark.y_m]))

    def arc(self, mark: Mark) -> str:
        """One arc with a white casing, a centre mark that tells the state without colour, and a tip."""
        style, centre = STYLES[mark.state], self.centre(mark)
        width = min(4.0, max(2.5, 0.13 * self.radius))
        if is_whole(mark.facing, mark.drawn):
            shape = {"cx": centre[0], "cy": centre[1], "r": self.radius}
            name = "circle"
        else:
            direction = self.view.direction(mark.facing or 0.0)
            shape = {"d": svg.arc_path(centre, self.radius, direction, mark.drawn)}
            name = "path"
        casing = svg.tag(name, stroke="#fff", stroke_width=width + 2, stroke_opacity=0.7, **shape)
        line = svg.tag(name, stroke=style.colour, stroke_width=width, stroke_dasharray=style.dashes, **shape)
        tip = svg.tag("title", svg.escaped(_tip(mark)))
        return svg.tag("g", [tip, casing, line, style.centre(centre)], class_=f"arc {mark.state.value}")

    def tip_of_arrow(self, mark: Mark) -> FloatArray:
        """Where an arrow ends: errors are enlarged, moves are as they are; never so short that it cannot be seen."""
        start = self.centre(mark)
        along = self.view.to_drawing(np.array(mark.expected_xy, float)) - start
        length = float(np.hypot(*along))
        if length < 1e-6:
            return start
        factor = self.arrows.factor or 1 if has_error(mark) else 1
        return np.asarray(start + along / length * max(length * factor, LEAST_ARROW))

    def arrow(self, mark: Mark) -> str:
        """From the drawn centre towards where the part should be; dashed where that mends a broken map."""
        path = svg.arrow_path(self.centre(mark), self.tip_of_arrow(mark))
        casing = svg.tag("path", d=path, stroke="#fff", stroke_width=5, stroke_opacity=0.8)
        if mark.state is State.DISPLACED:
            return casing + svg.tag("path", d=path, stroke=STYLES[mark.state].text_colour, class_="mending", **MENDING)
        return casing + svg.tag("path", d=path, stroke="#111", stroke_width=2, class_="error")

    def places(self) -> list[tuple[Mark, Place | None]]:
        """Where the labels go; parts choose first, loose detections take what is left."""
        order = sorted(self.drawn, key=lambda mark: mark.state is State.UNASSIGNED)[:LABELLED_UP_TO]
        captions = [self.caption(mark) for mark in order]
        left, top, right, bottom = self.view.bounds
        bounds = (left + 3, top + 3, right - 3, bottom - 3)
        return list(zip(order, place_labels(captions, self.inked(), bounds), strict=True))

    def caption(self, mark: Mark) -> Caption:
        """The label's size and where it would like to be: in front of the arc, in free space."""
        text = _label_text(mark)
        x, y = self.centre(mark)
        wish = -math.pi / 4 if mark.facing is None else -self.view.direction(mark.facing)
        width = fonts.text_width(text, LABEL_SIZE, bold=True) + 4
        return Caption(text, float(x), float(y), width, LABEL_SIZE * 1.1, self.radius + 4, wish)

    def inked(self) -> FloatArray:
        """Points (N, 2) along all arcs and arrows, for labels to keep off."""
        points = [np.empty((0, 2))]
        for mark in self.drawn:
            middle = 0.0 if mark.facing is None else self.view.direction(mark.facing)
            angles = middle + np.linspace(-mark.drawn / 2, mark.drawn / 2, 13)
            centre = self.centre(mark)
            points.append(centre + self.radius * np.stack([np.cos(angles), -np.sin(angles)], axis=1))
            if has_arrow(mark):
                points.append(np.linspace(centre, self.tip_of_arrow(mark), 7))
        return np.concatenate(points)

    def label(self, mark: Mark, place: Place) -> str:
        """The text with a white halo, and a line back to the arc where it had to stand aside."""
        left, top, right, bottom = place.box
        centre = self.centre(mark)
        colour = STYLES[mark.state].text_colour
        leader = ""
        if place.is_far:
            near = np.clip(centre, [left, top], [right, bottom])
            start = centre + (near - centre) * min(1.0, self.radius / max(1e-9, float(np.hypot(*(near - centre)))))
            path = svg.arrow_path(start, near, head=0.0)
            leader = svg.tag("path", d=path, stroke=colour, stroke_width=1.2)
        text = svg.text(
            _label_text(mark), (left + right) / 2, bottom - LABEL_SIZE * 0.24, LABEL_SIZE,
            fill=colour, stroke="#fff", stroke_width=4, paint_order="stroke", text_anchor="middle",
        )  # fmt: skip
        return leader + text


def _label_text(mark: Mark) -> str:
    text = clean(mark.label)
    text = text if len(text) <= 14 else text[:13] + "…"
    return text + {State.DOUBTFUL: "?", State.DISPLACED: "!"}.get(mark.state, "")


def _tip(mark: Mark) -> str:
    """What a mouse pointer resting on an arc is told."""
    number = "" if mark.n is None else f", detection {mark.n}"
    word = "away by" if mark.state is State.DISPLACED else "error"
    error = "" if mark.error_m is None else f", {word} {metres(mark.error_m)}"
    place = f"x {metres(mark.x_m)}, y {metres(mark.y_m)}"
    return f"{clean(mark.label)}: {STYLES[mark.state].text}{number}{error}; {place}"
