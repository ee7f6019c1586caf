"""Finding `scale`: a similarity whose scale is not 1 for all that is known."""

from __future__ import annotations

from fidmap.model import Arena, Assignment, Attributes, Finding, Settings
from fidmap.uncertainty.population import scale_bounds

# a scale nearer to 1 bends no distance of an arena by a centimetre
LEAST = 1e-3


def scale_finding(
    attributes: Attributes, arena: Arena, assignment: Assignment, settings: Settings
) -> tuple[Finding, ...]:
    """The finding where the scale was searched and its interval excludes 1; else nothing."""
    move = assignment.transform
    if settings.transform != "similarity" or move is None:
        return ()
    bounds = scale_bounds(attributes, arena, assignment, settings)
    if bounds is None or bounds[0] <= 1 <= bounds[1] or abs(move.scale - 1) < LEAST:
        return ()
    size = "large" if move.scale < 1 else "small"
    percent = 100 * abs(1 / move.scale - 1)
    text = (
        f"the map is drawn {percent:.1f} % too {size}: the scale that fits it to the arena is {move.scale:.4f} "
        f"({bounds[0]:.4f} to {bounds[1]:.4f}), so check its resolution and the survey"
    )
    return (Finding("warning", "scale", text),)
