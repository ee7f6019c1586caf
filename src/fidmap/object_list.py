"""Lists of objects as robots and referees of RoboCup Rescue write them: names and places.

Two forms: the CSV of the league (`victims`, `qr codes`, `pois`: seven lines about the mission, then a table whose
columns begin with id, time, text, x), and `.pts` of the referees' tool of 2024 (a label, then name, x, y).
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass

from fidmap.csv_file import ROWS_MAX, number
from fidmap.model import PointsFileError
from fidmap.text_file import FilePath, one_sentence, quoted, read_text

KINDS = frozenset({"victims", "qr codes", "pois"})
MISSION_LINES = 20
FARTHEST = 1e8
LEAST_PIXEL = 10


@dataclass(frozen=True)
class Listed:
    """One object: its name (may be empty) and its place as written."""

    line: int
    name: str
    x: float
    y: float


def read_objects(path: FilePath) -> tuple[Listed, ...] | None:
    """The objects of a list, or None for any other file.

    Raises:
        PointsFileError: a list with faults, all of them in one sentence, each with its line.
    """
    text, _ = read_text(path, "a points file", PointsFileError)
    try:
        lines = [[cell.strip() for cell in cells] for cells in csv.reader(io.StringIO(text, newline=""))]
    except csv.Error:
        return None
    if lines and lines[0] and lines[0][0].lower() in KINDS:
        return _league_list(path, lines)
    if _is_pts(lines):
        return _objects(path, [(k + 1, cells[0], cells[1:3]) for k, cells in enumerate(lines) if k and any(cells)])
    return None


def _league_list(path: FilePath, lines: Sequence[list[str]]) -> tuple[Listed, ...]:
    """The table below the lines about the mission; the name of an object is its text."""
    headers = [[cell.lower().removesuffix("-coord") for cell in cells] for cells in lines[:MISSION_LINES]]
    start = next((k for k, words in enumerate(headers) if {"id", "x", "y"} <= set(words)), None)
    if start is None:
        raise PointsFileError(one_sentence(path, ["is a list of objects without the line id,time,text,x,y,z"]))
    words = headers[start]
    x, y = words.index("x"), words.index("y")
    name = words.index("text") if "text" in words else words.index("id")
    rows = []
    for k, cells in enumerate(lines[start + 1 :], start + 2):
        if any(cells):
            full = cells + [""] * len(words)
            rows.append((k, full[name], [full[x], full[y]]))
    return _objects(path, rows)


def _is_pts(lines: Sequence[list[str]]) -> bool:
    """A line with a label alone, then lines of a name and two numbers."""
    filled = [[cell for cell in cells if cell] for cells in lines if any(cells)]
    return (
        len(filled) > 1
        and len(filled[0]) == 1
        and all(len(cells) == 3 for cells in filled[1:])
        and all(number(cell) is not None for cell in filled[1][1:])
    )


def _objects(path: FilePath, rows: Sequence[tuple[int, str, list[str]]]) -> tuple[Listed, ...]:
    if len(rows) > ROWS_MAX:
        raise PointsFileError(one_sentence(path, [f"has {len(rows)} lines, more than {ROWS_MAX}"]))
    faults, objects = [], []
    for line, name, place in rows:
        plain = [number(cell) for cell in place]
        values = [float(text) if text is not None else math.nan for text in plain]
        if not all(abs(value) <= FARTHEST for value in values):
            faults.append(f"line {line}: x and y must be numbers up to {FARTHEST:g}, not {quoted(','.join(place))}")
        else:
            objects.append(Listed(line, name, *values))
    if faults:
        raise PointsFileError(one_sentence(path, faults))
    return tuple(objects)


def are_pixels(objects: Sequence[Listed]) -> bool:
    """Whether places look like pixels of a drawing: all whole, none negative, some beyond the size of an arena."""
    places = [value for listed in objects for value in (listed.x, listed.y)]
    whole = all(value >= 0 and value.is_integer() for value in places)
    return whole and max(places, default=0) > LEAST_PIXEL
