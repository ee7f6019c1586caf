"""Ranks of several maps in a table, and beside them the ranks that a human judge gave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from fidmap.model import Value
from fidmap.ranking import Agreement, Rank
from fidmap.report.wording import attribute_title, clean

Ranks = Sequence[Rank | None]


def print_ranking(
    console: Console,
    maps: Sequence[str],
    ours: Mapping[str, Ranks],
    figures: Mapping[str, Sequence[float | None]],
    theirs: Mapping[str, Ranks] | None = None,
) -> None:
    """Print one line per map, best overall first.

    Args:
        console: where to print.
        maps: names, in the order of all the sequences.
        ours: per attribute the metric's ranks.
        figures: per attribute the percentages behind them.
        theirs: per attribute the judge's ranks; shown after a slash.
    """
    table = Table(box=box.SIMPLE)
    table.add_column("map", overflow="fold")
    for name in ours:
        table.add_column(attribute_title(name) + (" / human" if theirs and name in theirs else ""), justify="right")
    leading = ours.get("overall") or next(iter(ours.values()))
    order = sorted(range(len(maps)), key=lambda k: ((rank := leading[k]) and rank.middle) or len(maps) + 1)
    for k in order:
        cells = [_cell(ours[name][k], figures.get(name, ()), theirs.get(name) if theirs else None, k) for name in ours]
        table.add_row(Text(clean(maps[k])), *cells)
    console.print(table)


def _cell(ours: Rank | None, figures: Sequence[float | None], theirs: Ranks | None, k: int) -> str:
    """`4-5 (60.1 %) / 2`."""
    figure = figures[k] if figures else None
    percent = "" if figure is None else f" ({figure:.1f} %)"
    human = "" if theirs is None else f" / {theirs[k] or '-'}"
    return f"{ours or '-'}{percent}{human}"


def print_agreement(console: Console, agreements: Mapping[str, Agreement]) -> None:
    """Print how far metric and judge agree, per attribute, with n and a permutation p-value."""
    table = Table(box=box.SIMPLE, title="Metric against human judge", title_justify="left")
    for column in ("attribute", "n", "Spearman", "p", "Kendall tau-b", "p"):
        table.add_column(column, justify="left" if column == "attribute" else "right")
    for name, found in agreements.items():
        cells = [found.spearman.value, found.spearman.p_value, found.kendall.value, found.kendall.p_value]
        table.add_row(attribute_title(name), str(found.n), *(_number(value) for value in cells))
    console.print(table)
    console.print(Text("p: share of permutations that agree or disagree at least as strongly (two-sided)"))


def _number(value: Value) -> str:
    return "-" if value.value is None else f"{value.value:.3f}"
