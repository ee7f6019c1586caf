"""Faults between the values of an arena file: ids, positions, groups and their classes.

They are looked for in the document as written, not in the validated models, so that one wrong number
elsewhere does not hide them: all faults of a file are told at once. What is wrong for itself is left to the
schema.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any, TypeGuard

from fidmap.file_schema import place, word_of
from fidmap.model import ATTRIBUTES, LONG, SHORT
from fidmap.text_file import quoted

PAIRS_MAX = 200_000
RESERVED_CLASSES = (*ATTRIBUTES, "overall")

Row = Mapping[str, Any]


def cross_faults(document: Row, limit: float | None) -> list[str]:
    """Every fault between values, each as 'PLACE: what is wrong'.

    Args:
        document: the file's mapping.
        limit: walking pallets over which a group is long; None where nobody has set it yet.
    """
    parts, groups = _rows(document, "parts"), _rows(document, "groups")
    faults = [*_repeated_ids(document, "parts"), *_repeated_ids(document, "groups")]
    faults += _part_faults(document, parts)
    by_id = {word_of(row.get("id")): row for row in parts.values()}
    for index, group in groups.items():
        where = place(("groups", index), document)
        told = (*_member_faults(group, by_id), *_class_faults(group, limit))
        faults += [f"{where}: {fault}" for fault in told]
    faults += _twin_groups(document, groups, limit)
    pairs = sum(len(_members(group)) * (len(_members(group)) - 1) // 2 for group in groups.values())
    if pairs > PAIRS_MAX:
        faults.append(f"groups: compare {pairs} pairs of parts, at most {PAIRS_MAX} are allowed")
    return faults


def _rows(document: Row, key: str) -> dict[int, Row]:
    """The entries of a list that are mappings, by their place in it."""
    entries = document.get(key)
    return {i: row for i, row in enumerate(entries) if isinstance(row, dict)} if isinstance(entries, list) else {}


def _repeated_ids(document: Row, key: str) -> Iterator[str]:
    first: dict[str, int] = {}
    for index, row in _rows(document, key).items():
        word = word_of(row.get("id"))
        if word and first.setdefault(word, index) != index:
            yield f"{key}[{index}].id: '{word}' is already the id of {key}[{first[word]}]"


def _has(row: Row, key: str) -> bool:
    return row.get(key) is not None


def _part_faults(document: Row, parts: Mapping[int, Row]) -> Iterator[str]:
    """Reserved ids, half positions, parts without a position among parts with one."""
    placed = [_has(row, "x_m") and _has(row, "y_m") for row in parts.values()]
    for index, row in parts.items():
        where = place(("parts", index), document)
        if row.get("id") == "-":
            yield f"parts[{index}].id: '-' means 'no part' in points files, choose another id"
        if _has(row, "x_m") != _has(row, "y_m"):
            given, absent = ("x_m", "y_m") if _has(row, "x_m") else ("y_m", "x_m")
            yield f"{where}: {given} without {absent}, give both or none"
        elif any(placed) and not _has(row, "x_m"):
            yield f"{where}: has no position though others have, give x_m and y_m for all parts or for none"
    if document.get("frame") == "map" and placed and not any(placed):
        yield "frame: 'map' needs positions, give x_m and y_m for all parts"


def _members(group: Row) -> list[str]:
    entries = group.get("parts")
    words = [word_of(entry) for entry in entries] if isinstance(entries, list) else []
    return [word for word in words if word]


def _member_faults(group: Row, by_id: Mapping[str | None, Row]) -> Iterator[str]:
    """Unknown and repeated parts, and distances that are given to many or to nobody."""
    members = _members(group)
    for word, times in Counter(members).items():
        if word not in by_id:
            yield f"part '{word}' is not in parts"
        if times > 1:
            yield f"part '{word}' is named twice"
    if len(members) > 2 and _has(group, "distance_m"):
        yield f"distance_m is for two parts, not {len(members)}"
    unplaced = [word for word in members if word in by_id and not _has(by_id[word], "x_m")]
    if len(members) >= 2 and unplaced and not _has(group, "distance_m"):
        remedy = "distance_m" if len(members) == 2 else "positions or split it into pairs with distance_m"
        yield f"part '{unplaced[0]}' has no position, so the group needs {remedy}"


def _class_faults(group: Row, limit: float | None) -> Iterator[str]:
    """A class that is missing, reserved, or contradicted by the walking distance (SSRR 2011, III)."""
    named, pallets = word_of(group.get("class")), group.get("walking_pallets")
    if not _has(group, "class") and pallets is None:
        yield "needs class or walking_pallets"
    if named in RESERVED_CLASSES:
        yield f"class '{named}' is the name of an attribute, choose another"
    if named in {SHORT, LONG} and limit is not None and _is_number(pallets) and named != _by_way(pallets, limit):
        yield f"class {named} contradicts walking_pallets {quoted(pallets)} (over {limit:g} is long)"


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _by_way(pallets: float, limit: float) -> str:
    return LONG if pallets > limit else SHORT


def _twin_groups(document: Row, groups: Mapping[int, Row], limit: float | None) -> Iterator[str]:
    """Two groups of one class that compare the same parts would count twice."""
    first: dict[tuple[object, frozenset[str]], int] = {}
    for index, group in groups.items():
        named, pallets, members = word_of(group.get("class")), group.get("walking_pallets"), _members(group)
        key: object = named
        if named is None and _is_number(pallets):
            key = float(pallets) if limit is None else _by_way(pallets, limit)
        if key is None or len(members) < 2:
            continue
        earlier = first.setdefault((key, frozenset(members)), index)
        if earlier != index:
            yield (
                f"{place(('groups', index), document)}: compares the same parts in the same class"
                f" as {place(('groups', earlier), document)}"
            )
