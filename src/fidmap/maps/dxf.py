"""DXF drawings, read by ezdxf: lines, arcs and curves are walls; hatches and solids are solid."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from fidmap.maps.cursor import BrokenRecordError, Budget
from fidmap.maps.drawing import MAX_BYTES, Drawing, Shape, drawing_grid, flatness
from fidmap.maps.extras import need
from fidmap.maps.files import fault, read_bytes
from fidmap.maps.overrides import Overrides, is_resolution
from fidmap.model import Grid

UNITS_M = {
    1: 0.0254, 2: 0.3048, 3: 1609.344, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 8: 2.54e-8, 9: 2.54e-5, 10: 0.9144,
    13: 1e-6, 14: 0.1, 15: 10.0, 16: 100.0,
}  # fmt: skip
MAX_ENTITIES = 200_000
MAX_INSERTED = 20_000
MAX_DEPTH = 50
AREAS = {"HATCH", "SOLID", "TRACE", "MPOLYGON"}


def read(path: Path, name: str, overrides: Overrides) -> Grid:
    """Read the model space of a DXF file as a map.

    Raises:
        MapFileError: no unit, or as `drawing_grid`.
        MissingLibraryError: ezdxf is not installed.
        BrokenRecordError: not DXF, or more entities than a map can have.
    """
    need("ezdxf", "vector", "a DXF file")
    data = read_bytes(path, name, MAX_BYTES, "a drawing")
    try:
        document = _load(data)
        unit = overrides.unit_m or UNITS_M.get(int(document.header.get("$INSUNITS", 0)))
        if unit is None:
            raise fault(name, "does not say its unit ($INSUNITS); say it with --unit M_PER_UNIT, 0.001 for mm")
        shapes = list(_shapes(document, flatness(unit, overrides)))
    except _OURS:
        raise
    # a parser fed with hostile tags raises nearly anything
    except Exception as error:
        raise BrokenRecordError(f"ezdxf says: {str(error)[:200] or type(error).__name__}") from None
    return drawing_grid(Drawing(shapes, unit), path, name, "dxf", overrides)


def _load(data: bytes) -> Any:
    # what it repairs on its way is nothing to tell a referee, and Python prints what nobody handles
    logging.getLogger("ezdxf").addHandler(logging.NullHandler())
    from ezdxf import filemanagement
    from ezdxf.document import Drawing as Document

    if data.startswith(b"AutoCAD Binary DXF"):
        from ezdxf.lldxf.tagger import binary_tags_loader

        return Document.load(binary_tags_loader(data, errors="ignore"))
    latin = data.decode("latin-1")
    encoding = filemanagement.dxf_stream_info(StringIO(latin)).encoding
    return filemanagement.read(StringIO(data.decode(encoding, "replace").replace("\r\n", "\n")))


def _shapes(document: Any, distance: float) -> Iterator[Shape]:
    """Everything visible, blocks taken apart."""
    from ezdxf.disassemble import recursive_decompose

    hidden = {layer.dxf.name.lower() for layer in document.layers if layer.is_off() or layer.is_frozen()}
    _check_blocks(document)
    budget = Budget(MAX_ENTITIES)
    for entity in recursive_decompose(document.modelspace()):
        budget.spend()
        layer = str(entity.dxf.get("layer", "0"))
        if layer.lower() in hidden or entity.dxf.get("invisible", 0):
            continue
        names = frozenset({layer.lower(), _colour(document, entity, layer)})
        for outline in _outlines(entity, distance):
            yield Shape(outline, entity.dxftype() in AREAS, names=names)


def _check_blocks(document: Any) -> None:
    """Refuse blocks within blocks that come to too much, without taking them apart."""
    sizes: dict[str, int] = {}

    def size(layout: Any, above: tuple[str, ...]) -> int:
        total = 0
        for insert in layout.query("INSERT"):
            name = str(insert.dxf.get("name", "")).lower()
            if name in above or len(above) > MAX_DEPTH:
                raise BrokenRecordError(f"its block {name[:40]!r} holds itself, or blocks nested too deeply")
            if name not in sizes and name in document.blocks:
                block = document.blocks.get(name)
                sizes[name] = len(block) + size(block, (*above, name))
            total += max(1, abs(insert.mcount)) * sizes.get(name, 0)
        return total

    if size(document.modelspace(), ()) > MAX_INSERTED:
        raise BrokenRecordError(f"its blocks come to more than {MAX_INSERTED:,} entities")


def _colour(document: Any, entity: Any, layer: str) -> str:
    """#rrggbb of an entity, which may take it from its layer."""
    from ezdxf.colors import aci2rgb

    if entity.rgb is not None:
        red, green, blue = entity.rgb
    else:
        number = entity.dxf.get("color", 256)
        if number == 256 and document.layers.has_entry(layer):
            number = abs(document.layers.get(layer).dxf.color)
        red, green, blue = aci2rgb(number if 1 <= number <= 255 else 7)
    return f"#{red:02x}{green:02x}{blue:02x}"


def _outlines(entity: Any, distance: float) -> Iterator[Any]:
    """Corners (N, 2) of an entity's curves; text, points and what else has no outline gives none."""
    from ezdxf.path import from_hatch, make_path

    try:
        paths = list(from_hatch(entity)) if entity.dxftype() in {"HATCH", "MPOLYGON"} else [make_path(entity)]
    except TypeError:
        return
    for outline in paths:
        _check_curves(outline, distance)
        corners = [(place.x, place.y) for place in outline.flattening(distance, segments=4)]
        if len(corners) > 1:
            yield np.array(corners, float)


def _check_curves(outline: Any, distance: float) -> None:
    """Refuse curves so large that their polygon would have millions of corners."""
    reach = max((abs(value) for place in outline.control_vertices() for value in (place.x, place.y)), default=0.0)
    if not math.isfinite(reach) or not is_resolution(min(1000.0, distance * 1e4)) or reach / distance > 1e11:
        raise BrokenRecordError("a curve of it is too large for a map")


def _own_errors() -> tuple[type[Exception], ...]:
    from fidmap.maps.extras import MissingLibraryError
    from fidmap.model import MapFileError

    return BrokenRecordError, MissingLibraryError, MapFileError


_OURS = _own_errors()
