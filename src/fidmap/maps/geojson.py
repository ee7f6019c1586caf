"""GeoJSON (RFC 7946): lines are walls, polygons are solid."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fidmap.maps.cursor import BrokenRecordError, Budget
from fidmap.maps.drawing import MAX_BYTES, Drawing, Shape, drawing_grid
from fidmap.maps.files import read_bytes
from fidmap.maps.overrides import Overrides
from fidmap.model import Finding, FloatArray, Grid

EARTH_M = 6_371_008.8  # mean radius
LARGEST_DEGREES = 0.5
NAMING = frozenset({"layer", "name", "id", "type", "class", "stroke", "fill", "color"})


def read(path: Path, name: str, overrides: Overrides) -> Grid:
    """Read lines and polygons as a map: degrees as the standard says, or metres where they cannot be degrees.

    Raises:
        MapFileError: as `drawing_grid`.
        BrokenRecordError: not GeoJSON.
    """
    data = read_bytes(path, name, MAX_BYTES, "a drawing")
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise BrokenRecordError(f"it is not JSON ({error})") from None
    shapes = list(_shapes(document, frozenset(), Budget(), 0))
    return drawing_grid(_placed(shapes, overrides.unit_m), path, name, "geojson", overrides)


def _shapes(node: Any, names: frozenset[str], budget: Budget, depth: int) -> Iterator[Shape]:
    """All shapes below a node of the document."""
    budget.spend()
    if depth > 10:
        raise BrokenRecordError("it is nested deeper than 10 levels")
    kind = node.get("type") if isinstance(node, dict) else None
    if kind in {"FeatureCollection", "GeometryCollection"}:
        below = node.get("features" if kind == "FeatureCollection" else "geometries")
        for item in below if isinstance(below, list) else ():
            yield from _shapes(item, names, budget, depth + 1)
    elif kind == "Feature":
        if node.get("geometry") is not None:
            yield from _shapes(node["geometry"], _names(node), budget, depth + 1)
    elif kind in {"LineString", "MultiLineString", "Polygon", "MultiPolygon"}:
        yield from _geometry(str(kind), node.get("coordinates"), names)
    elif kind not in {"Point", "MultiPoint"}:
        raise BrokenRecordError(f"it holds {str(kind)[:40]!r} where a GeoJSON object is expected")


def _names(feature: dict[str, Any]) -> frozenset[str]:
    """What a feature may be chosen by: its id and its telling properties."""
    properties = feature.get("properties")
    known = properties if isinstance(properties, dict) else {}
    words = [feature.get("id"), *(word for key, word in known.items() if key in NAMING)]
    return frozenset(str(word).lower() for word in words if isinstance(word, str | int))


def _geometry(kind: str, coordinates: Any, names: frozenset[str]) -> Iterator[Shape]:
    levels = {"LineString": 0, "MultiLineString": 1, "Polygon": 1, "MultiPolygon": 2}[kind]
    rings = [coordinates]
    for _ in range(levels):
        rings = [ring for group in rings if isinstance(group, list) for ring in group]
    for ring in rings:
        yield Shape(_corners(ring), kind.endswith("Polygon"), names=names)


def _corners(ring: Any) -> FloatArray:
    try:
        points = np.array([place[:2] for place in ring], float)
    except (TypeError, ValueError, IndexError, KeyError, OverflowError):
        raise BrokenRecordError("a line of it is no list of places") from None
    if len(points) and points.shape[1:] != (2,):
        raise BrokenRecordError("a line of it is no list of places")
    return points.reshape(-1, 2)


def _placed(shapes: list[Shape], unit_m: float | None) -> Drawing:
    """Planar with a given unit; degrees on a plane at their middle; or metres where the extent is no building's."""
    corners = np.concatenate([s.points for s in shapes if len(s.points)] or [np.zeros((1, 2))])
    if not np.isfinite(corners).all():
        raise BrokenRecordError("its places are not finite")
    low, high = corners.min(axis=0), corners.max(axis=0)
    if unit_m is not None:
        return Drawing(shapes, unit_m)
    if (high - low).max() > LARGEST_DEGREES or np.abs(corners).max() > 360:
        text = "its coordinates are too far apart for degrees and were taken as metres"
        return Drawing(shapes, 1.0, (Finding("note", "unit", text, "--unit M_PER_UNIT"),))
    middle = (low + high) / 2
    degree = math.radians(1) * EARTH_M
    scale = np.array([degree * math.cos(math.radians(middle[1])), degree])
    flat = [Shape((s.points - middle) * scale, s.filled, s.occupied, s.names) for s in shapes]
    text = (
        f"its coordinates were taken as degrees; x and y are metres from longitude {middle[0]:.7f}, latitude "
        f"{middle[1]:.7f}"
    )
    return Drawing(flat, 1.0, (Finding("note", "unit", text, "--unit M_PER_UNIT"),))
