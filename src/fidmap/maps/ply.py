"""PLY point clouds: text, little endian and big endian (Turk 1994, "The PLY Polygon File Format")."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fidmap.maps.cloud import Cloud, read_cloud
from fidmap.maps.cursor import BrokenRecordError
from fidmap.maps.overrides import Overrides
from fidmap.maps.point_table import binary_rows, kept, text_rows
from fidmap.model import Grid

MAX_HEADER_BYTES = 65_536
TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass
class Element:
    """A kind of thing in the file: how many, and the (name, type) of their properties; None for lists."""

    name: str
    count: int
    properties: list[tuple[str, str | None]]


def read(path: Path, name: str, overrides: Overrides) -> Grid:
    """Read the vertices of a PLY file as a map.

    Raises:
        MapFileError: as `read_cloud`.
        BrokenRecordError: a header or points that are not what they announce.
    """
    with path.open("rb") as file:
        form, elements, start = _header(file.read(MAX_HEADER_BYTES))
    before = [e.name for e in elements].index("vertex") if any(e.name == "vertex" for e in elements) else -1
    if before < 0:
        raise BrokenRecordError("it has no vertices")
    vertex = elements[before]
    names = [property_name for property_name, _ in vertex.properties]
    if not {"x", "y", "z"} <= set(names) or len(set(names)) < len(names):
        raise BrokenRecordError("its vertices do not have one x, y and z each")
    if form == "ascii":
        start = _lines_after(path, start, sum(e.count for e in elements[:before]))
        places = (names.index("x"), names.index("y"), names.index("z"))
        rows = functools.partial(text_rows, path, start, vertex.count, len(names), places)
        return read_cloud(Cloud(vertex.count, kept(rows, vertex.count)), path, name, "ply", overrides)
    start += sum(e.count * _layout(e, ORDERS[form]).itemsize for e in elements[:before])
    binary = functools.partial(binary_rows, path, start, vertex.count, _layout(vertex, ORDERS[form]))
    return read_cloud(Cloud(vertex.count, binary), path, name, "ply", overrides)


def _header(head: bytes) -> tuple[str, list[Element], int]:
    """Form, elements, and where the header ends."""
    mark = head.find(b"end_header")
    end = head.find(b"\n", mark)
    if mark < 0 or end < 0:
        raise BrokenRecordError("its header does not end")
    form, elements = "", list[Element]()
    for line in head[:mark].decode("latin-1").splitlines()[1:]:
        match line.split():
            case ["format", known, *_] if known in ORDERS:
                form = known
            case ["element", element, count] if count.isascii() and count.isdigit() and len(count) < 13:
                elements.append(Element(element, int(count), []))
            case ["property", "list", _, _, listed] if elements:
                elements[-1].properties.append((listed, None))
            case ["property", kind, single] if elements and kind in TYPES:
                elements[-1].properties.append((single, TYPES[kind]))
            case ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise BrokenRecordError(f"its header has the line {line[:60]!r}")
    if not form:
        raise BrokenRecordError("its header does not say its format")
    return form, elements, end + 1


def _layout(element: Element, order: str) -> np.dtype[np.void]:
    """The bytes of one thing; lists have no fixed size."""
    fixed = [(f"{k}" if name not in {"x", "y", "z"} else name, f"{order}{kind}")
             for k, (name, kind) in enumerate(element.properties) if kind is not None]  # fmt: skip
    if len(fixed) < len(element.properties):
        raise BrokenRecordError(f"a list stands in its element {element.name[:40]!r} before the points' end")
    return np.dtype(fixed)


def _lines_after(path: Path, start: int, count: int) -> int:
    """Where the text goes on after some lines."""
    with path.open("rb") as file:
        file.seek(start)
        for _ in range(count):
            if not file.readline(1 << 20):
                break
        return file.tell()
