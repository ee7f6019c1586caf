"""Contact sheets of a detector's worst faults, so that the next person sees what to mend."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from benchmarks.detect_maps import Fault

TILE, CAPTION, COLUMNS, ROWS = 132, 24, 6, 4
GREYS = np.array([255, 190, 0], np.uint8)  # free, unknown, occupied
DASH = 20  # degrees
COLOUR = {"miss": (0, 110, 200), "false": (200, 40, 40)}


def worst(faults: Sequence[Fault], kind: str, number: int = COLUMNS * ROWS) -> list[Fault]:
    """The heaviest faults of a kind, the tiers taking turns, so that no tier hides the others."""
    tiers: dict[str, list[Fault]] = {}
    for fault in sorted((f for f in faults if f.kind == kind), key=lambda f: (-f.weight, f.map)):
        tiers.setdefault(fault.map.rsplit("-", 1)[0], []).append(fault)
    turns = zip_longest(*(tiers[tier] for tier in sorted(tiers)))
    return [fault for turn in turns for fault in turn if fault is not None][:number]


def write_sheet(path: Path, faults: Sequence[Fault]) -> None:
    """A PNG of tiles: the map about each fault, the arc that is missed (blue) or was found (red)."""
    rows = max(1, -(-len(faults) // COLUMNS))
    sheet = Image.new("RGB", (COLUMNS * (TILE + 4), rows * (TILE + CAPTION + 4)), "white")
    for n, fault in enumerate(faults):
        sheet.paste(_tile(fault), (n % COLUMNS * (TILE + 4) + 2, n // COLUMNS * (TILE + CAPTION + 4) + 2))
    path.parent.mkdir(parents=True, exist_ok=True)
    sheet.quantize(48).save(path, optimize=True)


def _tile(fault: Fault) -> Image.Image:
    tile = Image.new("RGB", (TILE, TILE + CAPTION), "white")
    picture = Image.fromarray(GREYS[fault.labels][::-1]).convert("RGB").resize((TILE, TILE), Image.Resampling.NEAREST)
    tile.paste(picture)
    draw = ImageDraw.Draw(tile)
    side = fault.labels.shape[0]
    scale = TILE / side
    x, y = fault.centre_rc[1] * scale, (side - fault.centre_rc[0]) * scale
    r = fault.radius * scale
    middle = 0.0 if fault.facing is None else -math.degrees(fault.facing)  # pictures count angles clockwise
    half = 180 if fault.facing is None else 90
    for angle in range(-half, half, DASH):  # what the map draws shows between the dashes
        start = middle + angle + DASH / 4
        draw.arc((x - r, y - r, x + r, y + r), start, start + DASH / 2, COLOUR[fault.kind], 2)
    told = f"drawn {fault.weight:.0%}, best {fault.best:.2f}" if fault.kind == "miss" else f"sure {fault.weight:.2f}"
    draw.text((1, TILE), f"{fault.map} {100 * fault.resolution_m:g} cm", "black", font_size=10)
    draw.text((1, TILE + 11), told, "black", font_size=10)
    return tile
