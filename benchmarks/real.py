"""`./run bench real`: scores on real maps that nobody here made; writes its section of docs/benchmarks.md."""

from __future__ import annotations

import csv
import json
import math
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.stats import spearmanr

from benchmarks.counting import Count, DrawnPart, count, reach
from benchmarks.page import table, write_section
from benchmarks.slam_challenge import REFERENCE, TUNED_ON, read_drawn_parts, real_data_root
from fidmap.arena import read_arena
from fidmap.detect import find_barrel_parts
from fidmap.evaluate import evaluate, evaluate_points
from fidmap.geometry import angle_between
from fidmap.grid import trinarize
from fidmap.maps import read_map
from fidmap.model import CONTINUOUS, Arena, BarrelPart, Report

SIMILAR = replace(CONTINUOUS, profile="transform similarity", transform="similarity")
HALF_OPENING = replace(CONTINUOUS, profile="min_opening 0.5", min_opening=0.5)
DATA = real_data_root()


def main() -> int:
    """Measure and write."""
    if not DATA.is_dir():
        sys.stderr.write(f"no real maps at {DATA}: set FIDMAP_REAL_DATA to the folder that holds them\n")
        return 1
    sections = [playpen(), tb3_world(), singa(), slam_challenge()]
    write_section("real", "## Real maps\n\n" + "\n".join(sections))
    sys.stdout.write("\n".join(sections))
    return 0


def playpen() -> str:
    """Nine whole barrels in the map's own frame; test data."""
    grid, arena = read_map(DATA / "playpen/playpen_map.yaml"), read_arena(DATA / "playpen/arena.yaml")
    rows = []
    for settings in (HALF_OPENING, CONTINUOUS):
        report = evaluate(grid, arena, settings)
        found = [p for p in report.attributes.parts if p.barrel is not None]
        lost = [p.id for p in report.attributes.parts if p.barrel is None]
        barrels = {p.barrel.n for p in found if p.barrel is not None}
        stray = sum(_far_from(d, arena) for d in counted(report.detections) if d.n not in barrels)
        rows.append(
            [
                f"{settings.min_opening:.2f}", f"{len(found)} of 9", ", ".join(lost) or "none",
                _mean([p.global_error_m for p in found]), _mean([p.relative_error_m for p in found]), stray,
            ]
        )  # fmt: skip
    head = [
        "min_opening",
        "assigned",
        "left out",
        "mean global error, m",
        "after registration, m",
        "counted, but no barrel",
    ]
    return "### playpen (test)\n\n" + table(head, rows)


def counted(detections: Sequence[BarrelPart]) -> list[BarrelPart]:
    """What `fidmap detect` shows by itself: confidence 0.5 and 120 degrees at least."""
    return [d for d in detections if d.confidence >= 0.5 and d.drawn >= math.radians(120)]


def _far_from(detection: BarrelPart, arena: Arena) -> bool:
    """Whether a detection is nearer than a radius to no part."""
    truth = np.array([(p.x_m, p.y_m) for p in arena.parts], float)
    return bool((np.hypot(*(truth - [detection.x_m, detection.y_m]).T) > arena.radius_m).all())


def _mean(values: Sequence[float | None]) -> str:
    known = [value for value in values if value is not None]
    return f"{np.mean(known):.4f}" if known else "-"


def tb3_world() -> str:
    """Nine pillars of 3 cells' radius in each of four maps; test data."""
    arena = read_arena(DATA / "tb3_world/arena.yaml")
    rows = []
    for path in sorted((DATA / "tb3_world").glob("*.yaml")):
        if path.name == "arena.yaml":
            continue
        report = evaluate(read_map(path), arena, HALF_OPENING)
        found = [p for p in report.attributes.parts if p.barrel is not None]
        sure = len(counted(report.detections))
        rows.append([path.stem, f"{len(found)} of 9", sure - len(found), _mean([p.relative_error_m for p in found])])
    return "### tb3_world, r = 0.15 m (test)\n\n" + table(["map", "assigned", "others", "mean residual, m"], rows)


def singa() -> str:
    """Half barrels annotated by hand in pixels, in an image without a scale; test data."""
    path = DATA / "robocup2010/singa.png"
    grid = trinarize(read_map(path, resolution_m=0.05))
    parts = counted(find_barrel_parts(grid, 0.3))
    hand = json.loads((DATA / "robocup2010/circles_by_hand.json").read_text(encoding="utf-8"))
    known = [(f"{b['id']}{k}", b[k]) for b in hand["barrels"] for k in ("A", "B", "whole", "half") if k in b]
    height = grid.labels.shape[0]
    places = np.array([(p.x_m / 0.05 - 0.5, height - 0.5 - p.y_m / 0.05) for p in parts])
    away = np.linalg.norm(np.array([xy for _, xy in known])[:, None] - places[None], axis=2)
    i, j = linear_sum_assignment(np.minimum(away, 50))
    hit = {known[a][0]: parts[b] for a, b in zip(i, j, strict=True) if away[a, b] <= 2}
    halves = [name for name in hit if "whole" not in name]
    missed = [name for name, _ in known if name not in hit]
    negatives = np.array([n["at"] for n in hand["hard_negatives"]])
    taken = int((np.linalg.norm(places[:, None] - negatives[None], axis=2) < 4).sum())
    rows: list[list[object]] = [
        ["halves within 2 px, 1:1", f"{len(halves)} of 18 ({', '.join(missed) or 'none'} missed)"],
        ["whole barrel", "found" if any("whole" in name for name in hit) else "missed"],
        ["least angle between the facings of a pair", _least_pair_angle(hit)],
        ["smaller round object", "taken" if taken else "not taken"],
        ["other finds", len(parts) - len(hit)],
    ]
    return "### robocup2010/singa.png (test)\n\n" + table(["what", "figure"], rows)


def _least_pair_angle(hit: dict[str, BarrelPart]) -> str:
    angles = [
        float(angle_between(one.facing, other.facing))
        for name, one in hit.items()
        if name.endswith("A")
        and (other := hit.get(name[:-1] + "B"))
        and one.facing is not None
        and other.facing is not None
    ]
    return f"{math.degrees(min(angles)):.0f} degrees over {len(angles)} pairs" if angles else "-"


def slam_challenge() -> str:
    """25 maps by real SLAM programs: detections counted against what each map draws, and scores against the ATE."""
    folder = DATA / "slam_challenge"
    quality = list(csv.DictReader((folder / "quality.csv").open(encoding="utf-8")))
    arenas = {name: read_arena(folder / f"{name}.arena.yaml") for name in ("A2", "R2")}
    counts, reports, similar, drawn = {}, {}, {}, {}
    for row in quality:
        name, arena = row["map"], arenas[row["arena"]]
        grid = read_map(folder / "maps" / f"{name}.yaml")
        reports[name] = evaluate(grid, arena)
        similar[name] = evaluate(grid, arena, SIMILAR)
        parts = counted(find_barrel_parts(trinarize(grid), 0.3))
        counts[name] = count(parts, read_drawn_parts(folder, name))
        drawn[name] = evaluate_points(_drawn_parts(folder, name), arena)
    text = "### slam_challenge: barrel parts found\n\nRun A2 is tuning data, run R2 is test data.\n\n"
    text += _pooled(counts, quality)
    text += "\n### slam_challenge: parts assigned\n\n"
    text += "Each map is scored by itself; its assigned parts are compared with where it draws which part.\n\n"
    text += _assigned(quality, reports, {row["map"]: read_drawn_parts(folder, row["map"]) for row in quality})
    text += "\n" + _findings(reports, similar)
    text += "\n### slam_challenge: overall score against trajectory error\n\n"
    text += "Spearman of overall against ATE (-1: the better map always has the higher score), per run.\n\n"
    text += _against_ate(quality, reports, drawn)
    text += "\n" + _per_map(quality, counts, reports, drawn)
    return text


def _drawn_parts(folder: Path, name: str) -> list[BarrelPart]:
    """What the truth says is drawn, as if somebody had located it."""
    yes = [p for p in read_drawn_parts(folder, name) if p.drawn == "yes" and p.x_m is not None and p.y_m is not None]
    return [
        BarrelPart(n, p.x_m, p.y_m, p.facing, math.pi)
        for n, p in enumerate(yes, start=1)
        if p.x_m is not None and p.y_m is not None
    ]


def _pooled(counts: dict[str, Count], quality: list[dict[str, str]]) -> str:
    program = {
        row["map"]: (row["run"], row["program"] + (" odometry" if "odometry only" in row["setting"] else ""))
        for row in quality
    }
    pools = {"A2, tune split (m28-m30, m33-m35, m59)": list(TUNED_ON), "A2, true poses (m68, m69)": list(REFERENCE)}
    for name, (run, maker) in program.items():
        if name not in (*TUNED_ON, *REFERENCE):
            pools.setdefault(f"{run[:2]}, {maker}", []).append(name)
    rows = []
    for pool, names in pools.items():
        true = sum(counts[n].true for n in names)
        false = sum(len(counts[n].false) for n in names)
        drawn = true + sum(len(counts[n].missed) for n in names)
        errors = [e for n in names for e in counts[n].errors_m]
        rms = f"{1000 * math.sqrt(np.mean(np.square(errors))):.0f}" if errors else "-"
        rows.append([pool, len(names), drawn, _share(true, drawn), _share(true, true + false), rms])
    return table(["maps", "number", "drawn parts", "recall", "precision", "centre RMS, mm"], rows)


def _share(part: int, whole: int) -> str:
    return f"{part / whole:.3f}" if whole else "-"


def _assigned(
    quality: list[dict[str, str]], reports: dict[str, Report], truth: dict[str, tuple[DrawnPart, ...]]
) -> str:
    """Drawn parts assigned to their own ids, and assigned parts that are another one or none at all."""
    rows = []
    for run in sorted({row["run"] for row in quality}):
        names = [row["map"] for row in quality if row["run"] == run]
        drawn = [(name, part.id) for name in names for part in truth[name] if part.drawn == "yes"]
        fates = {
            (name, result.id): _fate(result.barrel, result.id, truth[name])
            for name in names
            for result in reports[name].attributes.parts
            if result.barrel is not None
        }
        right = sum(fates.get(part) == "own" for part in drawn)
        elsewhere = [sum(fate == kind for fate in fates.values()) for kind in ("other", "none")]
        rows.append([run, len(names), len(drawn), _share(right, len(drawn)), len(fates), *elsewhere])
    head = ["run", "maps", "drawn parts", "assigned to their own id", "assigned parts", "of another id", "of no part"]
    return table(head, rows)


def _findings(reports: dict[str, Report], similar: dict[str, Report]) -> str:
    """Which maps have which findings; `scale` where the scale is searched as well."""
    by_code: dict[str, list[str]] = {}
    for name, report in reports.items():
        told = [*report.findings, *(f for f in similar[name].findings if f.code == "scale")]
        for code in sorted({finding.code for finding in told}):
            by_code.setdefault(code, []).append(name)
    rows = [[f"`{code}`", ", ".join(names)] for code, names in sorted(by_code.items())]
    return table(["finding (`scale` with `transform: similarity`)", "maps"], rows)


def _fate(barrel: BarrelPart, own_id: str, parts: Sequence[DrawnPart]) -> str:
    """Whether an assigned arc is drawn for that part ('own'), for an 'other' one or for 'none'; copies count."""
    near = set()
    for part in parts:
        places = [part, *(replace(part, x_m=x, y_m=y, facing=None) for x, y in part.copies)]
        if any(reach(barrel, place) is not None for place in places):
            near.add(part.id)
    return "own" if own_id in near else "other" if near else "none"


def _against_ate(quality: list[dict[str, str]], reports: dict[str, Report], drawn: dict[str, Report]) -> str:
    rows = []
    for run in sorted({row["run"] for row in quality}):
        names = [row["map"] for row in quality if row["run"] == run]
        ate = [float(row["ate_rmse"]) for row in quality if row["run"] == run]
        cells = [f"{spearmanr([_overall(found[n]) for n in names], ate).statistic:.2f}" for found in (reports, drawn)]
        rows.append([run, len(names), *cells])
    return table(["run", "maps", "parts found by fidmap", "parts drawn by the truth files"], rows)


def _overall(report: Report) -> float:
    return report.attributes.overall.value or 0.0


def _per_map(
    quality: list[dict[str, str]], counts: dict[str, Count], reports: dict[str, Report], drawn: dict[str, Report]
) -> str:
    rows = []
    for row in quality:
        name, found = row["map"], counts[row["map"]]
        parts = found.true + len(found.missed)
        rows.append(
            [
                name, row["program"], row["setting"], row["ate_rmse"], f"{found.true} of {parts}", len(found.false),
                f"{100 * _overall(reports[name]):.1f}", f"{100 * _overall(drawn[name]):.1f}",
            ]
        )  # fmt: skip
    head = ["map", "program", "setting", "ATE, m", "found", "false", "overall, %", "overall of the drawn parts, %"]
    return table(head, rows)


if __name__ == "__main__":
    sys.exit(main())
