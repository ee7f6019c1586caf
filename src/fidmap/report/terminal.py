"""The table that a referee can read aloud: one line per map, then what was found odd, in plain sentences.

Nothing here is markup: names come from file systems, and rich would take brackets in them for style.
"""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from fidmap.report.rows import (
    Row,
    comparison_warning,
    not_computable,
    scored,
    shared_findings,
    shown_attributes,
)
from fidmap.report.wording import attribute_title, percent, shortened

NAMES_UP_TO = 3
LEVEL_STYLES = {"error": "bold red", "warning": "bold yellow", "note": "bold cyan"}
LEAST_NAME = 12


def print_scores(console: Console, rows: Sequence[Row]) -> None:
    """Print the table, then the findings; maps that could not be used come last.

    Args:
        console: where to print; rich leaves colours out where it is no terminal.
        rows: in the order in which they shall be read.
    """
    if scored(rows):
        console.print(_fitted_table(console, rows))
    warning = comparison_warning(rows)
    if warning:
        _say(console, "warning", "", warning)
    for names, sentence in not_computable(rows):
        _say(console, "note", _who(names, rows), sentence)
    for level, names, sentence in shared_findings(rows):
        _say(console, level, _who(names, rows), sentence)
    for row in rows:
        if row.error is not None:
            _say(console, "error", row.name, f"could not be used: {row.error}")


def _fitted_table(console: Console, rows: Sequence[Row]) -> Table:
    """The table, with names as long as the terminal allows: they give way first, never the numbers."""
    bare = console.measure(_table(rows, LEAST_NAME)).maximum
    return _table(rows, LEAST_NAME + max(0, console.width - bare))


def _table(rows: Sequence[Row], longest_name: int) -> Table:
    """Rank, map and scores; of a long name the end is kept."""
    has_ranks = any(row.rank is not None for row in rows)
    attributes = shown_attributes(rows)
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    if has_ranks:
        table.add_column("Rank", justify="right", no_wrap=True)
    table.add_column("Map", no_wrap=True, min_width=LEAST_NAME)
    for name in attributes:
        table.add_column(attribute_title(name).replace(" ", "\n"), justify="right", no_wrap=True)
    for row in scored(rows):
        rank = [Text(row.rank or "–")] if has_ranks else []
        scores = [_score(row, name) for name in attributes]
        table.add_row(*rank, Text(shortened(row.name, longest_name)), *scores)
    return table


def _score(row: Row, attribute: str) -> Text:
    if attribute != "overall":
        return Text(percent(row.score(attribute)))
    return Text.assemble((percent(row.score(attribute)), "bold"), f" {row.interval(attribute)}".rstrip())


def _who(names: Sequence[str], rows: Sequence[Row]) -> str:
    """The maps that a sentence is about; nobody needs to be named where there is only one map."""
    everyone = scored(rows)
    if len(everyone) == 1:
        return ""
    if len(names) == len(everyone):
        return "all maps"
    if len(names) <= NAMES_UP_TO:
        return ", ".join(names)
    return f"{', '.join(names[:NAMES_UP_TO])} and {len(names) - NAMES_UP_TO} more"


def _say(console: Console, level: str, who: str, sentence: str) -> None:
    text = Text()
    text.append(level.capitalize(), style=LEVEL_STYLES[level])
    text.append(f", {who}: {sentence}" if who else f": {sentence}")
    console.print(text, soft_wrap=not console.is_terminal)
