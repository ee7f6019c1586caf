"""CSV tables that people and spreadsheets wrote: columns checked, every fault with its line.

Comma, semicolon or tab, whichever the header uses; with semicolons a comma inside a number is a decimal
comma. A byte order mark, CRLF and blank lines are no faults.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from fidmap.model import FidmapError
from fidmap.text_file import FilePath, one_sentence, quoted, read_text

ROWS_MAX = 100_000


@dataclass(frozen=True)
class Row:
    """One line of a table: its number in the file (from 1) and its cells by column; an absent cell is ''."""

    line: int
    cells: dict[str, str]


@dataclass(frozen=True)
class Table:
    """A table as its file holds it, and the faults of its form."""

    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    decimal_comma: bool
    faults: tuple[str, ...]


def read_table(
    path: FilePath,
    what: str,
    error: type[FidmapError],
    required: Sequence[str],
    optional: Sequence[str],
) -> Table:
    """Read a table whose first line names its columns, in any order.

    Args:
        path: the file.
        what: what it should be, for the error text ('a points file').
        error: raised where there is no table at all; faults of single lines come back in the table.
        required: columns that must be there.
        optional: columns that may be there; any other is a fault.
    """
    text, _ = read_text(path, what, error)
    header = next((line for line in text.splitlines() if line.strip()), "")
    separator = max(";\t,", key=header.count)
    try:
        lines = _lines(text, separator)
    except csv.Error as fault:
        raise error(one_sentence(path, [f"not CSV: {fault}"])) from None
    if not lines:
        expected = f"expected {what} with a first line {','.join(required)}"
        raise error(one_sentence(path, [f"is empty, {expected}"]))
    columns = tuple(cell.lower() for cell in lines[0][1])
    rows = tuple(Row(line, dict(zip(columns, cells, strict=False))) for line, cells in lines[1:])
    if len(rows) > ROWS_MAX:
        raise error(one_sentence(path, [f"has {len(rows)} lines, more than {ROWS_MAX}"]))
    faults = _column_faults(columns, required, optional)
    faults += [
        f"line {line}: has {len(cells)} cells for {len(columns)} columns"
        for line, cells in lines[1:]
        if len(cells) > len(columns)
    ]
    return Table(columns, rows, separator == ";", tuple(faults))


def _lines(text: str, separator: str) -> list[tuple[int, list[str]]]:
    """The lines that are not blank, numbered; cells stripped, without the empty ones that Excel appends."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    numbered: list[tuple[int, list[str]]] = []
    start = 1
    for cells in reader:
        stripped = [cell.strip() for cell in cells]
        while stripped and not stripped[-1]:
            stripped.pop()
        if stripped:
            numbered.append((start, stripped))
        start = reader.line_num + 1
    return numbered


def _column_faults(columns: Sequence[str], required: Sequence[str], optional: Sequence[str]) -> list[str]:
    known = (*required, *optional)
    unknown = [column for column in dict.fromkeys(columns) if column not in known]
    faults = [f"column '{column}' is missing" for column in required if column not in columns]
    faults += [f"column '{column}' is there twice" for column in known if columns.count(column) > 1]
    if unknown:
        names = ", ".join(quoted(column) for column in unknown)
        faults.append(f"unknown column{'s' * (len(unknown) > 1)} {names}, known are {', '.join(known)}")
    return faults


_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d{1,3})?", re.ASCII)


def number(text: str, decimal_comma: bool = False) -> str | None:
    """The text of a decimal number, with a point; None for what is no number ('nan' and '1_0' too)."""
    plain = text.replace(",", ".", 1) if decimal_comma else text
    return plain if len(plain) <= 60 and _NUMBER.fullmatch(plain) else None


def twice(words: Collection[tuple[int, str]]) -> list[tuple[int, str, int]]:
    """Words that occurred on an earlier line: (line, word, first line)."""
    first: dict[str, int] = {}
    return [(line, word, first[word]) for line, word in words if first.setdefault(word, line) != line]
