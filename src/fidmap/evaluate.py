"""The story: grid + arena + settings -> Report, in the paper's steps (SSRR 2011, II-A and II-B)."""

from __future__ import annotations

from collections.abc import Sequence

from fidmap.attributes import attributes
from fidmap.detect import find_barrel_parts, with_spreads
from fidmap.grid import trinarize
from fidmap.model import CONTINUOUS, Arena, BarrelPart, Grid, Report, Settings, Source, StartPose
from fidmap.register import register
from fidmap.uncertainty import with_intervals
from fidmap.uncertainty.scale import scale_finding
from fidmap.version import __version__

# arcs less sure than this would crowd the picture; a referee can still add them by hand
SHOWN_CONFIDENCE = 0.2
NO_MAP = Source()


def evaluate(
    grid: Grid, arena: Arena, settings: Settings = CONTINUOUS, start: StartPose | None = None, *, fast: bool = False
) -> Report:
    """Score a map: trinarize, find barrel parts, assign and register them, compute the attributes.

    `fast` leaves out the proof that no registration is better.

    Raises:
        ArenaFileError: the arena has no positions, so nothing can be assigned by itself.
        SettingsError: the arena's radius is smaller than two cells of this map.
    """
    parts = find_barrel_parts(trinarize(grid), arena.radius_m)
    shown = min(SHOWN_CONFIDENCE, settings.min_confidence)
    return _report([p for p in parts if p.confidence >= shown], arena, settings, start, grid.source, fast)


def evaluate_points(
    parts: Sequence[BarrelPart],
    arena: Arena,
    settings: Settings = CONTINUOUS,
    start: StartPose | None = None,
    grid: Grid | None = None,
    source: Source = NO_MAP,
    *,
    fast: bool = False,
) -> Report:
    """Score barrel parts that somebody located; `grid` is the map they stand in, `source` stands for it without one.

    Raises:
        ArenaFileError: the arena has no positions and no part was fixed by hand.
    """
    if grid is None:
        return _report(parts, arena, settings, start, source, fast)
    measured = with_spreads(trinarize(grid), parts, arena.radius_m)
    return _report(measured, arena, settings, start, grid.source, fast)


def _report(
    parts: Sequence[BarrelPart], arena: Arena, settings: Settings, start: StartPose | None, source: Source, fast: bool
) -> Report:
    """Register, score and collect."""
    parts = tuple(parts)
    assignment = register(parts, arena, settings, start, fast)
    scores = with_intervals(attributes(parts, arena, assignment, settings), arena, assignment, settings)
    findings = (*source.findings, *assignment.findings, *scale_finding(scores, arena, assignment, settings))
    return Report(source, arena, settings, parts, assignment, scores, findings, __version__, start)
