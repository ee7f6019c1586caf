"""fidmap scores robot maps by the fiducials drawn in them (the Fiducial Map Metric, SSRR 2011).

grid = fidmap.read_map("map.yaml")
arena = fidmap.read_arena("arena.yaml")
report = fidmap.evaluate(grid, arena)
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from fidmap.version import __version__

if TYPE_CHECKING:
    from fidmap.arena import read_arena
    from fidmap.detect import find_barrel_parts
    from fidmap.evaluate import evaluate, evaluate_points
    from fidmap.grid import trinarize
    from fidmap.maps import read_map
    from fidmap.points import read_points
    from fidmap.profiles import profile, read_profile

__all__ = [
    "__version__",
    "evaluate",
    "evaluate_points",
    "find_barrel_parts",
    "profile",
    "read_arena",
    "read_map",
    "read_points",
    "read_profile",
    "trinarize",
]

_HOME = {
    "evaluate": "evaluate",
    "evaluate_points": "evaluate",
    "find_barrel_parts": "detect",
    "profile": "profiles",
    "read_arena": "arena",
    "read_map": "maps",
    "read_points": "points",
    "read_profile": "profiles",
    "trinarize": "grid",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that `fidmap --help` stays quick."""
    if name not in _HOME:
        raise AttributeError(f"module 'fidmap' has no attribute {name!r}")
    value = getattr(import_module(f"fidmap.{_HOME[name]}"), name)
    globals()[name] = value
    return value


class _Package(ModuleType):
    """Keeps `fidmap.evaluate` the function: importing the module of that name would put itself in its place."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _HOME and isinstance(value, ModuleType):
            value = getattr(value, name)
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
