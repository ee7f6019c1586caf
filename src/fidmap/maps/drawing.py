"""Drawings of lines and areas as grids: walls are occupied, everything else is free.

A line makes every cell occupied that it runs through; it is cut into pieces of a tenth of a cell, so its places are
those of the drawing, not of the raster, and corners of cells that it misses are less than a twentieth deep. Arcs
come as polygons whose sagitta is at most a fortieth of a cell.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.maps.cursor import BrokenRecordError
from fidmap.maps.files import fault, printable
from fidmap.maps.oddities import label_oddities
from fidmap.maps.overrides import Overrides
from fidmap.maps.slab import MAX_SLAB_CELLS
from fidmap.model import Finding, FloatArray, Grid, Pose2, Source

RESOLUTION_M = 0.02
MARGIN_M = 0.5
MAX_BYTES = 64 << 20
MAX_SHAPES = 500_000
MAX_CORNERS = 5_000_000
MAX_STEPS = 60_000_000
PIECES = 10
BLOCK_STEPS = 1_000_000
SUBCELL_BITS = 4


@dataclass(frozen=True, eq=False)
class Shape:
    """points (N, 2): corners in drawing units, x right and y up. filled: an area. occupied: dark, else light.

    names: what it may be chosen by: layers, groups, classes, colours (#rrggbb), in lower case.
    """

    points: FloatArray
    filled: bool = False
    occupied: bool = True
    names: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Drawing:
    """Shapes in the order they are painted, metres per unit, and what was decided about the unit."""

    shapes: Sequence[Shape]
    unit_m: float
    findings: tuple[Finding, ...] = ()


def flatness(unit_m: float, overrides: Overrides) -> float:
    """Largest distance in drawing units between a curve and its polygon: a fortieth of a cell."""
    return (overrides.resolution_m or RESOLUTION_M) / 40 / unit_m


def drawing_grid(drawing: Drawing, path: Path, name: str, kind: str, overrides: Overrides) -> Grid:
    """Paint the chosen shapes.

    Raises:
        MapFileError: no such layer, nothing to paint, or a map beyond the bound on cells.
        BrokenRecordError: more lines than a map can have.
    """
    shapes = _chosen(drawing.shapes, overrides.layers, name)
    step = overrides.resolution_m or RESOLUTION_M
    corners = np.concatenate([shape.points for shape in shapes]) * drawing.unit_m
    if not (np.isfinite(corners).all() and np.abs(corners).max() < 1e8):
        raise BrokenRecordError("its places are not finite")
    low = np.floor((corners.min(axis=0) - MARGIN_M) / step) * step
    columns, rows = (math.ceil(side) for side in (corners.max(axis=0) + MARGIN_M - low) / step)
    if columns * rows > MAX_SLAB_CELLS:
        raise fault(
            name,
            f"covers {columns:,} x {rows:,} cells of {step:g} m; at most {MAX_SLAB_CELLS // 1_000_000} million are "
            "read, so give its --unit M_PER_UNIT, choose a --layer, or give a larger --resolution",
        )
    if _length(corners, shapes) / step * PIECES > MAX_STEPS:
        raise BrokenRecordError("its lines are longer than those of any map")
    occupancy = np.zeros((rows, columns), np.float32)
    _paint(occupancy, shapes, (corners - low) / step)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    walls = int((occupancy == 1).sum())
    findings = (*drawing.findings, *label_oddities(occupancy.size - walls, 0, walls))
    origin = Pose2(*map(float, low)) if overrides.origin is None else overrides.corner(overrides.origin, step)
    return Grid(occupancy, step, origin, source=Source(name, digest, kind, findings))


def _chosen(shapes: Sequence[Shape], layers: tuple[str, ...] | None, name: str) -> list[Shape]:
    """The shapes of the wanted layers, all of them by default."""
    if len(shapes) > MAX_SHAPES or sum(len(shape.points) for shape in shapes) > MAX_CORNERS:
        raise BrokenRecordError(f"it has more than {MAX_SHAPES:,} shapes or {MAX_CORNERS:,} corners")
    wanted = {layer.lower() for layer in layers or ()}
    known = sorted({word for shape in shapes for word in shape.names})
    if missing := sorted(wanted - set(known)):
        listed = ", ".join(map(printable, known[:20])) or "none"
        raise fault(name, f"has no layer or colour {', '.join(missing)}; choose with --layer among: {listed}")
    chosen = [shape for shape in shapes if len(shape.points) and (not wanted or wanted & shape.names)]
    if not chosen:
        raise fault(name, "holds no lines or areas; expected the walls of a map, so export them")
    return chosen


def _length(corners: FloatArray, shapes: Sequence[Shape]) -> float:
    """How long all outlines are together."""
    sides = np.diff(corners, axis=0)
    sides[np.cumsum([len(shape.points) for shape in shapes])[:-1] - 1] = 0
    return float(np.hypot(*sides.T).sum())


def _paint(occupancy: npt.NDArray[np.float32], shapes: Sequence[Shape], cells: FloatArray) -> None:
    """Shapes into the grid, in their order; cells (N, 2) are their corners as (column, row).

    Dark outlines wait for a light shape, or for the last one: together they are drawn much quicker.
    """
    waiting: list[FloatArray] = []
    end = 0
    for shape in shapes:
        begin, end = end, end + len(shape.points)
        outline = cells[begin:end]
        if not shape.occupied:
            _trace(occupancy, waiting)
            waiting = []
        if shape.filled and len(outline) > 2:
            # OpenCV counts from the centre of the first cell, in sixteenths
            fixed = np.rint((outline - 0.5) * 2**SUBCELL_BITS).astype(np.int32)
            cv2.fillPoly(occupancy, [fixed], 1.0 if shape.occupied else 0.0, shift=SUBCELL_BITS)
            outline = np.vstack([outline, outline[:1]])
        if shape.occupied:
            waiting.append(outline)
    _trace(occupancy, waiting)


def _trace(occupancy: npt.NDArray[np.float32], outlines: Sequence[FloatArray]) -> None:
    """Every cell that the outlines, each (N, 2), run through, in pieces of at most a tenth of a cell."""
    if not outlines:
        return
    ends = np.cumsum([len(outline) for outline in outlines])
    corners = np.concatenate(outlines)
    column, row = corners[ends - 1].astype(int).T
    occupancy[row, column] = 1
    sides = np.delete(np.diff(corners, axis=0), ends[:-1] - 1, axis=0)
    begins = np.delete(corners, ends - 1, axis=0)
    counts = np.ceil(np.hypot(*sides.T) * PIECES).astype(int) + 1
    until = np.cumsum(counts)
    for done in range(0, int(counts.sum()), BLOCK_STEPS):
        step = np.arange(done, min(done + BLOCK_STEPS, int(until[-1])))
        side = np.searchsorted(until, step, side="right")
        share = (step - until[side] + counts[side]) / counts[side]
        column, row = (begins[side] + share[:, None] * sides[side]).astype(int).T
        occupancy[row, column] = 1
