"""The tables of the detection benchmark, from what came out map by map."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.counting import Count, Verdict, average_precision, best_confidence, ranked, rates
from benchmarks.detect_maps import Tried
from benchmarks.detect_speed import Speed
from benchmarks.page import table
from benchmarks.peer_env import Answers, counted

TIERS = ("clean", "noisy", "broken", "large", "office", "field")
REAL = {"A2": "real, maze (run A2: tuned on)", "R2": "real, office (run R2)"}
F1_GOAL = {"clean": 0.98, "noisy": 0.95, "broken": 0.90, "large": 0.98, "A2": 0.97, "R2": 0.90}
AP_GOAL = {"clean": 0.99, "noisy": 0.96, "broken": 0.91, "large": 0.985}
RADIUS_M = 0.30
Groups = dict[str, list[Tried]]


def groups_of(tried: Sequence[Tried]) -> Groups:
    """The maps by tier, in the order of the tables, without those that were made for one resolution."""
    drawn = [t for t in tried if t.job.resolution_m is None]
    found = {name: [t for t in drawn if t.job.group == name] for name in (*TIERS, *REAL)}
    return {name: maps for name, maps in found.items() if maps}


def tier_table(groups: Groups) -> str:
    """How well parts are found."""
    rows = []
    for name, maps in groups.items():
        counts = [t.count for t in maps]
        at = rates(counts)
        usual = rates([t.count for t in maps if t.radius_m == RADIUS_M])
        rows.append(
            [
                REAL.get(name, name), len(maps), at.drawn, to_goal(at.f1, F1_GOAL.get(name)),
                to_goal(average_precision(counts), AP_GOAL.get(name)), three(at.precision), three(at.recall),
                three(usual.f1),
            ]
        )  # fmt: skip
    head = ["maps", "number", "drawn parts", "F1 (goal)", "AP (goal)", "precision", "recall", "F1 where R = 0.30 m"]
    return table(head, rows)


def to_goal(value: float, goal: float | None) -> str:
    return three(value) + ("" if goal is None else f" ({goal:g})")


def precision_table(groups: Groups) -> str:
    """How exact the true detections are, and what they say of themselves."""
    artificial = [t for name in TIERS for t in groups.get(name, [])]
    rows = []
    for name, maps in (*groups.items(), ("all artificial", artificial)):
        true = sure(maps)
        errors = [v.error_m for v in true]
        turns = [math.degrees(v.turn) for v in true if v.turn is not None]
        mean, median = unit_variances(true)
        milliseconds = 1e9 * sum(t.seconds for t in maps) / sum(t.cells for t in maps)
        rows.append(
            [
                REAL.get(name, name), rms_and_median(errors), f"{np.percentile(turns, 95):.1f}" if turns else "-",
                f"{mean:.2f}", f"{median:.2f}", f"{milliseconds:.0f}",
            ]
        )  # fmt: skip
    head = [
        "maps", "centre RMSE (median), mm", "facing, 95 %, degrees", "sigma: mean (1)", "sigma: median (1)",
        "ms per Mcell",
    ]  # fmt: skip
    return table(head, rows)


def sure(maps: Sequence[Tried], confidence: float = 0.5) -> list[Verdict]:
    """The true detections of so much confidence."""
    return [v for t in maps for v in t.count.above(confidence).of("true")]


def unit_variances(true: Sequence[Verdict]) -> tuple[float, float]:
    """Mean of (ex^2 + ey^2)/(2 sigma^2), and its median over ln 2 (robust): both 1 where sigma is honest."""
    ratios = [v.error_m**2 / (2 * s**2) for v in true if (s := v.detection.sigma_m) is not None]
    if not ratios:
        return math.nan, math.nan
    return float(np.mean(ratios)), float(np.median(ratios)) / math.log(2)


def rms_mm(errors_m: Sequence[float]) -> float:
    """Root mean square of metres, in millimetres."""
    return float(1000 * np.sqrt(np.mean(np.square(errors_m))))


def rms_and_median(errors_m: Sequence[float]) -> str:
    """Both in millimetres, the median in brackets."""
    if not errors_m:
        return "-"
    return f"{rms_mm(errors_m):.1f} ({1000 * np.median(errors_m):.1f})"


def peer_table(groups: Groups, answers: Answers) -> str:
    """Everybody on the same maps: F1 / AP per tier, centres, CPU."""
    ours: list[object] = ["fidmap"]
    ours += [_score([t.count for t in maps], 0.5) for maps in groups.values()]
    everything = [t for name in TIERS for t in groups.get(name, [])]
    rows = [[*ours, rms_and_median([v.error_m for v in sure(everything)]), _speed(groups, lambda t: t.seconds)]]
    for tool, of in answers.items():
        counts = {name: [counted(of[t.name], t) for t in maps] for name, maps in groups.items()}
        at = {name: best_confidence(found) for name, found in counts.items()}
        errors = [e for name in TIERS for c in counts.get(name, []) for e in c.above(at[name]).errors_m]
        cells: list[object] = [_score(found, at[name]) for name, found in counts.items()]
        rows.append([tool, *cells, rms_and_median(errors), _speed(groups, lambda t, of=of: of[t.name].seconds)])  # type: ignore[misc]
    head = ["tool", *(f"{name} F1/AP" for name in groups), "centre RMSE (median), mm", "ms per Mcell, large"]
    return table(head, rows)


def _score(counts: Sequence[Count], confidence: float) -> str:
    return f"{rates(counts, confidence).f1:.2f}/{average_precision(counts):.2f}"


def _speed(groups: Groups, seconds: Callable[[Tried], float]) -> str:
    maps = groups.get("large", [])
    return f"{1e9 * sum(seconds(t) for t in maps) / sum(t.cells for t in maps):.0f}" if maps else "-"


def speed_table(ours: Speed, hough: dict[int, float]) -> str:
    """Time by size, its growth and memory; the peer's seconds by side where it was asked."""
    rows: list[list[object]] = []
    for side in sorted(ours.seconds):
        peer = 1e9 * hough[side] / side**2 if side in hough else None
        mine = ours.per_mcell_ms(side)
        beside = ["", ""] if peer is None else [f"{peer:.1f}", f"{mine / peer:.1f}"]
        milliseconds = f"{1000 * ours.seconds[side]:.1f}" + (" (15)" if side == 700 else "")
        rows.append([f"{side} x {side}", milliseconds, f"{mine:.1f}" + (" (16)" if side == 4000 else ""), *beside])
    text = table(["cells", "ms (goal)", "ms per Mcell (goal)", "HoughCircles, ms per Mcell", "ratio"], rows)
    text += f"\nTime grows with the map's size to the power {ours.exponent:.2f} (goal 1.05); "
    return text + f"the peak of memory is {ours.bytes_per_cell:.1f} bytes per cell (goal 12).\n"


def reliability(maps: Sequence[Tried]) -> list[tuple[int, float, float]]:
    """Per tenth of confidence: detections that count, their mean confidence, the share that is true."""
    confidence, true = ranked([t.count for t in maps])
    tenth = np.minimum((confidence * 10).astype(int), 9)
    rows = []
    for k in range(10):
        mine = tenth == k
        n = int(mine.sum())
        rows.append((n, float(confidence[mine].mean()) if n else math.nan, float(true[mine].mean()) if n else math.nan))
    return rows


def calibration_error(rows: Sequence[tuple[int, float, float]]) -> float:
    """Mean distance between confidence and share of true detections, over detections."""
    kept = [row for row in rows if row[0]]
    total = sum(n for n, _, _ in kept)
    return sum(n * abs(c - t) for n, c, t in kept) / total if total else math.nan


def calibration_table(artificial: Sequence[Tried], real: Sequence[Tried]) -> str:
    """What confidence is worth."""
    rows = []
    for k, (ours, theirs) in enumerate(zip(reliability(artificial), reliability(real), strict=True)):
        span = f"{k / 10:.1f} to {(k + 1) / 10:.1f}"
        rows.append([span, ours[0], _share(ours[1]), _share(ours[2]), theirs[0], _share(theirs[2])])
    head = ["confidence", "detections", "mean", "true", "real, R2", "true"]
    error = f"{calibration_error(reliability(artificial)):.3f}"
    return table(head, rows) + f"\nMean distance between confidence and share of true ones: {error}.\n"


def _share(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.2f}"


def three(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.3f}"
