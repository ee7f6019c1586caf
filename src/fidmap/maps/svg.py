"""SVG drawings: dark strokes are walls, dark fills are solid, light fills are free, painted in their order.

The document is walked here, not by a library: references (`use`, entities, style sheets) are what makes an SVG
explode, and a plan needs none. svgelements parses paths and transforms.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from fidmap.maps.cursor import BrokenRecordError, Budget
from fidmap.maps.drawing import MAX_BYTES, Drawing, Shape, drawing_grid, flatness
from fidmap.maps.extras import need
from fidmap.maps.files import fault, read_bytes
from fidmap.maps.overrides import Overrides
from fidmap.model import FloatArray, Grid

SVG = "{http://www.w3.org/2000/svg}"
LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
UNITS_M = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254, "pt": 0.0254 / 72, "pc": 0.0254 / 6}
SKIPPED = {"defs", "symbol", "clipPath", "mask", "pattern", "marker", "metadata", "text", "title", "desc"}
MAX_DEPTH = 50
MAX_PATH_TEXT = 2_000_000
MAX_ARC_CORNERS = 100_000
LENGTH = re.compile(r"\s*([-+]?[0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]{1,3})?)\s*([a-zA-Z%]*)\s*")


@dataclass(frozen=True, eq=False)
class Style:
    """What an element hands down: transform, colours as #rrggbb ('' for none), and names to be chosen by."""

    matrix: Any
    fill: str = "#000000"
    stroke: str = ""
    names: frozenset[str] = frozenset()


def read(path: Path, name: str, overrides: Overrides) -> Grid:
    """Read an SVG drawing as a map.

    Raises:
        MapFileError: no unit, or as `drawing_grid`.
        MissingLibraryError: svgelements is not installed.
        BrokenRecordError: not SVG, or more than a map can have.
    """
    elements = need("svgelements", "vector", "an SVG file")
    data = read_bytes(path, name, MAX_BYTES, "a drawing")
    try:
        text = data.decode("utf-8-sig")  # no other encoding: entities could hide in it
        if "<!ENTITY" in text:
            raise BrokenRecordError("it defines entities, which a drawing does not need")
        root = ElementTree.fromstring(text)  # noqa: S314 - entities, what makes XML explode, were refused
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise BrokenRecordError(f"it is not XML ({error})") from None
    unit = overrides.unit_m or _unit(root)
    if unit is None:
        raise fault(name, "does not give its size in mm, cm or in; say how large one unit is with --unit M_PER_UNIT")
    walk = _Walk(elements, flatness(unit, overrides))
    shapes = list(walk.shapes(root, Style(_page(elements, root)), 0))
    return drawing_grid(Drawing(shapes, unit), path, name, "svg", overrides)


def _page(elements: Any, root: ElementTree.Element) -> Any:
    """What moves the lower-left corner of the view box to (0, 0); y still counts downwards."""
    words = root.get("viewBox", "").replace(",", " ").split()
    try:
        x, y, _, height = (float(word) for word in words)
    except ValueError:
        return elements.Matrix()
    return elements.Matrix(1, 0, 0, 1, -x, -y - height)


def _unit(root: ElementTree.Element) -> float | None:
    """Metres per user unit: the physical width over the width of the view box."""
    match = LENGTH.fullmatch(root.get("width", ""))
    box = root.get("viewBox", "").replace(",", " ").split()
    if match is None or match[2] not in UNITS_M or len(box) != 4:
        return None
    try:
        unit = float(match[1]) * UNITS_M[match[2]] / float(box[2])
    except (ValueError, ZeroDivisionError):
        return None
    return unit if 1e-9 < unit < 1e6 else None


class _Walk:
    """The elements of one document."""

    def __init__(self, elements: Any, distance: float) -> None:
        self.elements = elements
        self.distance = distance
        self.budget = Budget()

    def shapes(self, node: ElementTree.Element, above: Style, depth: int) -> Iterator[Shape]:
        """What a node and those below it draw."""
        self.budget.spend()
        kind = str(node.tag).removeprefix(SVG)
        if depth > MAX_DEPTH:
            raise BrokenRecordError(f"it is nested deeper than {MAX_DEPTH} levels")
        if kind in SKIPPED or _said(node, "display") == "none":
            return
        style = self._style(node, above)
        yield from self._drawn(kind, node, style)
        for child in node:
            yield from self.shapes(child, style, depth + 1)

    def _style(self, node: ElementTree.Element, above: Style) -> Style:
        try:
            own = self.elements.Matrix(node.get("transform", "")[:10_000])
        except (ValueError, TypeError, IndexError, AttributeError, KeyError, ArithmeticError):
            raise BrokenRecordError(f"a transform of it is {node.get('transform', '')[:40]!r}") from None
        fill = self._colour(_said(node, "fill"), above.fill)
        stroke = self._colour(_said(node, "stroke"), above.stroke)
        words = [node.get("id"), node.get(LABEL), *node.get("class", "").split()]
        names = above.names | {word.lower() for word in words if word}
        return Style(own * above.matrix, fill, stroke, names)

    def _colour(self, text: str, inherited: str) -> str:
        if text in {"", "inherit", "currentColor"}:
            return inherited
        if text in {"none", "transparent"}:
            return ""
        try:
            colour = self.elements.Color(text[:100])
            return "#000000" if colour.value is None else str(colour.hexrgb)
        except (ValueError, TypeError, AttributeError, IndexError):
            return "#000000"

    def _drawn(self, kind: str, node: ElementTree.Element, style: Style) -> Iterator[Shape]:
        path = self._path(kind, node)
        if path is None:
            return
        colours = frozenset(filter(None, (style.fill, style.stroke)))
        for corners, curved_names in self._outlines(path, style):
            names = curved_names | colours
            if style.fill and len(corners) > 2:
                yield Shape(corners, True, _dark(style.fill), names)
            if style.stroke and _dark(style.stroke):
                yield Shape(corners, False, True, names)

    def _path(self, kind: str, node: ElementTree.Element) -> Any:
        """The element's outline as a path of svgelements, or None where it has none."""
        words = {key: value[:MAX_PATH_TEXT] for key, value in node.attrib.items()}
        maker = {
            "path": lambda: self.elements.Path(words.get("d", "")),
            "line": lambda: self.elements.Path(self.elements.SimpleLine(*self._numbers(words, "x1 y1 x2 y2"))),
            "rect": lambda: self.elements.Path(self.elements.Rect(*self._numbers(words, "x y width height rx ry"))),
            "circle": lambda: self.elements.Path(self.elements.Circle(*self._numbers(words, "cx cy r"))),
            "ellipse": lambda: self.elements.Path(self.elements.Ellipse(*self._numbers(words, "cx cy rx ry"))),
            "polyline": lambda: self.elements.Path(self.elements.Polyline(words.get("points", ""))),
            "polygon": lambda: self.elements.Path(self.elements.Polygon(words.get("points", ""))),
        }.get(kind)
        try:
            return None if maker is None else maker()
        # a parser fed with hostile text raises nearly anything
        except Exception as error:
            raise BrokenRecordError(f"a {kind} of it cannot be read ({str(error)[:80]})") from None

    @staticmethod
    def _numbers(words: dict[str, str], names: str) -> list[float]:
        found = [LENGTH.fullmatch(words.get(name, "0")) for name in names.split()]
        return [float(match[1]) if match else 0.0 for match in found]

    def _outlines(self, path: Any, style: Style) -> Iterator[tuple[FloatArray, frozenset[str]]]:
        """Corners (N, 2) with y up of each part of a path; curves are cut before they are transformed."""
        m = style.matrix
        linear, shift = np.array([[m.a, m.c], [m.b, m.d]], float), np.array([m.e, m.f], float)
        distance = self.distance / max(float(np.linalg.norm(linear)), 1e-12)
        try:
            for corners in self._parts(path, distance):
                yield (np.array(corners) @ linear.T + shift) * (1, -1), style.names
        except (ValueError, TypeError, ArithmeticError, AttributeError, IndexError) as error:
            raise BrokenRecordError(f"a path of it cannot be drawn ({str(error)[:80]})") from None

    def _parts(self, path: Any, distance: float) -> Iterator[list[tuple[float, float]]]:
        """The corners of each connected part."""
        corners: list[tuple[float, float]] = []
        for segment in path:
            self.budget.spend()
            if isinstance(segment, self.elements.Move):
                if len(corners) > 1:
                    yield corners
                corners = [(segment.end.x, segment.end.y)]
            else:
                corners += self._segment(segment, distance)
        if len(corners) > 1:
            yield corners

    def _segment(self, segment: Any, distance: float) -> list[tuple[float, float]]:
        """The corners after the first of a line, or of a curve close enough to it.

        Between n + 1 points at equal steps of its parameter a curve with |second derivative| <= 2 reach keeps
        within 2 reach / (8 n^2) of its chords.
        """
        if isinstance(segment, self.elements.Line | self.elements.Close):
            return [] if segment.end is None else [(segment.end.x, segment.end.y)]
        reach = self._reach(segment)
        if not math.isfinite(reach):
            raise BrokenRecordError("a curve of it is not finite")
        pieces = math.ceil(math.sqrt(reach / (4 * distance))) + 1
        if pieces > MAX_ARC_CORNERS:
            raise BrokenRecordError("a curve of it is too large for a map")
        return [(p.x, p.y) for p in (segment.point(k / pieces) for k in range(1, pieces + 1))]

    def _reach(self, segment: Any) -> float:
        """Half the largest second derivative of a curve with its parameter from 0 to 1, or more.

        An arc's is r sweep^2; of a Bezier curve of degree n it is n (n - 1) times the largest second difference of
        its control points, at most 6.
        """
        if isinstance(segment, self.elements.Arc):
            return float(max(abs(segment.rx), abs(segment.ry)) * segment.sweep**2 / 2)
        points = [complex(p.x, p.y) for p in (segment.start, *self._controls(segment), segment.end)]
        return 3 * max(abs(c - 2 * b + a) for a, b, c in zip(points, points[1:], points[2:], strict=False))

    def _controls(self, segment: Any) -> list[Any]:
        if isinstance(segment, self.elements.CubicBezier):
            return [segment.control1, segment.control2]
        return [segment.control]


def _said(node: ElementTree.Element, key: str) -> str:
    """A property from the style, which wins, or from the attribute."""
    for part in node.get("style", "").split(";"):
        word, _, value = part.partition(":")
        if word.strip() == key:
            return value.strip()
    return node.get(key, "").strip()


def _dark(colour: str) -> bool:
    """Whether a colour #rrggbb is nearer to black than to white."""
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return 299 * red + 587 * green + 114 * blue < 127_500
