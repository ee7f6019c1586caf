"""`--fail-under`: which attributes must reach which value."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fidmap.cli.exits import usage

if TYPE_CHECKING:
    from fidmap.model import Arena


def split_gates(words: Sequence[str], maps: Sequence[str]) -> tuple[list[str], list[str]]:
    """Gates and maps: `--fail-under coverage=0.9 consistency=0.8` leaves its second word among the maps."""
    if not words:
        return [], list(maps)
    names = _names()
    gates = [word for word in maps if "=" in word and word.partition("=")[0] in names]
    return [*words, *gates], [word for word in maps if word not in gates]


def _names() -> set[str]:
    """What every report has; an arena may name more classes."""
    from fidmap.model import ATTRIBUTES, LONG, SHORT

    return {*ATTRIBUTES, SHORT, LONG, "overall"}


def parse_gates(words: Iterable[str], arena: Arena) -> dict[str, float]:
    """`0.8` (overall) or `NAME=0.9`, NAME an attribute or a class of the arena's groups, to limits."""
    known = {*_names(), *(g.named_class for g in arena.groups if g.named_class)}
    limits: dict[str, float] = {}
    for word in words:
        name, equals, number = word.rpartition("=")
        name = name if equals else "overall"
        try:
            limit = float(number)
        except ValueError:
            limit = math.nan
        if name not in known:
            raise usage(f"--fail-under {word}: no attribute '{name}'; known are {', '.join(sorted(known))}")
        if not 0 <= limit <= 1:
            raise usage(f"--fail-under {word}: the limit must be a fraction between 0 and 1")
        limits[name] = limit
    return limits


def failures(document: Mapping[str, Any], limits: Mapping[str, float]) -> list[str]:
    """One sentence per gate that a report fails; a value that is not computable fails."""
    attributes = document["attributes"]
    found = []
    for name, limit in limits.items():
        value = attributes.get(name) or attributes["consistency"]["classes"].get(name, {})
        if value.get("value") is None:
            reason = value.get("reason", "the arena has no such group")
            found.append(f"{document['map']}: {name} is not computable ({reason}); the gate asks for {limit:.3f}")
        elif value["value"] < limit:
            found.append(f"{document['map']}: {name} {value['value']:.3f} is under {limit:.3f}")
    return found
