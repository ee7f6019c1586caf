"""`./run bench evening`: how long a referee waits; writes its section of docs/benchmarks.md.

Twenty maps of 2000 x 2000 cells with 20 parts, scored with reports; one small map without; `--help`. Whole processes,
timed from outside, with the operating system's account of the largest of them.
"""

from __future__ import annotations

import compileall
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image

from benchmarks.page import table, write_section
from fidmap.arena.write import write_arena
from fidmap.maps.write import write_map
from fidmap.synth.evening import evening

MAPS, CELLS = 20, 2000
FIDMAP = [sys.executable, "-m", "fidmap"]


def timed(arguments: list[str], times: int = 3) -> tuple[float, float]:
    """Median wall seconds of a command, and its peak memory in MB (of the largest process so far)."""
    seconds = []
    for _ in range(times):
        start = time.perf_counter()
        subprocess.run([*FIDMAP, *arguments], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        seconds.append(time.perf_counter() - start)
    return float(np.median(seconds)), resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


def decoding_seconds(folder: Path) -> float:
    """The peer: Pillow and numpy decoding the same images in one process, nothing else."""
    start = time.perf_counter()
    for path in sorted(folder.glob("*.pgm")):
        np.asarray(Image.open(path))
    return time.perf_counter() - start


def main() -> int:
    """Measure and write."""
    root = Path(__file__).resolve().parents[1]
    compileall.compile_dir(root / "src", quiet=1)  # as pip does with what it installs
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        arena, maps = evening(maps=MAPS, cells=CELLS)
        write_arena(folder / "arena.yaml", arena.arena)
        for map_name, grid in maps:
            write_map(folder, map_name, grid)
        big = [str(path) for path in sorted(folder.glob("*.yaml")) if path.name != "arena.yaml"]
        demo = root / "src/fidmap/demo_data"
        help_seconds, _ = timed(["--help"], 5)
        small, _ = timed(["score", str(demo / "good.yaml"), "--arena", str(demo / "arena.yaml")], 5)
        out = folder / "reports"
        seconds, peak = timed(["score", *big, "--arena", str(folder / "arena.yaml"), "--out", str(out)], 1)
        pages = [path.stat().st_size / 1e6 for path in out.glob("*/report.html")]
        decoding = decoding_seconds(folder)
    rows = [
        [f"{MAPS} maps of {CELLS} x {CELLS} cells, 20 parts, with reports", f"{seconds:.1f} s", "<= 60 s"],
        ["largest page", f"{max(pages):.2f} MB ({len(pages)} pages)", "<= 2 MB"],
        ["peak memory of the largest process", f"{peak:.0f} MB", "<= 1000 MB"],
        ["the same against Pillow decoding the same images alone", f"{seconds / decoding:.0f} times", ""],
        ["one map of about 200 x 200 cells, without reports", f"{small:.2f} s", "<= 2 s"],
        ["`fidmap --help`", f"{help_seconds:.2f} s", "<= 0.5 s"],
    ]
    text = f"## A referee's evening\n\nOn {os.cpu_count()} cores, from process start.\n\n"
    text += table(["what", "figure", "goal"], rows)
    write_section("evening", text)
    sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
