"""docs/benchmarks.md: one section per benchmark, each written by its own run and left alone by the others."""

from __future__ import annotations

import platform
import re
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from fidmap.version import __version__

PAGE = Path(__file__).resolve().parents[1] / "docs" / "benchmarks.md"
HEAD = """# Benchmarks

Each section is written by its own command: `./run bench real` (scores on real maps), `./run bench detect` (barrel parts
found), `./run bench sharpness` (resolution quality), `./run bench register` (registrations), `./run bench uncertainty`
(intervals), `./run bench formats` (readers), `./run bench evening` (speed), and so on. Real maps are not part of the
project: the benchmarks read them from the folder that `FIDMAP_REAL_DATA` names, and what was tuned on is said beside
each figure. Times are of whatever machine ran last, so compare ratios, not seconds.
"""


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def write_section(name: str, text: str) -> None:
    """Put a section between its markers, in the order in which sections were first written."""
    page = PAGE.read_text(encoding="utf-8") if PAGE.is_file() else HEAD
    when = datetime.now(UTC).strftime("%Y-%m-%d")
    stamp = f"fidmap {__version__}, Python {platform.python_version()}, {when}."
    section = f"<!-- {name} -->\n{text.strip()}\n\n{stamp}\n<!-- /{name} -->\n"
    pattern = re.compile(rf"<!-- {name} -->.*?<!-- /{name} -->\n", re.S)
    page = pattern.sub(lambda _: section, page) if pattern.search(page) else f"{page}\n{section}"
    PAGE.write_text(page, encoding="utf-8")
