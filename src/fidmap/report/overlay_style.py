"""The looks of each state: colours after Okabe and Ito, told apart with any colour vision.

Each state also has its own centre mark and line, for print in grey.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from fidmap.model import FloatArray, Label
from fidmap.report import svg
from fidmap.report.states import State
from fidmap.report.view import GREYS

SAMPLE_SIZE = 26.0
MENDING: dict[str, svg.Attribute] = {"stroke_width": 2.5, "stroke_dasharray": "9 4"}


@dataclass(frozen=True)
class Style:
    """How one state is drawn; `text_colour` is the darker shade that stays readable on white."""

    text: str
    colour: str
    text_colour: str
    shape: Literal["dot", "square", "ring", "cross", "diamond", "triangle"]
    dashes: str | None = None

    def centre(self, at: FloatArray) -> str:
        """The small mark at the centre of the circle."""
        x, y = float(at[0]), float(at[1])
        solid: dict[str, svg.Attribute] = {"fill": self.colour, "stroke": "#fff", "stroke_width": 1.2}
        if self.shape == "dot":
            return svg.tag("circle", cx=x, cy=y, r=3.4, **solid)
        if self.shape == "square":
            return svg.tag("rect", x=x - 4, y=y - 4, width=8, height=8, **solid)
        if self.shape == "diamond":
            return svg.tag("path", d=_polygon(x, y, [(0, -5.5), (5.5, 0), (0, 5.5), (-5.5, 0)]), **solid)
        if self.shape == "triangle":
            return svg.tag("path", d=_polygon(x, y, [(0, -6), (5.5, 4), (-5.5, 4)]), **solid)
        if self.shape == "ring":
            return svg.tag("circle", cx=x, cy=y, r=3, fill="#fff", stroke=self.colour, stroke_width=2)
        path = f"M{svg.number(x - 4)} {svg.number(y - 4)}l8 8m0 -8l-8 8"
        return svg.tag("path", d=path, stroke=self.colour, stroke_width=2.4, fill="none")


def _polygon(x: float, y: float, corners: list[tuple[float, float]]) -> str:
    return "M" + "L".join(f"{svg.number(x + dx)} {svg.number(y + dy)}" for dx, dy in corners) + "Z"


STYLES = {
    State.ASSIGNED: Style("assigned", "#0072B2", "#005F96", "dot"),
    State.FIXED: Style("assigned by hand", "#009E73", "#00664B", "square"),
    State.DOUBTFUL: Style("assigned, doubtful", "#E69F00", "#855C00", "diamond"),
    State.MISSING: Style("missing, expected here", "#D55E00", "#A84A00", "cross", "7 5"),
    State.UNASSIGNED: Style("detected, no part", "#CC79A7", "#96407A", "ring"),
    State.DISPLACED: Style("displaced, the map is broken here", "#56B4E9", "#1B6C9C", "triangle"),
}


def sample(state: State) -> str:
    """The legend's picture of a state, in a box of SAMPLE_SIZE by SAMPLE_SIZE around (0, 0)."""
    style = STYLES[state]
    centre = np.array([-4.0, 0.0])
    path = svg.arc_path(centre, 12.0, 0.0, np.pi)
    line = svg.tag("path", d=path, stroke=style.colour, stroke_width=4, stroke_dasharray=style.dashes, fill="none")
    return line + style.centre(centre)


def arrow_sample() -> str:
    """The legend's picture of an error arrow."""
    path = svg.arrow_path(np.array([-11.0, 5.0]), np.array([11.0, -5.0]))
    return svg.tag("path", d=path, stroke="#111", stroke_width=2, fill="none")


def mending_sample() -> str:
    """The legend's picture of the arrow that mends a displaced part."""
    path = svg.arrow_path(np.array([-11.0, 5.0]), np.array([11.0, -5.0]))
    return svg.tag("path", d=path, stroke=STYLES[State.DISPLACED].text_colour, fill="none", **MENDING)


def hex_grey(label: Label) -> str:
    """The grey of a label as SVG writes it."""
    return "#" + 3 * f"{GREYS[label]:02x}"


def swatch(label: Label) -> str:
    """The legend's picture of a cell's label."""
    box: dict[str, svg.Attribute] = {"x": -10, "y": -8, "width": 20, "height": 16}
    return svg.tag("rect", fill=hex_grey(label), stroke="#57606a", **box)
