"""Points files: barrel parts located by hand, or found by the program and corrected by a human."""

from __future__ import annotations

import csv
import difflib
import io
import math
from collections import Counter
from collections.abc import Sequence
from os import fspath

from fidmap.angles import degrees_text, radians_of_text
from fidmap.csv_file import Row, Table, number, read_table, twice
from fidmap.model import Arena, BarrelPart, PointsFileError
from fidmap.object_list import Listed, are_pixels, read_objects
from fidmap.text_file import FAULTS_SHOWN, FilePath, one_sentence, quoted

NO_PART = "-"
COLUMNS = ("n", "x_m", "y_m", "facing_deg", "drawn_deg", "sigma_m", "confidence", "part", "id")
_REQUIRED = ("x_m", "y_m")
_BOUNDS = {
    "x_m": (-1e8, 1e8),
    "y_m": (-1e8, 1e8),
    "facing_deg": (-360.0, 360.0),
    "drawn_deg": (0.0, 360.0),
    "sigma_m": (0.0, 1e8),
    "confidence": (0.0, 1.0),
}
_N_MAX = 10**9


def read_points(
    path: FilePath, arena: Arena | None = None, resolution_m: float | None = None
) -> tuple[BarrelPart, ...]:
    """Read a points file (`x_m,y_m` and any of the other `COLUMNS`), in the map's frame, or a list of objects.

    An empty `n` is numbered on after the largest given, in the order of the file. An empty `facing_deg` is no
    facing, an empty `drawn_deg` half a circle for parts with a facing and a whole one for others, an empty
    `confidence` 1. `part`, what the program once found, is ignored; `id` is the human's word.

    Args:
        path: a points file, or a list of a rescue league (`victims`, `qr codes`, `pois`, `.pts`).
        arena: objects of a list whose name is a part's id, and nobody else's in the list, are that part.
        resolution_m: metres per pixel of a list whose places are pixels of a drawing.

    Raises:
        PointsFileError: all faults in one sentence, each with its line.
    """
    if (objects := read_objects(path)) is not None:
        return _listed_parts(path, objects, arena, resolution_m)
    optional = tuple(column for column in COLUMNS if column not in _REQUIRED)
    table = read_table(path, "a points file", PointsFileError, _REQUIRED, optional)
    faults = list(table.faults) or _row_faults(table)
    if faults:
        raise PointsFileError(one_sentence(path, faults))
    given = [int(row.cells.get("n") or 0) for row in table.rows]
    following = iter(range(max(given, default=0) + 1, max(given, default=0) + 1 + len(given)))
    return tuple(
        _part(row, n or next(following), table.decimal_comma) for row, n in zip(table.rows, given, strict=True)
    )


def _listed_parts(
    path: FilePath, objects: Sequence[Listed], arena: Arena | None, resolution_m: float | None
) -> tuple[BarrelPart, ...]:
    """Objects as whole barrels; pixels count downwards, so they are turned over."""
    right = up = 1.0
    if are_pixels(objects):
        if resolution_m is None:
            fault = "its places look like pixels of a drawing; say how large one is with --resolution M_PER_PIXEL"
            raise PointsFileError(one_sentence(path, [fault]))
        right, up = resolution_m, -resolution_m
    known = {part.id for part in arena.parts} if arena is not None else set()
    often = Counter(listed.name for listed in objects)
    return tuple(
        BarrelPart(
            n=n,
            x_m=right * listed.x,
            y_m=up * listed.y,
            fixed_id=listed.name if listed.name in known and often[listed.name] == 1 else None,
        )
        for n, listed in enumerate(objects, 1)
    )


def _row_faults(table: Table) -> list[str]:
    """Faults of all rows, in the order of their lines."""
    found = [(row.line, fault) for row in table.rows for fault in _cell_faults(row, table.decimal_comma)]
    numbers = [(row.line, str(int(n))) for row in table.rows if (n := row.cells.get("n")) and _is_n(n)]
    found += [(line, f"n {n} stands already on line {first}") for line, n, first in twice(numbers)]
    ids = [(row.line, word) for row in table.rows if (word := row.cells.get("id")) and word != NO_PART]
    found += [(line, f"id '{word}' stands already on line {first}") for line, word, first in twice(ids)]
    return [f"line {line}: {fault}" for line, fault in sorted(found, key=lambda item: item[0])]


def _is_n(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) < 12 and 1 <= int(text) <= _N_MAX


def _cell_faults(row: Row, decimal_comma: bool) -> list[str]:
    faults = []
    if (n := row.cells.get("n")) and not _is_n(n):
        faults.append(f"n must be a whole number from 1, not {quoted(n)}")
    for column, (low, high) in _BOUNDS.items():
        text = row.cells.get(column, "")
        if not text:
            if column in _REQUIRED:
                faults.append(f"{column} is missing")
            continue
        plain = number(text, decimal_comma)
        if plain is None:
            faults.append(f"{column} must be a number, not {quoted(text)}")
        elif not low <= float(plain) <= high or (column == "drawn_deg" and float(plain) == 0):
            above = "more than " * (column == "drawn_deg")
            faults.append(f"{column} must be from {above}{low:g} to {high:g}, not {quoted(text)}")
    return faults


def _part(row: Row, n: int, decimal_comma: bool) -> BarrelPart:
    texts = {column: number(row.cells.get(column, ""), decimal_comma) for column in _BOUNDS}
    facing = None if texts["facing_deg"] is None else radians_of_text(texts["facing_deg"])
    drawn = math.pi if facing is not None else 2 * math.pi
    return BarrelPart(
        n=n,
        x_m=float(texts["x_m"] or 0),
        y_m=float(texts["y_m"] or 0),
        facing=facing,
        drawn=drawn if texts["drawn_deg"] is None else radians_of_text(texts["drawn_deg"]),
        sigma_m=None if texts["sigma_m"] is None else float(texts["sigma_m"]),
        confidence=1.0 if texts["confidence"] is None else float(texts["confidence"]),
        fixed_id=row.cells.get("id") or None,
    )


def points_csv(parts: Sequence[BarrelPart], part_names: Sequence[str | None]) -> str:
    """The text of a points file; reading it back gives the same parts to the last bit, but for `spread_m`.

    Args:
        parts: the barrel parts, in the map's frame.
        part_names: per barrel part what the program took it for, or None.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for part, name in zip(parts, part_names, strict=True):
        facing = "" if part.facing is None else degrees_text(part.facing)
        sigma = "" if part.sigma_m is None else repr(float(part.sigma_m))
        place = (repr(float(part.x_m)), repr(float(part.y_m)))
        quality = (degrees_text(part.drawn), sigma, repr(float(part.confidence)))
        writer.writerow([part.n, *place, facing, *quality, name or "", part.fixed_id or ""])
    return text.getvalue()


def check_ids(parts: Sequence[BarrelPart], arena: Arena, path: FilePath) -> None:
    """Check that every id of a points file is a part of the arena (or '-', no part).

    Raises:
        PointsFileError: all unknown ids in one sentence, each with its `n` and the nearest known id.
    """
    known = {part.id for part in arena.parts} | {NO_PART}
    faults: list[str] = []
    for part in parts:
        if part.fixed_id is not None and part.fixed_id not in known:
            shown = len(faults) < FAULTS_SHOWN  # looking for the nearest id is slow, and not all are shown
            close = difflib.get_close_matches(part.fixed_id, sorted(known), n=1, cutoff=0.5) if shown else ()
            hint = f" (did you mean {close[0]}?)" if close else ""
            faults.append(f"n {part.n}: id {quoted(part.fixed_id)} is no part of arena '{arena.name}'{hint}")
    if faults:
        raise PointsFileError(one_sentence(fspath(path), faults))
