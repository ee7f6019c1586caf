"""`--points`: a human's corrections come back through the command line and change the scores as they say."""

from __future__ import annotations

import csv
import hashlib
import json
import math
from pathlib import Path
from typing import Any

import pytest
import yaml

from command_line import ONE, documents, evening, fault, fidmap

Rows = list[dict[str, str]]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return evening(tmp_path, monkeypatch)


@pytest.fixture
def first(here: Path) -> dict[str, Any]:
    """The report that the program made by itself, and its points file as `p.csv`."""
    (document,) = documents(fidmap("score", "noisy.yaml", *ONE, "--json", "--out", "out").stdout)
    (here / "p.csv").write_bytes((here / "out/noisy/points.csv").read_bytes())
    return document


def rescored(*words: str) -> dict[str, Any]:
    (document,) = documents(fidmap("score", *words, *ONE, "--json", "--points", "p.csv").stdout)
    return document


def rows() -> Rows:
    with Path("p.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def write(edited: Rows) -> None:
    with Path("p.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(edited[0]))
        writer.writeheader()
        writer.writerows(edited)


def part(document: dict[str, Any], name: str) -> dict[str, Any]:
    return next(entry for entry in document["parts"] if entry["id"] == name)


def row_of(edited: Rows, name: str) -> dict[str, str]:
    return next(row for row in edited if row["part"] == name)


def test_the_file_carries_what_the_report_carries(first: dict[str, Any]) -> None:
    """The same n and part, full precision, `id` empty for the human."""
    assert [int(row["n"]) for row in rows()] == [arc["n"] for arc in first["detections"]]
    assert [row["part"] or None for row in rows()] == [arc["part"] for arc in first["detections"]]
    assert [float(row["x_m"]) for row in rows()] == [arc["x_m"] for arc in first["detections"]]
    assert {row["id"] for row in rows()} == {""}


def test_read_back_unchanged_it_gives_the_same_report(here: Path, first: dict[str, Any]) -> None:
    """Byte for byte, but for where it came from."""
    again = rescored("noisy.yaml")

    provenance = again.pop("provenance")
    assert json.dumps(again) == json.dumps({k: v for k, v in first.items() if k != "provenance"})
    assert provenance["points"] == "p.csv"
    assert provenance["points_sha256"] == hashlib.sha256((here / "p.csv").read_bytes()).hexdigest()
    assert provenance["map_sha256"] == first["provenance"]["map_sha256"]


def test_without_a_map_only_what_needs_the_map_is_missing(here: Path, first: dict[str, Any]) -> None:
    """`map` is then the points file, known by its own hash."""
    alone = rescored()

    assert alone["map"] == "p.csv"
    assert alone["provenance"]["map_sha256"] == hashlib.sha256((here / "p.csv").read_bytes()).hexdigest()
    quality = alone["attributes"]["resolution_quality"]
    assert quality["value"] is None
    assert "map" in quality["reason"]
    kept = ("coverage", "relative_accuracy", "consistency", "overall")
    assert [alone["attributes"][name]["value"] for name in kept] == [
        first["attributes"][name]["value"] for name in kept
    ]
    assert alone["parts"] == first["parts"]
    assert alone["detections"] == first["detections"]


def test_a_deleted_row_is_a_lost_part(first: dict[str, Any]) -> None:
    write([row for row in rows() if row["part"] != "1A"])
    again = rescored("noisy.yaml")

    assert part(first, "1A")["assigned"]
    assert not part(again, "1A")["assigned"]
    assert again["attributes"]["coverage"]["value"] == pytest.approx(
        first["attributes"]["coverage"]["value"] - 1 / len(first["parts"])
    )


def test_an_added_row_fills_a_missing_part(first: dict[str, Any]) -> None:
    """Two numbers and an id are enough; n goes on after the largest."""
    kept = rows()
    kept.remove(row_of(kept, "1A"))
    missing, most = part(first, "1A"), max(int(row["n"]) for row in kept)
    place = {"x_m": str(missing["x_m"]), "y_m": str(missing["y_m"]), "id": "1A"}
    write([*kept, {**dict.fromkeys(kept[0], ""), **place}])
    again = rescored("noisy.yaml")

    found = part(again, "1A")
    assert found["assigned"]
    assert found["state"] == "fixed"
    assert found["n"] == most + 1
    assert found["relative_error_m"] == pytest.approx(missing["relative_error_m"], abs=1e-3)


def test_a_moved_row_moves_its_part(first: dict[str, Any]) -> None:
    edited = rows()
    row = row_of(edited, "1A")
    row["x_m"] = str(float(row["x_m"]) + 0.4)
    write(edited)

    again = rescored("noisy.yaml")
    assert part(again, "1A")["x_m"] == pytest.approx(part(first, "1A")["x_m"] + 0.4)
    assert part(again, "1A")["relative_error_m"] > 0.2
    assert again["attributes"]["relative_accuracy"]["value"] < first["attributes"]["relative_accuracy"]["value"]


def test_a_named_row_is_that_part_and_a_dash_is_none(first: dict[str, Any]) -> None:
    """The human's word stands, however far the two lie apart."""
    edited = rows()
    row_of(edited, "1A")["id"], row_of(edited, "1B")["id"] = "-", "4A"
    write(edited)
    again = rescored("noisy.yaml")

    assert not part(again, "1A")["assigned"]
    assert not part(again, "1B")["assigned"]
    assert part(again, "4A")["n"] == part(first, "1B")["n"]
    assert part(again, "4A")["state"] == "fixed"


def test_the_same_parts_named_by_hand_score_the_same(first: dict[str, Any]) -> None:
    edited = rows()
    for row in edited:
        row["id"] = row["part"]
    write(edited)
    again = rescored("noisy.yaml")

    assert [entry["assigned"] for entry in again["parts"]] == [entry["assigned"] for entry in first["parts"]]
    assert again["attributes"]["coverage"] == first["attributes"]["coverage"]
    assert again["attributes"]["overall"]["value"] == pytest.approx(first["attributes"]["overall"]["value"], abs=0.02)


def test_positions_alone_are_scored(here: Path) -> None:
    """A referee with a tape measure: two columns, no map."""
    (here / "p.csv").write_text("x_m,y_m,id\n0,0,1A\n0,1.22,1B\n")
    document = rescored()
    assert document["attributes"]["coverage"]["value"] == pytest.approx(2 / 14)
    assert document["groups"][0]["error_m"] == pytest.approx(0)


def test_an_arena_without_positions_takes_the_names_of_a_points_file(here: Path) -> None:
    (here / "bare.yaml").write_text(
        "fidmap_arena: 1\nname: bare\nradius_m: 0.3\nparts:\n  - {id: A}\n  - {id: B}\n"
        "groups:\n  - {id: w, parts: [A, B], class: short, distance_m: 1.0}\n"
    )
    (here / "p.csv").write_text("x_m,y_m,id\n0,0,A\n0,1.1,B\n")
    result = fidmap("score", "--points", "p.csv", "--arena", "bare.yaml", "--json")
    (document,) = documents(result.stdout)
    assert document["attributes"]["consistency"]["value"] == pytest.approx(1 - 0.1 / 1.2)
    assert fault("score", "good.yaml", "--arena", "bare.yaml", "--json") == (
        "bare.yaml: no part has a position, so nothing can be assigned by itself: give x_m and y_m for every part, or "
        "put the two halves on each wall into a group with distance_m, or name the parts in the id column of a points "
        "file (--points)"
    )


def test_an_arena_without_positions_pairs_the_halves_on_a_wall(here: Path) -> None:
    """The demo's arena, its positions taken out of it: pairs and consistency are those of the arena as it was."""
    truth = yaml.safe_load((here / "arena.yaml").read_text())
    place = {part["id"]: (part["x_m"], part["y_m"]) for part in truth["parts"]}
    groups = [{**g, "distance_m": math.dist(*(place[p] for p in g["parts"]))} for g in truth["groups"]]
    parts = [{"id": part["id"], "opening_deg": 180} for part in truth["parts"]]
    bare = {"fidmap_arena": 1, "name": "bare", "radius_m": 0.3, "parts": parts, "groups": groups}
    (here / "bare.yaml").write_text(yaml.safe_dump(bare))

    (document,) = documents(fidmap("score", "good.yaml", "--arena", "bare.yaml", "--json").stdout)

    assert document["attributes"]["coverage"]["value"] == 1
    assert sorted(round(g["distance_m"]) for g in document["groups"]) == [0, 0, 0, 0, 0, 1, 1]
    assert document["attributes"]["consistency"]["value"] > 0.9
    assert document["attributes"]["relative_accuracy"] == {"value": None, "reason": "the arena has no positions"}
    assert document["registration"]["rotation_deg_reason"] == "the arena has no positions"
    assert [f["code"] for f in document["findings"]] == ["interchangeable", "class-unknown"]


@pytest.mark.usefixtures("first")
def test_an_input_is_never_overwritten(here: Path) -> None:
    """Edited in its report's folder and scored into the same folder: the edit stays, the rest is new."""
    points = here / "out/noisy/points.csv"
    text = points.read_text().replace(",1A,\n", ",1A,-\n")
    points.write_text(text)
    result = fidmap("score", "noisy.yaml", *ONE, "--points", "out/noisy/points.csv", "--out", "out")

    assert result.exit_code == 0
    assert points.read_text() == text
    assert not json.loads((here / "out/noisy/report.json").read_text())["parts"][0]["assigned"]
    assert sorted(path.name for path in (here / "out").iterdir()) == ["index.html", "noisy"]
    assert not (here / "out/noisy/points.csv.bak").exists()


@pytest.mark.usefixtures("first")
def test_an_edit_that_was_not_given_back_is_kept_aside(here: Path) -> None:
    points = here / "out/noisy/points.csv"
    points.write_text("x_m,y_m\n1,2\n")
    result = fidmap("score", "noisy.yaml", *ONE, "--out", "out")

    assert (here / "out/noisy/points.csv.bak").read_text() == "x_m,y_m\n1,2\n"
    assert "kept as points.csv.bak" in result.stderr


def test_two_points_files_of_one_name_keep_their_own_reports(here: Path) -> None:
    """teamA/points.csv and teamB/points.csv, one after the other, into one folder."""
    for team, y in (("a", 1.22), ("b", 1.3)):
        (here / team).mkdir()
        (here / team / "points.csv").write_text(f"x_m,y_m,id\n0,0,1A\n0,{y},1B\n")
        result = fidmap("score", *ONE, "--points", f"{team}/points.csv", "--out", "out")
        assert result.exit_code == 0
    folders = [path.name for path in (here / "out").iterdir() if path.is_dir()]
    assert len(folders) == 2
    assert "does not hold a report of this map and is kept" in result.stderr


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (None, "p.csv: no such file, expected a points file, so check the path"),
        ("", "p.csv: is empty, expected a points file with a first line x_m,y_m"),
        ("x_m,y_m\n1,two\n", "p.csv: line 2: y_m must be a number, not 'two'"),
        ("x_m,y_m,id\n1,2,1C\n", "p.csv: n 1: id '1C' is no part of arena 'demo' (did you mean 1B?)"),
    ],
)
def test_faults_of_a_points_file_are_one_sentence(here: Path, text: str | None, told: str) -> None:
    if text is not None:
        (here / "p.csv").write_text(text)
    assert fault("score", "good.yaml", *ONE, "--points", "p.csv", "--out", "out") == told
    assert not (here / "out").exists()
    result = fidmap("score", "good.yaml", *ONE, "--points", "p.csv", "--json")
    assert documents(result.stdout) == [{"map": "good.yaml", "error": {"code": "points-file", "text": told}}]
