"""`fidmap demo`, and the program as a program: start, help, version, pipes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import fidmap as package
from command_line import DEMO_DATA, evening, fault, fidmap


def test_demo_copies_its_input_and_names_no_place_of_this_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The maps lie beside their reports, so that a user sees what an input looks like."""
    evening(tmp_path, monkeypatch)
    result = fidmap("demo")

    assert result.exit_code == 0
    folder = tmp_path / "fidmap-demo"
    assert sorted(p.name for p in folder.iterdir()) == ["broken", "good", "index.html", "maps", "noisy"]
    assert (folder / "maps/arena.yaml").read_bytes() == (DEMO_DATA / "arena.yaml").read_bytes()
    assert result.stderr.splitlines() == [
        "fidmap: this is: fidmap score fidmap-demo/maps/good.yaml fidmap-demo/maps/noisy.yaml "
        "fidmap-demo/maps/broken.yaml --arena fidmap-demo/maps/arena.yaml --out fidmap-demo",
        "fidmap: reports are in fidmap-demo/index.html",
    ]
    rows = [line.split() for line in result.stdout.splitlines()[3:]]
    assert [row[0] for row in rows] == ["1", "2", "3"]
    for row, name in zip(rows, ("good", "noisy", "broken"), strict=True):
        assert f"fidmap-demo/maps/{name}.yaml".endswith(row[1].removeprefix("…"))
        assert row[1].endswith(f"/{name}.yaml")
    places = (str(tmp_path), str(Path(package.__file__).parents[2]))
    for file in (*folder.rglob("*.html"), *folder.rglob("report.json"), *folder.rglob("*.svg")):
        assert not any(place in file.read_text(encoding="utf-8") for place in places), file
    assert json.loads((folder / "good/report.json").read_text())["map"] == "fidmap-demo/maps/good.yaml"


def test_demo_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").write_text("mine")
    assert fault("demo", "--out", "taken") == (
        "taken: no report can be written there (Not a directory); choose another --out."
    )


def test_version_and_help() -> None:
    assert fidmap("--version").stdout == f"fidmap {package.__version__}\n"
    assert fidmap("--help").exit_code == 0
    result = fidmap("nonsense")
    assert (result.exit_code, result.stdout) == (2, "")


HEAVY = ("numpy", "cv2", "scipy", "pydantic", "PIL", "jinja2", "yaml", "resvg_py", "rich.console")


def test_help_loads_nothing_heavy() -> None:
    """`fidmap --help` answers within half a second, because numpy and the like are imported inside commands."""
    code = f"import sys, fidmap.cli; print([name for name in {HEAVY!r} if name in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"


def test_a_closed_pipe_is_quiet_and_a_full_disk_is_one_sentence() -> None:
    program = [sys.executable, "-m", "fidmap", "profile", "show", "continuous"]
    read, write = os.pipe()
    os.close(read)
    closed = subprocess.run(program, stdout=write, stderr=subprocess.PIPE, text=True, check=False)
    os.close(write)
    assert (closed.returncode, closed.stderr) == (1, "")
    with open("/dev/full", "w") as full:  # noqa: PTH123
        filled = subprocess.run(program, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert filled.returncode == 1
    assert filled.stderr == "fidmap: the result could not be written to stdout (No space left on device)\n"
