"""`fidmap detect`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from fidmap.cli import options
from fidmap.cli.exits import UNUSABLE, complain, usage


def detect(
    maps: options.MapPaths = None,
    radius: Annotated[float, typer.Option("--radius", metavar="M", help="Radius of the barrels in metres.")] = ...,  # type: ignore[assignment]
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
) -> None:
    """Find barrel parts in maps: arcs of a known radius, without any arena."""
    if not maps:
        raise usage("no map: give at least one MAP")
    if not (math.isfinite(radius) and radius > 0):
        raise usage(f"--radius {radius}: expected a positive number of metres")

    from rich.console import Console

    from fidmap.report.detections import print_detections, write_detections
    from fidmap.report.json_line import json_line
    from fidmap.report.names import report_names
    from fidmap.study.jobs import DetectJob, Overrides
    from fidmap.study.jobs import detect as find

    overrides = Overrides(resolution, options.parse_origin(origin), free_thresh, occupied_thresh)
    code = 0
    for path, name in zip(maps, report_names(maps), strict=True):
        document, grid, parts = find(DetectJob(path, radius, overrides, min_confidence, math.radians(min_drawn_deg)))
        if grid is None:
            complain(document["error"]["text"])
            code = UNUSABLE
        else:
            for finding in grid.source.findings:
                complain(f"{finding.level}: {path}: {finding.text}")
            if out is not None:
                write_detections(out, name, grid, parts, radius)
        if json:
            typer.echo(json_line(document))
        elif grid is not None:
            print_detections(Console(), path, parts)
    raise typer.Exit(code)
