"""Grids in the manner of different mapping programs, from scans and the poses somebody believed.

Sources of the rules: log-odds (Elfes 1989) with clamping as in OctoMap; hits / (hits + misses) with a least
number of visits as in Karto's OccupancyGrid; CoreSLAM's 'hole' profile (Steux, El Hamzaoui 2010: tinySLAM,
ts_map_update).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
import numpy.typing as npt

from fidmap.model import FloatArray, Grid, Pose2, Source
from fidmap.synth.laser import Scans
from fidmap.synth.rays import Batch, Frame, batches, frame_of, ray_ends, samples

IntArray = npt.NDArray[np.int64]
Float32Array = npt.NDArray[np.float32]
Kind = Literal["log_odds", "hits", "coreslam"]
Output = Literal["trinary", "raw", "binary"]


@dataclass(frozen=True)
class Mapper:
    """A manner of mapping.

    kind: the rule. usable_m: longer ranges only clear cells up to here. every: use one scan in so many.
    thicken: cells by which occupied is widened. output: 'trinary' (p = 1, 0 or NaN), 'raw' probabilities, or
    'binary' (black and white without any unknown).
    log_odds: hit and miss are added per scan and cell, limit clamps. hits: occupied at hits >= share *
    visits, with min_visits visits. coreslam: hole_m is the width of a wall's profile, quality the weight of
    one beam.
    """

    kind: Kind = "hits"
    usable_m: float = 20.0
    every: int = 1
    thicken: int = 0
    output: Output = "trinary"
    hit: float = 0.85
    miss: float = -0.4
    limit: float = 3.5
    share: float = 0.1
    min_visits: int = 2
    hole_m: float = 0.3
    quality: float = 50 / 256


MAPPERS: dict[str, Mapper] = {
    "log_odds": Mapper("log_odds"),
    "thin": Mapper("log_odds", hit=0.6, miss=-0.7),
    "hits": Mapper("hits"),
    "half_hits": Mapper("hits", share=0.25, min_visits=1),
    "sparse": Mapper("hits", every=8, min_visits=1),
    "thick": Mapper("hits", thicken=1),
    "raw": Mapper("hits", share=0.25, min_visits=1, output="raw"),
    "raw_log_odds": Mapper("log_odds", output="raw"),
    "binary": Mapper("log_odds", output="binary"),
    "coreslam": Mapper("coreslam"),
    "coreslam_narrow": Mapper("coreslam", hole_m=0.15),
    "coreslam_raw": Mapper("coreslam", output="raw"),
}


def draw_map(
    scans: Scans,
    poses: FloatArray,
    mapper: Mapper,
    resolution_m: float,
    *,
    margin_m: float = 0.5,
    min_cells: int = 0,
    name: str = "synthetic",
) -> Grid:
    """Map the scans from the given poses.

    Args:
        scans: what was measured (M scans).
        poses: (M, 3) estimated x, y, yaw in the map's frame.
        mapper: the manner.
        resolution_m: side of a cell.
        margin_m: unknown rim around what was measured.
        min_cells: least width and height; smaller maps get more unknown rim.
        name: name of the grid's source.

    Returns:
        The grid; its origin has no yaw and is a multiple of the resolution away from (0, 0).

    Raises:
        ValueError: the numbers of scans and poses differ, or nothing was measured.
    """
    if len(poses) != len(scans.ranges):
        raise ValueError(f"{len(scans.ranges)} scans need as many poses, not {len(poses)}")
    used = slice(None, None, mapper.every)
    ends = ray_ends(scans.ranges[used], scans.bearings, poses[used], min(mapper.usable_m, scans.max_range_m))
    frame = frame_of(ends, resolution_m, margin_m, min_cells)
    p = _RULES[mapper.kind](batches(ends, frame), frame, mapper)
    if mapper.output != "raw":
        p = _trinary(p, mapper)
    origin = Pose2(frame.x_m, frame.y_m, 0.0)
    return Grid(p, resolution_m, origin, source=Source(name, format="synthetic"))


def count_probability(hits: Float32Array, visits: Float32Array, mapper: Mapper) -> Float32Array:
    """Occupancy p of cells from hits and visits (hits + passes); NaN below `min_visits`.

    p is 1/2 at hits = share * visits, piecewise linear to 0 and 1, so that the threshold of the program that
    is imitated lies at 1/2 whatever it was.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = hits / visits
    p = np.where(ratio < mapper.share, 0.5 * ratio / mapper.share, 1 - 0.5 * (1 - ratio) / (1 - mapper.share))
    p[visits < mapper.min_visits] = np.nan
    return p.astype(np.float32)


def remembered(mapper: Mapper, beams: IntArray, scans: IntArray) -> FloatArray:
    """What is left of hits (N,) in a map after so many later beams and scans hit the same cells, as a share.

    Counted hits stay. CoreSLAM keeps 1 - quality with every beam. Clamped log-odds walk at random between two walls:
    where as much speaks for a cell as against it, a step's variance is hit |miss|, and a walk's past decays over
    2 (2 limit)^2 / (pi^2 variance) steps (the slowest mode of diffusion between reflecting walls).
    """
    if mapper.kind == "coreslam":
        return np.asarray((1 - mapper.quality) ** beams.astype(np.float64))
    if mapper.kind == "log_odds":
        steps = 8 * mapper.limit**2 / (math.pi**2 * mapper.hit * -mapper.miss)
        return np.asarray(np.exp(-scans / steps))
    return np.ones(len(beams))


def hole_profile(along_m: FloatArray, range_m: FloatArray, hole_m: float) -> FloatArray:
    """CoreSLAM's value of a beam's cells: 0 (free), rising to 1 at the hit and falling again behind it.

    Args:
        along_m: (N,) distance of the cells from the sensor.
        range_m: (N,) range of their beams.
        hole_m: full width of the rise and fall.
    """
    return np.maximum(0.0, 1 - np.abs(along_m - range_m) / (hole_m / 2))


def _map_hits(parts: Batch, frame: Frame, mapper: Mapper) -> Float32Array:
    hits = np.zeros(frame.shape, np.float32)
    visits = np.zeros(frame.shape, np.float32)
    for window, rays in parts(4, 0.0):
        found = samples(rays, window)
        hits[window.cells] += window.count(found.end)
        visits[window.cells] += window.count(found.end) + window.count(found.passed)
    return count_probability(hits, visits, mapper)


def _map_log_odds(parts: Batch, frame: Frame, mapper: Mapper) -> Float32Array:
    odds = np.zeros(frame.shape, np.float32)
    seen = np.zeros(frame.shape, bool)
    for window, rays in parts(1, 0.0):
        found = samples(rays, window)
        occupied, passed = window.touched(found.end), window.touched(found.passed)
        change = np.where(occupied, np.float32(mapper.hit), np.float32(mapper.miss) * passed)
        view = odds[window.cells]
        np.clip(view + change, -mapper.limit, mapper.limit, out=view)
        seen[window.cells] |= occupied | passed
    p: Float32Array = (1 / (1 + np.exp(-odds))).astype(np.float32)
    p[~seen] = np.nan
    return p


def _map_coreslam(parts: Batch, frame: Frame, mapper: Mapper) -> Float32Array:
    """Each beam pulls its cells towards its profile; within one scan the pulls on a cell are averaged."""
    p = np.full(frame.shape, 0.5, np.float32)
    hole_m = max(mapper.hole_m, 4 * frame.resolution_m)  # a narrower profile falls between the cells
    for window, rays in parts(1, hole_m / 2):
        found = samples(rays, window, beyond_m=hole_m / 2)
        value = hole_profile(found.along_m, found.range_m, hole_m)
        count = window.count(found.all)
        total = window.count(found.all, value)
        keep = (1 - mapper.quality) ** count
        view = p[window.cells]
        view[...] = keep * view + (1 - keep) * total / np.maximum(count, 1)
    return p


_RULES: dict[str, Callable[[Batch, Frame, Mapper], Float32Array]] = {
    "hits": _map_hits,
    "log_odds": _map_log_odds,
    "coreslam": _map_coreslam,
}


def _trinary(p: Float32Array, mapper: Mapper) -> Float32Array:
    """Occupied 1, free 0, unknown NaN (binary: also 0), by what the imitated program would have saved."""
    if mapper.kind == "hits":
        occupied, free = p >= 0.5, p < 0.5
    elif mapper.kind == "log_odds":
        occupied, free = p >= 0.55, p <= 0.45
    else:
        occupied, free = p >= 0.6, p <= 0.35
    if mapper.thicken:
        kernel = np.ones((2 * mapper.thicken + 1,) * 2, np.uint8)
        occupied = cv2.dilate(occupied.astype(np.uint8), kernel).astype(bool)
    result = np.full(p.shape, 0.0 if mapper.output == "binary" else np.nan, np.float32)
    result[free] = 0.0
    result[occupied] = 1.0
    return result
