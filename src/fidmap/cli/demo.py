"""`fidmap demo`."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Annotated

import typer

from fidmap.cli.score import score

MAPS = ("good", "noisy", "broken")


def demo(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where the reports go.")] = Path("fidmap-demo"),
) -> None:
    """Score the maps that come with fidmap: one arena, mapped well, with noise, and brokenly."""
    with resources.as_file(resources.files("fidmap") / "demo_data") as folder:
        maps = [str(folder / f"{name}.yaml") for name in MAPS]
        typer.echo(f"fidmap score {' '.join(f'{name}.yaml' for name in MAPS)} --arena arena.yaml --out {out}", err=True)
        score(maps, arena=str(folder / "arena.yaml"), out=out)
