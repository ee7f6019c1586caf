"""The story: grid + arena + settings -> Report, in the paper's steps (SSRR 2011, II-A and II-B)."""

from __future__ import annotations

from collections.abc import Sequence

from fidmap.attributes import attributes
from fidmap.detect import find_barrel_parts
from fidmap.grid import trinarize
from fidmap.model import CONTINUOUS, Arena, BarrelPart, Grid, Report, Settings, Source, StartPose
from fidmap.register import register
from fidmap.version import __version__


def evaluate(
    grid: Grid, arena: Arena, settings: Settings = CONTINUOUS, start: StartPose | None = None
) -> Report:
    """Score a map: trinarize, find barrel parts, assign and register them, compute the attributes.

    Raises:
        ArenaFileError: the arena has no positions, so nothing can be assigned by itself.
    """
    parts = find_barrel_parts(trinarize(grid), arena.radius_m)
    return evaluate_points(parts, arena, settings, start, grid.source)


def evaluate_points(
    parts: Sequence[BarrelPart],
    arena: Arena,
    settings: Settings = CONTINUOUS,
    start: StartPose | None = None,
    source: Source = Source(),
) -> Report:
    """Score barrel parts that were found, or located by hand, already; `source` is the map they stand in.

    Raises:
        ArenaFileError: the arena has no positions and no part was fixed by hand.
    """
    parts = tuple(parts)
    assignment = register(parts, arena, settings, start)
    scores = attributes(parts, arena, assignment, settings)
    findings = (*source.findings, *assignment.findings)
    return Report(source, arena, settings, parts, assignment, scores, findings, __version__, start)
