"""Artificial maps on disk: one folder per map with the map, its arena and the truth about it."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fidmap.arena.write import write_arena
from fidmap.maps.write import write_map
from fidmap.model import Arena, OutputError
from fidmap.output_file import write_whole
from fidmap.synth.mappers import MAPPERS
from fidmap.synth.poses import Tier
from fidmap.synth.suite import CaseSpec, Split, SynthCase, build_arena, case_rng, make_case, random_spec, with_radius
from fidmap.synth.truth import PartTruth
from fidmap.version import __version__

Document = dict[str, Any]
MAP, ARENA, TRUTH = "map", "arena.yaml", "truth.json"


@dataclass(frozen=True)
class SynthJob:
    """Make one case and write it to `folder`; None leaves what is drawn at random.

    pose_errors: what those of the tier are multiplied by.
    """

    folder: Path
    split: Split
    seed: int
    tier: Tier
    index: int = 0
    mapper: str | None = None
    resolution_m: float | None = None
    radius_m: float | None = None
    pose_errors: float = 1.0


@dataclass(frozen=True)
class Made:
    """What a job wrote, or why it could not."""

    folder: Path
    map: Path | None = None
    error: str | None = None


def make(job: SynthJob) -> Made:
    """One case, written; a place that cannot be written becomes the error."""
    case = synthetic_case(job)
    try:
        path = write_map(job.folder, MAP, case.grid)
        write_arena(job.folder / ARENA, case.arena.arena)
        text = json.dumps(truth_document(case, job), indent=1, allow_nan=False) + "\n"
        write_whole(job.folder / TRUTH, text.encode())
    except OutputError as fault:
        return Made(job.folder, error=str(fault))
    return Made(job.folder, path)


def died(job: SynthJob) -> Made:
    """The result of a case whose process was killed."""
    return Made(job.folder, error=f"{job.folder}: its process died, probably for lack of memory; use fewer --workers")


def synthetic_case(job: SynthJob) -> SynthCase:
    """The case that a job describes: the same for the same job, whatever was made before it."""
    rng = case_rng(job.split, job.seed, job.tier, job.index)
    spec = _chosen(random_spec(rng, job.tier), job)
    name = f"{job.split}-{job.tier}-{job.seed}-{job.index:03d}"
    return make_case(rng, replace(spec, arena=replace(spec.arena, name=name)), tier=job.tier, name=name)


def _chosen(spec: CaseSpec, job: SynthJob) -> CaseSpec:
    """A random case with what the user chose in its place."""
    if job.mapper is not None:
        spec = replace(spec, mapper=MAPPERS[job.mapper])
    if job.resolution_m is not None:
        spec = replace(spec, resolution_m=job.resolution_m)
    if job.radius_m is not None:
        spec = with_radius(spec, job.radius_m)
    return replace(spec, noise=spec.noise.times(job.pose_errors))


def truth_document(case: SynthCase, job: SynthJob) -> Document:
    """truth.json: what docs/synth.md describes; metres and degrees."""
    frame, mapper = case.spec.frame, case.spec.mapper
    return {
        "fidmap_truth": 1,
        "version": __version__,
        "name": case.name,
        "split": job.split,
        "seed": job.seed,
        "tier": case.tier,
        "index": job.index,
        "pose_errors": job.pose_errors,
        "mapper": {"kind": mapper.kind, "output": mapper.output, "thicken": mapper.thicken, "every": mapper.every},
        "resolution_m": case.spec.resolution_m,
        "radius_m": round(case.arena.arena.radius_m, 6),
        "arena_in_map": [_short(frame.x_m), _short(frame.y_m), _degrees(frame.yaw)],
        "parts": [_part(truth) for truth in case.truths],
    }


def _part(truth: PartTruth) -> Document:
    """One part: the true place in the arena's frame, everything drawn in the map's."""
    return {
        "id": truth.id,
        "x_m": _short(truth.x_m),
        "y_m": _short(truth.y_m),
        "facing_deg": _degrees(truth.facing),
        "opening_deg": _degrees(truth.opening),
        "drawn": truth.drawn,
        "drawn_x_m": _short(truth.drawn_x_m),
        "drawn_y_m": _short(truth.drawn_y_m),
        "drawn_facing_deg": _degrees(truth.drawn_facing),
        "voted_x_m": _short(truth.voted_x_m),
        "voted_y_m": _short(truth.voted_y_m),
        "drawn_deg": _degrees(truth.support),
        "seen_deg": _degrees(truth.seen),
        "clutter_deg": _degrees(truth.clutter),
        "scans": truth.scans,
        "copies": [{"x_m": _short(x), "y_m": _short(y)} for x, y in truth.copies],
    }


def _short(value: float | None) -> float | None:
    return None if value is None else round(value, 6)


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else round(math.degrees(angle), 4)


def random_arena(job: SynthJob) -> Arena:
    """The arena that the job's case would stand in, without a map of it."""
    rng = case_rng(job.split, job.seed, job.tier, job.index)
    spec = _chosen(random_spec(rng, job.tier), job)
    return build_arena(rng, replace(spec.arena, name=f"{job.tier}-{job.seed}")).arena
