"""`fidmap inspect`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fidmap.cli import options
from fidmap.cli.exits import DONE, UNUSABLE, complain, usage
from fidmap.cli.inputs import distinct, progress_bar

if TYPE_CHECKING:
    from fidmap.inspect import Inspection
    from fidmap.study.inspection import InspectJob


def inspect(
    maps: options.MapPaths = None,
    *,
    radius: Annotated[float | None, typer.Option("--radius", metavar="M", help="Radius of the barrels.")] = None,
    arena: Annotated[str | None, typer.Option("--arena", metavar="FILE", help="The arena file.")] = None,
    json: options.Json = False,
    fix: Annotated[bool, typer.Option("--fix", help="Write a mended copy NAME-fixed.yaml beside the map.")] = False,
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Write a picture per map here.")] = None,
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
    """What a map is, and what is odd about it: what that does to the score, and which option mends it."""
    if not maps:
        raise usage("no map: give at least one MAP")
    if radius is not None and not (math.isfinite(radius) and radius > 0):
        raise usage(f"--radius {radius}: expected a positive number of metres")
    pose, heights = options.parse_origin(origin), options.parse_slab(slab)

    from fidmap.arena import read_arena
    from fidmap.maps.overrides import Overrides
    from fidmap.report.files import check_output
    from fidmap.report.names import report_names
    from fidmap.study.inspection import InspectJob

    truth = None if arena is None else read_arena(arena)
    if out is not None:
        check_output(out)
    overrides = Overrides(
        resolution, pose, free_thresh, occupied_thresh,
        topic=topic, time_s=time, flavour=flavour, origin_at=origin_at,
        slab_m=heights, up=up, layers=tuple(layer) if layer else None, unit_m=unit,
    )  # fmt: skip
    kept = distinct(maps, resolution is not None)
    codes = set()
    with progress_bar(len(kept), stdout_is_used=True) as progress:
        for path, name in progress.track(list(zip(kept, report_names(kept), strict=True)), description="inspecting"):
            codes.add(_one(InspectJob(path, overrides, radius, truth), name, out, json, fix))
    raise typer.Exit(max(codes))


def _one(job: InspectJob, name: str, out: Path | None, json: bool, fix: bool) -> int:
    """Inspect, print, mend and draw one map; its exit code."""
    from rich.console import Console

    from fidmap.model import OutputError
    from fidmap.report.inspection import finding_line, print_inspection
    from fidmap.report.json_line import json_line
    from fidmap.study.inspection import examine

    document, seen = examine(job)
    if json:
        typer.echo(json_line(document))
    if seen is None:
        complain(document["error"]["text"])
        for finding in document.get("findings", ()):
            complain(finding_line(finding))
        return UNUSABLE
    if not json:
        print_inspection(Console(), document, seen.grid)
    try:
        _write(job, name, seen, out, fix)
    except OutputError as error:
        complain(str(error))
        return UNUSABLE
    return DONE


def _write(job: InspectJob, name: str, seen: Inspection, out: Path | None, fix: bool) -> None:
    """The picture and the mended copy, where they are asked for."""
    from fidmap.grid import trinarize
    from fidmap.report.files import write_files
    from fidmap.report.inspection import thumbnail_png
    from fidmap.study.inspection import mend

    if out is not None:
        folder = write_files(out, name, {"thumbnail.png": thumbnail_png(trinarize(seen.grid).labels)})
        complain(f"a picture is in {folder}")
    if fix:
        path, done = mend(job, seen)
        said = f"wrote {path} without {', '.join(done)}" if path else "nothing that a program could mend"
        complain(f"{job.map}: {said}")
