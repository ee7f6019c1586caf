"""`fidmap convert`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fidmap.cli import options
from fidmap.cli.exits import complain


def convert(
    source: Annotated[str, typer.Argument(metavar="IN", help="A map, in any readable format.")],
    target: Annotated[
        Path, typer.Argument(metavar="OUT", help="NAME.yaml for map_server, NAME.tif for RoboCup GeoTIFF.")
    ],
    *,
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
    """Write a map as map_server YAML with PGM, or as RoboCup GeoTIFF; reading it back gives the same grid."""
    pose, heights = options.parse_origin(origin), options.parse_slab(slab)

    from fidmap.maps import convert as writing
    from fidmap.maps import read_map

    writing.files_of(target)
    grid = read_map(
        source, resolution_m=resolution, origin=pose, free_thresh=free_thresh, occupied_thresh=occupied_thresh,
        topic=topic, time_s=time, flavour=flavour, origin_at=origin_at,
        slab_m=heights, up=up, layers=tuple(layer) if layer else None, unit_m=unit,
    )  # fmt: skip
    for finding in grid.source.findings:
        complain(f"{finding.level}: {source}: {finding.text}")
    typer.echo("\n".join(map(str, writing.write(target, grid))))
