"""Reports read back as losses per part and group: what the probability that one map is better is made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fidmap.report.json_line import Document
from fidmap.uncertainty.compare import GroupLoss, Losses, PartLoss

BIASED = 1.5


def losses_of(document: Document) -> Losses | None:
    """The losses of a report; None for one that does not hold them (an older version wrote it)."""
    parts, groups = document.get("parts"), document.get("groups")
    weights = _dict(_dict(document.get("provenance")).get("settings")).get("weights")
    if not (isinstance(parts, list) and parts and isinstance(groups, list) and isinstance(weights, dict)):
        return None
    try:
        return Losses(
            tuple(_part(one) for one in parts),
            tuple(_group(one) for one in groups),
            {n: float(w) for n, w in weights.items()},
        )
    except (KeyError, TypeError, ValueError):
        return None


def sizes_warning(documents: Mapping[str, Document]) -> str | None:
    """A sentence where maps of arenas with different numbers of parts are compared."""
    sizes = {len(found.parts) for one in documents.values() if (found := losses_of(one)) is not None}
    if len(sizes) < 2 or max(sizes) <= BIASED * min(sizes):
        return None
    return (
        f"The arenas have {min(sizes)} to {max(sizes)} parts. The fit adapts to few parts, which raises relative "
        "accuracy: maps of the smaller arenas look better than they are."
    )


def _part(one: Mapping[str, Any]) -> PartLoss:
    if one["assigned"] and one.get("relative_error_m") is not None and "relative_loss" not in one:
        raise KeyError("relative_loss")
    return PartLoss(
        str(one["id"]), bool(one["assigned"]), _fraction(one, "relative_loss"), _fraction(one, "global_loss")
    )


def _group(one: Mapping[str, Any]) -> GroupLoss:
    pairs: Sequence[Sequence[str]] = [one["parts"]] if "parts" in one else [pair["parts"] for pair in one["pairs"]]
    ids = tuple(dict.fromkeys(str(name) for pair in pairs for name in pair))
    return GroupLoss(str(one["class"]), ids, _fraction(one, "loss"))


def _fraction(one: Mapping[str, Any], key: str) -> float | None:
    value = one.get(key)
    return None if value is None else float(value)


def _dict(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}
