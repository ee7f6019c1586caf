"""`--out`: names, what is replaced and what is kept, the index, and disks that fail."""

from __future__ import annotations

import errno
import json
import os
import re
from pathlib import Path

import pytest

from command_line import ONE, documents, evening, fault, fidmap

FILES = ["overlay.png", "overlay.svg", "points.csv", "report.html", "report.json"]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return evening(tmp_path, monkeypatch)


def team(folder: Path, name: str, source: str) -> str:
    """A map that a team handed in as NAME/map.yaml."""
    (folder / name).mkdir(exist_ok=True)
    for suffix in ("yaml", "pgm"):
        (folder / name / f"{source}.{suffix}").write_bytes((folder / f"{source}.{suffix}").read_bytes())
    (folder / name / f"{source}.yaml").rename(folder / name / "map.yaml")
    return f"{name}/map.yaml"


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_folder_per_map_and_an_index(here: Path) -> None:
    """Names are the shortest distinct path tails; stdout stays JSON, where things are is told on stderr."""
    maps = [team(here, "teamA", "good"), team(here, "teamB", "noisy")]
    result = fidmap("score", *maps, "broken.yaml", *ONE, "--out", "out", "--json")

    assert result.exit_code == 0
    assert names(here / "out") == ["broken", "index.html", "teamA_map", "teamB_map"]
    assert names(here / "out/teamA_map") == FILES
    assert result.stderr == "fidmap: reports are in out/index.html\n"
    for name, document in zip(("teamA_map", "teamB_map", "broken"), documents(result.stdout), strict=True):
        assert json.loads((here / "out" / name / "report.json").read_text()) == document
    index = (here / "out/index.html").read_text()
    assert "Ranking of 3 maps" in index
    assert "arena demo · profile continuous" in index
    assert index.index("teamA_map/report.html") < index.index("teamB_map/report.html")
    best = index[index.index("teamA_map/report.html") : index.index("teamB_map/report.html")]
    assert re.search(r"<b>\d+\.\d %</b> <span class=\"soft under\">\(\d+.* to \d+.*\)</span>", best)
    assert re.search(r"<td class=\"num detail\">(~ )?\d+(\.\d)? %</td>\s*</tr>", best)
    assert index.count('<td class="num detail">-</td>') == 1


def test_the_same_map_replaces_its_report_and_another_one_is_kept(here: Path) -> None:
    fidmap("score", "good.yaml", *ONE, "--out", "out")
    again = fidmap("score", "good.yaml", *ONE, "--out", "out", "--profile", "ssrr2011")
    assert again.stderr == "fidmap: reports are in out/index.html\n"
    assert json.loads((here / "out/good/report.json").read_text())["profile"] == "ssrr2011"

    (here / "other").mkdir()
    (here / "other/good.yaml").write_text((here / "noisy.yaml").read_text())
    (here / "other/noisy.pgm").write_bytes((here / "noisy.pgm").read_bytes())
    result = fidmap("score", "other/good.yaml", *ONE, "--out", "out", "--json")
    digest = documents(result.stdout)[0]["provenance"]["map_sha256"]
    assert names(here / "out") == ["good", f"good-{digest[:8]}", "index.html"]
    assert (
        f"fidmap: note: out/good does not hold a report of this map and is kept; this one is in out/good-{digest[:8]}."
        in (result.stderr)
    )
    assert json.loads((here / "out/good/report.json").read_text())["profile"] == "ssrr2011"


def test_the_index_keeps_the_evening(here: Path) -> None:
    """Correcting one map must not drop the others from the ranking; what is scored otherwise is not mixed in."""
    fidmap("score", "good.yaml", "noisy.yaml", *ONE, "--out", "out")
    fidmap("score", "noisy.yaml", *ONE, "--out", "out", "--points", "out/noisy/points.csv")
    index = (here / "out/index.html").read_text()
    assert "Ranking of 2 maps" in index
    assert index.count("good/report.html") == index.count("noisy/report.html") == 2

    (here / "out/strange").mkdir()
    (here / "out/strange/report.json").write_text("{}")
    fidmap("score", "broken.yaml", *ONE, "--out", "out", "--profile", "ssrr2011")
    assert "Ranking of 1 map<" in (here / "out/index.html").read_text()


def test_a_map_keeps_its_folder(here: Path) -> None:
    """One of many that is scored again by itself would be `map` by its shortest tail, a second report of one map."""
    maps = [team(here, "teamA", "good"), team(here, "teamB", "noisy")]
    fidmap("score", *maps, *ONE, "--out", "out")
    fidmap("score", f"./{maps[1]}", *ONE, "--out", "out", "--profile", "ssrr2011")

    assert names(here / "out") == ["index.html", "teamA_map", "teamB_map"]
    assert json.loads((here / "out/teamB_map/report.json").read_text())["profile"] == "ssrr2011"


def test_a_bad_map_stops_neither_the_rest_nor_the_index(here: Path) -> None:
    result = fidmap("score", "missing.yaml", "good.yaml", *ONE, "--out", "out")

    assert result.exit_code == 1
    assert names(here / "out") == ["good", "index.html"]
    assert "1 more could not be used" in (here / "out/index.html").read_text()


def test_nothing_is_written_when_nothing_could_be_scored(here: Path) -> None:
    assert fault("score", "missing.yaml", *ONE, "--out", "out").startswith("missing.yaml does not exist; ")
    assert not (here / "out").exists()


@pytest.mark.parametrize("command", [("score", *ONE), ("detect", "--radius", "0.3")])
@pytest.mark.parametrize(
    ("place", "told"),
    [
        ("arena.yaml", "arena.yaml: no report can be written there (Not a directory); choose another --out."),
        ("good.pgm/deep/er", "good.pgm/deep/er: no report can be written there (HERE/good.pgm: Not a directory); "
         "choose another --out."),
        ("n" * 300, f"{'n' * 300}: no report can be written there (File name too long); choose another --out."),
    ],
)  # fmt: skip
def test_an_unwritable_out_is_told_before_the_work(
    here: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...], place: str, told: str
) -> None:
    monkeypatch.setattr("fidmap.study.jobs.read_map", None)  # a map that was touched would be a TypeError
    before = names(here)
    assert fault(*command, "good.yaml", "--json", "--out", place).replace(str(here), "HERE") == told
    assert names(here) == before


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission_is_told(here: Path) -> None:
    (here / "locked").mkdir(mode=0o500)
    assert fault("score", "good.yaml", *ONE, "--out", "locked/out") == (
        f"locked/out: no report can be written there ({here / 'locked'}: Permission denied); choose another --out."
    )


@pytest.mark.parametrize("command", [("score", *ONE), ("detect", "--radius", "0.3")])
def test_a_disk_that_is_full_for_one_map_leaves_the_rest(
    here: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...]
) -> None:
    """The scores are printed all the same, nothing half-written is left, and the exit code says so."""
    write = Path.write_bytes

    def full(path: Path, data: bytes) -> int:
        if "noisy" in path.parent.name and path.name == "overlay.png":
            raise OSError(errno.ENOSPC, "No space left on device", str(path))
        return write(path, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    result = fidmap(*command, "noisy.yaml", "good.yaml", "--json", "--out", "out")

    assert result.exit_code == 1
    assert result.stdout.count("\n") == 2
    assert '"error"' not in result.stdout
    assert result.stderr.splitlines()[0].endswith("No space left on device); choose another --out.")
    assert [name for name in names(here / "out") if name != "index.html"] == ["good"]


def test_ctrl_c_leaves_nothing_half_written(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Interrupted in the middle of the second report: the first is whole, of the second nothing is there."""
    write = Path.write_bytes

    def interrupted(path: Path, data: bytes) -> int:
        if "noisy" in path.parent.name and path.name == "overlay.png":
            raise KeyboardInterrupt
        return write(path, data)

    monkeypatch.setattr(Path, "write_bytes", interrupted)
    result = fidmap("score", "good.yaml", "noisy.yaml", *ONE, "--out", "out")

    assert result.exit_code == 130
    assert names(here / "out") == ["good"]
    assert names(here / "out/good") == FILES
