"""`./run bench doctor [SPLIT SEED]`: how often a map that does not go with its arena is told, and a sound one is not.

Artificial and real maps as they are, at a wrong resolution, beside a wrong radius, turned over, and beside another
arena. Thresholds were chosen on the split 'tune' (seeds 101, 102) and on the real maps; the page shows 'test'.
"""

from __future__ import annotations

import csv
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from benchmarks.page import table, write_section
from benchmarks.slam_challenge import real_data_root
from fidmap.arena import read_arena
from fidmap.detect import find_barrel_parts
from fidmap.grid import trinarize
from fidmap.inspect.against import arena_findings
from fidmap.maps import read_map
from fidmap.model import CONTINUOUS, Arena, Grid
from fidmap.register import register
from fidmap.synth.poses import Tier
from fidmap.synth.suite import Split, suite

TIERS: tuple[Tier, ...] = ("exact", "clean", "noisy", "broken", "office", "field")
EACH = 5
LEAST_PARTS = 5


@dataclass(frozen=True)
class Case:
    """A map with its arena, and the arena of another map of its kind."""

    kind: str
    grid: Grid
    arena: Arena
    other: Arena


def artificial(split: Split, seed: int) -> Iterator[Case]:
    """Five maps of each tier."""
    for tier in TIERS:
        made = list(suite(split, seed, EACH, tier))
        for one, next_one in zip(made, [*made[1:], made[0]], strict=True):
            arena = one.arena.arena
            other = replace(next_one.arena.arena, radius_m=arena.radius_m)
            yield Case("artificial, broken" if tier == "broken" else "artificial", one.grid, arena, other)


def real() -> Iterator[Case]:
    """The SLAM maps, playpen and the simulated worlds; nothing where they are missing."""
    data = real_data_root()
    if not data.is_dir():
        return
    folder = data / "slam_challenge"
    arenas = {name: read_arena(folder / f"{name}.arena.yaml") for name in ("A2", "R2")}
    for row in csv.DictReader((folder / "quality.csv").open(encoding="utf-8")):
        other = arenas["R2" if row["arena"] == "A2" else "A2"]
        yield Case("real", read_map(folder / "maps" / f"{row['map']}.yaml"), arenas[row["arena"]], other)
    for place in ("playpen", "tb3_world"):
        arena = read_arena(data / place / "arena.yaml")
        for path in sorted((data / place).glob("*.yaml")):
            if path.name != "arena.yaml":
                yield Case("real", read_map(path), arena, replace(arenas["A2"], radius_m=arena.radius_m))


def variants(case: Case) -> Iterator[tuple[str, Grid, Arena]]:
    """The map with one fault at a time; the name says which."""
    grid, arena = case.grid, case.arena
    yield "sound", grid, arena
    for factor in (0.8, 0.9, 1.1, 1.25):
        yield f"resolution x {factor}", replace(grid, resolution_m=grid.resolution_m * factor), arena
    for factor in (0.75, 0.9, 1.1, 1.25):
        yield f"radius x {factor}", grid, replace(arena, radius_m=arena.radius_m * factor)
    labels = None if grid.labels is None else grid.labels[::-1]
    yield "mirrored", replace(grid, occupancy=grid.occupancy[::-1], labels=labels), arena
    yield "another arena", grid, case.other


def told(grid: Grid, arena: Arena) -> tuple[str, int, float, float]:
    """Codes (radius below two cells: 'error'), sure arcs, CPU seconds of the findings and of detection and search."""
    if arena.radius_m < 2 * grid.resolution_m:
        return "error", 0, 0.0, 0.0
    start = time.process_time()
    parts = find_barrel_parts(trinarize(grid), arena.radius_m)
    assignment = register(parts, arena, CONTINUOUS, fast=True)
    middle = time.process_time()
    found = arena_findings(parts, assignment, arena, CONTINUOUS, grid)
    sure = sum(part.confidence >= CONTINUOUS.min_confidence for part in parts)
    return ", ".join(f.code for f in found) or "nothing", sure, time.process_time() - middle, middle - start


def main() -> int:
    """Measure; write the page for the split 'test'."""
    split: Split = "tune" if sys.argv[1:2] == ["tune"] else "test"
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 7
    counts: dict[tuple[str, str], Counter[str]] = {}
    seconds: dict[str, list[tuple[float, float]]] = {}
    for case in chain(artificial(split, seed), real()):
        enough = ""
        for name, grid, arena in variants(case):
            code, sure, extra, rest = told(grid, arena)
            if name == "sound":
                enough = "" if sure >= LEAST_PARTS else ", fewer than 5 arcs"
            counts.setdefault((name, case.kind + enough), Counter())[code] += 1
            seconds.setdefault(name, []).append((extra, rest))
            sys.stderr.write(
                f"{name:18s} {case.kind:18s} {case.grid.source.name[-28:]:28s} {sure:3d} {extra:.3f} {code}\n"
            )
    rows = [
        [name, kind, sum(found.values()), ", ".join(f"{_code(code)} {n}" for code, n in found.most_common())]
        for (name, kind), found in sorted(counts.items(), key=lambda entry: list(seconds).index(entry[0][0]))
    ]
    costs = [
        [name, f"{1000 * np.median([e for e, _ in s]):.0f}", f"{1000 * max(e for e, _ in s):.0f}",
         f"{1000 * np.median([r for _, r in s]):.0f}"]
        for name, s in seconds.items()
    ]  # fmt: skip
    text = (
        f"## Maps that do not go with their arena\n\nSplit {split}, seed {seed}; real maps are those of the tuning.\n\n"
    )
    text += table(["fault", "maps", "number", "findings"], rows)
    text += "\nCPU time of these findings beside that of finding and placing the parts, ms.\n\n"
    text += table(["fault", "median", "most", "parts, median"], costs)
    if split == "test":
        write_section("doctor", text)
    sys.stdout.write(text)
    return 0


def _code(code: str) -> str:
    return code if code in {"nothing", "error"} else f"`{code}`"


if __name__ == "__main__":
    sys.exit(main())
