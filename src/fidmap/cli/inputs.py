"""The maps of one command line: each once, in the order given; and how far the work is."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from fidmap.cli.exits import complain

if TYPE_CHECKING:
    from rich.progress import Progress


def distinct(paths: Sequence[str], alone: bool) -> list[str]:
    """Every map once: an image whose own YAML is named too is left out, with a note.

    Args:
        paths: as the user named them.
        alone: images are read without their YAML, since a resolution was given.
    """
    from fidmap.maps import main_file

    seen: dict[Path, int] = {}
    for k in sorted(range(len(paths)), key=lambda k: not paths[k].lower().endswith((".yaml", ".yml"))):
        main = Path(os.path.realpath(paths[k])) if alone else main_file(paths[k])
        if main in seen:
            complain(f"note: {paths[k]} is the same map as {paths[seen[main]]}; it is taken once")
        else:
            seen[main] = k
    return [paths[k] for k in sorted(seen.values())]


def progress_bar(total: int, stdout_is_used: bool) -> Progress:
    """A bar on stderr where somebody may see it; never between the lines of a result on the same terminal."""
    from rich.console import Console
    from rich.progress import Progress

    hidden = total < 2 or not sys.stderr.isatty() or (stdout_is_used and sys.stdout.isatty())
    return Progress(console=Console(stderr=True), transient=True, redirect_stdout=False, disable=hidden)
