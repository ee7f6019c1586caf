"""One row of `./run bench formats`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fidmap.model import Grid


@dataclass(frozen=True)
class Row:
    """One format: `write` makes `folder/name...` and returns what is read; `decode` returns the decoded bytes.

    options: what `read_map` needs beside the path. points: how far attributes may lie from the PGM's.
    across: pixels across a cell, so that pictures of times and memory have the same size in pixels.
    """

    name: str
    write: Callable[[Path, Grid], Path]
    decode: Callable[[Path], int]
    options: dict[str, Any] = field(default_factory=dict)
    points: float = 1.0
    across: int = 1
