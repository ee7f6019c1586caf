"""The command line in tests: `fidmap(...)` in this process, and the demo maps in a folder to work in.

What an evaluation found is remembered by everything that it depends on, so that the many tests of options, files
and exit codes do not search for the same registration again; processes of a pool know nothing of it.
"""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from typer.testing import CliRunner, Result

import fidmap as package
from fidmap.cli import app
from fidmap.evaluate import evaluate
from fidmap.model import Arena, Grid, Report, Settings, StartPose
from fidmap.schemas import schema

DEMO_DATA = Path(package.__file__).parent / "demo_data"
ARENA = ("--arena", "arena.yaml")
ONE = (*ARENA, "--workers", "1")


def fidmap(*words: object) -> Result:
    """Run the program; anything but an exit code is a bug of ours and is raised."""
    result = CliRunner().invoke(app, [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def fault(*words: object) -> str:
    """The one sentence of a run that ends in exit 1 with nothing on stdout."""
    result = fidmap(*words)
    assert result.exit_code == 1, result.output
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith("fidmap: ")
    return result.stderr.removeprefix("fidmap: ").rstrip("\n")


def documents(text: str, name: str = "report") -> list[dict[str, Any]]:
    """JSON Lines, each valid by a shipped schema."""
    found = [json.loads(line) for line in text.splitlines()]
    validator = Draft202012Validator(schema(name))
    for document in found:
        validator.validate(document)
    return found


def without_seconds(document: dict[str, Any]) -> dict[str, Any]:
    """A report document but for the time it took."""
    return {**document, "provenance": {k: v for k, v in document["provenance"].items() if k != "seconds"}}


def evening(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in a folder that holds the demo maps and their arena."""
    for file in DEMO_DATA.iterdir():
        if file.is_file():
            shutil.copyfile(file, folder / file.name)
    monkeypatch.chdir(folder)
    monkeypatch.setattr("fidmap.study.jobs.evaluate", remembered)
    monkeypatch.setattr("os.cpu_count", lambda: 1)  # a pool only where a test asks for one
    return folder


_REPORTS: dict[str, Report] = {}


def remembered(
    grid: Grid, arena: Arena, settings: Settings, start: StartPose | None = None, *, fast: bool = False
) -> Report:
    """`evaluate`, once per grid, arena, settings and start pose."""
    read_with = (grid.source.sha256, grid.resolution_m, grid.origin, grid.free_thresh, grid.occupied_thresh)
    key = repr((*read_with, arena, settings, start, fast))
    if key not in _REPORTS:
        _REPORTS[key] = evaluate(grid, arena, settings, start, fast=fast)
    found = _REPORTS[key]
    return replace(found, map=grid.source, findings=(*grid.source.findings, *found.assignment.findings))
