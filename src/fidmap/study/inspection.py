"""One map from file to inspection document, and its mended copy."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from fidmap.detect import find_barrel_parts
from fidmap.grid import trinarize
from fidmap.inspect import Inspection, findings_of, inspect
from fidmap.inspect.against import arena_findings, radius_findings
from fidmap.inspect.mend import mended
from fidmap.maps import convert, main_file, read_map
from fidmap.maps.overrides import Overrides
from fidmap.model import CONTINUOUS, Arena, FidmapError, Finding, Grid, SettingsError
from fidmap.register import register
from fidmap.report.inspection import inspect_document
from fidmap.report.json_line import Document, error_document


@dataclass(frozen=True)
class InspectJob:
    """Inspect one map, perhaps beside a radius and an arena."""

    map: str
    overrides: Overrides
    radius_m: float | None = None
    arena: Arena | None = None


def examine(job: InspectJob) -> tuple[Document, Inspection | None]:
    """The inspect document with the inspection, or an error document."""
    try:
        grid = read_map(job.map, **vars(job.overrides))
        seen = inspect(grid, _beside(job, grid))
    except FidmapError as error:
        text = f"{job.map}: {error}" if isinstance(error, SettingsError) else str(error)
        return error_document(job.map, error.code, text, getattr(error, "findings", ())), None
    except MemoryError:
        return error_document(job.map, "out-of-memory", f"{job.map}: it needs more memory than there is"), None
    return inspect_document(job.map, grid, seen.share, seen.percent, seen.no_value, seen.findings), seen


def _beside(job: InspectJob, grid: Grid) -> tuple[Finding, ...]:
    if job.arena is None:
        return () if job.radius_m is None else radius_findings(grid, job.radius_m)
    arena = job.arena if job.radius_m is None else replace(job.arena, radius_m=job.radius_m)
    parts = find_barrel_parts(trinarize(grid), arena.radius_m)
    return arena_findings(parts, register(parts, arena, CONTINUOUS, fast=True), arena, CONTINUOUS, grid)


def mend(job: InspectJob, seen: Inspection) -> tuple[Path | None, tuple[str, ...]]:
    """Write a mended copy beside the map, `NAME-fixed.yaml`; nothing where nothing can be mended.

    Raises:
        OutputError: a copy is there already, or the place cannot be written.
    """
    grid, done = mended(seen.grid, seen.findings)
    if not done:
        return None, ()
    grid, more = mended(grid, findings_of(grid, trinarize(grid).labels))  # what the first ones hid
    main = main_file(job.map)
    return convert.write(main.with_name(f"{main.stem}-fixed.yaml"), grid)[0], (*done, *more)
