"""Ranks of several maps in a table, and beside them the ranks that a human judge gave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from fidmap.model import Value
from fidmap.ranking import Agreement, Rank
from fidmap.report.losses import A_TIE, doubt
from fidmap.report.wording import attribute_title, clean
from fidmap.uncertainty.compare import SURE

Ranks = Sequence[Rank | None]


def print_ranking(
    console: Console,
    maps: Sequence[str],
    ours: Mapping[str, Ranks],
    figures: Mapping[str, Sequence[float | None]],
    theirs: Mapping[str, Ranks] | None = None,
    doubts: Mapping[int, float | None] | None = None,
) -> None:
    """Print one line per map, best overall first.

    Args:
        console: where to print.
        maps: names, in the order of all the sequences.
        ours: per attribute the metric's ranks.
        figures: per attribute the percentages behind them; shown where there is no judge.
        theirs: per attribute the judge's ranks; shown after a slash, as in the paper's Table III.
        doubts: per map the probability that it is truly better overall than the next in the table.
    """
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("Map", overflow="fold", min_width=12)
    for name in ours:
        judged = "\n/ human" if theirs is not None and name in theirs else ""
        table.add_column(attribute_title(name).replace(" ", "\n") + judged, justify="right", no_wrap=True)
    if doubts:
        table.add_column("Better\nthan next", justify="right", no_wrap=True)
    for k in best_first(ours, figures, len(maps)):
        cells = [
            _with_percent(ours[name][k], figures.get(name, ()), k)
            if theirs is None
            else _with_judge(ours[name][k], theirs.get(name), k)
            for name in ours
        ]
        table.add_row(Text(clean(maps[k])), *cells, *([doubt(doubts.get(k))] if doubts else []))
    console.print(table)
    if doubts and any(p is not None and p < SURE for p in doubts.values()):
        console.print(Text(f"~ a tie: this mapper is {A_TIE}"))


def best_first(ours: Mapping[str, Ranks], figures: Mapping[str, Sequence[float | None]], count: int) -> list[int]:
    """Indices of the maps by their overall rank (or the first column's), then by its figure; those without one last."""
    name = "overall" if "overall" in ours else next(iter(ours), "")
    leading = ours.get(name, (None,) * count)
    values = figures.get(name) or (None,) * count
    return sorted(
        range(count), key=lambda k: (count + 1 if (r := leading[k]) is None else r.middle, -(values[k] or 0.0))
    )


def _with_percent(rank: Rank | None, figures: Sequence[float | None], k: int) -> str:
    """`4-5 (60.1 %)`."""
    figure = figures[k] if figures else None
    return f"{rank or '-'}" if figure is None else f"{rank or '-'} ({figure:.1f} %)"


def _with_judge(rank: Rank | None, judged: Ranks | None, k: int) -> str:
    """`4-5 / 2`."""
    return f"{rank or '-'}" if judged is None else f"{rank or '-'} / {judged[k] or '-'}"


def print_agreement(console: Console, agreements: Mapping[str, Agreement]) -> None:
    """Print how far metric and judge agree, per attribute, with n and a permutation p-value."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    for column in ("Metric against\nhuman", "n", "Spearman (95 %)", "p", "Kendall tau-b (95 %)", "p"):
        table.add_column(column, justify="right" if table.columns else "left", no_wrap=True)
    for name, found in agreements.items():
        cells = [
            cell
            for one in (found.spearman, found.kendall)
            for cell in (_number(one.value) + _interval(one.interval), _number(one.p_value))
        ]
        table.add_row(attribute_title(name), str(found.n), *cells)
    console.print()
    console.print(table)
    reasons = {attribute_title(name): found.spearman.value.reason for name, found in agreements.items()}
    for title, reason in reasons.items():
        if reason:
            console.print(Text(f"{title} cannot be compared: {reason}"))
    console.print(Text("p: share of permutations that agree or disagree at least as strongly (two-sided)"))


def _number(value: Value) -> str:
    return "-" if value.value is None else f"{value.value:.3f}"


def _interval(bounds: tuple[float, float] | None) -> str:
    return "" if bounds is None else f" ({bounds[0]:.2f} to {bounds[1]:.2f})"
