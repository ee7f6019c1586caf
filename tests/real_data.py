"""Where the real maps lie: data that nobody in this project made, so it is never part of it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def real_data(*parts: str) -> Path:
    """A file or folder of the real data; skips with a reason where it is absent, fails where CI is true."""
    folder = Path(os.environ.get("FIDMAP_REAL_DATA") or ROOT.parent / "shared" / "data")
    path = folder.joinpath(*parts)
    if not path.exists():
        reason = f"{path} is absent; set FIDMAP_REAL_DATA to the folder of real maps"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    return path
