"""Writes the maps that come with fidmap, and their arena: `./run bench make_demo [FOLDER]`."""

from __future__ import annotations

import sys
from pathlib import Path

from fidmap.arena.write import write_arena
from fidmap.maps.write import write_map
from fidmap.synth.demo import demo_maps

DEMO_DATA = Path(__file__).resolve().parents[1] / "src" / "fidmap" / "demo_data"


def write_demo(folder: Path) -> None:
    """The arena and its maps."""
    arena, maps = demo_maps()
    write_arena(folder / "arena.yaml", arena.arena)
    for name, grid in maps:
        write_map(folder, name, grid)


if __name__ == "__main__":
    write_demo(Path(sys.argv[1]) if len(sys.argv) > 1 else DEMO_DATA)
