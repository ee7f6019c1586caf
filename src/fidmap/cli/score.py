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

if TYPE_CHECKING:
    from fidmap.model import Arena, Settings
    from fidmap.report.rows import Row
    from fidmap.study.jobs import Outcome, ScoreJob


def score(
    maps: options.MapPaths = None,
    arena: Annotated[str, typer.Option("--arena", help="The arena file: surveyed parts and groups.")] = ...,  # type: ignore[assignment]
    profile: Annotated[str, typer.Option("--profile", help="A profile's name, or a profile file.")] = "continuous",
    points: Annotated[
        str | None, typer.Option("--points", help="Barrel parts located or corrected by hand (CSV).")
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

    from fidmap.study.jobs import Overrides, ScoreJob

    truth, settings = _read_arena(arena, profile)
    limits = parse_gates(gates, truth)
    overrides = Overrides(resolution, pose, free_thresh, occupied_thresh)
    kept: Sequence[str | None] = _distinct(paths, overrides) if paths else [None]
    jobs = [ScoreJob(path, truth, settings, overrides, points, start, draw=out is not None) for path in kept]
    rows = _run(jobs, out, json, workers)
    if not json:
        _print_table(rows)
    if out is not None:
        _write_index(out, rows)
    raise typer.Exit(_exit_code(rows, limits))


def _read_arena(arena: str, profile: str) -> tuple[Arena, Settings]:
    """The profile first: its limit decides which groups are long."""
    from fidmap.arena import read_arena
    from fidmap.profiles import read_profile

    settings = read_profile(profile)
    return read_arena(arena, settings.long_if_walking_pallets_over), settings


def _distinct(paths: Sequence[str], overrides: object) -> list[str]:
    """Every map once: an image whose own YAML is named too is left out, with a note."""
    from fidmap.maps import main_file

    plain = getattr(overrides, "resolution_m", None) is not None
    seen: dict[Path, str] = {}
    for path in sorted(paths, key=lambda p: not p.lower().endswith((".yaml", ".yml"))):
        main = Path(path).resolve() if plain else main_file(path)
        if main in seen:
            complain(f"note: {path} is the same map as {seen[main]}; it is scored once")
        else:
            seen[main] = path
    kept = set(seen.values())
    return [path for k, path in enumerate(paths) if path in kept and path not in paths[:k]]


def _run(jobs: Sequence[ScoreJob], out: Path | None, json: bool, workers: int) -> list[Row]:
    """Score, write and print one map after the other, in the order given."""
    from rich.console import Console
    from rich.progress import Progress

    from fidmap.report.names import report_names
    from fidmap.study import jobs as work
    from fidmap.study.pool import run

    names = report_names([job.name for job in jobs])
    processes = min(workers or os.cpu_count() or 1, len(jobs))
    rows = []
    with Progress(console=Console(stderr=True), transient=True, disable=len(jobs) < 2) as progress:
        task = progress.add_task("scoring", total=len(jobs))
        for job, name, outcome in zip(jobs, names, run(jobs, work.score, work.died, processes), strict=True):
            rows.append(_finish(job, name, outcome, out, json))
            progress.advance(task)
    return rows


def _finish(job: ScoreJob, name: str, outcome: Outcome, out: Path | None, json: bool) -> Row:
    """Write the folder of one outcome and print its line; tell faults."""
    from fidmap.report.files import write_report
    from fidmap.report.json_line import json_line
    from fidmap.report.rows import Row

    folder = None
    if out is not None and outcome.content is not None:
        points = None if job.points is None else Path(job.points)
        written = write_report(out, name, outcome.content, points)
        folder = written.folder.name
        for note in written.notes:
            complain(f"{note.level}: {note.text}")
    if json:
        typer.echo(json_line(outcome.document))
    if "error" in outcome.document:
        complain(outcome.document["error"]["text"])
    return Row(outcome.document, folder=folder)


def _print_table(rows: Sequence[Row]) -> None:
    """The table on stdout; maps that could not be used were told on stderr already."""
    from rich.console import Console

    from fidmap.report.terminal import print_scores

    usable = [row for row in ranked(rows) if row.error is None]
    if usable:
        print_scores(Console(), usable)


def ranked(rows: Sequence[Row], tie_within: float = 0.5) -> list[Row]:
    """Rows with their ranks by overall score, best first; those without a score last, in the order given."""
    from dataclasses import replace

    from fidmap.ranking import ranks

    overall = [None if row.error is not None else row.score("overall") for row in rows]
    places = ranks([None if value is None else 100 * value for value in overall], tie_within)
    if len(rows) == 1:
        return list(rows)
    named = [replace(row, rank=None if place is None else str(place)) for row, place in zip(rows, places, strict=True)]
    order = sorted(range(len(rows)), key=lambda k: -1.0 if (value := overall[k]) is None else value, reverse=True)
    return [named[k] for k in order]


def _write_index(out: Path, rows: Sequence[Row]) -> None:
    """index.html, and where it is."""
    from fidmap.report.files import write_index
    from fidmap.report.page import index_page

    complain(f"reports are in {write_index(out, index_page(ranked(rows)))}")


def _exit_code(rows: Sequence[Row], limits: dict[str, float]) -> int:
    """1 when a map could not be used, else 3 when a gate failed, else 0."""
    code = DONE
    for row in rows:
        if row.error is not None:
            return UNUSABLE
        for sentence in failures(row.document, limits):
            complain(f"gate failed: {sentence}")
            code = GATE_FAILED
    return code
