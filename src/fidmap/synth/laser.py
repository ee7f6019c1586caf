"""A 2D laser in an artificial arena: exact ray casting, then the faults of a real sensor.

A fan is a row of beams with even steps from one origin: x, y, direction of the first beam, step. Casting
works object by object: each covers an interval of beams, so the work grows with what is seen, not beams x
objects.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fidmap.model import FloatArray
from fidmap.synth.arena import SynthArena

IntArray = npt.NDArray[np.int64]
FANS_AT_ONCE = 48  # fans near each other share the objects in reach; more would only cost memory
EDGE_M = 0.15  # neighbouring beams whose ranges differ by more stand on the two sides of an edge


@dataclass(frozen=True)
class Laser:
    """A sensor; the defaults are about those of a Hokuyo UTM-30LX.

    fov, step: field of view and angle between beams. noise_m: deviation of the range. mixed: share of the
    beams at edges that return something between the two ranges. dropout: share of beams without return. skew:
    share of the motion between two scans that happens during one sweep. tilt: deviation of roll and pitch;
    height_m: of the sensor over the floor (beams tilted down end there, and slant ranges are longer than
    plane ones). silent: beams beyond reach are missing, as where a program drops them, instead of inf.
    """

    fov: float = math.radians(270)
    step: float = math.radians(0.25)
    max_range_m: float = 30.0
    noise_m: float = 0.01
    mixed: float = 0.3
    dropout: float = 0.002
    skew: float = 0.0
    tilt: float = 0.0
    height_m: float = 0.4
    silent: bool = False

    @property
    def bearings(self) -> FloatArray:
        """(B,) direction of each beam in the robot's frame, counter-clockwise from straight ahead."""
        count = round(self.fov / self.step) + 1
        bearings: FloatArray = -self.fov / 2 + self.step * np.arange(count, dtype=np.float64)
        return bearings


@dataclass(frozen=True, eq=False)
class Scans:
    """What the laser measured along a trajectory.

    poses: (M, 3) true x, y, yaw in the arena's frame. bearings: (B,). ranges: (M, B) metres, NaN without
    return and inf beyond reach. parts: (M, B) index of the fiducial part that was hit, -1 for anything else.
    """

    poses: FloatArray
    bearings: FloatArray
    ranges: npt.NDArray[np.float32]
    parts: npt.NDArray[np.int16]
    max_range_m: float

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        for name in ("poses", "bearings", "ranges", "parts"):
            view = getattr(self, name).view()
            view.setflags(write=False)
            object.__setattr__(self, name, view)

    def only(self, chosen: npt.NDArray[np.bool_]) -> Scans:
        """The scans of a (M,) mask."""
        return Scans(self.poses[chosen], self.bearings, self.ranges[chosen], self.parts[chosen], self.max_range_m)


def cast(
    walls: FloatArray, arcs: FloatArray, fans: FloatArray, beams: int, max_range_m: float = math.inf
) -> tuple[FloatArray, IntArray]:
    """Exact ranges from fans of beams to the nearest wall or arc.

    Args:
        walls: (S, 4) segments x0, y0, x1, y1 in metres.
        arcs: (C, 5) x, y, radius, middle direction, opening.
        fans: (F, 4) x, y, direction of the first beam, step; beams * step below 2 pi.
        beams: beams per fan.
        max_range_m: reach.

    Returns:
        ranges: (F, beams) metres, inf where nothing is in reach.
        hits: (F, beams) what was hit: 0 to S-1 a wall, S to S+C-1 an arc, -1 nothing.
    """
    ranges = np.full((len(fans), beams), math.inf)
    hits = np.full((len(fans), beams), -1, np.int64)
    for begin in range(0, len(fans), FANS_AT_ONCE):
        part = slice(begin, begin + FANS_AT_ONCE)
        near_walls, near_arcs = _in_reach(walls, arcs, fans[part], max_range_m)
        found = [
            _cast_walls(walls[near_walls], fans[part], beams, near_walls),
            _cast_arcs(arcs[near_arcs], fans[part], beams, near_arcs + len(walls)),
        ]
        at, distance, what = (np.concatenate(column) for column in zip(*found, strict=True))
        nearest = ranges[part].ravel()
        np.minimum.at(nearest, at, distance)
        first = distance == nearest[at]
        hit = hits[part].ravel()
        hit[at[first]] = what[first]
        ranges[part], hits[part] = nearest.reshape(-1, beams), hit.reshape(-1, beams)
    beyond = ranges > max_range_m
    ranges[beyond], hits[beyond] = math.inf, -1
    return ranges, hits


def _in_reach(walls: FloatArray, arcs: FloatArray, fans: FloatArray, reach_m: float) -> tuple[IntArray, IntArray]:
    """Indices of the walls and arcs whose boxes come within reach of the fans' box."""
    low, high = fans[:, :2].min(0) - reach_m, fans[:, :2].max(0) + reach_m
    ends = walls.reshape(-1, 2, 2)
    near_walls = ((ends.max(1) >= low) & (ends.min(1) <= high)).all(1)
    near_arcs = ((arcs[:, :2] + arcs[:, 2:3] >= low) & (arcs[:, :2] - arcs[:, 2:3] <= high)).all(1)
    return np.nonzero(near_walls)[0], np.nonzero(near_arcs)[0]


def _beams_of(
    fans: FloatArray, middle: FloatArray, half: FloatArray, beams: int
) -> tuple[IntArray, IntArray, IntArray]:
    """The beams within intervals of directions, as flat lists.

    Args:
        fans: (F, 4).
        middle: (F, K) middle direction of each object's interval as each fan sees it.
        half: (F, K) half its width.
        beams: beams per fan.

    Returns:
        fan, object and beam index of each beam in an interval, (N,) each.
    """
    start, step = fans[:, 2:3], fans[:, 3:4]
    low = np.mod(middle - half - start, 2 * math.pi)
    firsts, lasts = [], []
    for turn in (0.0, 2 * math.pi):  # an interval that begins behind the fan may reach into its first beams
        firsts.append(np.maximum(np.ceil((low - turn) / step - 1e-9), 0))
        lasts.append(np.minimum(np.floor((low + 2 * half - turn) / step + 1e-9), beams - 1))
    first, last = np.stack(firsts).astype(np.int64), np.stack(lasts).astype(np.int64)
    _, fan, thing = np.nonzero(last >= first)
    begin = first[last >= first]
    count = (last - first + 1)[last >= first]
    beam = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + np.repeat(begin, count)
    return np.repeat(fan, count), np.repeat(thing, count), beam


def _directions(fans: FloatArray, fan: IntArray, beam: IntArray, beams: int) -> tuple[FloatArray, FloatArray]:
    """Cosine and sine of each listed beam's direction; computed once per fan and beam, then looked up."""
    angles = fans[:, 2:3] + fans[:, 3:4] * np.arange(beams)
    return np.cos(angles)[fan, beam], np.sin(angles)[fan, beam]


Hits = tuple[IntArray, FloatArray, IntArray]


def _cast_walls(walls: FloatArray, fans: FloatArray, beams: int, names: IntArray) -> Hits:
    """Flat beam index, distance and name of each hit on a wall (of a beam within the wall's interval)."""
    a = walls[None, :, :2] - fans[:, None, :2]  # (F, S, 2)
    b = walls[None, :, 2:] - fans[:, None, :2]
    direction = np.arctan2(a[..., 1], a[..., 0])
    width = np.arctan2(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], (a * b).sum(-1))
    fan, wall, beam = _beams_of(fans, direction + width / 2, np.abs(width) / 2, beams)
    along = walls[:, 2:] - walls[:, :2]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.maximum(np.hypot(*along.T), 1e-12)[:, None]
    height = (a * normal).sum(-1)
    cos, sin = _directions(fans, fan, beam, beams)
    with np.errstate(divide="ignore", invalid="ignore"):  # a beam along the wall hits its end's neighbour
        distance = height[fan, wall] / (cos * normal[wall, 0] + sin * normal[wall, 1])
    good = distance > 0
    return (fan * beams + beam)[good], distance[good], names[wall[good]]


def _cast_arcs(arcs: FloatArray, fans: FloatArray, beams: int, names: IntArray) -> Hits:
    """Flat beam index, distance and name of each hit on an arc, from outside or inside its circle."""
    offset = arcs[None, :, :2] - fans[:, None, :2]  # (F, C, 2)
    distance = np.hypot(offset[..., 0], offset[..., 1])
    radius = arcs[:, 2]
    outside = distance > radius
    half = np.where(outside, np.arcsin(np.minimum(radius / np.maximum(distance, 1e-12), 1)), math.pi)
    fan, arc, beam = _beams_of(fans, np.arctan2(offset[..., 1], offset[..., 0]), half, beams)
    cos, sin = _directions(fans, fan, beam, beams)
    dx, dy = offset[fan, arc, 0], offset[fan, arc, 1]
    middle, across = dx * cos + dy * sin, dx * sin - dy * cos
    chord = np.sqrt(np.maximum(radius[arc] ** 2 - across**2, 0))
    face_x, face_y = np.cos(arcs[arc, 3]), np.sin(arcs[arc, 3])
    limit = np.where(arcs[arc, 4] >= 2 * math.pi, -2.0, np.cos(arcs[arc, 4] / 2) - 1e-9) * radius[arc]
    best = np.full(len(arc), math.inf)
    for root in (middle + chord, middle - chord):  # the nearer one last, so that it wins
        on_arc = (root * cos - dx) * face_x + (root * sin - dy) * face_y >= limit
        best = np.where((root > 0) & on_arc, root, best)
    good = np.isfinite(best)
    return (fan * beams + beam)[good], best[good], names[arc[good]]


def scan(arena: SynthArena, poses: FloatArray, laser: Laser, rng: np.random.Generator) -> Scans:
    """Measure along a trajectory.

    Args:
        arena: what is to be seen.
        poses: (M, 3) true x, y, yaw in the arena's frame, one per scan (the middle of its sweep).
        laser: the sensor and its faults.
        rng: the only source of randomness.
    """
    bearings = laser.bearings
    ranges, hits = _sweep(arena, poses, laser, len(bearings))
    ranges, hits = _tilted(ranges, hits, laser, rng)
    ranges, hits = _mixed(ranges, hits, laser, rng)
    ranges = ranges + laser.noise_m * rng.standard_normal(ranges.shape)
    lost = rng.random(ranges.shape) < laser.dropout
    ranges[lost | np.isinf(ranges) if laser.silent else lost] = np.nan
    crowd = max(map(len, arena.crowds), default=0)
    names = [np.full(len(arena.walls), -1), arena.arc_part, np.full(crowd + 1, -1)]
    part_of = np.concatenate(names).astype(np.int16)
    parts = np.where(np.isfinite(ranges), part_of[hits], np.int16(-1))
    return Scans(poses, bearings, ranges.astype(np.float32), parts, laser.max_range_m)


def _sweep(arena: SynthArena, poses: FloatArray, laser: Laser, beams: int) -> tuple[FloatArray, IntArray]:
    """Exact ranges; with skew in sectors, each from where the robot was while it was measured."""
    sectors = 1 if laser.skew == 0 else 9
    size = math.ceil(beams / sectors)
    motion = np.zeros_like(poses)
    if len(poses) > 1:
        motion = np.gradient(np.column_stack([poses[:, :2], np.unwrap(poses[:, 2])]), axis=0) * laser.skew
    fans = []
    for sector in range(sectors):
        x, y, yaw = (poses + ((sector + 0.5) / sectors - 0.5) * motion).T
        start = yaw - laser.fov / 2 + sector * size * laser.step
        fans.append(np.stack([x, y, start, np.full(len(poses), laser.step)], axis=1))
    per_pose = np.stack(fans, axis=1)
    found = []
    crowds = arena.crowds or (np.zeros((0, 5)),)
    for stretch, crowd in zip(np.array_split(per_pose, len(crowds)), crowds, strict=True):
        arcs = np.concatenate([arena.arcs, crowd])
        found.append(cast(arena.walls, arcs, stretch.reshape(-1, 4), size, laser.max_range_m))
    ranges, hits = (np.concatenate(column) for column in zip(*found, strict=True))
    return ranges.reshape(len(poses), -1)[:, :beams], hits.reshape(len(poses), -1)[:, :beams]


def _tilted(ranges: FloatArray, hits: IntArray, laser: Laser, rng: np.random.Generator) -> tuple[FloatArray, IntArray]:
    """Slant ranges of a swaying sensor: d / cos(elevation), and the floor where a beam points down to it."""
    if laser.tilt == 0:
        return ranges, hits
    roll, pitch = laser.tilt * rng.standard_normal((2, len(ranges), 1))
    elevation = pitch * np.cos(laser.bearings) + roll * np.sin(laser.bearings)
    slant = ranges / np.cos(elevation)
    floor = np.where(elevation < 0, laser.height_m / np.maximum(np.sin(-elevation), 1e-9), math.inf)
    return np.minimum(slant, floor), np.where(floor < slant, -1, hits)


def _mixed(ranges: FloatArray, hits: IntArray, laser: Laser, rng: np.random.Generator) -> tuple[FloatArray, IntArray]:
    """Beams split by an edge: some return a range between the nearer and the farther surface."""
    known = np.where(np.isfinite(ranges), ranges, np.nan)
    step = np.diff(known, axis=1, append=known[:, -1:])
    edge = np.abs(step) > EDGE_M
    mixed = edge & (rng.random(ranges.shape) < laser.mixed)
    # A laser spot is much smaller than the gap between beams, so most split returns lie near one surface.
    share = rng.beta(0.5, 0.5, ranges.shape)
    return np.where(mixed, ranges + share * step, ranges), np.where(mixed, -1, hits)
