"""Do intervals hold what they say? Simulated arenas with a known truth, by number of parts and by noise.

    ./run bench uncertainty [--quick] [--arenas N] [--seed N]

`--quick` looks at few arenas and writes no page; nor does a seed that was tuned on.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from benchmarks.page import PAGE, table, write_section
from benchmarks.uncertainty_arenas import Cell, Mapper, Scored, scored
from benchmarks.uncertainty_order import order_section
from benchmarks.uncertainty_picture import write_coverage
from fidmap.model import CONTINUOUS, SSRR2011, Attributes, Interval, Settings, Span, Value
from fidmap.uncertainty import with_intervals

PICTURE = PAGE.parent / "images" / "uncertainty.svg"
TUNED_ON, REPORTED = 1, 3
NAMES = ("coverage", "relative_accuracy", "global_accuracy", "consistency", "overall")
CELLS = [Cell(n, s, c) for n in (10, 20, 50, 200) for s in (0.0, 0.02, 0.05) for c in (0.01, 0.04)]
BROKEN = replace(Mapper(), broken=0.05)
# the studies beside the main one: their name, mapper and profile
BESIDE = (
    ("5 % of the fiducials 0.3 m (per axis) off", BROKEN, CONTINUOUS),
    ("profile ssrr2011", Mapper(), SSRR2011),
)


@dataclass
class Tally:
    """How often a truth lay inside, of how many intervals, and how wide they were."""

    inside: int = 0
    count: int = 0
    width: float = 0.0

    def add(self, span: Span, truth: float) -> None:
        """Count one interval, unless there is none."""
        if span.low is not None and span.high is not None:
            self.inside += span.low - 1e-9 <= truth <= span.high + 1e-9
            self.count += 1
            self.width += span.high - span.low

    @property
    def share(self) -> float:
        """Of intervals that hold the truth."""
        return self.inside / max(1, self.count)


@dataclass
class Row:
    """One cell: a tally per attribute, of measurement and of population intervals; CPU seconds per map."""

    cell: Cell
    measurement: dict[str, Tally] = field(default_factory=lambda: {n: Tally() for n in NAMES})
    population: dict[str, Tally] = field(default_factory=lambda: {n: Tally() for n in NAMES})
    seconds: float = 0.0


def studied(cell: Cell, mapper: Mapper, settings: Settings, seed: int, arenas: int) -> Row:
    """Score so many arenas; the population's truth is the mean score of all of them."""
    row, spans, values = Row(cell), [], []
    for k in range(arenas):
        random = np.random.default_rng([seed, cell.parts, round(1e3 * cell.survey_m), round(1e3 * cell.centre_m), k])
        one = scored(random, cell, mapper, settings)
        start = time.thread_time()
        found = with_intervals(one.measured, one.arena, one.assignment, settings)
        row.seconds += (time.thread_time() - start) / arenas
        spans.append(_intervals(found))
        values.append(_values(one))
        for name, interval in spans[-1].items():
            if (truth := _every(one.true)[name].value) is not None:
                row.measurement[name].add(interval.measurement, truth)
    for name in NAMES:
        known = [v[name] for v in values if name in v]
        for one_map in spans:
            if name in one_map and known:
                row.population[name].add(one_map[name].population, float(np.mean(known)))
    return row


def _every(found: Attributes) -> dict[str, Value]:
    return {**found.by_name, "overall": found.overall}


def _intervals(found: Attributes) -> dict[str, Interval]:
    return {n: v.interval for n, v in _every(found).items() if n in NAMES and v.interval is not None}


def _values(one: Scored) -> dict[str, float]:
    return {n: v.value for n, v in _every(one.measured).items() if v.value is not None}


def shown(rows: Iterable[Row], kind: str) -> str:
    """One line per cell: shares of intervals that hold the truth, in percent."""
    lines = []
    for row in rows:
        tallies = row.measurement if kind == "measurement" else row.population
        shares = [f"{100 * tallies[n].share:.1f}" for n in NAMES]
        width = 100 * tallies["overall"].width / max(1, tallies["overall"].count)
        cell = row.cell
        lines.append([cell.parts, f"{100 * cell.survey_m:.0f}", f"{100 * cell.centre_m:.0f}", *shares, f"{width:.1f}"])
    head = ("N", "survey, cm", "centres, cm", *(n.replace("_", " ") for n in NAMES), "width of overall, points")
    return table(head, lines)


def section(rows: list[Row], beside: list[tuple[str, list[Row]]], arenas: int, seed: int) -> str:
    """The section of the page."""
    speed = ", ".join(
        f"{1e3 * np.mean([r.seconds for r in rows if r.cell.parts == n]):.0f} ms (N = {n})" for n in (10, 20, 50, 200)
    )
    text = [
        "## Intervals: how often they hold the truth",
        f"Shares in percent over {arenas} simulated arenas per line, nominal 95; seed {seed} (tuned on seed "
        f"{TUNED_ON}). With so many arenas a share of 95 is known to {196 * (0.95 * 0.05 / arenas) ** 0.5:.1f} points. "
        "Half of the fiducials are pairs on a wall of 5 cm, half are 6 m apart. The mapper errs by 4 cm (shared by the "
        "halves on a wall) and 3 cm per axis, bends the map by up to 6 cm, misses one part in ten. Placements are "
        f"polished from the true one. CPU time of both intervals of all scores: {speed}.",
        "![coverage of the intervals](images/uncertainty.svg)",
        "### Measurement: the score without survey and centre errors\n\n" + shown(rows, "measurement"),
        "### Population: the mapper's expected score\n\n" + shown(rows, "population"),
    ]
    for name, lines in beside:
        text.append(f"### {name[0].upper()}{name[1:]}\n\nMeasurement\n\n" + shown(lines, "measurement"))
        text.append("Population\n\n" + shown(lines, "population"))
    return "\n\n".join(text)


def main() -> int:
    """Run the study in as many processes as there are cores."""
    parser = argparse.ArgumentParser(prog="./run bench uncertainty")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--arenas", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=REPORTED)
    chosen = parser.parse_args()
    arenas = 20 if chosen.quick else chosen.arenas
    middle = [c for c in CELLS if (c.survey_m, c.centre_m) == (0.02, 0.04)]
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        work = [(cell, Mapper(), CONTINUOUS) for cell in CELLS]
        work += [(cell, mapper, settings) for _, mapper, settings in BESIDE for cell in middle]
        order = pool.submit(order_section, chosen.seed, arenas)
        every = [pool.submit(studied, *one, chosen.seed, arenas) for one in work]
        rows = [one.result() for one in every]
        others = [rows[k : k + len(middle)] for k in range(len(CELLS), len(rows), len(middle))]
        rows, beside = rows[: len(CELLS)], list(zip([name for name, _, _ in BESIDE], others, strict=True))
        text = section(rows, beside, arenas, chosen.seed) + "\n\n" + order.result()
    print(text)
    if not chosen.quick and chosen.seed == REPORTED:
        write_section("uncertainty", text)
        write_coverage(Path(PICTURE), [(kind, _points(rows, kind)) for kind in ("measurement", "population")])
    return 0


def _points(rows: list[Row], kind: str) -> list[tuple[int, str, float]]:
    """(parts, attribute, share) of every cell."""
    return [(r.cell.parts, n, getattr(r, kind)[n].share) for r in rows for n in NAMES]


if __name__ == "__main__":
    sys.exit(main())
