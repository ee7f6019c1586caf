"""`./run` and the set-up from nothing: what a stranger with a fresh machine does first."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SYSTEM_PYTHON = Path("/usr/bin/python3")


def run(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, ROOT / "run", *words], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("words", [(), ("nonsense",), ("bench",), ("bench", "nonsense"), ("--help",)])
def test_unknown_words_show_the_usage(words: tuple[str, ...]) -> None:
    """Exit 2, nothing on stdout, and every word that there is."""
    result = run(*words)
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.startswith("usage: ./run COMMAND\n")
    shown = [line.split()[0] for line in result.stderr.splitlines()[1:]]
    assert shown == ["demo", "test", "fidmap", "lint", "bench", "fuzz"]
    assert "make_picture" in result.stderr


def test_fuzzing_names_the_kinds_of_files_when_it_knows_none_of_the_words() -> None:
    """It used to look for inputs for ever."""
    result = run("fuzz", "1", "--help")
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.startswith("no kind of file has --help in its name; there are map_server YAML, PGM, ")


def test_the_exit_code_is_that_of_the_command() -> None:
    assert run("fidmap", "--version").stdout.startswith("fidmap ")
    assert run("fidmap", "score", "x.yaml").returncode == 2
    assert run("fidmap", "profile", "show", "nonsense").returncode == 1


def bare_python(folder: Path) -> dict[str, str]:
    """An environment of Debian's Python without ensurepip, an empty HOME and nothing else on the PATH."""
    site = folder / "site"
    site.mkdir()
    (site / "ensurepip.py").write_text("raise ImportError('not here, as on Debian without python3-venv')\n")
    (folder / "home").mkdir()
    kept = {name: value for name, value in os.environ.items() if name.startswith("PIP_") or "proxy" in name.lower()}
    return {**kept, "HOME": str(folder / "home"), "PATH": "/usr/bin:/bin", "PYTHONPATH": str(site)}


def need(condition: bool, reason: str) -> None:
    """Skip loudly on a user's machine, fail in CI."""
    if not condition:
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)


@pytest.mark.slow
def test_set_up_from_a_clean_clone(tmp_path: Path) -> None:
    """No uv, no python3-venv, no root needed, an empty HOME: `./run demo` works, and again without setting up."""
    environment = bare_python(tmp_path)
    need(SYSTEM_PYTHON.exists(), f"no {SYSTEM_PYTHON}")
    pip = subprocess.run([SYSTEM_PYTHON, "-m", "pip", "--version"], env=environment, capture_output=True, check=False)
    need(pip.returncode == 0, f"{SYSTEM_PYTHON} has no pip (apt-get install python3-pip)")
    subprocess.run(["git", "clone", "-q", ROOT, tmp_path / "clone"], check=True)
    demo = [SYSTEM_PYTHON, tmp_path / "clone" / "run", "demo", "--out", "shown"]

    for setting_up in (True, False):
        done = subprocess.run(demo, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert ("setting up" in done.stderr) == setting_up
        assert "maps/good.yaml" in done.stdout
    assert (tmp_path / "shown/index.html").is_file()
    status = ["git", "-C", tmp_path / "clone", "status", "--porcelain"]
    assert subprocess.run(status, capture_output=True, check=True).stdout == b""
