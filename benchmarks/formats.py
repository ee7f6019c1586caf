"""`./run bench formats [WORD ...]`: every format's reader on the same map; writes its section of docs/benchmarks.md.

Times and memory of 4000 x 4000 cells, each format in a process of its own, beside its library's own decoding; and
the same arena map written in every format, scored. With words only the rows that contain one, and nothing is written.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.detect_speed import tiled
from benchmarks.format_rows import ROWS
from benchmarks.object_lists import scored_lists
from benchmarks.page import table, write_section
from benchmarks.rows import Row
from fidmap.evaluate import evaluate
from fidmap.maps import read_map
from fidmap.maps.tables import look_up
from fidmap.model import Arena, Grid, Report
from fidmap.synth.suite import CaseSpec, case_rng, make_case

CELLS, SEED, RESOLUTION_M = 4000, 11, 0.05
ATTRIBUTES = ("coverage", "relative_accuracy", "consistency", "overall")
SPEED_HEAD = ["format", "own decode", "read_map", "limit", "bytes per pixel beyond the image"]
RULE = f"""Square pictures of {CELLS} pixels a side; CPU milliseconds of one thread, the best of three. Own decode:
Pillow's, or the format's library. The limit is three times that plus one pass (a table look-up over all cells). Memory
is the peak of `read_map` beyond the decoded image; the goal is 6 bytes per cell, of which the grid itself takes 4.
Rescue maps have 9 pixels per cell; Pillow holds a colour picture in 4 bytes per pixel, of which the array has 3.
"""
OVER = """What is over, here or in other runs on a shared machine, and why. **PGM, BMP**: Pillow maps the file into
memory and copies it once, in 6 to 36 ms from run to run; reading, hashing, counting greys and the table look-up take 60
and more. A BMP is moreover decoded from the bytes that were hashed, not from the mapped file: two more copies.
**PLY, PCD**: the raw read, or the
library, copies bytes and looks at no point. A map needs their extent, the floor and which way is up, then each
point's height and cell, so all points are read twice, and once more for the hash; numpy takes {plain:.0f} ms to count
ten million points over cells, without any of this. **OctoMap**: a tree this small is decoded in less time than the
floor is found. **RoboCup JPEG** lies at its limit, below or above it from run to run.
**GeoJSON**: Python's json makes lists of numbers and no shapes. **PCD, compressed**: its library
holds the unpacked points twice.
"""
SAME = """One arena map (a clean artificial one, test split), written in every format and scored: attributes in
points of a hundred, and the largest difference to the PGM. Lists hold the parts that were assigned in it, under their
names and without facings.
"""


def arena_map() -> tuple[Arena, Grid]:
    """The map whose scores are compared."""
    case = make_case(case_rng("test", SEED, "clean", 0), CaseSpec(resolution_m=RESOLUTION_M))
    return case.arena.arena, case.grid


def large(grid: Grid, side: int) -> Grid:
    """The same map as tiles of a large one."""
    return Grid(tiled(grid.occupancy, side), grid.resolution_m)  # type: ignore[arg-type]


def speed_row(row: Row, grid: Grid, folder: Path) -> list[str]:
    """Write the map, measure it in processes of its own, and compare with the limit."""
    path = row.write(folder, large(grid, CELLS // row.across))
    seconds = _alone("time", row, path)
    memory = _alone("memory", row, path)
    limit = 3 * seconds["decode"] + seconds["pass"]
    beyond = (memory["peak"] - memory["decoded"]) / CELLS**2
    shutil.rmtree(folder)
    folder.mkdir()
    return [
        row.name,
        f"{1e3 * seconds['decode']:.0f}",
        f"{1e3 * seconds['read']:.0f}{' (over)' * (seconds['read'] > limit)}",
        f"{1e3 * limit:.0f}",
        f"{beyond:.1f}{' (over)' * (beyond > 6)}",
    ]


def _alone(mode: str, row: Row, path: Path) -> dict[str, float]:
    command = [sys.executable, "-m", "benchmarks.formats", f"--{mode}", row.name, str(path)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    result: dict[str, float] = json.loads(done.stdout)
    return result


def measured(mode: str, name: str, path: Path) -> dict[str, float]:
    """What a process of its own measures: CPU seconds, or the growth of its peak memory in bytes."""
    row = next(row for row in ROWS if row.name == name)
    if mode == "--memory":
        # Not getrusage: its maximum includes what the parent had when it made this process.
        Path("/proc/self/clear_refs").write_text("5")
        before = _peak()
        read_map(path, **row.options)
        return {"peak": _peak() - before, "decoded": row.decode(path)}
    codes, floats = np.zeros((CELLS, CELLS), np.uint8), np.zeros(256, np.float32)
    return {
        "decode": _best(lambda: row.decode(path)),
        "read": _best(lambda: read_map(path, **row.options)),
        "pass": _best(lambda: look_up(floats, codes)),
    }


def _peak() -> int:
    """Peak memory of this process in bytes, since it was last reset (Linux)."""
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    return 1024 * int(line.split()[1])


def _best(work: Callable[[], object]) -> float:
    """Least CPU seconds of three runs, or of one that takes long."""
    times: list[float] = []
    while len(times) < 3 and sum(times) < 3:
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def score_rows(rows: list[Row], folder: Path) -> list[list[str]]:
    """Scores of one map in every format, and how far they lie from the PGM's."""
    arena, grid = arena_map()
    first = evaluate(read_map(ROWS[0].write(folder, grid)), arena)
    lines = [_score_line(name, report, first, 1.0) for name, report in scored_lists(first, folder)]
    for number, row in reversed(list(enumerate(rows))):
        place = folder / f"score{number}"
        place.mkdir()
        report = evaluate(read_map(row.write(place, grid), **row.options), arena)
        lines.insert(0, _score_line(row.name, report, first, row.points))
    return lines


def _score_line(name: str, report: Report, first: Report, most: float) -> list[str]:
    points = _points(report)
    apart = max(abs(a - b) for a, b in zip(points, _points(first), strict=True))
    return [name, *(f"{value:.1f}" for value in points), f"{apart:.2f}{' (over)' * (apart > most)}"]


def plain_counting() -> float:
    """Milliseconds of numpy for ten million points over 4000 x 4000 cells: places to cells, then counts."""
    xy = np.random.default_rng(0).random((2, 10_000_000), np.float32) * np.float32(CELLS)
    return 1e3 * _best(lambda: np.bincount(xy[1].astype(np.int32) * CELLS + xy[0].astype(np.int32), minlength=CELLS**2))


def _points(report: Report) -> list[float]:
    values = {**report.attributes.by_name, "overall": report.attributes.overall}
    return [100 * (values[name].value or 0.0) for name in ATTRIBUTES]


def main() -> int:
    """Measure, print, and write unless only some formats were asked for."""
    words = sys.argv[1:]
    if words and words[0] in {"--time", "--memory"}:
        print(json.dumps(measured(words[0], words[1], Path(words[2]))))
        return 0
    rows = [row for row in ROWS if not words or any(word.lower() in row.name.lower() for word in words)]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        grid = arena_map()[1]
        (folder / "speed").mkdir()
        text = "## Formats\n\n" + RULE + "\n"
        text += table(SPEED_HEAD, [speed_row(row, grid, folder / "speed") for row in rows])
        text += "\n" + OVER.format(plain=plain_counting()) + "\n" + SAME + "\n"
        text += table(["format", *(a.replace("_", " ") for a in ATTRIBUTES), "apart"], score_rows(rows, folder))
    if not words:
        write_section("formats", text)
    sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
