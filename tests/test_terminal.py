"""The terminal table: what a referee reads aloud, on 80 columns, whatever the maps are called."""

from __future__ import annotations

import io
from dataclasses import replace

import pytest
from rich.console import Console

from fidmap.model import Report, Value
from fidmap.report.json_line import error_document, report_document
from fidmap.report.rows import Row, finding_sentence
from fidmap.report.terminal import print_scores
from sample_report import SETTINGS_DOCUMENT, sample_report


def row(report: Report, rank: str | None = None) -> Row:
    return Row(report_document(report, SETTINGS_DOCUMENT, 0.1), rank)


def with_global(name: str) -> Report:
    report = sample_report(name)
    by_name = {**report.attributes.by_name, "global_accuracy": Value(0.8)}
    return replace(report, attributes=replace(report.attributes, by_name=by_name, missing=()))


def printed(rows: list[Row], width: int = 80, is_terminal: bool | None = None) -> str:
    console = Console(file=io.StringIO(), width=width, force_terminal=is_terminal, _environ={"TERM": "xterm"})
    print_scores(console, rows)
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def test_one_map_is_one_line_and_its_findings() -> None:
    lines = printed([row(sample_report())]).splitlines()

    assert lines[1].split() == ["Map", "Coverage", "accuracy", "Consistency", "Overall"]
    assert lines[3].split() == ["teamA/map.yaml", "62.5", "%", "84.6", "%", "47.3", "%", "64.8", "%"]
    assert lines[4] == (
        "Warning: Unknown cells (grey 205) load as free with free_thresh 0.25. Option: --free-thresh 0.196"
    )
    assert lines[-1].startswith("Note: 8 parts have no sigma_m")


def test_several_maps_have_ranks_and_share_their_findings() -> None:
    text = printed([row(sample_report("a.yaml"), "1-2"), row(sample_report("b.yaml"), "1-2")])

    assert text.count("Unknown cells") == 1
    assert "Warning, all maps: Unknown cells" in text
    assert text.count("1-2") == 2


def test_global_accuracy_has_a_column_only_where_it_is_computable() -> None:
    assert "Global" not in printed([row(sample_report("a.yaml"))])
    text = printed([row(sample_report("a.yaml"), "2"), row(with_global("b.yaml"), "1")])

    assert "Global" in text
    assert "Note, a.yaml: global accuracy is not computable: the arena's frame is relative." in text
    assert "hardly comparable" in text


@pytest.mark.parametrize("width", [80, 100, 200])
def test_numbers_are_never_cut_and_long_names_lose_their_beginning(width: int) -> None:
    name = "competition/2026/" + "team-with-a-long-name/" * 4 + "map.yaml"
    lines = printed([row(with_global(name), "10-12"), row(sample_report("b.yaml"), "1")], width).splitlines()

    line = next(line for line in lines if line.lstrip().startswith("10-12"))
    assert len(line) <= width
    assert line.count("%") == 5
    assert "map.yaml" in line
    assert all(len(line) <= width for line in lines[:5])


def test_names_are_neither_markup_nor_control_codes() -> None:
    text = printed([row(sample_report("[red]x[/red]\x1b[2J.yaml"))])

    assert "[red]x[/red]\ufffd[2J.yaml" in text
    assert "\x1b" not in text


def test_colour_only_on_a_terminal() -> None:
    assert "\x1b[" not in printed([row(sample_report())])
    assert "\x1b[" in printed([row(sample_report())], is_terminal=True)


def test_maps_that_could_not_be_used_come_last() -> None:
    text = printed([Row(error_document("bad.yaml", "map-file", "bad.yaml: no image.")), row(sample_report())])

    assert text.rstrip().endswith("Error, bad.yaml: could not be used: bad.yaml: no image.")


def test_no_table_when_nothing_was_scored() -> None:
    text = printed([Row(error_document("bad.yaml", "map-file", "no image."))])

    assert text == "Error, bad.yaml: could not be used: no image.\n"


def test_a_finding_ends_before_its_option_begins() -> None:
    """Whether or not its text has a full stop; without an option it stays as it is."""
    assert finding_sentence({"text": "odd", "option": "--mend"}) == "odd. Option: --mend"
    assert finding_sentence({"text": "Odd.", "option": "--mend"}) == "Odd. Option: --mend"
    assert finding_sentence({"text": "odd", "option": None}) == "odd"
