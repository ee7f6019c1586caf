"""`fidmap synth`: what lies in the folders, and that it is always the same."""

from __future__ import annotations

import json
import math
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from fidmap.arena import read_arena
from fidmap.cli import app
from fidmap.maps import read_map
from fidmap.synth.suite import suite

DOCS = Path(__file__).resolve().parents[1] / "docs" / "synth.md"


def run(*arguments: object) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of `fidmap synth ...`."""
    result = CliRunner().invoke(app, ["synth", *map(str, arguments)])
    return result.exit_code, result.stdout, result.stderr


def files(folder: Path) -> dict[str, bytes]:
    """Everything below a folder."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A suite of two maps, made in one process."""
    folder = tmp_path_factory.mktemp("suite")
    words = ("--split", "tune", "--seed", 5, "--tier", "clean", "--tier", "broken", "--maps", 1, "--workers", 1)
    code, stdout, _ = run("suite", *words, folder)
    assert code == 0
    return folder, stdout, words


def test_a_suite_is_one_folder_per_map(made):
    """Paths of the maps on stdout, in order; map, arena and truth in each folder."""
    folder, stdout, _ = made
    names = ["tune-clean-5-000", "tune-broken-5-000"]

    assert stdout.splitlines() == [str(folder / name / "map.yaml") for name in names]
    assert sorted(files(folder)) == sorted(
        f"{name}/{file}" for name in names for file in ("arena.yaml", "map.pgm", "map.yaml", "truth.json")
    )


def test_the_number_of_workers_changes_nothing(made, tmp_path):
    """The same bytes from two processes."""
    folder, _, words = made

    assert run("suite", *words[:-1], 2, tmp_path)[0] == 0
    assert files(tmp_path) == files(folder)


def test_the_files_hold_the_case_of_the_library(made):
    """Map, arena and truth as `fidmap.synth.suite` gives them."""
    folder, _, _ = made
    case = next(suite("tune", 5, 1, "broken"))
    here = folder / "tune-broken-5-000"
    truth = json.loads((here / "truth.json").read_text())
    grid = read_map(here / "map.yaml")

    assert grid.occupancy.shape == case.grid.occupancy.shape
    assert np.array_equal(grid.occupancy > 0.65, case.grid.occupancy > 0.65)
    assert [p.id for p in read_arena(here / "arena.yaml").parts] == [t["id"] for t in truth["parts"]]
    for written, known in zip(truth["parts"], case.truths, strict=True):
        assert (written["x_m"], written["y_m"]) == pytest.approx((known.x_m, known.y_m), abs=1e-6)
        assert written["drawn"] == known.drawn
        assert written["drawn_deg"] == pytest.approx(math.degrees(known.support), abs=1e-3)
        assert len(written["copies"]) == len(known.copies)


def test_one_map_as_asked_for(tmp_path):
    """Resolution and radius are what was said."""
    code, _, _ = run("map", "--seed", 1, "--resolution", 0.1, "--radius", 0.4, "--mapper", "hits", tmp_path)
    truth = json.loads((tmp_path / "truth.json").read_text())

    assert code == 0
    assert read_map(tmp_path / "map.yaml").resolution_m == 0.1
    assert read_arena(tmp_path / "arena.yaml").radius_m == truth["radius_m"] == 0.4
    assert truth["mapper"]["kind"] == "hits"


def test_without_pose_errors_scans_put_every_part_where_it_stands(tmp_path):
    """The same arena and scans as with them; only the poses are others."""
    truths = []
    for times in (1, 0):
        assert run("map", "--seed", 3, "--tier", "noisy", "--pose-errors", times, tmp_path / str(times))[0] == 0
        truths.append(json.loads((tmp_path / str(times) / "truth.json").read_text()))
    x, y, yaw = truths[0]["arena_in_map"]
    c, s = math.cos(math.radians(yaw)), math.sin(math.radians(yaw))

    off = [
        [
            math.hypot(
                x + c * p["x_m"] - s * p["y_m"] - p["voted_x_m"], y + s * p["x_m"] + c * p["y_m"] - p["voted_y_m"]
            )
            for p in truth["parts"]
            if p["voted_x_m"] is not None
        ]
        for truth in truths
    ]

    assert [truth["pose_errors"] for truth in truths] == [1.0, 0.0]
    assert max(off[0]) > 0.01
    assert max(off[1]) < 1e-4


@pytest.mark.parametrize("tier", ["clean", "office", "field"])
def test_an_arena_can_be_read(tmp_path, tier):
    """Mazes, offices and fields."""
    assert run("arena", "--seed", 2, "--tier", tier, tmp_path / "a.yaml")[0] == 0
    assert len(read_arena(tmp_path / "a.yaml").parts) >= 2


def test_wrong_usage_and_bad_places(tmp_path):
    """Exit 2 names what is expected, exit 1 the place; stdout stays empty."""
    (tmp_path / "taken").write_text("")

    code, stdout, stderr = run("map", "--seed", 1, "--mapper", "gmapping", tmp_path)
    assert (code, stdout) == (2, "")
    assert "--mapper gmapping: expected one of log_odds, thin, hits" in stderr

    code, stdout, stderr = run("map", "--seed", 1, "--pose-errors", -1, tmp_path)
    assert (code, stdout) == (2, "")
    assert "--pose-errors -1.0: expected 0 (true poses) to 10 times" in stderr

    code, stdout, stderr = run("map", "--seed", 1, "--tier", "field", tmp_path / "taken")
    assert (code, stdout) == (1, "")
    assert "taken/map.pgm: cannot be written" in stderr


def test_the_examples_of_the_page_run(tmp_path, monkeypatch):
    """Every command in docs/synth.md that starts with `fidmap`, one after the other in one folder."""
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```console\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.S)
    lines = [line[2:] for block in blocks for line in block.splitlines() if line.startswith("$ fidmap ")]

    assert len(lines) >= 4
    for line in lines:
        result = CliRunner().invoke(app, shlex.split(line)[1:])
        assert result.exit_code == 0, f"{line}: {result.stderr}"
