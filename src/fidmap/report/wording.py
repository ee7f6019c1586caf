"""How numbers and names are said to people: units on everything, nothing hostile in a name."""

from __future__ import annotations

import re

ATTRIBUTE_TITLES = {
    "coverage": "Coverage",
    "relative_accuracy": "Relative accuracy",
    "consistency": "Consistency",
    "global_accuracy": "Global accuracy",
    "resolution_quality": "Resolution quality",
    "overall": "Overall",
}

ATTRIBUTE_MEANINGS = {
    "coverage": "share of the fiducial parts that the map shows",
    "relative_accuracy": "how near the parts are to their places after the best fit",
    "consistency": "how well distances between the two parts of a fiducial are kept",
    "global_accuracy": "how near the parts are to their places in the agreed frame",
    "resolution_quality": "how sharply the arcs are drawn",
    "overall": "weighted mean of the attributes that could be computed",
}

# Control characters, lone surrogates, direction overrides and what XML forbids: a file name may hold them, a
# terminal or an XML parser must not see them.
_HOSTILE = re.compile("[\x00-\x1f\x7f-\x9f\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]")


def clean(text: object) -> str:
    """Text from a file or a file name, made safe to show; escaping for HTML or SVG comes after it."""
    return _HOSTILE.sub("\ufffd", str(text))


def sentence(text: object) -> str:
    """Cleaned text with a full stop where it has none, so that more can follow."""
    cleaned = clean(text)
    return cleaned if cleaned.endswith((".", "!", "?")) else f"{cleaned}."


def shortened(text: str, limit: int) -> str:
    """The end of a long name: with paths it is the end that tells two of them apart."""
    return text if len(text) <= limit else "…" + text[len(text) - limit + 1 :]


def percent(fraction: float | None) -> str:
    """A score for people: one decimal, with its unit."""
    return "–" if fraction is None else f"{100 * fraction:.1f} %"


def bounds(low: float | None, high: float | None) -> str:
    """An interval for people, `(76 to 86)`, after its score's percent; tenths where it is narrower than 5 points."""
    if low is None or high is None:
        return ""
    digits = 0 if high - low >= 0.05 else 1
    return f"({100 * low:.{digits}f} to {100 * high:.{digits}f})"


def metres(value: float | None, digits: int = 3) -> str:
    """A length with its unit; a millimetre is below what any map resolves."""
    return "–" if value is None else f"{_no_minus_zero(value, digits)} m"


def degrees(value: float | None) -> str:
    """An angle, given in degrees, with its unit."""
    return "–" if value is None else f"{_no_minus_zero(value, 1)}°"


def _no_minus_zero(value: float, digits: int) -> str:
    text = f"{value:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0 else text


def attribute_title(name: str) -> str:
    """The heading of an attribute; classes of groups keep the name that the arena file gave them."""
    return ATTRIBUTE_TITLES.get(name, name)
