"""Other people's finders of circles on the same maps; runs in `.venv-bench`, which holds nothing of ours.

    python benchmarks/peers.py FOLDER

FOLDER holds maps.json (a list of names and radii in cells) and each map's labels as NAME.npy (0 free, 1 unknown,
2 occupied). Writes peers.json: per tool and map the CPU seconds (one thread) and what was found, as
[row, column, facing or null, score] in cells and radians. All settings were tuned on maps of the tune split.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable
from importlib import import_module
from multiprocessing import Pool
from pathlib import Path
from typing import Any

import cv2
import numpy as np

Array = np.ndarray[Any, Any]
Found = list[tuple[float, float, float | None, float]]
OCCUPIED = 2
DIRECTIONS = 16


def enlarged(image: Array, radius: float, least: float) -> tuple[Array, int]:
    """The image with cells of so many pixels that circles have a size for image tools, slightly blurred."""
    times = max(1, math.ceil(least / radius - 1e-9))
    if times > 1:
        image = cv2.resize(image, None, fx=times, fy=times, interpolation=cv2.INTER_LINEAR)
    return cv2.GaussianBlur(image, (0, 0), 1.0), times


def hough_circles(labels: Array, radius: float) -> Found:
    """OpenCV HoughCircles (gradient method) on the occupied cells; the score is its votes by radius."""
    image, times = enlarged(np.array([0, 0, 255], np.uint8)[labels], radius, 12.0)
    r = radius * times
    circles = cv2.HoughCirclesWithAccumulator(
        image, cv2.HOUGH_GRADIENT, dp=1, minDist=0.25 * r, param1=150, param2=max(3.0, 0.4 * r),
        minRadius=round(0.95 * r), maxRadius=round(1.2 * r),
    )  # fmt: skip
    if circles is None:
        return []
    return [(float(y) / times, float(x) / times, None, float(n) / r) for x, y, _, n in np.reshape(circles, (-1, 4))]


def edge_drawing(labels: Array, radius: float) -> Found:
    """EdgeDrawing's circles and ellipses of about the radius; the score is the share of the ring that is occupied."""
    image, times = enlarged(np.array([255, 120, 0], np.uint8)[labels], radius, 12.0)
    tool: Any = import_module("cv2.ximgproc").createEdgeDrawing()
    settings = tool.Params()
    settings.MinPathLength, settings.NFAValidation, settings.PFmode = 10, False, True
    tool.setParams(settings)
    tool.detectEdges(image)
    shapes = tool.detectEllipses()
    found: Found = []
    for x, y, circle, a, b, _ in [] if shapes is None else np.reshape(shapes, (-1, 6)):
        size, round_ = (circle, 1.0) if circle else ((a + b) / 2, min(a, b) / max(a, b))
        if 0.7 < size / times / radius < 1.35 and round_ > 0.6:
            row, column = float(y) / times + 0.5 / times, float(x) / times + 0.5 / times
            found.append((row, column, None, support(labels, row, column, size / times) * round_))
    return suppressed(found, radius / 10)


def support(labels: Array, row: float, column: float, radius: float) -> float:
    """Share of a ring's directions with an occupied cell within a cell of it."""
    angle = np.arange(72) * math.pi / 36
    hit = np.zeros(72, bool)
    for shift in (-1.0, 0.0, 1.0):
        rows = np.clip(np.floor(row + (radius + shift) * np.sin(angle)), 0, labels.shape[0] - 1).astype(int)
        columns = np.clip(np.floor(column + (radius + shift) * np.cos(angle)), 0, labels.shape[1] - 1).astype(int)
        hit |= labels[rows, columns] == OCCUPIED
    return float(hit.mean())


def templates(labels: Array, radius: float) -> Found:
    """Half rings in 16 directions with free cells before them, by correlation; the score is the correlation."""
    times = max(1, math.ceil(6.0 / radius - 1e-9))
    labels = np.repeat(np.repeat(labels, times, axis=0), times, axis=1)
    occupied = cv2.dilate((labels == OCCUPIED).astype(np.uint8), cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)))
    signed = np.where(occupied > 0, np.float32(1), np.where(labels == 0, np.float32(-1), np.float32(0)))
    found: Found = []
    for k in range(DIRECTIONS):
        facing = 2 * math.pi * k / DIRECTIONS
        kernel = half_ring(radius * times, facing)
        response = cv2.filter2D(signed, cv2.CV_32F, kernel, borderType=cv2.BORDER_CONSTANT)
        peaks = (response > 1.0) & (response >= cv2.dilate(response, np.ones((3, 3), np.uint8)))
        found += [
            ((float(i) + 0.5) / times, (float(j) + 0.5) / times, facing, float(response[i, j]))
            for i, j in np.argwhere(peaks)
        ]
    return suppressed(found, radius / 2)


def half_ring(radius: float, facing: float) -> Array:
    """+1 in all on half a ring, -0.6 in all on the free half ring before it."""
    reach = math.ceil(radius + 5)
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1].astype(float)
    away = np.hypot(x, y)
    half = np.cos(np.arctan2(y, x) - facing) > math.cos(math.radians(80))
    ring = half & (np.abs(away - radius) <= 0.6)
    before = half & (away > radius + 2) & (away <= radius + 4)
    return np.asarray(ring / ring.sum() - before * (0.6 / before.sum()), np.float32)


def skimage_hough(labels: Array, radius: float) -> Found:
    """scikit-image hough_circle on the occupied cells; the score is the share of the circle that voted."""
    transform: Any = import_module("skimage.transform")
    radii = np.unique(np.round([radius, radius + 0.7])).astype(int)
    spaces = transform.hough_circle(labels == OCCUPIED, radii, normalize=True)
    near = max(1, round(radius / 4))
    scores, x, y, _ = transform.hough_circle_peaks(spaces, radii, near, near, 0.3)
    found: Found = [(float(b) + 0.5, float(a) + 0.5, None, float(s)) for s, a, b in zip(scores, x, y, strict=True)]
    return suppressed(found, radius / 3)


def suppressed(found: Found, near: float) -> Found:
    """The best of each place (and direction, within 60 degrees)."""
    if not found:
        return []
    found = sorted(found, key=lambda one: -one[3])
    places = np.array([one[:2] for one in found])
    facings = np.array([0.0 if one[2] is None else one[2] for one in found])
    alive = np.ones(len(found), bool)
    kept: Found = []
    for k, one in enumerate(found):
        if alive[k]:
            kept.append(one)
            close = np.hypot(*(places - places[k]).T) < near
            alive &= ~(close & (np.cos(facings - facings[k]) > 0.5))
    return kept


TOOLS: dict[str, Callable[[Array, float], Found]] = {
    "OpenCV HoughCircles": hough_circles,
    "EdgeDrawing ellipses": edge_drawing,
    "half-ring templates": templates,
    "scikit-image hough_circle": skimage_hough,
}


def work(job: tuple[str, str, float, list[str], int]) -> tuple[str, dict[str, dict[str, object]]]:
    """Tools on one map, so many times each, of which the fastest counts."""
    folder, name, radius, tools, runs = job
    cv2.setNumThreads(1)
    labels = np.load(Path(folder) / f"{name}.npy")
    results: dict[str, dict[str, object]] = {}
    for tool in tools:
        TOOLS[tool](np.ascontiguousarray(labels[:64, :64]), radius)  # first calls set things up
        seconds = []
        for _ in range(runs):
            start = time.process_time()
            found = TOOLS[tool](labels, radius)
            seconds.append(time.process_time() - start)
        results[tool] = {"seconds": min(seconds), "found": found}
    return name, results


def main() -> int:
    """Run all and write; what is to be timed runs alone, in the end."""
    folder = Path(sys.argv[1])
    maps = json.loads((folder / "maps.json").read_text(encoding="utf-8"))
    jobs = [(str(folder), m["name"], m["radius"], m["tools"] or list(TOOLS), m["runs"]) for m in maps]
    results: dict[str, dict[str, dict[str, object]]] = {}
    for timed, processes in ((False, 2), (True, 1)):
        with Pool(processes) as pool:
            results |= dict(pool.imap_unordered(work, [job for job in jobs if (job[-1] > 1) == timed]))
    (folder / "peers.json").write_text(json.dumps(results), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
