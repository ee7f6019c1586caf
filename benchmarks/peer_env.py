"""The peers' environment `.venv-bench`, and their run: opencv-contrib beside opencv-headless breaks `cv2` for both."""

from __future__ import annotations

import hashlib
import json
import math
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.counting import Count, count
from benchmarks.detect_maps import Tried
from fidmap.grid import cells_to_metres
from fidmap.model import BarrelPart

ROOT = Path(__file__).resolve().parents[1]
VENV, LOCK = ROOT / ".venv-bench", ROOT / "requirements-bench.lock"
HOUGH = "OpenCV HoughCircles"


def set_up() -> Path:
    """Make the environment once, as `run` makes the program's; returns its Python."""
    stamp, python = VENV / "fidmap.stamp", VENV / "bin" / "python"
    wanted = hashlib.sha256(LOCK.read_bytes() + sys.version.encode() + str(ROOT).encode()).hexdigest()
    if stamp.is_file() and stamp.read_text() == wanted:
        return python
    print("setting up .venv-bench (once, about 20 s) ...", file=sys.stderr, flush=True)
    # this process runs in .venv, which has no pip: the Python that it was made from has
    base = str(Path(sys.base_prefix) / "bin" / f"python{sys.version_info.major}.{sys.version_info.minor}")
    subprocess.run([base, "-m", "venv", "--clear", "--without-pip", str(VENV)], check=True)
    pip = [base, "-m", "pip", "--python", str(python), "--disable-pip-version-check", "install", "-qq"]
    subprocess.run([*pip, "--require-hashes", "-r", str(LOCK)], check=True)
    stamp.write_text(wanted)
    return python


@dataclass(frozen=True)
class Answer:
    """What one tool did on one map: CPU seconds of one thread, and [row, column, facing or null, score] each."""

    seconds: float
    found: list[tuple[float, float, float | None, float]]


Answers = dict[str, dict[str, Answer]]


def ask(folder: Path, maps: Sequence[tuple[str, float]], timed: Mapping[str, int]) -> Answers:
    """Run all tools on the maps saved in a folder; the answers by tool and map.

    Args:
        folder: holds NAME.npy of each map.
        maps: names, and radii in cells.
        timed: maps that only HoughCircles gets, for its speed, and how many times.
    """
    rows = [
        {"name": name, "radius": radius, "tools": [HOUGH] if name in timed else None, "runs": timed.get(name, 1)}
        for name, radius in maps
    ]
    (folder / "maps.json").write_text(json.dumps(rows), encoding="utf-8")
    subprocess.run([set_up(), ROOT / "benchmarks" / "peers.py", folder], check=True)
    raw = json.loads((folder / "peers.json").read_text(encoding="utf-8"))
    answers: Answers = {}
    for name, tools in raw.items():
        for tool, answer in tools.items():
            answers.setdefault(tool, {})[name] = Answer(answer["seconds"], [tuple(one) for one in answer["found"]])
    return answers


def counted(answer: Answer, tried: Tried) -> Count:
    """A tool's finds on a map against its truth."""
    places = np.array([one[:2] for one in answer.found], float).reshape(-1, 2)
    places = cells_to_metres(places, tried.resolution_m, tried.origin)
    detections = [
        BarrelPart(
            n, float(x), float(y), None if facing is None else facing + tried.origin.yaw, math.pi, confidence=score
        )
        for n, ((x, y), (_, _, facing, score)) in enumerate(zip(places, answer.found, strict=True), start=1)
    ]
    return count(detections, tried.parts, tried.radius_m)
