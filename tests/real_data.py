"""Real data that is not part of the project: at FIDMAP_REAL_DATA, beside the checkout by default."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

DEFAULT = Path(__file__).resolve().parents[1] / ".." / "shared" / "data"


def real_data(*parts: str) -> Path:
    """The path of a real file or folder; skips the test loudly where it is absent, and fails it in CI."""
    path = Path(os.environ.get("FIDMAP_REAL_DATA", DEFAULT)).resolve().joinpath(*parts)
    if path.exists():
        return path
    reason = f"no real data at {path}; set FIDMAP_REAL_DATA to its folder"
    if os.environ.get("CI") == "true":
        pytest.fail(reason)
    pytest.skip(reason)
