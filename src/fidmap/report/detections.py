"""What `fidmap detect` shows: a table, and a folder with picture and points file per map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from fidmap.grid import trinarize
from fidmap.model import CONTINUOUS, Arena, Assignment, Attributes, BarrelPart, Grid, Report, Value
from fidmap.points import points_csv
from fidmap.report.files import DRAWING, PICTURE, POINTS, write_files
from fidmap.report.overlay import draw_overlay
from fidmap.report.wording import clean, degrees, metres

NO_ARENA = "no arena was given"


def print_detections(console: Console, map_name: str, parts: Sequence[BarrelPart]) -> None:
    """One table per map, most confident first."""
    table = Table(title=Text(f"{clean(map_name)}: {len(parts)} barrel parts"), box=box.SIMPLE, title_justify="left")
    for column in ("n", "x", "y", "facing", "drawn", "sigma", "confidence"):
        table.add_column(column, justify="right")
    for part in parts:
        facing = "whole" if part.facing is None else degrees(math.degrees(part.facing))
        sigma = "" if part.sigma_m is None else metres(part.sigma_m)
        place = (metres(part.x_m), metres(part.y_m))
        table.add_row(str(part.n), *place, facing, degrees(math.degrees(part.drawn)), sigma, f"{part.confidence:.2f}")
    console.print(table)


def write_detections(directory: Path, name: str, grid: Grid, parts: Sequence[BarrelPart], radius_m: float) -> Path:
    """Write overlay.svg, overlay.png and points.csv to `directory/name` and return that folder.

    Raises:
        OutputError: nothing can be written there.
    """
    arena = Arena("none", radius_m, ())
    nothing = Attributes({}, {}, Value(None, NO_ARENA), (), (), ())
    report = Report(grid.source, arena, CONTINUOUS, tuple(parts), Assignment((), (), None, 0.0), nothing, (), "")
    overlay = draw_overlay(report, trinarize(grid))
    files = {
        DRAWING: overlay.svg().encode(),
        PICTURE: overlay.png(),
        POINTS: points_csv(parts, [None] * len(parts)).encode(),
    }
    return write_files(directory, name, files)
