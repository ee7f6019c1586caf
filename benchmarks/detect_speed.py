"""Speed, growth and memory of the detector, each in a process of its own with one thread.

    python -m benchmarks.detect_speed MODE LABELS.npy RADIUS_CELLS

MODE `time` prints the CPU seconds of one search, the least of some; `memory` the bytes that a search takes at its peak
beyond the process that holds the `TrinaryGrid`.
"""

from __future__ import annotations

import math
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fidmap.detect import find_barrel_parts
from fidmap.model import Label, TrinaryGrid

RESOLUTION_M = 0.02
SIZES = (500, 700, 1000, 2000, 4000)
ROUNDS = 4  # processes for each, one after the other: machines that others use have slow seconds
Labels = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Speed:
    """CPU seconds by side of a square map in cells, and peak memory of the largest in bytes per cell."""

    seconds: dict[int, float]
    bytes_per_cell: float

    def per_mcell_ms(self, side: int) -> float:
        """Milliseconds per million cells."""
        return 1e9 * self.seconds[side] / side**2

    @property
    def exponent(self) -> float:
        """Slope of log seconds over log cells, by least squares."""
        sides = np.array(sorted(self.seconds), float)
        return float(np.polyfit(2 * np.log(sides), np.log([self.seconds[int(s)] for s in sides]), 1)[0])


def mapped_part(labels: Labels) -> Labels:
    """The map without its unknown rim."""
    rows, columns = (np.flatnonzero((labels == Label.OCCUPIED).any(axis=axis)) for axis in (1, 0))
    return labels[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]


def measure(tile: Labels, radius: float, folder: Path) -> Speed:
    """Search squares tiled with one map, so that large and small ones are equally full of walls."""
    seconds = dict.fromkeys(SIZES, math.inf)
    for side in SIZES:
        np.save(_path(folder, side), tiled(tile, side))
    for side in SIZES * ROUNDS:
        seconds[side] = min(seconds[side], float(_alone("time", _path(folder, side), radius)))
    taken = float(_alone("memory", _path(folder, SIZES[-1]), radius))
    return Speed(seconds, taken / SIZES[-1] ** 2)


def tiled(tile: Labels, side: int) -> Labels:
    """A square of so many cells."""
    times = [-(-side // n) for n in tile.shape]
    return np.ascontiguousarray(np.tile(tile, times)[:side, :side])


def runs(side: int) -> int:
    """How often a process searches a square."""
    return 15 if side <= 1000 else 2


def name_of(side: int) -> str:
    """Under which the peers find a square."""
    return f"speed-{side}"


def _path(folder: Path, side: int) -> Path:
    return folder / f"{name_of(side)}.npy"


def _alone(mode: str, path: Path, radius: float) -> str:
    command = [sys.executable, "-m", "benchmarks.detect_speed", mode, str(path), str(radius)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def main() -> int:
    """What the processes of their own do."""
    mode, path, radius = sys.argv[1:]
    radius_m = float(radius) * RESOLUTION_M
    grid = TrinaryGrid(np.load(path), RESOLUTION_M)
    find_barrel_parts(TrinaryGrid(np.ascontiguousarray(grid.labels[:400, :400]), RESOLUTION_M), radius_m)
    if mode == "memory":
        print(_peak_bytes(grid, radius_m))
        return 0
    times = []
    for _ in range(runs(grid.labels.shape[0])):
        start = time.process_time()
        find_barrel_parts(grid, radius_m)
        times.append(time.process_time() - start)
    print(min(times))
    return 0


def _peak_bytes(grid: TrinaryGrid, radius_m: float) -> int:
    """Growth of the process's peak: nothing before it was larger, since the labels were read as they are."""
    before = _peak_kib()
    find_barrel_parts(grid, radius_m)
    return (_peak_kib() - before) * 1024


def _peak_kib() -> int:
    """The peak of this program's memory; that of `getrusage` begins with what the process that started it had."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(status.split("VmHWM:")[1].split()[0])


if __name__ == "__main__":
    sys.exit(main())
