"""The parts of a scored map as lists of objects, the way teams of the rescue leagues hand them in."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from fidmap.evaluate import evaluate_points
from fidmap.model import Report
from fidmap.points import points_csv, read_points

Place = tuple[str, float, float]  # name of the part, x and y in metres
HEAD = "1.2\nTeam\nCountry\n2024-07-19\n16:10:50\nFinal\n"


def _pois(places: Sequence[Place]) -> str:
    rows = [f"{k},16:08:20,{name},{x!r},{y!r},0.5,R1,A,object\n" for k, (name, x, y) in enumerate(places, 1)]
    return f"pois\n{HEAD}\nid,time,text,x-coord,y,z,robot,mode,type\n{''.join(rows)}"


def _codes(places: Sequence[Place]) -> str:
    rows = [f"{k},12:06:00,{name},{x!r},{y!r},0.5\n" for k, (name, x, y) in enumerate(places, 1)]
    return f'"qr codes"\n"1.0"\n{HEAD.partition(chr(10))[2]}\nid,time,text,x,y,z\n{"".join(rows)}'


def _pts(places: Sequence[Place]) -> str:
    return "".join(["Evaluation\n", *(f"{name},{x!r},{y!r}\n" for name, x, y in places)])


LISTS: dict[str, Callable[[Sequence[Place]], str]] = {
    "list of objects, `pois` of 2024": _pois,
    "list of objects, `qr codes`": _codes,
    "list of points, `.pts`": _pts,
}


def scored_lists(report: Report, folder: Path) -> Iterator[tuple[str, Report]]:
    """The assigned parts of a report in each kind of list, and in its own points file, read and scored again."""
    assigned = [(part.id, part.barrel) for part in report.attributes.parts if part.barrel is not None]
    places = [(name, float(barrel.x_m), float(barrel.y_m)) for name, barrel in assigned]
    texts = {name: write(places) for name, write in LISTS.items()}
    texts["points file of `--out`"] = points_csv(report.detections, [None] * len(report.detections))
    for name, text in texts.items():
        (folder / "list.csv").write_text(text)
        parts = read_points(folder / "list.csv", report.arena)
        yield name, evaluate_points(parts, report.arena)
