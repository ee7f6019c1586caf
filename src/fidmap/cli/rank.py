"""`fidmap rank`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fidmap.cli.exits import complain, usage

if TYPE_CHECKING:
    from rich.console import Console

    from fidmap.human import HumanRanking
    from fidmap.ranking import Rank
    from fidmap.report.json_line import Document


def rank(
    reports: Annotated[
        list[Path],
        typer.Argument(metavar="REPORT|DIR|CSV...", help="Reports, folders of reports, or one CSV of printed figures."),
    ],
    human: Annotated[
        Path | None, typer.Option("--human", metavar="FILE", help="A human judge's percents or ranks (CSV).")
    ] = None,
    tie_within: Annotated[
        float, typer.Option("--tie-within", min=0, help="Scores at most so many points apart share a rank.")
    ] = 0.5,
) -> None:
    """Rank scored maps, with ties, and compare the ranks with a human judge's."""
    if not tie_within >= 0:
        raise usage(f"--tie-within {tie_within}: expected a number of percent points, 0 or more")

    from rich.console import Console

    from fidmap.human import read_human
    from fidmap.report.comparison import print_ranking

    figures = _figures(reports)
    ours = {name: column.ranks(tie_within) for name, column in figures.columns.items()}
    percents = {name: column.percents for name, column in figures.columns.items()}
    console = Console()
    if human is None:
        print_ranking(console, figures.maps, ours, percents)
        return
    judged = read_human(human)
    places = [judged.maps.index(name) if name in judged.maps else None for name in figures.maps]
    _tell_unmatched(figures.maps, judged.maps)
    theirs = {
        name: [None if place is None else ranks[place] for place in places]
        for name, ranks in ((n, column.ranks(tie_within)) for n, column in judged.columns.items())
        if name in ours
    }
    print_ranking(console, figures.maps, ours, percents, theirs)
    _print_agreement(console, ours, theirs)


def _print_agreement(
    console: Console, ours: Mapping[str, Sequence[Rank | None]], theirs: Mapping[str, Sequence[Rank | None]]
) -> None:
    """Rank correlations per attribute that both have."""
    from fidmap.ranking import agreement
    from fidmap.report.comparison import print_agreement

    print_agreement(console, {name: agreement(ours[name], theirs[name]) for name in theirs})


def _tell_unmatched(ours: Sequence[str], theirs: Sequence[str]) -> None:
    """Names that only one side has."""
    for side, names in (
        ("not judged", set(ours) - set(theirs)),
        ("judged, but without a report", set(theirs) - set(ours)),
    ):
        if names:
            complain(f"note: {side}: {', '.join(sorted(names))}")


def _figures(paths: Sequence[Path]) -> HumanRanking:
    """The percentages to rank: of a CSV of printed figures, or of reports."""
    from fidmap.human import read_human
    from fidmap.model import ReportFileError

    tables = [path for path in paths if path.suffix.lower() == ".csv"]
    if tables and len(paths) > 1:
        raise ReportFileError(f"{tables[0]}: a CSV of figures is ranked alone; give it by itself, or only reports")
    return read_human(tables[0]) if tables else _of_reports(_documents(paths))


def _documents(paths: Sequence[Path]) -> dict[str, Document]:
    """Reports by name: the name of the folder that holds each."""
    from fidmap.model import ReportFileError
    from fidmap.report.read import read_report

    found: dict[str, Document] = {}
    for path in paths:
        is_collection = path.is_dir() and not (path / "report.json").is_file()
        files = sorted(path.glob("*/report.json")) if is_collection else [path]
        if not files:
            raise ReportFileError(f"{path}: holds no reports; give a folder that fidmap score --out wrote")
        for file in files:
            folder = file if file.is_dir() else file.parent
            name = folder.resolve().name
            if name in found:
                raise ReportFileError(f"{file}: a second report is named {name}; rename one of the folders")
            found[name] = read_report(file)
    return found


def _of_reports(documents: dict[str, Document]) -> HumanRanking:
    """Scores of reports as percentages; columns that no report can compute are left out."""
    from fidmap.human import Column, HumanRanking
    from fidmap.report.rows import Row, comparison_warning

    columns = {}
    for name in ("coverage", "relative_accuracy", "consistency", "global_accuracy", "overall"):
        values = [document["attributes"][name]["value"] for document in documents.values()]
        if any(value is not None for value in values):
            columns[name] = Column("percents", tuple(None if value is None else 100 * value for value in values))
    warning = comparison_warning([Row(document) for document in documents.values()])
    if warning:
        complain(f"warning: {warning}")
    return HumanRanking(tuple(documents), columns)
