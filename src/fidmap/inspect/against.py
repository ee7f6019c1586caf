"""What a map shows beside a radius or an arena: arcs of another radius, another scale, a mirrored map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fidmap.detect import find_barrel_parts
from fidmap.evaluate import evaluate_points
from fidmap.geometry import circle_through
from fidmap.grid import metres_to_cells, trinarize
from fidmap.model import Arena, BarrelPart, Finding, FloatArray, Grid, Label, Settings, TrinaryGrid

FACTORS = (1.0, 0.8, 1.25, 0.64, 1.56)
LEAST_ARCS, LEAST_CONFIDENCE, OFF = 3, 0.5, 0.1
LEAST_PARTS, SCALE_OFF, LEAST_GAIN = 5, 0.02, 0.05
SCALES = (0.8, 1.25)


def radius_findings(grid: Grid, radius_m: float) -> tuple[Finding, ...]:
    """`radius-off` where the map's arcs have another radius by a tenth and more: fitted, not assumed.

    Raises:
        SettingsError: the radius is smaller than two cells.
    """
    trinary = trinarize(grid)
    tried = {factor: _sure(trinary, factor * radius_m, factor == 1) for factor in FACTORS}
    worth = {factor: sum(part.confidence for part in parts) for factor, parts in tried.items()}
    best = max(FACTORS, key=lambda factor: worth[factor] * (1.25 if factor == 1 else 1))
    radii = [r for part in tried[best] if (r := _fitted(trinary, part, best * radius_m)) is not None]
    if len(radii) < LEAST_ARCS or abs(np.median(radii) / radius_m - 1) < OFF:
        return ()
    fitted = float(np.median(radii))
    text = (
        f"the {len(radii)} arcs in the map have a radius of about {fitted:.3f} m, not {radius_m:g}: "
        f"either the radius is another one, or the resolution is wrong by a factor of {fitted / radius_m:.2f}"
    )
    return (Finding("warning", "radius-off", text, f"--resolution {grid.resolution_m * radius_m / fitted:.4g}"),)


def _sure(trinary: TrinaryGrid, radius_m: float, must: bool) -> list[BarrelPart]:
    if not must and radius_m < 2 * trinary.resolution_m:
        return []
    return [part for part in find_barrel_parts(trinary, radius_m) if part.confidence >= LEAST_CONFIDENCE]


def _fitted(trinary: TrinaryGrid, part: BarrelPart, radius_m: float) -> float | None:
    """Radius of a circle through the walls near an arc, centre and radius free, twice trimmed; metres."""
    radius = radius_m / trinary.resolution_m
    centre = metres_to_cells(np.array([[part.x_m, part.y_m]]), trinary.resolution_m, trinary.origin)[0]
    cells = _walls_near(trinary, centre, 1.4 * radius) - centre
    if part.facing is not None:
        facing = part.facing - trinary.origin.yaw
        ahead = cells @ np.array([np.sin(facing), np.cos(facing)])
        cells = cells[ahead > 0.2 * radius]
    middle, fitted = np.zeros(2), radius
    for tolerance in (0.3, 0.15, 0.1):
        near = cells[np.abs(np.hypot(*(cells - middle).T) - fitted) < max(1.5, tolerance * radius)]
        if len(near) < 6:
            return None
        middle, fitted = circle_through(near)
    return fitted * trinary.resolution_m if 0.5 < fitted / radius < 2 else None


def _walls_near(trinary: TrinaryGrid, centre: FloatArray, reach: float) -> FloatArray:
    """Centres (N, 2) of occupied cells within a square around a place, in cells."""
    low = np.maximum(0, np.floor(centre - reach)).astype(int)
    high = np.ceil(centre + reach).astype(int) + 1
    cut = trinary.labels[low[0] : high[0], low[1] : high[1]]
    return np.asarray(np.argwhere(cut == Label.OCCUPIED) + low + 0.5, np.float64)


def arena_findings(grid: Grid, arena: Arena, settings: Settings) -> tuple[Finding, ...]:
    """`scale-off` and `mirrored`, from a registration that may scale and mirror; nothing with few parts.

    Raises:
        ArenaFileError: the arena has no positions.
        SettingsError: the radius is smaller than two cells.
    """
    parts = find_barrel_parts(trinarize(grid), arena.radius_m)
    sure = [part for part in parts if part.confidence >= settings.min_confidence]
    # values that the quick search reached are enough for what has to be clearly better
    plain = evaluate_points(sure, arena, settings, fast=True).assignment
    free = replace(settings, transform="similarity", mirror=True, scale_range=SCALES)
    assignment = evaluate_points(sure, arena, free, fast=True).assignment
    count = sum(barrel is not None for barrel in assignment.barrel_of)
    better = assignment.value - plain.value > LEAST_GAIN * count
    if assignment.transform is None or count < LEAST_PARTS or not better:
        return ()
    return tuple(_transform_findings(assignment.transform.scale, assignment.transform.mirrored, count, grid))


def _transform_findings(scale: float, mirrored: bool, parts: int, grid: Grid) -> Sequence[Finding]:
    found = []
    if mirrored:
        text = (
            f"{parts} parts fit the arena only when the map is mirrored: image rows or the world file are upside down"
        )
        found.append(Finding("warning", "mirrored", text, "--profile FILE with mirror: true"))
    if abs(scale - 1) > SCALE_OFF:
        text = (
            f"{parts} parts fit the arena best when the map is scaled by {scale:.3f}: the resolution looks wrong, "
            "which shifts all distances"
        )
        found.append(Finding("warning", "scale-off", text, f"--resolution {grid.resolution_m * scale:.4g}"))
    return found
