"""`fidmap detect`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fidmap.cli import options
from fidmap.cli.exits import DONE, UNUSABLE, complain, usage
from fidmap.cli.inputs import distinct, progress_bar

if TYPE_CHECKING:
    from fidmap.study.jobs import DetectJob


def detect(
    maps: options.MapPaths = None,
    *,
    radius: Annotated[float, typer.Option("--radius", metavar="M", help="Radius of the barrels in metres.")],
    json: options.Json = False,
    min_confidence: Annotated[float, typer.Option("--min-confidence", min=0, max=1, help="Least confidence.")] = 0.5,
    min_drawn_deg: Annotated[
        float, typer.Option("--min-drawn-deg", min=0, max=360, help="Least visible angle in degrees.")
    ] = 120,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Write a points file and a picture per map here.")
    ] = None,
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
    """Find barrel parts in maps: arcs of a known radius, without any arena."""
    if not maps:
        raise usage("no map: give at least one MAP")
    if not (math.isfinite(radius) and radius > 0):
        raise usage(f"--radius {radius}: expected a positive number of metres")
    pose = options.parse_origin(origin)

    from fidmap.maps.overrides import Overrides
    from fidmap.report.files import check_output
    from fidmap.report.names import report_names
    from fidmap.study.jobs import DetectJob

    if out is not None:
        check_output(out)
    heights = options.parse_slab(slab)
    overrides = Overrides(
        resolution, pose, free_thresh, occupied_thresh,
        topic=topic, time_s=time, flavour=flavour, origin_at=origin_at, slab_m=heights, up=up,
        layers=tuple(layer) if layer else None, unit_m=unit,
    )  # fmt: skip
    kept = distinct(maps, resolution is not None)
    codes = set()
    with progress_bar(len(kept), stdout_is_used=True) as progress:
        for path, name in progress.track(list(zip(kept, report_names(kept), strict=True)), description="detecting"):
            job = DetectJob(path, radius, overrides, min_confidence, math.radians(min_drawn_deg))
            codes.add(_one(job, name, out, json))
    raise typer.Exit(max(codes))


def _one(job: DetectJob, name: str, out: Path | None, json: bool) -> int:
    """Find, write and print the parts of one map; its exit code."""
    from rich.console import Console

    from fidmap.model import OutputError
    from fidmap.report.detections import print_detections, write_detections
    from fidmap.report.json_line import json_line
    from fidmap.study.jobs import detect as find

    document, grid, parts = find(job)
    if json:
        typer.echo(json_line(document))
    if grid is None:
        complain(document["error"]["text"])
        return UNUSABLE
    for finding in grid.source.findings:
        complain(f"{finding.level}: {job.map}: {finding.text}")
    if not json:
        print_detections(Console(), job.map, parts)
    try:
        if out is not None:
            write_detections(out, name, grid, parts, job.radius_m)
    except OutputError as error:
        complain(str(error))
        return UNUSABLE
    return DONE
