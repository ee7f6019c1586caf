"""A human judge's ranking of maps, as a CSV file: percents or ranks, per column."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

from fidmap.csv_file import Table, number, read_table, twice
from fidmap.model import ATTRIBUTES, HumanFileError
from fidmap.ranking import TIE_WITHIN, Rank, ranks
from fidmap.text_file import FilePath, one_sentence, quoted

JUDGED = (*ATTRIBUTES, "overall")
_RANGE = re.compile(r"(\d{1,6})\s*[-\u2013]\s*(\d{1,6})", re.ASCII)


@dataclass(frozen=True)
class Column:
    """One attribute as judged: `percents` where given as percents, `shared` where given as ranks.

    Both have one entry per map, None for a map that was not judged.
    """

    kind: Literal["percents", "ranks"]
    percents: tuple[float | None, ...] = ()
    shared: tuple[Rank | None, ...] = ()

    def ranks(self, tie_within: float = TIE_WITHIN) -> tuple[Rank | None, ...]:
        """The ranks: as given, or from the percents with ties within so many points."""
        return self.shared if self.kind == "ranks" else ranks(self.percents, tie_within)


@dataclass(frozen=True)
class HumanRanking:
    """What a judge said about each map; `columns` holds the attributes that the file has."""

    maps: tuple[str, ...]
    columns: dict[str, Column]


def read_human(path: FilePath) -> HumanRanking:
    """Read `map,coverage,relative_accuracy,consistency,overall` (any of them; blank: not judged).

    Whether a column holds percents or ranks is decided per column, in this order:
    1. a cell with a percent sign: percents; a cell like `4-5`: ranks;
    2. a value that is no whole number, or lies outside 1 to the number of judged maps: percents;
    3. whole numbers that form a ranking (a tie leaves as many places free as it has maps, 1 2 2 4): ranks;
    4. whole numbers without a gap (1 2 2 3) are a fault, since they say neither; all else is percents.

    Raises:
        HumanFileError: all faults in one sentence, each with its line or column.
    """
    table = read_table(path, "a human ranking", HumanFileError, ("map",), JUDGED)
    judged = [column for column in JUDGED if column in table.columns]
    faults = list(table.faults)
    if not faults:
        faults = _row_faults(table, judged)
    columns: dict[str, Column] = {}
    if not faults:
        for column in judged:
            cells = [row.cells.get(column, "") for row in table.rows]
            columns[column], found = _column(column, cells, table.decimal_comma)
            faults += found
    if faults:
        raise HumanFileError(one_sentence(path, faults))
    return HumanRanking(tuple(row.cells["map"] for row in table.rows), columns)


def _row_faults(table: Table, judged: Sequence[str]) -> list[str]:
    """Faults of single cells and of map names, in the order of their lines."""
    found = [] if judged else [(1, f"no column is judged, expected any of {', '.join(JUDGED)}")]
    names = [(row.line, row.cells.get("map", "")) for row in table.rows]
    found += [(line, "map is missing") for line, name in names if not name]
    found += [
        (line, f"map {quoted(name)} stands already on line {first}") for line, name, first in twice(names) if name
    ]
    for row in table.rows:
        for column in judged:
            cell = row.cells.get(column, "")
            if fault := _cell_fault(cell, len(table.rows), table.decimal_comma):
                found.append((row.line, f"{column} {fault}, not {quoted(cell)}"))
    return [f"line {line}: {fault}" for line, fault in sorted(found, key=lambda item: item[0])]


def _cell_fault(cell: str, maps: int, decimal_comma: bool) -> str | None:
    """What is wrong with a cell for itself, or None."""
    if not cell:
        return None
    if between := _RANGE.fullmatch(cell):
        good = 1 <= int(between[1]) < int(between[2]) <= maps
        return None if good else f"must rise from 1 to at most {maps}, the number of maps"
    plain = _percent(cell, decimal_comma)
    if plain is None:
        return "must be a percent or a rank like 4 or 4-5"
    return None if 0 <= plain <= 100 else "must be from 0 to 100 percent"


def _percent(cell: str, decimal_comma: bool) -> float | None:
    plain = number(cell.removesuffix("%").rstrip(), decimal_comma)
    return None if plain is None else float(plain)


def _column(name: str, cells: Sequence[str], decimal_comma: bool) -> tuple[Column, list[str]]:
    """Decide what a column holds (the order of `read_human`) and take it in."""
    ranges = any(_RANGE.fullmatch(cell) for cell in cells)
    signs = any(cell.endswith("%") for cell in cells)
    if ranges and signs:
        return Column("ranks"), [f"column {name}: mixes percents with ranks"]
    if ranges:
        return _ranked(name, cells, decimal_comma)
    values = tuple(_percent(cell, decimal_comma) if cell else None for cell in cells)
    judged = sorted(value for value in values if value is not None)
    if not signs and judged and all(value.is_integer() and 1 <= value <= len(judged) for value in judged):
        if _is_ranking(judged):
            return Column("ranks", shared=_shared(values)), []
        if judged[0] == 1 and all(b - a <= 1 for a, b in pairwise(judged)):
            return Column("ranks"), [f"column {name}: is no ranking, write tied maps as 2-3"]
    if not signs and judged and judged[-1] <= 1 and not all(value.is_integer() for value in judged):
        return Column("percents"), [f"column {name}: holds fractions, write percents from 0 to 100"]
    return Column("percents", percents=values), []


def _is_ranking(judged: Sequence[float]) -> bool:
    """Whether sorted whole numbers are places: each is the place of its first holder (1 2 2 4)."""
    return all(value == bisect_left(judged, value) + 1 for value in judged)


def _shared(values: Sequence[float | None]) -> tuple[Rank | None, ...]:
    """Places 1 2 2 4 as the ranks 1, 2-3, 2-3, 4."""
    return ranks([None if value is None else -value for value in values], 0)


def _ranked(name: str, cells: Sequence[str], decimal_comma: bool) -> tuple[Column, list[str]]:
    """A column with ranges; the ranks are taken as written, since judges rank by eye."""
    shared: list[Rank | None] = []
    faults = []
    for cell in cells:
        between = _RANGE.fullmatch(cell)
        value = _percent(cell, decimal_comma) if cell and not between else None
        if between:
            shared.append(Rank(int(between[1]), int(between[2])))
        elif value is not None and value.is_integer() and 1 <= value <= len(cells):
            shared.append(Rank(int(value), int(value)))
        else:
            shared.append(None)
            if cell:
                faults.append(f"column {name}: {quoted(cell)} is no rank from 1 to {len(cells)}")
    return Column("ranks", shared=tuple(shared)), faults
