"""One map from file to report document, and from detections to theirs; what a worker process does."""

from __future__ import annotations

import hashlib
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fidmap.detect import find_barrel_parts
from fidmap.evaluate import evaluate, evaluate_points
from fidmap.grid import trinarize
from fidmap.inspect import with_findings
from fidmap.inspect.against import arena_findings
from fidmap.maps import read_map
from fidmap.maps.overrides import Overrides
from fidmap.model import (
    Arena,
    BarrelPart,
    FidmapError,
    Finding,
    Grid,
    Report,
    Settings,
    SettingsError,
    Source,
    StartPose,
)
from fidmap.points import check_ids, points_csv, read_points
from fidmap.profiles import profile_document
from fidmap.report.files import ReportContent
from fidmap.report.json_line import Document, detect_document, error_document, report_document, wrapped_degrees
from fidmap.report.overlay import draw_overlay
from fidmap.report.page import report_page

NOTHING_OVERRIDDEN = Overrides()
TOO_LARGE = "needs more memory than there is; score it alone, with --workers 1, or with larger cells"


def overrides_document(overrides: Overrides) -> Document:
    """The overrides that were given, for the provenance of a report."""
    given: dict[str, Any] = {k: v for k, v in vars(overrides).items() if v is not None}
    if overrides.origin is not None:
        given["origin"] = {
            "x_m": overrides.origin.x_m,
            "y_m": overrides.origin.y_m,
            "yaw_deg": wrapped_degrees(overrides.origin.yaw),
        }
    return {"overrides": given} if given else {}


@dataclass(frozen=True)
class ScoreJob:
    """Score one map, or a points file without one (`map` is None); `draw`: page and picture too; `fast`: no proof."""

    map: str | None
    arena: Arena
    settings: Settings
    overrides: Overrides = NOTHING_OVERRIDDEN
    points: str | None = None
    start: StartPose | None = None
    draw: bool = False
    fast: bool = False

    @property
    def name(self) -> str:
        """What the result is called: the map, or the points file where there is none."""
        return self.map or self.points or ""


@dataclass(frozen=True)
class Outcome:
    """A report document or an error document, and the content of its folder where one was asked for."""

    document: Document
    content: ReportContent | None = None


def score(job: ScoreJob) -> Outcome:
    """Read and score one map; a fault of the file becomes an error document."""
    started = time.perf_counter()
    try:
        grid = None if job.map is None else with_findings(read_map(job.map, **vars(job.overrides)))
        report, inputs = _evaluate(job, grid)
        report = replace(report, findings=(*_beside_arena(job, report, grid), *report.findings))
        settings = profile_document(job.settings)
        seconds = time.perf_counter() - started
        document = report_document(report, settings, round(seconds, 4), inputs)
        return Outcome(document, _content(report, grid, document) if job.draw else None)
    except FidmapError as error:
        return Outcome(error_document(job.name, error.code, _naming(job.name, error)))
    except MemoryError:
        return Outcome(error_document(job.name, "out-of-memory", f"{job.name}: it {TOO_LARGE}"))


def _naming(name: str, error: FidmapError) -> str:
    """The text of an error; settings know no files, so what they did not fit is named here."""
    return f"{name}: {error}" if isinstance(error, SettingsError) else str(error)


def died(job: ScoreJob) -> Outcome:
    """The error document of a map whose process was killed."""
    return Outcome(error_document(job.name, "process-died", f"{job.name}: its process died; perhaps it {TOO_LARGE}"))


def _evaluate(job: ScoreJob, grid: Grid | None) -> tuple[Report, Document]:
    """The report, and what beside map and arena is needed to make it again."""
    inputs = {**overrides_document(job.overrides), **({"fast": True} if job.fast else {})}
    if job.points is None:
        assert grid is not None, "a job has a map or a points file"
        return evaluate(grid, job.arena, job.settings, job.start, fast=job.fast), inputs
    parts = read_points(job.points, job.arena, job.overrides.resolution_m)
    check_ids(parts, job.arena, job.points)
    digest = hashlib.sha256(Path(job.points).read_bytes()).hexdigest()
    source = Source(job.points, digest, "points")
    report = evaluate_points(parts, job.arena, job.settings, job.start, grid, source, fast=job.fast)
    return report, {**inputs, "points": job.points, "points_sha256": digest}


def _beside_arena(job: ScoreJob, report: Report, grid: Grid | None) -> tuple[Finding, ...]:
    """What is wrong with map or arena where they do not go together; parts located by hand have no radius."""
    looked_at = grid if job.points is None else None
    return arena_findings(report.detections, report.assignment, job.arena, job.settings, looked_at)


def _content(report: Report, grid: Grid | None, document: Document) -> ReportContent:
    """Everything that a report's folder holds."""
    overlay = draw_overlay(report, None if grid is None else trinarize(grid))
    drawing = overlay.svg()
    return ReportContent(
        document,
        report_page(document, drawing),
        drawing,
        overlay.png(),
        points_csv(report.detections, _names(report)),
    )


def _names(report: Report) -> list[str | None]:
    """Per detection the part that it was assigned to."""
    names: list[str | None] = [None] * len(report.detections)
    for part, j in zip(report.arena.parts, report.assignment.barrel_of, strict=True):
        if j is not None:
            names[j] = part.id
    return names


@dataclass(frozen=True)
class DetectJob:
    """Find the barrel parts of one map."""

    map: str
    radius_m: float
    overrides: Overrides
    min_confidence: float
    min_drawn: float


def detect(job: DetectJob) -> tuple[Document, Grid | None, tuple[BarrelPart, ...]]:
    """The detect document (or error document), the grid and the parts; seconds are of the finding alone."""
    try:
        grid = read_map(job.map, **vars(job.overrides))
        trinary = trinarize(grid)
        started = time.perf_counter()
        found = find_barrel_parts(trinary, job.radius_m)
        seconds = time.perf_counter() - started
    except FidmapError as error:
        return error_document(job.map, error.code, _naming(job.map, error)), None, ()
    parts = tuple(p for p in found if p.confidence >= job.min_confidence and p.drawn >= job.min_drawn - 1e-9)
    return detect_document(job.map, job.radius_m, parts, round(seconds, 6)), grid, parts
