"""`fidmap detect`: barrel parts without an arena."""

from __future__ import annotations

from pathlib import Path

import pytest

from command_line import documents, evening, fault, fidmap
from fidmap.points import read_points

RADIUS = ("--radius", "0.30")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return evening(tmp_path, monkeypatch)


def test_json_lines_in_the_order_given() -> None:
    result = fidmap("detect", "good.yaml", "missing.yaml", "broken.yaml", *RADIUS, "--json")

    assert result.exit_code == 1
    good, missing, broken = documents(result.stdout, "detect")
    assert [line["map"] for line in (good, missing, broken)] == ["good.yaml", "missing.yaml", "broken.yaml"]
    assert missing["error"]["code"] == "map-file"
    assert good["radius_m"] == 0.3
    assert good["seconds"] > 0
    assert len(good["detections"]) == 14
    assert "part" not in good["detections"][0]
    assert result.stderr == f"fidmap: {missing['error']['text']}\n"


def test_the_table_shows_metres_and_degrees() -> None:
    """A half circle drawn to the full is 180 degrees, not 3.1."""
    result = fidmap("detect", "good.yaml", *RADIUS)

    lines = result.stdout.splitlines()
    assert lines[0].rstrip() == "good.yaml: 14 barrel parts"
    drawn = [float(line.split()[6].rstrip("°")) for line in lines if line.strip()[:1].isdigit()]
    assert len(drawn) == 14
    assert all(120 <= value <= 200 for value in drawn)
    assert all(len(line) <= 80 for line in lines)


def test_thresholds_of_confidence_and_angle() -> None:
    """Both are inclusive lower limits; 0 shows all that the detector has."""

    def found(*words: str) -> list[dict[str, float]]:
        (document,) = documents(fidmap("detect", "broken.yaml", *RADIUS, "--json", *words).stdout, "detect")
        arcs: list[dict[str, float]] = document["detections"]
        return arcs

    usual, all_arcs = found(), found("--min-confidence", "0", "--min-drawn-deg", "0")
    assert all(arc["confidence"] >= 0.5 and arc["drawn_deg"] >= 120 for arc in usual)
    assert usual == [arc for arc in all_arcs if arc["confidence"] >= 0.5 and arc["drawn_deg"] >= 120]
    sure = found("--min-confidence", "0.99", "--min-drawn-deg", "170")
    assert sure == [arc for arc in all_arcs if arc["confidence"] >= 0.99 and arc["drawn_deg"] >= 170]
    assert 0 < len(sure) < len(usual) <= len(all_arcs)


def test_out_writes_a_picture_and_a_points_file_that_scores(here: Path) -> None:
    result = fidmap("detect", "good.yaml", *RADIUS, "--out", "out", "--json")

    (document,) = documents(result.stdout, "detect")
    assert sorted(path.name for path in (here / "out/good").iterdir()) == ["overlay.png", "overlay.svg", "points.csv"]
    assert [part.n for part in read_points("out/good/points.csv")] == [arc["n"] for arc in document["detections"]]
    scored = fidmap("score", "--points", "out/good/points.csv", "--arena", "arena.yaml", "--json")
    assert documents(scored.stdout)[0]["attributes"]["coverage"]["value"] == 1


def test_a_map_is_looked_at_once_and_a_plain_image_needs_its_resolution() -> None:
    result = fidmap("detect", "good.pgm", "good.yaml", *RADIUS, "--json")
    assert len(documents(result.stdout, "detect")) == 1
    assert "fidmap: note: good.pgm is the same map as good.yaml; it is taken once" in result.stderr

    Path("good.yaml").unlink()
    assert "--resolution M_PER_CELL" in fault("detect", "good.pgm", *RADIUS)
    words = ("--resolution", "0.05", "--origin", "10,20,0", "--free-thresh", "0.1", "--occupied-thresh", "0.7")
    (document,) = documents(fidmap("detect", "good.pgm", *RADIUS, "--json", *words).stdout, "detect")
    assert len(document["detections"]) == 14
    assert all(arc["x_m"] > 10 and arc["y_m"] > 20 for arc in document["detections"])


def test_what_is_odd_about_a_map_goes_to_stderr() -> None:
    result = fidmap("detect", "good.pgm", *RADIUS, "--json")
    assert result.stderr.startswith("fidmap: note: good.pgm: good.pgm was read through good.yaml beside it")
    assert result.stderr.count("\n") == 1


def test_nothing_found_is_said() -> None:
    result = fidmap("detect", "good.yaml", "--radius", "3")
    assert result.exit_code == 0
    assert result.stdout == "good.yaml: no barrel part was found\n"


def test_a_radius_below_two_cells_is_a_sentence_about_the_map() -> None:
    assert fault("detect", "good.yaml", "--radius", "0.01").startswith("good.yaml: a radius of 0.01 m is 0.2 cells")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (RADIUS, "no map: give at least one MAP"),
        (("good.yaml",), "Missing option '--radius'"),
        (("good.yaml", "--radius", "0"), "--radius 0.0: expected a positive number of metres"),
        (("good.yaml", "--radius", "nan"), "--radius nan: expected a positive number of metres"),
        (("good.yaml", *RADIUS, "--min-confidence", "2"), "--min-confidence"),
        (("good.yaml", *RADIUS, "--min-confidence", "nan"), "--min-confidence"),
        (("good.yaml", *RADIUS, "--min-drawn-deg", "nan"), "--min-drawn-deg"),
        (("good.yaml", *RADIUS, "--min-drawn-deg", "361"), "--min-drawn-deg"),
        (("good.yaml", *RADIUS, "--origin", "here"), "--origin here: expected 3 numbers"),
    ],
)
def test_wrong_usage(words: tuple[str, ...], told: str) -> None:
    result = fidmap("detect", *words)
    assert result.exit_code == 2
    assert told in result.stderr
    assert result.stdout == ""
