"""Reports read back as losses per part and group: what the probability that one map is better is made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

from fidmap.report.json_line import Document
from fidmap.uncertainty.compare import SURE, GroupLoss, Losses, PartLoss, probability_better

BIASED = 1.5
A_TIE = f"truly better than the next with less than {100 * SURE:.0f} %"


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


def better_than_next(documents: Sequence[Document]) -> list[float | None]:
    """For reports in their order the probability that each map's mapper is truly better overall than the next one's.

    None where it cannot be told, as for the last.
    """
    losses = [losses_of(document) if _has_overall(document) else None for document in documents]
    told = [None if one is None or other is None else probability_better(one, other) for one, other in pairwise(losses)]
    return [*told, None]


def doubt(probability: float | None) -> str:
    """`97 %`, or `~ 71 %` where that is no more than a tie."""
    if probability is None:
        return "-"
    return f"{'~ ' * (probability < SURE)}{min(99.9, 100 * probability):.{0 if probability < 0.995 else 1}f} %"


def _has_overall(document: Document) -> bool:
    overall = _dict(_dict(document.get("attributes")).get("overall"))
    return overall.get("value") is not None


def sizes_warning(documents: Sequence[Document]) -> str | None:
    """A sentence where maps of arenas with different numbers of parts are compared."""
    sizes = {len(found.parts) for one in documents if (found := losses_of(one)) is not None}
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
