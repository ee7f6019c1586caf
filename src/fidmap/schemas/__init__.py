"""JSON Schemas of what fidmap reads and writes: arena and profile files, lines of `score`, `detect` and `inspect`."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from fidmap.arena import arena_json_schema
from fidmap.profiles import profile_json_schema

NAMES = ("arena", "profile", "report", "detect", "inspect")
_DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema(name: str) -> dict[str, Any]:
    """A shipped schema (draft 2020-12) by its name in `NAMES`."""
    loaded: dict[str, Any] = json.loads((files(__name__) / f"{name}.schema.json").read_text(encoding="utf-8"))
    return loaded


def generated() -> dict[str, str]:
    """The text of the schemas that follow from the file models; `python -m fidmap.schemas` writes them."""
    bodies = {"arena": arena_json_schema(), "profile": profile_json_schema()}
    return {
        name: json.dumps({"$schema": _DIALECT, **body, "title": f"A fidmap {name} file"}, indent=2) + "\n"
        for name, body in bodies.items()
    }
