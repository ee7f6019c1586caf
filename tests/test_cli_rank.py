"""`fidmap rank`: reports, folders of reports and printed figures, and the paper's comparison with a human judge."""

from __future__ import annotations

import json
import re
import shutil
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
    told = {}
    for line in result.stdout.splitlines():
        found = re.match(r"(\D+?) +10 +(\S+) \((\S+ to \S+)\) +(\S+) +(\S+) \((\S+ to \S+)\) +(\S+)$", line)
        if found:
            told[found[1]] = found.groups()[1:]
    assert {name: (row[0], row[3]) for name, row in told.items()} == {
        "Coverage": ("0.757", "0.658"),
        "Relative accuracy": ("0.552", "0.463"),
        "Consistency": ("0.564", "0.508"),
        "Overall": ("0.896", "0.750"),
    }
    for rho, rho_interval, _, tau, tau_interval, _ in told.values():
        for value, interval in ((rho, rho_interval), (tau, tau_interval)):
            low, high = (float(word) for word in interval.split(" to "))
            assert low < float(value) < high <= 1
    assert all(len(line) <= 80 for line in result.stdout.splitlines())


def test_reports_and_folders_of_reports(here: Path) -> None:
    """Best first, named by their folders; the same by any way of naming them."""
    fidmap("score", "broken.yaml", "good.yaml", "noisy.yaml", *ONE, "--out", "out")
    by_folder = fidmap("rank", "out")
    assert by_folder.exit_code == 0
    assert [line.split()[0] for line in by_folder.stdout.splitlines()[3:6]] == ["good", "noisy", "broken"]
    assert cells(by_folder.stdout, "good")[3].startswith("1 (99.")
    each = fidmap("rank", "out/good", "out/broken/report.json", "out/noisy")
    assert each.stdout == by_folder.stdout
    assert all(len(line) <= 80 for line in by_folder.stdout.splitlines())
    tied = fidmap("rank", "out", "--tie-within", "100")
    assert [cells(tied.stdout, name)[3].split()[0] for name in ("good", "noisy", "broken")] == ["1-3"] * 3

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


def test_the_picture_of_ranks(here: Path) -> None:
    """A dot per map and panel, as SVG or PNG; two maps at one place share a dot and are both named."""
    (here / "f.csv").write_text("map,coverage,overall\na,90,60\nb,70,50\nc,50,40\n")
    (here / "h.csv").write_text("map,coverage,overall\na,1,2\nb,2-3,1\nc,2-3,3\n")
    assert fidmap("rank", "f.csv", "--human", "h.csv", "--picture", "ranks.svg").exit_code == 0
    drawing = (here / "ranks.svg").read_text()
    assert drawing.count("<circle") == 6
    assert "Coverage: rho 0.87" in drawing
    assert fidmap("rank", "f.csv", "--human", "h.csv", "--picture", "ranks.png").exit_code == 0
    assert (here / "ranks.png").read_bytes().startswith(b"\x89PNG")
    for words in (("--picture", "ranks.svg"), ("--human", "h.csv", "--picture", "ranks.gif")):
        wrong = fidmap("rank", "f.csv", *words)
        assert wrong.exit_code == 2
        assert "expected a name that ends in .svg or .png, together with --human" in wrong.stderr


def test_the_doubt_of_the_order(here: Path) -> None:
    """A map that is far better is likely so (its fiducials are few); a copy is a tie; old reports say nothing."""
    fidmap("score", "broken.yaml", "good.yaml", *ONE, "--out", "out")
    text = fidmap("rank", "out").stdout
    assert 90 < float(cells(text, "good")[-1].split()[-2]) < 99
    shutil.copytree(here / "out/good", here / "out/twin")
    twins = fidmap("rank", "out").stdout
    assert cells(twins, "good")[-1] == "~ 50 %"
    assert "~ a tie: " in twins
    path = here / "out/good/report.json"
    document = json.loads(path.read_text())
    for part in document["parts"]:
        part.pop("relative_loss", None)
    path.write_text(json.dumps(document))
    assert cells(fidmap("rank", "out/good", "out/broken").stdout, "good")[-1] == "-"


def test_arenas_of_different_sizes_are_warned_about(here: Path) -> None:
    fidmap("score", "broken.yaml", "good.yaml", *ONE, "--out", "out")
    assert "parts. The fit adapts" not in fidmap("rank", "out").stderr
    path = here / "out/broken/report.json"
    document = json.loads(path.read_text())
    document["parts"] = document["parts"][:6]
    names = {part["id"] for part in document["parts"]}
    document["groups"] = [group for group in document["groups"] if set(group["parts"]) <= names]
    path.write_text(json.dumps(document))
    assert "warning: The arenas have 6 to 14 parts. The fit adapts to few parts" in fidmap("rank", "out").stderr
