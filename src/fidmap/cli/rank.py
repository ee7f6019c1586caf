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


# findings after which a score is to be mended before it is ranked
WRONG_MAP = ("radius-off", "scale-off", "mirrored", "another-arena")


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
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="FILE", help="With --human: ranks against ranks, as .svg or .png."),
    ] = None,
) -> None:
    """Rank scored maps, with ties, and compare the ranks with a human judge's."""
    if not tie_within >= 0:
        raise usage(f"--tie-within {tie_within}: expected a number of percent points, 0 or more")
    if picture is not None and (human is None or picture.suffix.lower() not in {".svg", ".png"}):
        raise usage(f"--picture {picture}: expected a name that ends in .svg or .png, together with --human")

    from rich.console import Console

    from fidmap.human import read_human
    from fidmap.report.comparison import print_ranking

    figures, documents = _figures(reports)
    _tell_wrong_maps(documents)
    ours = {name: column.ranks(tie_within) for name, column in figures.columns.items()}
    percents = {name: column.percents for name, column in figures.columns.items()}
    console = Console()
    if human is None:
        print_ranking(console, figures.maps, ours, percents, doubts=_doubts(documents, ours, percents))
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
    _tell_agreement(console, figures.maps, ours, theirs, picture)


def _tell_agreement(
    console: Console,
    maps: Sequence[str],
    ours: Mapping[str, Sequence[Rank | None]],
    theirs: Mapping[str, Sequence[Rank | None]],
    picture: Path | None,
) -> None:
    """Rank correlations per attribute that both have, and their picture."""
    from fidmap.ranking import agreement
    from fidmap.report.comparison import print_agreement
    from fidmap.report.human_picture import write_ranks

    found = {name: agreement(ours[name], theirs[name]) for name in theirs}
    print_agreement(console, found)
    if picture is not None:
        write_ranks(picture, maps, ours, theirs, found)


def _doubts(
    documents: Mapping[str, Document],
    ours: Mapping[str, Sequence[Rank | None]],
    percents: Mapping[str, Sequence[float | None]],
) -> dict[int, float | None]:
    """Per map the probability that it is better overall than the next one in the table; none for printed figures."""
    from fidmap.report.comparison import best_first
    from fidmap.report.losses import better_than_next, sizes_warning

    if not documents or "overall" not in ours:
        return {}
    every = list(documents.values())
    if warning := sizes_warning(every):
        complain(f"warning: {warning}")
    order = best_first(ours, percents, len(every))
    return dict(zip(order, better_than_next([every[k] for k in order]), strict=True))


def _tell_wrong_maps(documents: Mapping[str, Document]) -> None:
    """Warnings of the reports that say a score is not the map's: its scale, its sides or its arena are wrong."""
    from fidmap.report.rows import finding_sentence

    for name, document in documents.items():
        for finding in document.get("findings", ()):
            if finding.get("code") in WRONG_MAP:
                complain(f"{finding['level']}: {name}: {finding_sentence(finding)}")


def _tell_unmatched(ours: Sequence[str], theirs: Sequence[str]) -> None:
    """Names that only one side has."""
    for side, names in (
        ("not judged", set(ours) - set(theirs)),
        ("judged, but without a report", set(theirs) - set(ours)),
    ):
        if names:
            complain(f"note: {side}: {', '.join(sorted(names))}")


def _figures(paths: Sequence[Path]) -> tuple[HumanRanking, dict[str, Document]]:
    """The percentages to rank, of a CSV of printed figures or of reports, and the reports by name."""
    from fidmap.human import read_human
    from fidmap.model import ReportFileError

    tables = [path for path in paths if path.suffix.lower() == ".csv"]
    if tables and len(paths) > 1:
        raise ReportFileError(f"{tables[0]}: a CSV of figures is ranked alone; give it by itself, or only reports")
    if tables:
        return read_human(tables[0]), {}
    documents = _documents(paths)
    return _of_reports(documents), documents


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
