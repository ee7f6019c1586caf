"""Real data that is absent: a skip with its reason on a user's machine, a failure in CI."""

from __future__ import annotations

from pathlib import Path

import pytest

from real_data import real_data


@pytest.mark.parametrize(("ci", "outcome"), [("", pytest.skip.Exception), ("true", pytest.fail.Exception)])
def test_absent_real_data(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ci: str, outcome: type[BaseException]
) -> None:
    """The reason names the folder and the variable that moves it."""
    monkeypatch.setenv("FIDMAP_REAL_DATA", str(tmp_path))
    monkeypatch.setenv("CI", ci)

    with pytest.raises(outcome, match="set FIDMAP_REAL_DATA"):
        real_data("nothing")
