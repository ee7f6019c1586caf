"""`fidmap score`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fidmap.cli import options
from fidmap.cli.exits import DONE, GATE_FAILED, UNUSABLE, complain, usage
from fidmap.cli.gates import failures, parse_gates, split_gates
from fidmap.cli.inputs import distinct, progress_bar

if TYPE_CHECKING:
    from fidmap.model import Arena, Settings
    from fidmap.report.rows import Row
    from fidmap.study.jobs import Outcome, ScoreJob


def score(
    maps: options.MapPaths = None,
    *,
    arena: Annotated[str, typer.Option("--arena", metavar="FILE", help="The arena file: surveyed parts and groups.")],
    profile: Annotated[
        str, typer.Option("--profile", metavar="NAME|FILE", help="A profile's name, or a profile file.")
    ] = "continuous",
    points: Annotated[
        str | None, typer.Option("--points", metavar="FILE", help="Barrel parts located or corrected by hand (CSV).")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Write reports here.")] = None,
    json: options.Json = False,
    workers: options.Workers = 0,
    fail_under: Annotated[
        list[str] | None,
        typer.Option("--fail-under", metavar="0.8|NAME=0.8", help="Exit 3 when a score is lower; may be repeated."),
    ] = None,
    start_pose: Annotated[
        str | None,
        typer.Option(
            "--start-pose", metavar="X_M,Y_M,YAW_DEG[,SIGMA_M,SIGMA_DEG]", help="Where the map's origin stands."
        ),
    ] = None,
    resolution: options.Resolution = None,
    origin: options.Origin = None,
    free_thresh: options.FreeThresh = None,
    occupied_thresh: options.OccupiedThresh = None,
) -> None:
    """Score maps against an arena: coverage, accuracy, consistency, and a weighted overall score."""
    gates, paths = split_gates(fail_under or [], maps or [])
    if not paths and points is None:
        raise usage("no map: give at least one MAP, or --points FILE")
    if points is not None and len(paths) > 1:
        raise usage("--points goes with at most one MAP")
    start, pose = options.parse_start_pose(start_pose), options.parse_origin(origin)

    from fidmap.report.files import check_output
    from fidmap.study.jobs import Overrides, ScoreJob

    truth, settings = _read_arena(arena, profile, points)
    limits = parse_gates(gates, truth)
    if out is not None:
        check_output(out)
    overrides = Overrides(resolution, pose, free_thresh, occupied_thresh)
    kept: Sequence[str | None] = distinct(paths, resolution is not None) or [None]
    jobs = [ScoreJob(path, truth, settings, overrides, points, start, draw=out is not None) for path in kept]
    rows = _run(jobs, out, json, workers)
    if not json:
        _print_table(rows)
    if out is not None:
        _write_index(out, rows)
    raise typer.Exit(_exit_code(rows, limits, out))


def _read_arena(arena: str, profile: str, points: str | None) -> tuple[Arena, Settings]:
    """The profile first: its limit decides which groups are long."""
    from fidmap.arena import read_arena
    from fidmap.model import ArenaFileError
    from fidmap.profiles import read_profile

    settings = read_profile(profile)
    truth = read_arena(arena, settings.long_if_walking_pallets_over)
    if points is None and not truth.has_positions:
        raise ArenaFileError(
            f"{arena}: its parts have no positions, so the program cannot tell which is which; give x_m and y_m "
            "for every part, or locate and name the parts in a points file (--points)"
        )
    return truth, settings


def _run(jobs: Sequence[ScoreJob], out: Path | None, json: bool, workers: int) -> list[Row]:
    """Score, write and print one map after the other, in the order given."""
    from fidmap.report.names import report_names
    from fidmap.study import jobs as work
    from fidmap.study.pool import run

    names = report_names([job.name for job in jobs])
    processes = min(workers or os.cpu_count() or 1, len(jobs))
    rows = []
    with progress_bar(len(jobs), stdout_is_used=json) as progress:
        task = progress.add_task("scoring", total=len(jobs))
        for job, name, outcome in zip(jobs, names, run(jobs, work.score, work.died, processes), strict=True):
            rows.append(_finish(job, name, outcome, out, json))
            progress.advance(task)
    return rows


def _finish(job: ScoreJob, name: str, outcome: Outcome, out: Path | None, json: bool) -> Row:
    """Write the folder of one outcome and print its line; tell faults."""
    from fidmap.report.json_line import json_line
    from fidmap.report.rows import Row

    folder = None if out is None else _write(job, name, outcome, out)
    if json:
        typer.echo(json_line(outcome.document))
    if "error" in outcome.document:
        complain(outcome.document["error"]["text"])
    return Row(outcome.document, folder=folder)


def _write(job: ScoreJob, name: str, outcome: Outcome, out: Path) -> str | None:
    """The name of the folder that holds the report; None where there is none, which is told."""
    from fidmap.model import OutputError
    from fidmap.report.files import write_report

    if outcome.content is None:
        return None
    try:
        written = write_report(out, name, outcome.content, None if job.points is None else Path(job.points))
    except OutputError as error:
        complain(str(error))
        return None
    for note in written.notes:
        complain(f"{note.level}: {note.text}")
    return written.folder.name


def _print_table(rows: Sequence[Row]) -> None:
    """The table on stdout; maps that could not be used were told on stderr already."""
    from rich.console import Console

    from fidmap.report.rows import ranked, scored
    from fidmap.report.terminal import print_scores

    if scored(rows):
        print_scores(Console(), scored(ranked(rows)))


def _write_index(out: Path, rows: Sequence[Row]) -> None:
    """index.html of these maps and of earlier ones scored alike, and where it is; nothing without any report."""
    from fidmap.report.files import write_index
    from fidmap.report.page import index_page
    from fidmap.report.read import earlier_rows
    from fidmap.report.rows import ranked

    if any(row.folder for row in rows):
        index = write_index(out, index_page(ranked([*rows, *earlier_rows(out, rows)])))
        complain(f"reports are in {index}")


def _exit_code(rows: Sequence[Row], limits: dict[str, float], out: Path | None) -> int:
    """1 when a map could not be used or its report not be written, else 3 when a gate failed, else 0."""
    from fidmap.report.rows import scored

    sentences = [sentence for row in scored(rows) for sentence in failures(row.document, limits)]
    for sentence in sentences:
        complain(f"gate failed: {sentence}")
    if len(scored(rows)) < len(rows) or (out is not None and not all(row.folder for row in rows)):
        return UNUSABLE
    return GATE_FAILED if sentences else DONE
