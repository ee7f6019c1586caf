"""Where the scans of a drive put each part on average, whatever its map still shows of them.

Truth is what a map draws; this is what its poses say. The two differ where a mapper forgets, where one scan saw more
of an arc than another, and by the motion during a scan.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.counting import Verdict
from benchmarks.detect_maps import SEED, Job, Tried
from fidmap.model import FloatArray
from fidmap.synth.copies import SAME_COPY, hits_of
from fidmap.synth.suite import case_rng, random_spec, scans_of, with_radius

RADIUS_M = 0.3  # of the maps that are drawn in all resolutions
Votes = dict[str, FloatArray]


def scan_votes(job: Job) -> Votes:
    """The votes (N, 2) of all beams that hit each part on the drive behind a map, in the map's frame."""
    tier = job.group
    rng = case_rng(job.split, SEED, tier, job.index)  # type: ignore[arg-type]
    spec = with_radius(random_spec(rng, tier), RADIUS_M)  # type: ignore[arg-type]
    arena, scans, poses = scans_of(rng, spec)
    votes = {}
    for number, part in enumerate(arena.arena.parts):
        scan, beam = np.nonzero(scans.parts == number)
        votes[part.id] = hits_of(scans, poses, scan, beam, arena.part_arc(number)).votes
    return votes


def drives(tried: Sequence[Tried]) -> dict[tuple[str, int], Votes]:
    """Of every drive that was mapped in all resolutions, by tier and index."""
    jobs = {(t.job.group, t.job.index): t.job for t in tried if t.job.resolution_m is not None}
    return {key: scan_votes(job) for key, job in jobs.items()}


def from_votes(verdict: Verdict, votes: Votes) -> tuple[float, float]:
    """How far a true detection, and the truth, lie from the mean of the scans that agree about its part; metres."""
    assert verdict.part is not None
    found = np.array([verdict.detection.x_m, verdict.detection.y_m])
    place, all_votes = found - verdict.error_xy, votes[verdict.part.id]
    mean = all_votes[np.hypot(*(all_votes - place).T) < SAME_COPY * RADIUS_M].mean(axis=0)
    return float(np.hypot(*(mean - found))), float(np.hypot(*(mean - place)))
