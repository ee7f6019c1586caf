"""Folder names for reports: short, distinct, and safe on every file system."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from pathlib import Path, PurePath

LONGEST = 60
RESERVED = {"index.html"}


def report_names(paths: Sequence[str | Path]) -> list[str]:
    """The shortest distinct tails of map paths, joined by `_`, like teamA_map and teamB_map.

    Names differ also where a file system does not tell capitals apart.

    Args:
        paths: as the user named them, in any order.

    Returns:
        One name per path, in the order given.
    """
    parts = [_parts(path) for path in paths]
    names = _shortest_distinct(parts, [False] * len(parts))
    twins = _shared(names)  # whole paths that differ only in their suffix, like map.pgm and map.yaml
    names = _shortest_distinct(parts, twins) if any(twins) else names
    return _numbered(names)


def _parts(path: str | Path) -> tuple[str, ...]:
    """The folders and the file of a path, from the root; `..` and a bare name are told apart only there."""
    return PurePath(os.path.abspath(path)).parts[1:] or ("map",)  # noqa: PTH100 resolve() would follow links


def _shortest_distinct(parts: Sequence[tuple[str, ...]], with_suffix: Sequence[bool]) -> list[str]:
    """Lengthen tails that are shared, one folder at a time, until none is or all folders are used."""
    depths = [1] * len(parts)
    while True:
        names = [_name(*entry) for entry in zip(parts, depths, with_suffix, strict=True)]
        longer = [
            depth < len(part) for depth, part, shared in zip(depths, parts, _shared(names), strict=True) if shared
        ]
        if not any(longer):
            return names
        depths = [
            min(depth + shared, len(part)) for depth, part, shared in zip(depths, parts, _shared(names), strict=True)
        ]


def _shared(names: Sequence[str]) -> list[bool]:
    counts = Counter(name.casefold() for name in names)
    return [counts[name.casefold()] > 1 for name in names]


def _name(parts: tuple[str, ...], depth: int, with_suffix: bool) -> str:
    file = PurePath(parts[-1])
    last = f"{file.stem}_{file.suffix[1:]}" if with_suffix and file.suffix else file.stem
    return safe_name("_".join([*parts[len(parts) - depth : -1], last]))


def safe_name(text: str) -> str:
    """Letters, digits, `_`, `-` and inner dots of any text, at most 60 of them, the end being kept."""
    kept = "".join(letter if letter.isalnum() or letter in "_-." else "-" for letter in text)
    name = kept[-LONGEST:].strip(".-") or "map"
    return name.replace(".", "_") if name.casefold() in RESERVED else name


def _numbered(names: Sequence[str]) -> list[str]:
    """Tell the last twins apart by number: the same map named twice, or names that cleaning made equal."""
    taken: set[str] = set()
    result = []
    for name in names:
        chosen, number = name, 1
        while chosen.casefold() in taken:
            number += 1
            chosen = f"{name}-{number}"
        taken.add(chosen.casefold())
        result.append(chosen)
    return result
