"""The real maps of `slam_challenge`: their truth and the rule for counting detections against it."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from fidmap.model import BarrelPart

ROOT = Path(__file__).resolve().parents[1]
TUNED_ON = ("m28", "m29", "m30", "m33", "m34", "m35", "m59")
REFERENCE = ("m68", "m69")
NEAR_M, NEAR_ANGLE = 0.15, math.radians(60)


def real_data_root() -> Path:
    """Where the real maps are: FIDMAP_REAL_DATA, or the folder beside the checkout."""
    return Path(os.environ.get("FIDMAP_REAL_DATA", ROOT.parent / "shared" / "data"))


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
class Count:
    """Detections against truth: the true ones with their errors, the ignored, the false, and what was missed."""

    errors_m: tuple[float, ...]
    ignored: int
    false: tuple[BarrelPart, ...]
    missed: tuple[DrawnPart, ...]

    @property
    def true(self) -> int:
        """Number of true detections."""
        return len(self.errors_m)


def read_drawn_parts(folder: Path, name: str) -> tuple[DrawnPart, ...]:
    """The truth file of one map."""
    document = json.loads((folder / "truth" / f"parts_{name}.json").read_text(encoding="utf-8"))
    return tuple(_drawn_part(part) for part in document["parts"])


def _drawn_part(part: dict[str, object]) -> DrawnPart:
    def number(key: str) -> float | None:
        value = part.get(key)
        return None if value is None else float(str(value))

    out = part.get("facing")
    facing = math.atan2(float(out[1]), float(out[0])) if isinstance(out, list) else None
    copies = part.get("other_copies")
    found = tuple((float(c["x"]), float(c["y"])) for c in copies) if isinstance(copies, list) else ()
    return DrawnPart(str(part["id"]), number("x"), number("y"), facing, str(part["drawn"]), found)


def count(detections: Iterable[BarrelPart], parts: tuple[DrawnPart, ...]) -> Count:
    """Count in order of confidence.

    A detection takes the nearest free `yes` part within reach, else is ignored where a part is drawn partly, less, or
    again, else is false.
    """
    free = [part for part in parts if part.drawn == "yes"]
    others = [part for part in parts if part.drawn != "yes"]
    copies = [DrawnPart(p.id, x, y, None, "copy", ()) for p in parts for x, y in p.copies]
    errors, ignored, false = [], 0, []
    for detection in sorted(detections, key=lambda d: -d.confidence):
        near = [(d, part) for part in free if (d := reach(detection, part)) is not None]
        if near:
            error, part = min(near, key=lambda pair: pair[0])
            free.remove(part)
            errors.append(error)
        elif any(reach(detection, part) is not None for part in (*others, *copies)):
            ignored += 1
        else:
            false.append(detection)
    return Count(tuple(errors), ignored, tuple(false), tuple(free))


def reach(detection: BarrelPart, part: DrawnPart) -> float | None:
    """Distance in metres of a detection that may be the part, else None."""
    if part.x_m is None or part.y_m is None:
        return None
    distance = math.hypot(detection.x_m - part.x_m, detection.y_m - part.y_m)
    if distance > NEAR_M:
        return None
    if detection.facing is None or part.facing is None:
        return distance
    apart = abs((detection.facing - part.facing + math.pi) % (2 * math.pi) - math.pi)
    return distance if apart <= NEAR_ANGLE else None
