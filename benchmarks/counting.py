"""Detections against what a map draws: the one rule by which finders of barrel parts are counted.

In order of confidence a detection takes the nearest free part that is drawn ('yes') within reach, else it is ignored
where a part is drawn partly, less, or again (a copy), else it is false. A second detection of a part that was taken
is false wherever it lies.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fidmap.model import BarrelPart, FloatArray

NEAR_M, NEAR_ANGLE = 0.15, math.radians(60)
SAME = 1 / 3  # radii; two detections so near each other that face the same way are one part found twice
State = Literal["true", "false", "ignored"]


@dataclass(frozen=True)
class DrawnPart:
    """Where a map draws a part: metres in the map's frame, facing in radians; drawn yes, partly or no."""

    id: str
    x_m: float | None
    y_m: float | None
    facing: float | None
    drawn: str
    copies: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Verdict:
    """What became of a detection; `part` is the one that a true detection took."""

    detection: BarrelPart
    state: State
    part: DrawnPart | None = None

    @property
    def error_xy(self) -> tuple[float, float]:
        """Error of a true detection's centre in metres."""
        assert self.part is not None
        assert self.part.x_m is not None
        assert self.part.y_m is not None
        return self.detection.x_m - self.part.x_m, self.detection.y_m - self.part.y_m

    @property
    def error_m(self) -> float:
        """Distance of a true detection from its part."""
        return math.hypot(*self.error_xy)

    @property
    def turn(self) -> float | None:
        """Error of a true detection's facing in radians; None where one of the two has none."""
        if self.part is None or self.part.facing is None or self.detection.facing is None:
            return None
        return apart(self.part.facing, self.detection.facing)


@dataclass(frozen=True)
class Count:
    """Detections of one map with their verdicts, most confident first, and the parts that nothing took."""

    verdicts: tuple[Verdict, ...]
    missed: tuple[DrawnPart, ...]

    def of(self, state: State) -> list[Verdict]:
        """The verdicts of a kind."""
        return [verdict for verdict in self.verdicts if verdict.state == state]

    @property
    def true(self) -> int:
        """Number of true detections."""
        return len(self.of("true"))

    @property
    def drawn(self) -> int:
        """Number of parts that are to be found."""
        return self.true + len(self.missed)

    @property
    def errors_m(self) -> list[float]:
        """Errors of the true detections."""
        return [verdict.error_m for verdict in self.of("true")]

    @property
    def false(self) -> list[BarrelPart]:
        """The false detections."""
        return [verdict.detection for verdict in self.of("false")]

    @property
    def ignored(self) -> int:
        """Number of detections that count neither way."""
        return len(self.of("ignored"))

    def above(self, confidence: float) -> Count:
        """The count of the detections of so much confidence; a greedy count of fewer is the beginning of this one."""
        kept = tuple(verdict for verdict in self.verdicts if verdict.detection.confidence >= confidence)
        lost = [v.part for v in self.verdicts[len(kept) :] if v.part is not None]
        return Count(kept, (*self.missed, *lost))


def count(detections: Iterable[BarrelPart], parts: Sequence[DrawnPart], radius_m: float = 0.3) -> Count:
    """Count the detections of one map in order of confidence."""
    free = [part for part in parts if part.drawn == "yes"]
    others = [part for part in parts if part.drawn != "yes"]
    others += [DrawnPart(p.id, x, y, None, "copy", ()) for p in parts for x, y in p.copies]
    verdicts: list[Verdict] = []
    taken: list[BarrelPart] = []
    for detection in sorted(detections, key=lambda d: -d.confidence):
        near = [(d, part) for part in free if (d := reach(detection, part)) is not None]
        if any(_same(detection, other, radius_m) for other in taken):
            verdicts.append(Verdict(detection, "false"))
        elif near:
            _, part = min(near, key=lambda pair: pair[0])
            free.remove(part)
            taken.append(detection)
            verdicts.append(Verdict(detection, "true", part))
        else:
            open_ = any(reach(detection, part) is not None for part in others)
            verdicts.append(Verdict(detection, "ignored" if open_ else "false"))
    return Count(tuple(verdicts), tuple(free))


def reach(detection: BarrelPart, part: DrawnPart) -> float | None:
    """Distance in metres of a detection that may be the part, else None."""
    if part.x_m is None or part.y_m is None:
        return None
    distance = math.hypot(detection.x_m - part.x_m, detection.y_m - part.y_m)
    if distance > NEAR_M:
        return None
    if detection.facing is None or part.facing is None:
        return distance
    return distance if apart(detection.facing, part.facing) <= NEAR_ANGLE else None


def apart(a: float, b: float) -> float:
    """Angle between two directions, 0 to pi."""
    return abs((a - b + math.pi) % (2 * math.pi) - math.pi)


def _same(a: BarrelPart, b: BarrelPart, radius_m: float) -> bool:
    """Whether two detections are of one part; a tool without facings cannot be asked."""
    if a.facing is None or b.facing is None or math.hypot(a.x_m - b.x_m, a.y_m - b.y_m) > SAME * radius_m:
        return False
    return apart(a.facing, b.facing) < NEAR_ANGLE


@dataclass(frozen=True)
class Rates:
    """Counts of many maps together; a rate without anything to divide by is NaN."""

    true: int
    false: int
    drawn: int

    @property
    def precision(self) -> float:
        """Share of the detections that are true."""
        return self.true / (self.true + self.false) if self.true + self.false else math.nan

    @property
    def recall(self) -> float:
        """Share of the drawn parts that are found."""
        return self.true / self.drawn if self.drawn else math.nan

    @property
    def f1(self) -> float:
        """Harmonic mean of both: 2 true / (detections + drawn parts)."""
        total = self.true + self.false + self.drawn
        return 2 * self.true / total if total else math.nan


def rates(counts: Iterable[Count], confidence: float = 0.5) -> Rates:
    """The detections of a confidence, over all maps."""
    above = [one.above(confidence) for one in counts]
    return Rates(sum(c.true for c in above), sum(len(c.false) for c in above), sum(c.drawn for c in above))


def ranked(counts: Iterable[Count]) -> tuple[FloatArray, FloatArray]:
    """Confidences (N,), falling, and whether true (N,), of all detections that count."""
    kept = [(v.detection.confidence, v.state == "true") for c in counts for v in c.verdicts if v.state != "ignored"]
    kept.sort(key=lambda row: (-row[0], row[1]))  # of equal confidence the false first: ties give nothing away
    return np.array([row[0] for row in kept], float), np.array([row[1] for row in kept], float)


def average_precision(counts: Sequence[Count]) -> float:
    """Mean over all drawn parts of the precision at which each is found, 0 for those never found; no interpolation."""
    _, true = ranked(counts)
    drawn = sum(c.drawn for c in counts)
    precision = np.cumsum(true) / np.arange(1, len(true) + 1)
    return float((precision * true).sum() / drawn) if drawn else math.nan


def best_confidence(counts: Sequence[Count]) -> float:
    """The confidence at which F1 is greatest, in hindsight."""
    confidence, true = ranked(counts)
    if not len(confidence):
        return 0.0
    drawn = sum(c.drawn for c in counts)
    f1 = 2 * np.cumsum(true) / (np.arange(1, len(true) + 1) + drawn)
    last = np.append(confidence[1:] < confidence[:-1], True)  # equal confidences come together
    return float(confidence[int(np.argmax(np.where(last, f1, -1.0)))])
