"""A report made by hand: a small map drawn with cv2, with parts in every state that a report knows."""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np

from fidmap.grid import metres_to_cells, trinarize
from fidmap.model import (
    Arena,
    Assignment,
    Attributes,
    BarrelPart,
    FiducialPart,
    Finding,
    Grid,
    Group,
    GroupResult,
    PairResult,
    PartResult,
    Pose2,
    Report,
    Settings,
    Source,
    Transform,
    TrinaryGrid,
    Value,
)

RADIUS_M = 0.3
RESOLUTION_M = 0.05
ORIGIN = Pose2(-1.0, -2.0, 0.0)
T_TRUTH_MAP = Transform(rotation=math.radians(10), tx_m=0.4, ty_m=-0.3)
PLACES = {  # id: (x_m, y_m, facing in degrees) in the map's frame, where the part should be
    "1A": (2.0, 1.0, 180),
    "1B": (2.1, 1.0, 0),
    "2A": (6.0, 3.0, 90),
    "2B": (6.0, 2.9, -90),
    "3A": (9.0, 1.0, 180),
    "3B": (9.1, 1.0, 0),
    "4A": (4.0, 5.0, 90),
    "4B": (4.0, 4.9, -90),
}
ERRORS = {"1A": (0.02, 0.01), "1B": (-0.03, 0.02), "2A": (0.5, 0.5), "2B": (0.0, 0.0), "3A": (0.04, -0.05)}
FIXED, MISSING = ("2B",), ("3B", "4A", "4B")


def facing_in_arena(degrees: float) -> float:
    return math.radians(degrees) + T_TRUTH_MAP.rotation


def to_arena(x: float, y: float) -> tuple[float, float]:
    c, s = math.cos(T_TRUTH_MAP.rotation), math.sin(T_TRUTH_MAP.rotation)
    return c * x - s * y + T_TRUTH_MAP.tx_m, s * x + c * y + T_TRUTH_MAP.ty_m


def sample_grid(
    size_m: tuple[float, float] = (14, 10), resolution_m: float = RESOLUTION_M, origin: Pose2 = ORIGIN
) -> TrinaryGrid:
    """Free space with an outer wall, one wall per fiducial, and the halves that the sample knows."""
    width, height = (round(side / resolution_m) for side in size_m)
    p = np.full((height, width), np.nan, np.float32)
    cell = 1 / resolution_m
    cv2.rectangle(p, (int(0.5 * cell), int(1.2 * cell)), (int(12.5 * cell), int(8.6 * cell)), 0.0, -1)
    cv2.rectangle(p, (int(0.5 * cell), int(1.2 * cell)), (int(12.5 * cell), int(8.6 * cell)), 1.0, 2)
    flat = replace(origin, yaw=0.0)
    for name, (x, y, facing) in PLACES.items():
        ex, ey = ERRORS.get(name, (0.0, 0.0))
        row, column = metres_to_cells(np.array([x + ex, y + ey]), resolution_m, flat)
        centre, axes = (round(column), round(row)), (round(RADIUS_M * cell),) * 2
        if name not in MISSING:
            cv2.ellipse(p, centre, axes, facing, -90, 90, 1.0, 1)
        along = round(0.8 * cell)
        across = (0, along) if facing in {0, 180} else (along, 0)
        ends = [(centre[0] + sign * across[0], centre[1] + sign * across[1]) for sign in (-1, 1)]
        cv2.line(p, ends[0], ends[1], 1.0, 1)
    cv2.circle(p, (int(11 * cell), int(7 * cell)), int(RADIUS_M * cell), 1.0, 1)
    source = Source("teamA/map.yaml", "ab" * 32, "map_server")
    return trinarize(Grid(p, resolution_m, origin, source=source))


def sample_arena() -> Arena:
    parts = tuple(
        FiducialPart(name, *to_arena(x, y), facing_in_arena(facing), math.pi) for name, (x, y, facing) in PLACES.items()
    )
    groups = tuple(
        Group(pair, (f"{pair}A", f"{pair}B"), kind) for pair, kind in zip("1234", ["short", "long"] * 2, strict=True)
    )
    return Arena("A2", RADIUS_M, parts, groups, path="arena.yaml", sha256="cd" * 32)


def sample_detections() -> tuple[BarrelPart, ...]:
    arcs = [
        BarrelPart(
            n=n,
            x_m=PLACES[name][0] + ex,
            y_m=PLACES[name][1] + ey,
            facing=math.radians(PLACES[name][2]),
            drawn=math.radians(170),
            sigma_m=0.01,
            confidence=0.97,
            fixed_id=name if name in FIXED else None,
        )
        for n, (name, (ex, ey)) in enumerate(ERRORS.items(), start=1)
    ]
    loose = [
        BarrelPart(6, 10.0, 5.0, None, 2 * math.pi, 0.02, 0.61),
        BarrelPart(7, 1.2, 4.6, math.radians(45), math.radians(130), None, 0.52),
    ]
    return (*arcs, *loose)


def sample_attributes(detections: tuple[BarrelPart, ...]) -> Attributes:
    by_id = dict(zip(ERRORS, detections, strict=False))
    parts = tuple(
        PartResult(name, by_id.get(name), math.hypot(*ERRORS[name]) if name in ERRORS else None, None, x, y)
        for name, (x, y, _) in PLACES.items()
    )
    pair = {p: (f"{p}A", f"{p}B") for p in "1234"}
    groups = (
        GroupResult("1", "short", (PairResult(pair["1"], 0.11, 0.1, 0.01, 0.0083),), 0.0083),
        GroupResult("2", "long", (PairResult(pair["2"], 0.76, 0.1, 0.66, 0.55),), 0.55),
        GroupResult("3", "short", (PairResult(pair["3"], None, 0.1, None, 1.0),), 1.0),
        GroupResult("4", "long", (PairResult(pair["4"], None, 0.1, None, None),), None),
    )
    return Attributes(
        by_name={
            "coverage": Value(0.625),
            "relative_accuracy": Value(0.846),
            "consistency": Value(0.473),
            "global_accuracy": Value(None, "the arena's frame is relative"),
            "resolution_quality": Value(0.91),
        },
        classes={"short": Value(0.496), "long": Value(0.45)},
        overall=Value(0.648),
        missing=("global_accuracy",),
        parts=parts,
        groups=groups,
    )


def sample_report(name: str = "teamA/map.yaml", sha256: str = "ab" * 32) -> Report:
    detections = sample_detections()
    index = {name: i for i, name in enumerate(ERRORS)}
    findings = (
        Finding("note", "survey-sigma", "8 parts have no sigma_m; 0.02 m is taken for each."),
        Finding(
            "warning",
            "unknown-loads-as-free",
            "Unknown cells (grey 205) load as free with free_thresh 0.25.",
            "--free-thresh 0.196",
        ),
        Finding("warning", "doubtful-assignment", "2A lies 0.71 m from its place, more than D/2 = 0.60 m."),
    )
    return Report(
        map=Source(name, sha256, "map_server"),
        arena=sample_arena(),
        settings=Settings(),
        detections=detections,
        assignment=Assignment(
            tuple(index.get(part) for part in PLACES),
            tuple(part in FIXED for part in PLACES),
            T_TRUTH_MAP,
            4.23,
        ),
        attributes=sample_attributes(detections),
        findings=findings,
        version="0.1.0",
    )


SETTINGS_DOCUMENT = {
    "fidmap_profile": 1,
    "base": "continuous",
    "min_opening": 2 / 3,
    "weights": {"coverage": 1.0},
}
