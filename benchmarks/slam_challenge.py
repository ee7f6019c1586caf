"""The real maps of `slam_challenge` and their truth."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

from benchmarks.counting import DrawnPart

ROOT = Path(__file__).resolve().parents[1]
TUNED_ON = ("m28", "m29", "m30", "m33", "m34", "m35", "m59")
REFERENCE = ("m68", "m69")
__all__ = ["DrawnPart", "read_drawn_parts", "real_data_root"]


def real_data_root() -> Path:
    """Where the real maps are: FIDMAP_REAL_DATA, or the folder beside the checkout."""
    return Path(os.environ.get("FIDMAP_REAL_DATA", ROOT.parent / "shared" / "data"))


def read_drawn_parts(folder: Path, name: str) -> tuple[DrawnPart, ...]:
    """The truth file of one map."""
    document = json.loads((folder / "truth" / f"parts_{name}.json").read_text(encoding="utf-8"))
    return tuple(_drawn_part(part) for part in document["parts"])


def _drawn_part(part: dict[str, object]) -> DrawnPart:
    def number(key: str) -> float | None:
        value = part.get(key)
        return None if value is None else float(str(value))

    out = part.get("facing")
    facing = math.atan2(float(out[1]), float(out[0])) if isinstance(out, list) else None
    copies = part.get("other_copies")
    found = tuple((float(c["x"]), float(c["y"])) for c in copies) if isinstance(copies, list) else ()
    return DrawnPart(str(part["id"]), number("x"), number("y"), facing, str(part["drawn"]), found)
