"""Options that several commands share, and words of theirs that need parsing."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from fidmap.cli.exits import usage

if TYPE_CHECKING:
    from fidmap.model import Pose2, StartPose

FlavourWord = Literal["nav2", "nav2-old", "ros1"]
OriginWord = Literal["corner", "centre"]
MapPaths = Annotated[list[str] | None, typer.Argument(metavar="[MAP]...", help="Map files, in any readable format.")]
Resolution = Annotated[
    float | None, typer.Option("--resolution", metavar="M_PER_CELL", help="Side of a cell, for plain images.")
]
Origin = Annotated[
    str | None,
    typer.Option("--origin", metavar="X_M,Y_M,YAW_DEG", help="Pose of the lower-left corner of the map."),
]
FreeThresh = Annotated[float | None, typer.Option("--free-thresh", help="Occupancy up to which a cell is free.")]
OccupiedThresh = Annotated[
    float | None, typer.Option("--occupied-thresh", help="Occupancy from which a cell is occupied.")
]
Topic = Annotated[str | None, typer.Option("--topic", metavar="NAME", help="Which topic of a bag holds the map.")]
Time = Annotated[
    float | None,
    typer.Option("--time", metavar="SECONDS", help="The last map of a bag until then, counted from its beginning."),
]
Flavour = Annotated[FlavourWord | None, typer.Option("--flavour", help="Whose map_server reads the YAML.")]
OriginAt = Annotated[
    OriginWord | None, typer.Option("--origin-at", help="What of the lower-left cell the map's origin is.")
]
Slab = Annotated[
    str | None,
    typer.Option("--slab", metavar="LOW_M,HIGH_M", help="What of a 3D map is looked at: heights above the floor."),
]
Layer = Annotated[
    list[str] | None,
    typer.Option("--layer", metavar="NAME|#RRGGBB", help="A layer or colour of a drawing; may be repeated."),
]
Unit = Annotated[float | None, typer.Option("--unit", metavar="M_PER_UNIT", help="Metres per unit of a drawing.")]
Up = Annotated[str | None, typer.Option("--up", metavar="AXIS", help="The axis of a 3D map that is up: z, -y, ...")]
Json = Annotated[bool, typer.Option("--json", help="JSON Lines on stdout: one object per map, nothing else.")]
Workers = Annotated[int, typer.Option("--workers", min=0, help="Processes; 0 takes one per core.")]


def parse_origin(text: str | None) -> Pose2 | None:
    """`X_M,Y_M,YAW_DEG`, or None."""
    if text is None:
        return None
    from fidmap.model import Pose2

    x, y, yaw = _numbers(text, "--origin", (3,))
    return Pose2(x, y, math.radians(yaw))


def parse_slab(text: str | None) -> tuple[float, float] | None:
    """`LOW_M,HIGH_M`, or None."""
    if text is None:
        return None
    low, high = _numbers(text, "--slab", (2,))
    return low, high


def parse_start_pose(text: str | None) -> StartPose | None:
    """`X_M,Y_M,YAW_DEG[,SIGMA_M,SIGMA_DEG]`, or None."""
    if text is None:
        return None
    from fidmap.model import Pose2, StartPose

    x, y, yaw, *sigmas = _numbers(text, "--start-pose", (3, 5))
    pose = Pose2(x, y, math.radians(yaw))
    if not sigmas:
        return StartPose(pose)
    if min(sigmas) <= 0:
        raise usage(f"--start-pose {text}: the sigmas must be positive")
    return StartPose(pose, sigmas[0], math.radians(sigmas[1]))


def _numbers(text: str, option: str, counts: tuple[int, ...]) -> list[float]:
    words = text.split(",")
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
    if len(values) not in counts or not all(math.isfinite(value) for value in values):
        expected = " or ".join(map(str, counts))
        raise usage(f"{option} {text}: expected {expected} numbers separated by commas, without spaces")
    return values
