"""`fidmap rank`: reports, folders of reports and printed figures, and the paper's comparison with a human judge."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from command_line import ONE, evening, fault, fidmap
from test_paper_ranking import TABLE_1, TABLE_2, TABLE_3


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return evening(tmp_path, monkeypatch)


def cells(text: str, name: str) -> list[str]:
    """The cells of a map's line."""
    line = next(line for line in text.splitlines() if re.match(rf"\s*{re.escape(name)}\s", line))
    return re.split(r"\s{2,}|(?<=\d)\s(?=\d)", line.strip())[1:]


def paper_csv(path: str, rows: list[tuple[float, ...]]) -> None:
    head = "map,coverage,relative_accuracy,consistency,overall\n"
    Path(path).write_text(head + "".join(f"{k + 1},{','.join(map(str, row))}\n" for k, row in enumerate(rows)))


def test_the_paper() -> None:
    """Tables I and II as printed give Table III (but for the cells where it contradicts them) and its agreement."""
    paper_csv("metric.csv", [(c, r, (short + long) / 2, o) for c, r, short, long, o in TABLE_1])
    paper_csv("human.csv", [tuple(row) for row in TABLE_2])
    result = fidmap("rank", "metric.csv", "--human", "human.csv")

    assert result.exit_code == 0
    ours = [cells(result.stdout, str(k + 1)) for k in range(10)]
    agreeing = 0
    for found, printed in zip(ours, TABLE_3, strict=True):
        pairs = [found_cell.split(" / ") for found_cell in found]
        for pair, cell in zip(pairs, printed.split(), strict=True):
            agreeing += sum(a == b for a, b in zip(pair, cell.split("/"), strict=True))
    assert agreeing == 80 - 8
    table = {
        line.rsplit(maxsplit=5)[0]: line.split()[-5:]
        for line in result.stdout.splitlines()
        if re.search(r" 10 +0\.", line)
    }
    assert {name: (row[0], row[1], row[3]) for name, row in table.items()} == {
        "Coverage": ("10", "0.757", "0.658"),
        "Relative accuracy": ("10", "0.552", "0.463"),
        "Consistency": ("10", "0.564", "0.508"),
        "Overall": ("10", "0.896", "0.750"),
    }
    assert all(len(line) <= 80 for line in result.stdout.splitlines())


def test_reports_and_folders_of_reports(here: Path) -> None:
    """Best first, named by their folders; the same by any way of naming them."""
    fidmap("score", "broken.yaml", "good.yaml", "noisy.yaml", *ONE, "--out", "out")
    by_folder = fidmap("rank", "out")
    assert by_folder.exit_code == 0
    assert [line.split()[0] for line in by_folder.stdout.splitlines()[3:]] == ["good", "noisy", "broken"]
    assert cells(by_folder.stdout, "good")[-1] == "1 (99.7 %)"
    each = fidmap("rank", "out/good", "out/broken/report.json", "out/noisy")
    assert each.stdout == by_folder.stdout
    assert all(len(line) <= 80 for line in by_folder.stdout.splitlines())
    tied = fidmap("rank", "out", "--tie-within", "100")
    assert [cells(tied.stdout, name)[-1].split()[0] for name in ("good", "noisy", "broken")] == ["1-3"] * 3

    (here / "judge.csv").write_text("map,overall,coverage\ngood,1,\nnoisy,2-3,\nbroken,2-3,\nabsent,4,\n")
    judged = fidmap("rank", "out", "--human", "judge.csv")
    assert cells(judged.stdout, "noisy")[-1] == "2 / 2-3"
    assert "fidmap: note: judged, but without a report: absent\n" in judged.stderr
    assert "Coverage cannot be compared: 0 maps ranked by both, three are needed" in judged.stdout

    document = json.loads((here / "out/good/report.json").read_text())
    document["attributes"]["overall"]["missing"] = []
    (here / "out/good/report.json").write_text(json.dumps(document))
    assert "fidmap: warning: The overall scores leave out different attributes" in fidmap("rank", "out").stderr


def test_ties_are_half_a_point_unless_said_otherwise(here: Path) -> None:
    (here / "f.csv").write_text("map,overall\na,60.0\nb,60.5\nc,61.1\nd,\n")
    assert [cells(fidmap("rank", "f.csv").stdout, name)[0] for name in "abc"] == ["2-3 (60.0 %)", "2-3 (60.5 %)",
                                                                                   "1 (61.1 %)"]  # fmt: skip
    exact = fidmap("rank", "f.csv", "--tie-within", "0").stdout
    assert [cells(exact, name)[0] for name in "abc"] == ["3 (60.0 %)", "2 (60.5 %)", "1 (61.1 %)"]
    assert cells(exact, "d") == ["-"]
    assert exact.splitlines()[-1].startswith("d")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("none",), "none: no such report; expected a report.json or the folder that holds it."),
        (("empty",), "empty: holds no reports; give a folder that fidmap score --out wrote"),
        (("good.pgm",), "good.pgm: not JSON ("),
        (("none.csv",), "none.csv: no such file, expected a human ranking, so check the path"),
        (("f.csv", "empty"), "f.csv: a CSV of figures is ranked alone; give it by itself, or only reports"),
        (("f.csv", "--human", "none.csv"), "none.csv: no such file, expected a human ranking, so check the path"),
        (("f.csv", "--human", "bad.csv"), "bad.csv: line 2: overall must be a percent or a rank like 4 or 4-5"),
    ],
)
def test_faults(here: Path, words: tuple[str, ...], told: str) -> None:
    (here / "empty").mkdir()
    (here / "f.csv").write_text("map,overall\na,60.0\n")
    (here / "bad.csv").write_text("map,overall\na,first\n")
    assert fault("rank", *words).startswith(told)


@pytest.mark.parametrize("words", [(), ("f.csv", "--tie-within", "-1"), ("f.csv", "--tie-within", "nan")])
def test_wrong_usage(words: tuple[str, ...]) -> None:
    result = fidmap("rank", *words)
    assert result.exit_code == 2
    assert result.stdout == ""
