"""PCD point clouds: text, binary, and binary compressed by LZF.

Format: https://pointclouds.org/documentation/tutorials/pcd_file_format.html.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fidmap.maps.cloud import CHUNK_POINTS, Cloud, Points, read_cloud
from fidmap.maps.cursor import BrokenRecordError
from fidmap.maps.extras import need
from fidmap.maps.overrides import Overrides
from fidmap.maps.point_table import binary_rows, kept, text_rows
from fidmap.model import Grid

MAX_HEADER_BYTES = 16_384
MAX_UNPACKED_BYTES = 1_200_000_000
KEYS = ("FIELDS", "SIZE", "TYPE", "POINTS", "DATA")


def read(path: Path, name: str, overrides: Overrides) -> Grid:
    """Read the points of a PCD file as a map.

    Raises:
        MapFileError: as `read_cloud`.
        MissingLibraryError: compressed, and the library for it is not installed.
        BrokenRecordError: a header or points that are not what they announce.
    """
    with path.open("rb") as file:
        header, start = _header(file.read(MAX_HEADER_BYTES))
    count, fields = _points(header), header["FIELDS"]
    layout, widths = _layout(header)
    match header["DATA"]:
        case ["ascii"]:
            before = np.cumsum([0, *widths])
            x, y, z = (int(before[fields.index(axis)]) for axis in "xyz")
            rows = functools.partial(text_rows, path, start, count, sum(widths), (x, y, z))
            blocks = kept(rows, count)
        case ["binary"]:
            blocks = functools.partial(binary_rows, path, start, count, layout)
        case ["binary_compressed"]:
            blocks = functools.partial(_unpacked_rows, _unpacked(path, start, count * layout.itemsize), count, layout)
        case other:
            raise BrokenRecordError(f"its DATA is {' '.join(other)[:40]!r}")
    return read_cloud(Cloud(count, blocks), path, name, "pcd", overrides)


def _header(head: bytes) -> tuple[dict[str, list[str]], int]:
    """Words by key, and where the data begins: after the line of DATA."""
    header: dict[str, list[str]] = {}
    at = 0
    while "DATA" not in header:
        end = head.find(b"\n", at)
        if end < 0:
            raise BrokenRecordError("its header does not end")
        words = head[at:end].decode("latin-1").split()
        if words and not words[0].startswith("#"):
            header[words[0].upper()] = words[1:]
        at = end + 1
    if missing := [key for key in KEYS if not header.get(key)]:
        raise BrokenRecordError(f"its header lacks {', '.join(missing)}")
    return header, at


def _points(header: dict[str, list[str]]) -> int:
    text = header["POINTS"][0]
    if not (text.isascii() and text.isdigit() and len(text) < 13):
        raise BrokenRecordError(f"it announces {text[:20]!r} points")
    return int(text)


def _layout(header: dict[str, list[str]]) -> tuple[np.dtype[np.void], list[int]]:
    """The bytes of one point, and how many numbers each field has."""
    fields = header["FIELDS"]
    columns = [fields, header["SIZE"], header["TYPE"], header.get("COUNT") or ["1"] * len(fields)]
    if len({len(column) for column in columns}) > 1 or len(fields) > 1000:
        raise BrokenRecordError("its header does not give one size, type and count for each field")
    if any(fields.count(axis) != 1 for axis in "xyz"):
        raise BrokenRecordError("its points do not have one x, y and z each")
    layout, widths = [], []
    for k, (field, size, kind, count) in enumerate(zip(*columns, strict=True)):
        if kind + size not in {*(t + s for t in "IU" for s in "1248"), "F4", "F8"} or not count.isdigit():
            raise BrokenRecordError(f"its field {field[:20]!r} has the type {kind[:5]}{size[:5]} x {count[:9]}")
        if not 0 < int(count) <= 100_000 or (field in {"x", "y", "z"} and int(count) != 1):
            raise BrokenRecordError(f"its field {field[:20]!r} has {count[:9]} numbers per point")
        widths.append(int(count))
        name = field if field in {"x", "y", "z"} else f"{k}"
        layout.append((name, f"<{kind.lower()}{size}", *(((int(count),),) if int(count) > 1 else ())))
    return np.dtype(layout), widths


def _unpacked(path: Path, start: int, wanted: int) -> bytes:
    """The columns of a compressed file, one after the other."""
    lzf = need("lzf", "pointcloud", "a compressed PCD file")
    with path.open("rb") as file:
        file.seek(start)
        packed, unpacked = (int(n) for n in np.frombuffer(file.read(8).ljust(8, b"\0"), "<u4"))
        if unpacked != wanted or wanted > MAX_UNPACKED_BYTES:
            raise BrokenRecordError(
                f"its points unpack to {unpacked:,} bytes, expected {wanted:,} and at most {MAX_UNPACKED_BYTES:,}; "
                "larger ones can be saved as `binary`"
            )
        data = file.read(min(packed, path.stat().st_size))
    # LZF makes at most 264 bytes of 3: nothing is allocated for a file that is too short for what it announces
    whole = len(data) == packed and wanted <= 100 * packed
    try:
        content = lzf.decompress(data, wanted) if wanted and whole else b""
    except ValueError:
        content = None
    if content is None or len(content) != wanted:
        raise BrokenRecordError("its compressed points are damaged or cut off")
    return bytes(content)


def _unpacked_rows(data: bytes, count: int, layout: np.dtype[np.void]) -> Iterator[Points]:
    """Blocks (n, 3) out of columns that stand one after the other."""
    columns, at = [], 0
    for field in layout.names or ():
        kind = layout[field]
        if field in {"x", "y", "z"}:
            columns.append((field, np.frombuffer(data, kind, count, at)))
        at += kind.itemsize * count
    ordered = [column for _, column in sorted(columns, key=lambda item: item[0])]
    for done in range(0, count, CHUNK_POINTS):
        yield np.stack([column[done : done + CHUNK_POINTS] for column in ordered]).T
