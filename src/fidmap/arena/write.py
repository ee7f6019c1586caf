"""An `Arena` to its file, as a person would write it: one line per part and group."""

from __future__ import annotations

import math
from pathlib import Path

import yaml

from fidmap.model import Arena, FiducialPart, Group
from fidmap.output_file import write_whole

Row = dict[str, object]
SAME_M = 1e-4  # a distance this near to what the positions say is left out


def write_arena(path: Path, arena: Arena) -> None:
    """Write an arena file: positions to 0.1 mm, as a survey would give them.

    Raises:
        OutputError: the place cannot be written.
    """
    write_whole(path, arena_text(arena).encode())


def arena_text(arena: Arena) -> str:
    """The text of an arena file."""
    top: Row = {"fidmap_arena": 1, "name": arena.name, "radius_m": _short(arena.radius_m), "frame": arena.frame}
    if arena.pallet_m is not None:
        top["pallet_m"] = _short(arena.pallet_m)
    places = {part.id: (part.x_m, part.y_m) for part in arena.parts if part.x_m is not None and part.y_m is not None}
    lines = [yaml.safe_dump(top, sort_keys=False, allow_unicode=True).rstrip(), "parts:"]
    lines += [f"  - {_flow(_part(part))}" for part in arena.parts]
    if arena.groups:
        lines += ["groups:", *(f"  - {_flow(_group(group, places))}" for group in arena.groups)]
    return "\n".join(lines) + "\n"


def _part(part: FiducialPart) -> Row:
    """A part's row; the opening only where it is not what the facing says."""
    usual = 2 * math.pi if part.facing is None else math.pi
    row: Row = {
        "id": part.id,
        "x_m": _short(part.x_m),
        "y_m": _short(part.y_m),
        "z_m": _short(part.z_m),
        "facing_deg": None if part.facing is None else _short(math.degrees(part.facing)),
        "opening_deg": None if abs(part.opening - usual) < 1e-6 else _short(math.degrees(part.opening)),
        "sigma_m": _short(part.sigma_m),
    }
    return {key: value for key, value in row.items() if value is not None}


def _group(group: Group, places: dict[str, tuple[float, float]]) -> Row:
    """A group's row; a way that does not exist (nobody can walk it) is called long."""
    row: Row = {"id": group.id, "parts": list(group.parts)}
    way = group.walking_pallets
    if group.named_class is not None:
        row["class"] = group.named_class
    elif way is not None and not math.isfinite(way):
        row["class"] = "long"
    if way is not None and math.isfinite(way):
        row["walking_pallets"] = int(way) if float(way).is_integer() else round(way, 2)
    if group.distance_m is not None and not _follows(group, places):
        row["distance_m"] = _short(group.distance_m)
    return row


def _follows(group: Group, places: dict[str, tuple[float, float]]) -> bool:
    """Whether a group's distance is the one between its parts' positions."""
    if group.distance_m is None or any(part not in places for part in group.parts):
        return False
    first, second = (places[part] for part in group.parts)
    return abs(math.dist(first, second) - group.distance_m) < SAME_M


def _short(value: float | None) -> float | None:
    return None if value is None else round(float(value), 4)


def _flow(row: Row) -> str:
    return yaml.safe_dump(row, sort_keys=False, default_flow_style=True, width=1000, allow_unicode=True).strip()
