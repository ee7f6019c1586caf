"""`fidmap score`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
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
    fast: Annotated[
        bool, typer.Option("--fast", help="For sweeps: do not prove that no other registration is better.")
    ] = False,
    mirror: Annotated[
        bool, typer.Option("--mirror", help="The map may be mirrored: `mirror: true` of a profile.")
    ] = False,
    resolution: options.Resolution = None,
    origin: options.Origin = None,
    free_thresh: options.FreeThresh = None,
    occupied_thresh: options.OccupiedThresh = None,
    topic: options.Topic = None,
    time: options.Time = None,
    flavour: options.Flavour = None,
    origin_at: options.OriginAt = None,
    slab: options.Slab = None,
    up: options.Up = None,
    layer: options.Layer = None,
    unit: options.Unit = None,
) -> None:
    """Score maps against an arena: coverage, accuracy, consistency, and a weighted overall score."""
    gates, paths = split_gates(fail_under or [], maps or [])
    if not paths and points is None:
        raise usage("no map: give at least one MAP, or --points FILE")
    if points is not None and len(paths) > 1:
        raise usage("--points goes with at most one MAP")
    start, pose = options.parse_start_pose(start_pose), options.parse_origin(origin)

    from fidmap.maps.overrides import Overrides
    from fidmap.report.files import check_output
    from fidmap.report.read import reports_in
    from fidmap.study.jobs import ScoreJob

    truth, settings = _read_arena(arena, profile, points)
    settings = replace(settings, mirror=settings.mirror or mirror)
    limits = parse_gates(gates, truth)
    output = None
    if out is not None:
        check_output(out)
        output = Output(out, reports_in(out))
    heights = options.parse_slab(slab)
    overrides = Overrides(
        resolution, pose, free_thresh, occupied_thresh,
        topic=topic, time_s=time, flavour=flavour, origin_at=origin_at, slab_m=heights, up=up,
        layers=tuple(layer) if layer else None, unit_m=unit,
    )  # fmt: skip
    kept: Sequence[str | None] = distinct(paths, resolution is not None) or [None]
    drawn = out is not None
    jobs = [ScoreJob(path, truth, settings, overrides, points, start, drawn, fast) for path in kept]
    rows = _run(jobs, output, json, workers)
    if not json:
        _print_table(rows)
    if output is not None and any(row.folder for row in rows):
        _write_index(output, rows)
    raise typer.Exit(_exit_code(rows, limits, output))


def _read_arena(arena: str, profile: str, points: str | None) -> tuple[Arena, Settings]:
    """The profile first: its limit decides which groups are long."""
    from fidmap.arena import read_arena
    from fidmap.model import ArenaFileError
    from fidmap.profiles import read_profile

    settings = read_profile(profile)
    truth = read_arena(arena, settings.long_if_walking_pallets_over)
    if points is None and not truth.has_positions:
        from fidmap.register.pairs import nothing_to_go_by, pairable

        if not pairable(truth):
            raise ArenaFileError(f"{arena}: {nothing_to_go_by()}")
    return truth, settings


@dataclass(frozen=True)
class Output:
    """Where reports go, and those that were there before."""

    directory: Path
    earlier: Sequence[Row]

    def write(self, job: ScoreJob, name: str, outcome: Outcome) -> str | None:
        """The name of the folder that holds the report; None where there is none, which is told.

        A map keeps the folder that it has: scored alone it would be `map`, among others it is `teamA_map`.
        """
        from fidmap.model import OutputError
        from fidmap.report.files import write_report
        from fidmap.report.read import identity

        if outcome.content is None:
            return None
        same = (row.folder for row in self.earlier if identity(row.document) == identity(outcome.document))
        points = None if job.points is None else Path(job.points)
        try:
            written = write_report(self.directory, next(same, None) or name, outcome.content, points)
        except OutputError as error:
            complain(str(error))
            return None
        for note in written.notes:
            complain(f"{note.level}: {note.text}")
        return written.folder.name


def _run(jobs: Sequence[ScoreJob], out: Output | None, json: bool, workers: int) -> list[Row]:
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


def _finish(job: ScoreJob, name: str, outcome: Outcome, out: Output | None, json: bool) -> Row:
    """Write the folder of one outcome and print its line; tell faults."""
    from fidmap.report.json_line import json_line
    from fidmap.report.rows import Row

    folder = None if out is None else out.write(job, name, outcome)
    if json:
        typer.echo(json_line(outcome.document))
    if "error" in outcome.document:
        complain(outcome.document["error"]["text"])
    return Row(outcome.document, folder=folder)


def _print_table(rows: Sequence[Row]) -> None:
    """The table on stdout; maps that could not be used were told on stderr already."""
    from rich.console import Console

    from fidmap.report.rows import ranked, scored
    from fidmap.report.terminal import print_scores

    if scored(rows):
        print_scores(Console(), scored(ranked(rows)))


def _write_index(out: Output, rows: Sequence[Row]) -> None:
    """index.html of these maps and of earlier ones that were scored alike, and where it is."""
    from fidmap.report.files import write_index
    from fidmap.report.page import index_page
    from fidmap.report.read import comparable
    from fidmap.report.rows import ranked

    page = index_page(ranked([*rows, *comparable(out.earlier, rows)]))
    complain(f"reports are in {write_index(out.directory, page)}")


def _exit_code(rows: Sequence[Row], limits: dict[str, float], out: Output | None) -> int:
    """1 when a map could not be used or its report not be written, else 3 when a gate failed, else 0."""
    from fidmap.report.rows import scored

    sentences = [sentence for row in scored(rows) for sentence in failures(row.document, limits)]
    for sentence in sentences:
        complain(f"gate failed: {sentence}")
    if len(scored(rows)) < len(rows) or (out is not None and not all(row.folder for row in rows)):
        return UNUSABLE
    return GATE_FAILED if sentences else DONE
