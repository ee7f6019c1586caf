"""`./run bench detect [--quick]`: how well barrel parts are found; writes its section of docs/benchmarks.md.

Artificial maps of the test split, which nothing is tuned on, and real ones where they are; other people's tools on the
same maps. `--quick` takes few maps of the tune split, asks no other tools and writes nothing: for daily work,
which must not look at test data.
"""

from __future__ import annotations

import csv
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks import detect_ladder, detect_speed, detect_tables, peer_env
from benchmarks.detect_maps import SEED, Job, Tried, attempt, died
from benchmarks.detect_speed import RESOLUTION_M, Speed
from benchmarks.page import PAGE, write_section
from benchmarks.plot import write_calibration
from benchmarks.sheet import worst, write_sheet
from benchmarks.slam_challenge import real_data_root
from fidmap.grid import trinarize
from fidmap.study.pool import run
from fidmap.synth.arena import ArenaSpec
from fidmap.synth.poses import tier_noise
from fidmap.synth.suite import CaseSpec, Split, case_rng, make_case

FULL = {"clean": 40, "noisy": 40, "broken": 40, "large": 6, "office": 40, "field": 40}
QUICK = {"clean": 6, "noisy": 6, "broken": 6, "large": 0, "office": 6, "field": 6}
IMAGES = PAGE.parent / "images"
RADIUS_CELLS = 0.3 / RESOLUTION_M
RULE = f"""Parts that a map draws, found one to one within 0.15 m and 60 degrees of facing, by confidence; parts drawn
but below two thirds, and other copies of a part, count neither way; a part found twice is one true and one false
detection. F1 at confidence 0.5, AP (not interpolated) over all maps of a tier. Artificial maps are the test split of
`fidmap synth suite`, seed {SEED}, with radii of 0.12 to 0.45 m (0.30 m in six of ten) and all mappers.
Goals in brackets.
"""
PRECISION = """Of the true detections; sigma is honest where its two figures are 1 (mean and median of the squared error
over the variance it states). It was learned from where a part's scans put it, which lies farther off than what a map
shows of it and is truth here, so it is rather too careful (docs/decisions, 0037).
"""
PEERS = """The other tools' F1 is at the confidence that is best in hindsight, tier by tier, which flatters them. All
but the templates give no facing, so their centres are compared alone. Milliseconds are of one thread's CPU.
Each was tuned by hand over some ten settings on 24 maps of the tune split: more patience would better them, the
templates above all.
"""
SPEED = """One map tiled to squares, cells of 2 cm; the least time of 60 searches in four processes, or of 8 where there
are more than a million cells; HoughCircles' least of as many. The squares are dense with walls, as maps of the large
tier above (1500 to 4000 cells a side) are not.
"""


def main() -> int:
    """Measure, print, and write unless in haste."""
    quick = "--quick" in sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        jobs = (
            _jobs(QUICK, None, "tune") + detect_ladder.jobs(1, "tune")
            if quick
            else _jobs(FULL, folder, "test") + detect_ladder.jobs(24, "test")
        )
        tried = attempts(jobs)
        groups = detect_tables.groups_of(tried)
        text = _accuracy(groups, tried, None if quick else IMAGES / "detect-centres.svg")
        if not quick:
            text += _beside_peers(groups, folder)
            text += _pictures(groups)
            write_section("detect", text)
    sys.stdout.write(text)
    return 0


def _jobs(numbers: dict[str, int], folder: Path | None, split: Split) -> list[Job]:
    """The large maps first: they take longest."""
    jobs = [
        Job(tier, k, folder=folder, split=split)
        for tier in sorted(numbers, key=lambda t: t != "large")
        for k in range(numbers[tier])
    ]
    quality = real_data_root() / "slam_challenge" / "quality.csv"
    if quality.is_file():
        rows = csv.DictReader(quality.read_text(encoding="utf-8").splitlines())
        jobs += [
            Job(row["arena"], real=row["map"], folder=folder) for row in rows if split == "test" or row["arena"] == "A2"
        ]
    return jobs


def attempts(jobs: Sequence[Job]) -> list[Tried]:
    """All maps, on two processes of one thread each."""
    found = []
    for number, tried in enumerate(run(jobs, attempt, died, 2), start=1):
        found.append(tried)
        if number % 20 == 0 or number == len(jobs):
            sys.stderr.write(f"{number} of {len(jobs)} maps\n")
    return found


def _accuracy(groups: detect_tables.Groups, tried: Sequence[Tried], picture: Path | None) -> str:
    artificial = [t for name in detect_tables.TIERS for t in groups.get(name, [])]
    text = f"## Barrel parts found\n\n{RULE}\n{detect_tables.tier_table(groups)}\n"
    text += f"{PRECISION}\n{detect_tables.precision_table(groups)}\n"
    text += detect_ladder.section(tried, picture)
    text += f"### What confidence is worth\n\n{detect_tables.calibration_table(artificial, groups.get('R2', []))}\n"
    return text


def _beside_peers(groups: detect_tables.Groups, folder: Path) -> str:
    """Other tools, and speed in the same run."""
    ours = speed(folder)
    sides = {side: detect_speed.name_of(side) for side in ours.seconds}
    maps = [(t.name, t.radius_m / t.resolution_m) for found in groups.values() for t in found]
    maps += [(name, RADIUS_CELLS) for name in sides.values()]
    timed = {name: detect_speed.ROUNDS * detect_speed.runs(side) for side, name in sides.items()}
    answers = peer_env.ask(folder, maps, timed)
    hough = {side: answers[peer_env.HOUGH][name].seconds for side, name in sides.items()}
    text = f"### Beside other tools\n\n{PEERS}\n{detect_tables.peer_table(groups, answers)}\n"
    return text + f"### Speed\n\n{SPEED}\n{detect_tables.speed_table(ours, hough)}\n"


def speed(folder: Path) -> Speed:
    """Time and memory on squares tiled with a clean maze."""
    rng = case_rng("test", SEED, "clean", 10_000)
    spec = CaseSpec(
        ArenaSpec(pairs=6, wholes=1, singles=1, clutter=5), noise=tier_noise("clean", rng), resolution_m=RESOLUTION_M
    )
    grid = trinarize(make_case(rng, spec).grid)
    return detect_speed.measure(detect_speed.mapped_part(np.array(grid.labels)), RADIUS_CELLS, folder)


def _pictures(groups: detect_tables.Groups) -> str:
    """Write them and say where they are."""
    artificial = [t for name in detect_tables.TIERS for t in groups.get(name, [])]
    faults = [fault for t in artificial for fault in t.faults]
    write_sheet(IMAGES / "detect-misses.png", worst(faults, "miss"))
    write_sheet(IMAGES / "detect-false-finds.png", worst(faults, "false"))
    curves = [("artificial maps", "#0072b2", detect_tables.reliability(artificial))]
    if "R2" in groups:
        curves.append(("real office (R2)", "#d55e00", detect_tables.reliability(groups["R2"])))
    write_calibration(IMAGES / "detect-calibration.svg", curves)
    return """![Share of true detections over confidence](images/detect-calibration.svg)

### What to mend

Drawn best and missed at confidence 0.5, tier by tier: the part (blue), the share of it that the map draws, and the
confidence of the best detection that would have been right.

![Misses](images/detect-misses.png)

The surest false finds, tier by tier.

![False finds](images/detect-false-finds.png)
"""


if __name__ == "__main__":
    sys.exit(main())
