"""Lists of objects of the rescue leagues as points."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from command_line import fidmap
from fidmap.model import Arena, FiducialPart, PointsFileError
from fidmap.points import read_points
from real_data import real_data

MISSION = '"1.0"\n"Team"\n"Country"\n2019-07-02\n12:05:01\nPrelim1\n\n'
VICTIMS = '"victims"\n' + MISSION + "id,time,text,x,y,z\n1,12:06:00,,1.5,-2.25,0.3\n2,12:07:00,,3,4,0.1\n"
CODES = '"qr codes"\n' + MISSION + 'id,time,text,x,y,z\n1,12:06:00,"RRL, 014",0.5,1,0\n2,12:07:00,B,3,4,0\n'
POIS = (
    "pois,,,,,,,,\n1.2,,,,,,,,\nTeam,,,,,,,,\nLand,,,,,,,,\n7/19/2024,,,,,,,,\n16:10:50,,,,,,,,\nPrelim4,,,,,,,,\n"
    ",,,,,,,,\nid,time,text,x-coord,y,z,robot,mode,type\n"
    "1,16:08:20,A,1.0753,-0.6884,0.86,'R1',T,hazmatsign\n2,16:08:21,B,-0.3,2.5,0.1,'R1',A,qrcode\n"
    "3,16:08:29,A,1.1,-0.7,0.86,'R1',T,hazmatsign\n"
)


def arena(*ids: str) -> Arena:
    return Arena("lab", 0.3, tuple(FiducialPart(part_id, 0.0, 0.0) for part_id in ids))


def written(folder: Path, text: str, name: str = "list.csv") -> Path:
    (folder / name).write_text(text)
    return folder / name


@pytest.mark.parametrize(
    ("text", "places"),
    [
        (VICTIMS, [(1.5, -2.25), (3, 4)]),
        (CODES, [(0.5, 1), (3, 4)]),
        (POIS, [(1.0753, -0.6884), (-0.3, 2.5), (1.1, -0.7)]),
        (POIS.replace(",,,,,,,,", ""), [(1.0753, -0.6884), (-0.3, 2.5), (1.1, -0.7)]),
        ("Example,,\nB,1.5,2\nqr 2,-3.25,1e-1\n", [(1.5, 2), (-3.25, 0.1)]),
    ],
)
def test_places_of_a_list(tmp_path: Path, text: str, places: list[tuple[float, float]]) -> None:
    """In the order of the list, numbered from 1, as whole barrels."""
    parts = read_points(written(tmp_path, text))
    assert [(part.x_m, part.y_m) for part in parts] == places
    assert [part.n for part in parts] == list(range(1, len(places) + 1))
    assert {(part.facing, part.drawn, part.fixed_id) for part in parts} == {(None, 2 * math.pi, None)}


def test_names_that_the_arena_knows(tmp_path: Path) -> None:
    """B is the arena's B; A stands there twice, so the program has to find out which is meant."""
    path = written(tmp_path, POIS)
    assert [part.fixed_id for part in read_points(path, arena("A", "B", "C"))] == [None, "B", None]
    assert [part.fixed_id for part in read_points(path, arena("C"))] == [None] * 3


def test_pixels_need_a_resolution(tmp_path: Path) -> None:
    """Whole numbers beyond an arena's size are pixels, which count downwards; small whole metres are metres."""
    path = written(tmp_path, "Lab\nqr_1,555,412\nqr_2,20,0\n", "lab.pts")
    with pytest.raises(PointsFileError) as caught:
        read_points(path)
    assert str(caught.value) == (
        f"{path}: its places look like pixels of a drawing; say how large one is with --resolution M_PER_PIXEL"
    )
    assert [(p.x_m, p.y_m) for p in read_points(path, resolution_m=0.01)] == [
        (pytest.approx(5.55), pytest.approx(-4.12)), (pytest.approx(0.2), 0),
    ]  # fmt: skip
    metres = written(tmp_path, "Lab\na,1,2\nb,3,4\n", "small.pts")
    assert [(p.x_m, p.y_m) for p in read_points(metres, resolution_m=0.01)] == [(1, 2), (3, 4)]


def test_faults_are_told_together(tmp_path: Path) -> None:
    """Each with its line; a list without its table says what is missing."""
    path = written(tmp_path, VICTIMS.replace("1.5", "one").replace(",4,", ",nan,"))
    with pytest.raises(PointsFileError) as caught:
        read_points(path)
    assert str(caught.value) == (
        f"{path}: line 10: x and y must be numbers up to 1e+08, not 'one,-2.25'; "
        "line 11: x and y must be numbers up to 1e+08, not '3,nan'"
    )
    with pytest.raises(PointsFileError, match="is a list of objects without the line id,time,text,x,y,z"):
        read_points(written(tmp_path, '"victims"\n1.0\n'))
    with pytest.raises(PointsFileError, match="column 'x_m' is missing"):
        read_points(written(tmp_path, "a,b\n1,2\n"))


def test_the_command_line_scores_a_list(tmp_path: Path) -> None:
    """Objects of a team against the survey of the referees: names fix the parts, errors are centimetres."""
    places = {"A": (1.0, 1.0), "B": (5.0, 1.0), "C": (5.0, 4.0), "D": (1.0, 4.5)}
    parts = "".join(f"  - {{id: {name}, x_m: {x}, y_m: {y}}}\n" for name, (x, y) in places.items())
    pair = 'groups:\n  - {id: "1", parts: [A, B], class: short}\n'
    truth = written(tmp_path, f"fidmap_arena: 1\nname: lab\nradius_m: 0.3\nparts:\n{parts}{pair}", "arena.yaml")
    rows = "".join(f"{k},12:00:00,{name},{x + 2.03},{y - 1},0\n" for k, (name, (x, y)) in enumerate(places.items()))
    path = written(tmp_path, '"qr codes"\n' + MISSION + "id,time,text,x,y,z\n" + rows)
    result = fidmap("score", "--points", path, "--arena", truth, "--json")
    assert result.exit_code == 0, result.stderr
    values = json.loads(result.stdout)["attributes"]
    assert values["coverage"]["value"] == 1
    assert values["relative_accuracy"]["value"] == pytest.approx(1, abs=1e-6)


def test_real_lists_are_read() -> None:
    """Both files of the referees' tool and a team's list of 2024: the same objects twice, and pixels."""
    folder = real_data("robocup2024")
    pois, points = (read_points(folder / name) for name in ("example_pois.csv", "eval.pts"))
    assert len(pois) == len(points) == 22
    assert [(p.x_m, p.y_m) for p in pois] == [(p.x_m, p.y_m) for p in points]
    assert len(read_points(folder / "LabGroundTruth.pts", resolution_m=0.01)) == 40
