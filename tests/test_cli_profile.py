"""`fidmap profile`: a preset shown is a profile file to start from."""

from __future__ import annotations

from pathlib import Path

import pytest

from command_line import fault, fidmap
from fidmap.profiles import names, profile, read_profile


def test_list() -> None:
    assert fidmap("profile", "list").stdout.split() == ["continuous", "ssrr2011"] == list(names())


@pytest.mark.parametrize("name", ["continuous", "ssrr2011"])
def test_what_is_shown_reads_back_as_the_same_profile(tmp_path: Path, name: str) -> None:
    (tmp_path / "p.yaml").write_text(fidmap("profile", "show", name).stdout)
    assert read_profile(tmp_path / "p.yaml") == profile(name)


def test_a_file_is_shown_complete(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("fidmap_profile: 1\nname: mine\nmin_opening: 0.5\n")
    shown = fidmap("profile", "show", tmp_path / "mine.yaml").stdout
    assert "name: mine\n" in shown
    assert "min_opening: 0.5\n" in shown
    assert "facing_tolerance_deg: 60.0\n" in shown


def test_faults_and_usage() -> None:
    assert fault("profile", "show", "none") == "none: neither a profile (continuous, ssrr2011) nor a file"
    assert fidmap("profile", "show").exit_code == 2
    assert fidmap("profile").exit_code == 2
