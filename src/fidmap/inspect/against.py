"""What a map shows beside a radius or an arena: arcs of another radius, another scale, a mirrored map."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from fidmap.detect import find_barrel_parts
from fidmap.grid import trinarize
from fidmap.inspect.placement import Fit, best_fit, fit_of
from fidmap.inspect.radius import SeenArcs, seen_arcs
from fidmap.model import Arena, Assignment, BarrelPart, Finding, Grid, Settings
from fidmap.register import register

# an arena's parts of which so few are seen, and fit no better than by chance, make other radii worth a search
FEW = 0.6


def radius_findings(grid: Grid, radius_m: float) -> tuple[Finding, ...]:
    """`radius-off` where the map's arcs have another radius: fitted, not assumed.

    Raises:
        SettingsError: the radius is smaller than two cells.
    """
    trinary = trinarize(grid)
    arcs = seen_arcs(trinary, radius_m, find_barrel_parts(trinary, radius_m))
    if arcs.ratio is None:
        return ()
    if arcs.is_off(radius_m / grid.resolution_m):
        return (_either(arcs, arcs.ratio, radius_m, grid.resolution_m),)
    return (_perhaps(arcs.ratio, radius_m),) if arcs.may_be_off(radius_m / grid.resolution_m) else ()


def arena_findings(
    parts: Sequence[BarrelPart], assignment: Assignment, arena: Arena, settings: Settings, grid: Grid | None
) -> tuple[Finding, ...]:
    """`scale-off`, `mirrored`, `another-arena` and `radius-off`: what these settings do not allow for.

    A sound map costs no more than a circle through each arc; other radii and registrations are tried where few of the
    arena's parts were seen or fit.

    Args:
        parts: what was found in the map with the arena's radius, or located by hand.
        assignment: of these parts.
        arena: with the radius that was looked for.
        settings: those of the assignment.
        grid: the map; None leaves the radius alone, as with parts located by hand.
    """
    plain = fit_of(parts, arena, assignment, settings) if arena.has_positions else Fit()
    arcs = None
    if grid is not None:
        arcs = seen_arcs(trinarize(grid), arena.radius_m, parts, 0 if plain.sound else FEW * len(arena.parts))
    fit = plain
    if arena.has_positions:
        if arcs is not None and arcs.factor != 1:  # the map is seen with another radius only
            parts = arcs.parts
            plain = fit_of(parts, arena, register(arcs.parts, arena, settings, fast=True), settings)
        fit = best_fit(parts, arena, settings, plain)
    found = list(_placement(fit, plain, settings, grid))
    if arcs is not None and grid is not None and arcs.is_off(arena.radius_m / grid.resolution_m):
        found += _radius(arcs, arena, grid.resolution_m, fit)
    return tuple(found)


def _placement(fit: Fit, plain: Fit, settings: Settings, grid: Grid | None) -> Iterator[Finding]:
    """What is wrong with a map that fits better scaled or mirrored, or not at all."""
    if fit is plain or fit.move is None:
        if plain.strange:
            yield _strange(plain)
        return
    scale = fit.move.scale
    mirrored = fit.move.mirrored and not settings.mirror
    scaled = fit.is_scaled(scale) and settings.transform == "rigid"
    if mirrored and scaled:
        yield Finding(
            "warning", "another-arena",
            f"the map fits the arena best mirrored and scaled by {scale:.3f} at once ({fit.count} parts), which no "
            "single mistake does: it looks like a map of another arena, and its score says nothing",
            "--arena FILE",
        )  # fmt: skip
    elif mirrored:
        yield Finding(
            "warning", "mirrored",
            f"{fit.count} parts fit the arena only when the map is mirrored, so what was scored is mostly chance: "
            "image rows or the world file are upside down",
            "--mirror",
        )  # fmt: skip
    elif scaled:
        percent = 100 * abs(1 / scale - 1)
        size = "large" if scale < 1 else "small"
        yield Finding(
            "warning", "scale-off",
            f"{fit.count} parts fit the arena best when the map is scaled by {scale:.3f}: it is drawn {percent:.1f} % "
            f"too {size}, so its resolution looks wrong, which shifts all distances and lowers the score",
            None if grid is None else f"--resolution {grid.resolution_m * scale:.4g}",
        )  # fmt: skip


def _strange(plain: Fit) -> Finding:
    return Finding(
        "warning", "another-arena",
        f"of {plain.possible} sure arcs only {plain.count} have a place in the arena, most of them badly, and neither "
        "another scale nor mirroring helps: a map of another arena, or a badly broken one, whose score is chance",
        "--arena FILE",
    )  # fmt: skip


def _radius(arcs: SeenArcs, arena: Arena, resolution_m: float, fit: Fit) -> Iterator[Finding]:
    """`radius-off`: the placement says whether the arena's radius or the map's resolution is wrong, if it is known."""
    assert arcs.ratio is not None
    if fit.move is None or not fit.believed:
        yield _either(arcs, arcs.ratio, arena.radius_m, resolution_m)
        return
    right = replace(arcs, ratio=arcs.ratio * fit.move.scale)
    if right.is_off(arena.radius_m / resolution_m) and right.ratio is not None:
        fitted = right.ratio * arena.radius_m
        text = (
            f"the arcs in the map have a radius of about {fitted:.3f} m, not {arena.radius_m:g}, while distances fit: "
            "the arena's radius looks wrong, which loses parts and sets the error that counts as lost"
        )
        yield Finding("warning", "radius-off", text, f"radius_m: {fitted:.2g} in the arena file")


def _perhaps(ratio: float, radius_m: float) -> Finding:
    """What is asked for by itself is answered with less certainty than what a score is doubted for."""
    text = (
        f"the arcs in the map are drawn with a radius of about {ratio * radius_m:.3f} m, not {radius_m:g}: mappers "
        "seldom draw arcs a tenth too large or too small, so the radius or the resolution may be another one"
    )
    return Finding("note", "radius-off", text, f"--radius {ratio * radius_m:.3g}")


def _either(arcs: SeenArcs, ratio: float, radius_m: float, resolution_m: float) -> Finding:
    fitted = ratio * radius_m
    text = (
        f"the {len(arcs.parts)} arcs in the map have a radius of about {fitted:.3f} m, not {radius_m:g}, so parts are "
        f"lost: either the radius is another one, or the resolution is wrong by a factor of {ratio:.2f}"
    )
    return Finding("warning", "radius-off", text, f"--resolution {resolution_m / ratio:.4g}")
