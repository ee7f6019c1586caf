"""Reports on disk: names, replacing, keeping, nothing half-written, and reading them back."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from fidmap.model import OutputError, ReportFileError
from fidmap.report.files import ReportContent, write_index, write_report
from fidmap.report.json_line import Document, report_document
from fidmap.report.names import report_names
from fidmap.report.read import read_report
from sample_report import SETTINGS_DOCUMENT, sample_report

SAME, OTHER = "ab" * 32, "cd" * 32
FILES = ["overlay.png", "overlay.svg", "points.csv", "report.html", "report.json"]


def document(sha256: str = SAME) -> Document:
    return report_document(sample_report(sha256=sha256), SETTINGS_DOCUMENT, 0.1)


def content(sha256: str = SAME, mark: str = "first") -> ReportContent:
    return ReportContent(document(sha256), f"<p>{mark}", "<svg/>", b"png", "n,x_m,y_m\n1,2,3\n")


def names_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize(
    ("paths", "names"),
    [
        (["maps/m28.yaml"], ["m28"]),
        (["teamA/map.yaml", "teamB/map.yaml"], ["teamA_map", "teamB_map"]),
        (["teamA/map.yaml", "teamB/map.yaml", "c/other.pgm"], ["teamA_map", "teamB_map", "other"]),
        (["x/a/run/map.yaml", "x/b/run/map.yaml"], ["a_run_map", "b_run_map"]),
        (["d/map.pgm", "d/map.yaml"], ["map_pgm", "map_yaml"]),
        (["d/Map.yaml", "e/map.yaml"], ["d_Map", "e_map"]),
        (["d/m.v2.yaml"], ["m.v2"]),
        (["d/../../etc/pass wd<&>.yaml"], ["pass-wd---"[:7]]),
        (["d/index.html.yaml"], ["index_html"]),
        (["d/.hidden.yaml"], ["hidden"]),
        (["d/\udcff\x00.yaml"], ["map"]),
        (["d/" + "long" * 40 + "end.yaml"], [("long" * 40 + "end")[-60:]]),
        ([], []),
    ],
)
def test_names_are_the_shortest_distinct_tails(paths: list[str], names: list[str]) -> None:
    assert report_names(paths) == names


def test_the_same_path_twice_still_gives_two_names() -> None:
    first, second = report_names(["d/map.yaml", "d/map.yaml"])

    assert first != second


def test_a_report_is_five_whole_files_and_nothing_else(tmp_path: Path) -> None:
    written = write_report(tmp_path / "new" / "out", "m28", content())

    assert written.folder == tmp_path / "new" / "out" / "m28"
    assert written.notes == ()
    assert names_in(written.folder) == FILES
    assert names_in(tmp_path / "new" / "out") == ["m28"]
    assert json.loads((written.folder / "report.json").read_text()) == document()


def test_the_same_maps_report_is_replaced_and_other_files_stay(tmp_path: Path) -> None:
    folder = write_report(tmp_path, "m28", content()).folder
    (folder / "protocol.txt").write_text("signed")
    written = write_report(tmp_path, "m28", content(mark="second"))

    assert written.folder == folder
    assert written.notes == ()
    assert (folder / "report.html").read_text() == "<p>second"
    assert names_in(folder) == sorted([*FILES, "protocol.txt"])
    assert names_in(tmp_path) == ["m28"]


def test_another_maps_report_is_kept(tmp_path: Path) -> None:
    write_report(tmp_path, "m28", content())
    written = write_report(tmp_path, "m28", content(OTHER, "second"))

    assert written.folder == tmp_path / "m28-cdcdcdcd"
    assert [note.code for note in written.notes] == ["report-of-another-map"]
    assert str(written.folder) in written.notes[0].text
    assert (tmp_path / "m28" / "report.html").read_text() == "<p>first"
    assert write_report(tmp_path, "m28", content(OTHER, "third")).folder == written.folder


@pytest.mark.parametrize("there", ["file", "broken report", "link"])
def test_what_is_no_report_is_never_overwritten(tmp_path: Path, there: str) -> None:
    place, elsewhere = tmp_path / "m28", tmp_path / "elsewhere"
    elsewhere.mkdir()
    if there == "file":
        place.write_text("mine")
    elif there == "link":
        place.symlink_to(elsewhere)
    else:
        place.mkdir()
        (place / "report.json").write_text("[" * 100_000)
    written = write_report(tmp_path, "m28", content())

    assert written.folder == tmp_path / "m28-abababab"
    assert names_in(elsewhere) == []
    assert there != "file" or place.read_text() == "mine"


def test_a_points_file_that_was_the_input_stays_as_it_is(tmp_path: Path) -> None:
    folder = write_report(tmp_path, "m28", content()).folder
    points = folder / "points.csv"
    points.write_text("n,x_m,y_m,id\n1,2,3,4A\n")
    write_report(tmp_path, "m28", content(mark="second"), input_points=folder / ".." / "m28" / "points.csv")

    assert points.read_text() == "n,x_m,y_m,id\n1,2,3,4A\n"
    assert (folder / "report.html").read_text() == "<p>second"
    assert names_in(folder) == FILES


def test_corrections_that_were_forgotten_are_kept_beside(tmp_path: Path) -> None:
    """A referee edits points.csv and then scores again without --points: the work must not be lost."""
    folder = write_report(tmp_path, "m28", content()).folder
    (folder / "points.csv").write_text("edited")
    written = write_report(tmp_path, "m28", content())

    assert (folder / "points.csv.bak").read_text() == "edited"
    assert (folder / "points.csv").read_text() == content().points
    assert [note.code for note in written.notes] == ["points-kept"]


@pytest.mark.parametrize("has_report", [False, True])
def test_nothing_is_left_when_the_disk_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, has_report: bool) -> None:
    if has_report:
        write_report(tmp_path, "m28", content())
    real = Path.write_bytes

    def full(path: Path, data: bytes) -> int:
        if path.name == "overlay.png":
            raise OSError(28, "No space left on device", str(path))
        return real(path, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OutputError, match="No space left on device"):
        write_report(tmp_path, "m28", content(mark="second"))

    assert names_in(tmp_path) == (["m28"] if has_report else [])
    assert not has_report or (tmp_path / "m28" / "report.html").read_text() == "<p>first"


def test_a_file_in_place_of_the_folder_is_one_sentence(tmp_path: Path) -> None:
    place = tmp_path / "out"
    place.write_text("")
    with pytest.raises(OutputError) as caught:
        write_report(place, "m28", content())

    assert str(caught.value) == (f"{place}: no report can be written there (File exists); choose another --out.")
    with pytest.raises(OutputError, match="choose another --out"):
        write_index(place, "<p>")


def test_a_folder_that_even_root_cannot_make() -> None:
    with pytest.raises(OutputError, match=r"^/proc/fidmap: no report can be written"):
        write_report(Path("/proc/fidmap"), "m28", content())


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission_is_one_sentence(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(OutputError, match="Permission denied"):
        write_report(tmp_path, "m28", content())


def test_the_index_is_replaced_whole(tmp_path: Path) -> None:
    write_index(tmp_path, "<p>one")

    assert write_index(tmp_path, "<p>two").read_text() == "<p>two"
    assert names_in(tmp_path) == ["index.html"]


def test_a_report_is_read_from_its_file_or_its_folder(tmp_path: Path) -> None:
    folder = write_report(tmp_path, "m28", content()).folder

    assert read_report(folder) == document()
    assert read_report(folder / "report.json") == document()


def changed(**changes: object) -> str:
    return json.dumps({**document(), **changes})


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("", "not JSON"),
        ("[" * 100_000, "nested too deeply"),
        ("[1]", "not a fidmap report"),
        ('{"fidmap_report": NaN}', "NaN is not a number"),
        (changed(fidmap_report=2), "version 2 is unknown"),
        (changed(map=3), "its map is not a text"),
        (changed(attributes=[]), "it has no attributes"),
        (changed(attributes={"coverage": {"value": 1}}), "its global_accuracy has no value"),
        (changed(attributes={**document()["attributes"], "coverage": {"value": 93}}), "its coverage is '93'"),
        (
            changed(attributes={**document()["attributes"], "overall": {"value": True}}),
            "its overall is 'True'",
        ),
        (changed(attributes={**document()["attributes"], "overall": {"value": 1, "missing": 3}}), "no list"),
        (changed(findings=[{"level": "panic", "text": "x"}]), "one of its findings"),
        (changed(findings={}), "its findings are no list"),
    ],
)
def test_what_is_no_report_is_one_sentence(tmp_path: Path, text: str, fault: str) -> None:
    file = tmp_path / "report.json"
    file.write_text(text)
    with pytest.raises(ReportFileError) as caught:
        read_report(file)

    assert fault in str(caught.value)
    assert str(caught.value).startswith(f"{file}: ")
    assert "expected a report.json that fidmap score --out wrote." in str(caught.value)
    assert "\n" not in str(caught.value)


def test_reports_that_are_missing_or_far_too_large(tmp_path: Path) -> None:
    with pytest.raises(ReportFileError, match="no such report; expected a report"):
        read_report(tmp_path)
    huge = tmp_path / "huge.json"
    with huge.open("wb") as file:
        file.truncate(10**10)
    with pytest.raises(ReportFileError, match="10,000,000,000 bytes is no report"):
        read_report(huge)


def test_sample_hashes_differ() -> None:
    assert replace(sample_report().map, sha256=OTHER) != sample_report().map
