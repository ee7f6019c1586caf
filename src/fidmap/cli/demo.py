"""`fidmap demo`."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Annotated

import typer

from fidmap.cli.exits import complain
from fidmap.cli.score import score

MAPS = ("good", "noisy", "broken")


def demo(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where maps and reports go.")] = Path("fidmap-demo"),
) -> None:
    """Score the maps that come with fidmap: one arena, mapped well, with noise, and brokenly."""
    from fidmap.report.files import check_output, write_files

    check_output(out)
    data = resources.files("fidmap") / "demo_data"
    folder = write_files(out, "maps", {entry.name: entry.read_bytes() for entry in data.iterdir() if entry.is_file()})
    maps, arena = [str(folder / f"{name}.yaml") for name in MAPS], str(folder / "arena.yaml")
    complain(f"this is: fidmap score {' '.join(maps)} --arena {arena} --out {out}")
    score(maps, arena=arena, out=out)
