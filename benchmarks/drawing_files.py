"""Plans of an arena as other programs draw them, for tests, fuzzing and benchmarks: DXF by ezdxf, SVG, GeoJSON."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

from benchmarks.arena_shapes import arc_points
from fidmap.model import FloatArray

Strokes = Sequence[tuple[str, FloatArray]]  # as `arena_shapes.strokes`


def write_dxf(path: Path, strokes: Strokes, units: int = 4) -> Path:
    """Millimetres by default; walls on WALLS as lines, barrels on BARRELS as arcs, in red."""
    from ezdxf.filemanagement import new

    document = new()
    document.header["$INSUNITS"] = units
    document.layers.add("WALLS")
    document.layers.add("BARRELS", color=1)
    space, scale = document.modelspace(), {4: 1000.0, 6: 1.0, 0: 1.0}[units]
    for kind, values in strokes:
        if kind == "line":
            x0, y0, x1, y1 = (float(v) * scale for v in values)
            space.add_line((x0, y0), (x1, y1), dxfattribs={"layer": "WALLS"})
            continue
        x, y, radius, middle, opening = (float(v) for v in values)
        angles = math.degrees(middle - opening / 2), math.degrees(middle + opening / 2)
        centre = (x * scale, y * scale)
        if opening > 6.28:
            space.add_circle(centre, radius * scale, dxfattribs={"layer": "BARRELS"})
        else:
            space.add_arc(centre, radius * scale, *angles, dxfattribs={"layer": "BARRELS"})
    document.saveas(path)
    return path


def write_svg(path: Path, strokes: Strokes, height_m: float = 20.0) -> Path:
    """A drawing 1 : 1, one user unit a centimetre, y down, barrels as arcs of paths."""
    parts = []
    for kind, values in strokes:
        if kind == "line":
            x0, y0, x1, y1 = (100 * float(v) for v in values)
            parts.append(f'<line x1="{x0!r}" y1="{-y0!r}" x2="{x1!r}" y2="{-y1!r}" class="wall"/>')
            continue
        x, y, radius, middle, opening = (float(v) for v in values)
        ends = [middle - opening / 2, middle + min(opening, 6.283) / 2]
        (ax, ay), (bx, by) = ((100 * (x + radius * math.cos(a)), -100 * (y + radius * math.sin(a))) for a in ends)
        r, large = 100 * radius, int(opening > math.pi)
        parts.append(f'<path d="M {ax!r} {ay!r} A {r!r} {r!r} 0 {large} 0 {bx!r} {by!r}" class="barrel"/>')
    body = "".join(parts)
    side = round(100 * height_m)
    path.write_text(
        f'<?xml version="1.0" encoding="UTF-8"?>\n<svg xmlns="http://www.w3.org/2000/svg" width="{side}cm" '
        f'height="{side}cm" viewBox="0 0 {side} {side}"><g transform="translate(0 {side})" fill="none" '
        f'stroke="#222" stroke-width="2">{body}</g></svg>\n'
    )
    return path


def write_geojson(path: Path, strokes: Strokes) -> Path:
    """Metres; barrels as polygons of a millimetre's error."""
    features = []
    for kind, values in strokes:
        points = values.reshape(2, 2) if kind == "line" else arc_points(values, 0.02)
        geometry = {"type": "LineString", "coordinates": points.tolist()}
        properties = {"layer": "walls" if kind == "line" else "barrels"}
        features.append({"type": "Feature", "properties": properties, "geometry": geometry})
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path
