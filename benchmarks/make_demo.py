"""Writes the maps that come with fidmap, and their arena: `./run bench make_demo [FOLDER]`."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import yaml
from PIL import Image

from fidmap.grid import trinarize
from fidmap.model import Arena, Grid
from fidmap.synth.demo import demo_maps

DEMO_DATA = Path(__file__).resolve().parents[1] / "src" / "fidmap" / "demo_data"
GREY = np.array([254, 205, 0], np.uint8)  # map_server's free, unknown, occupied, in the order of `Label`


def write_map(folder: Path, name: str, grid: Grid) -> None:
    """One map as map_server writes it: PGM and YAML, thresholds that keep 205 unknown."""
    labels = trinarize(grid).labels
    Image.fromarray(GREY[labels][::-1]).save(folder / f"{name}.pgm")
    origin = [round(grid.origin.x_m, 6), round(grid.origin.y_m, 6), 0.0]
    text = yaml.safe_dump(
        {
            "image": f"{name}.pgm",
            "resolution": grid.resolution_m,
            "origin": origin,
            "negate": 0,
            "occupied_thresh": 0.65,
            "free_thresh": 0.196,
        },
        sort_keys=False,
        default_flow_style=None,
    )
    (folder / f"{name}.yaml").write_text(text, encoding="utf-8")


def write_arena(path: Path, arena: Arena) -> None:
    """The arena file: positions to 0.1 mm, as a survey would give them."""
    lines = ["fidmap_arena: 1", f"name: {arena.name}", f"radius_m: {arena.radius_m}", f"frame: {arena.frame}"]
    lines += [f"pallet_m: {arena.pallet_m}", "parts:"]
    for part in arena.parts:
        assert part.x_m is not None
        assert part.y_m is not None
        row = {"id": part.id, "x_m": round(part.x_m, 4), "y_m": round(part.y_m, 4)}
        if part.facing is not None:
            row["facing_deg"] = round(float(np.degrees(part.facing)), 4)
        lines.append(f"  - {_flow(row)}")
    lines.append("groups:")
    for group in arena.groups:
        row = {"id": group.id, "parts": list(group.parts), "walking_pallets": int(group.walking_pallets or 0)}
        lines.append(f"  - {_flow(row)}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _flow(row: dict[str, object]) -> str:
    return yaml.safe_dump(row, sort_keys=False, default_flow_style=True, width=1000).strip()


def write_demo(folder: Path) -> None:
    """The arena and its maps."""
    folder.mkdir(parents=True, exist_ok=True)
    arena, maps = demo_maps()
    write_arena(folder / "arena.yaml", arena.arena)
    for name, grid in maps:
        write_map(folder, name, grid)


if __name__ == "__main__":
    write_demo(Path(sys.argv[1]) if len(sys.argv) > 1 else DEMO_DATA)
