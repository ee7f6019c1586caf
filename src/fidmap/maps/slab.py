"""The slab of a 3D map at the height of barrels, as a grid; and what is told about it."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fidmap.maps.floor import Floor
from fidmap.maps.oddities import label_oddities
from fidmap.maps.overrides import Overrides
from fidmap.model import Finding, Grid, Pose2, Source

MAX_SLAB_CELLS = 64_000_000
DEFAULT_SLAB_M = (0.2, 0.9)


def slab_of(overrides: Overrides) -> tuple[float, float]:
    """Lowest and highest height above the floor, in metres."""
    return overrides.slab_m or DEFAULT_SLAB_M


def slab_grid(
    occupancy: npt.NDArray[np.float32],
    resolution_m: float,
    low: tuple[float, float],
    floor: Floor,
    source: tuple[Path, str, str],
    overrides: Overrides,
) -> Grid:
    """The grid of a slab.

    Args:
        occupancy: (H, W) of 1, 0 and NaN, row 0 lowest.
        resolution_m: side of a cell.
        low: x and y of the lower-left corner.
        floor: what heights were measured from.
        source: the file, its name as the user gave it, and its format.
        overrides: an origin given there replaces `low`.
    """
    path, name, kind = source
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    walls, free = int(np.count_nonzero(occupancy == 1)), int(np.count_nonzero(occupancy == 0))
    findings = (
        *_told(floor, resolution_m, overrides),
        *label_oddities(free, occupancy.size - walls - free, walls),
    )
    origin = Pose2(*low) if overrides.origin is None else overrides.corner(overrides.origin, resolution_m)
    return Grid(occupancy, resolution_m, origin, source=Source(name, digest, kind, findings))


def _told(floor: Floor, resolution_m: float, overrides: Overrides) -> tuple[Finding, ...]:
    """What was decided for the user, with the option that decides otherwise."""
    low, high = slab_of(overrides)
    up = ", ".join(f"{value:.3f}" for value in floor.up + 0.0)
    if not floor.found:
        text = (
            f"no flat floor was found: the map is what lies {low:g} to {high:g} m above the lowest points, with "
            f"({up}) as up; walls may be missing or the floor be taken for walls"
        )
        return (Finding("warning", "no-floor", text, "--slab LOW_M,HIGH_M --up AXIS"),)
    text = (
        f"the map is what lies {low:g} to {high:g} m above the floor, which is at {floor.height_m:.2f} m along "
        f"({up}), in cells of {resolution_m:g} m"
    )
    return (Finding("note", "slab", text, "--slab LOW_M,HIGH_M"),)
