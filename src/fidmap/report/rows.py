"""Several maps side by side: what the index page and the terminal table share."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

from fidmap.ranking import TIE_WITHIN, ranks
from fidmap.report.json_line import Document
from fidmap.report.wording import bounds, clean, sentence

COLUMNS = ("coverage", "relative_accuracy", "consistency")
LEVELS = ("error", "warning", "note")


@dataclass(frozen=True)
class Row:
    """One map: its report document or its error document, its rank ('4-5') and its report's folder."""

    document: Document
    rank: str | None = None
    folder: str | None = None

    @property
    def name(self) -> str:
        """The map's name, safe to show."""
        return clean(self.document["map"])

    @property
    def error(self) -> str | None:
        """Why the map could not be used; None for a scored one."""
        error = self.document.get("error")
        return None if error is None else clean(error["text"])

    def score(self, attribute: str) -> float | None:
        """An attribute as a fraction, None where it is not computable."""
        value = self.document["attributes"].get(attribute, {}).get("value")
        return None if value is None else float(value)

    def interval(self, attribute: str) -> str:
        """The measurement interval of an attribute in words, empty where there is none."""
        entry = self.document["attributes"].get(attribute, {})
        return bounds(entry.get("low"), entry.get("high"))

    def reason(self, attribute: str) -> str:
        """Why an attribute is not computable."""
        return clean(self.document["attributes"].get(attribute, {}).get("reason", "not computed"))

    @property
    def missing(self) -> tuple[str, ...]:
        """What the overall score had to leave out."""
        return tuple(clean(name) for name in self.document["attributes"]["overall"].get("missing", ()))


def scored(rows: Sequence[Row]) -> list[Row]:
    """The maps that have a report."""
    return [row for row in rows if row.error is None]


def ranked(rows: Sequence[Row], tie_within: float = TIE_WITHIN) -> list[Row]:
    """Rows with their ranks by overall score, best first; those without a score last, in the order given."""
    if len(rows) < 2:
        return list(rows)
    overall = [None if row.error is not None else row.score("overall") for row in rows]
    places = ranks([None if value is None else 100 * value for value in overall], tie_within)
    named = [replace(row, rank=None if place is None else str(place)) for row, place in zip(rows, places, strict=True)]
    order = sorted(range(len(rows)), key=lambda k: -1.0 if (value := overall[k]) is None else value, reverse=True)
    return [named[k] for k in order]


def shown_attributes(rows: Sequence[Row]) -> list[str]:
    """The columns of a table; global accuracy only where one of the maps has it."""
    has_global = any(row.score("global_accuracy") is not None for row in scored(rows))
    return [*COLUMNS, *(["global_accuracy"] if has_global else []), "overall"]


def comparison_warning(rows: Sequence[Row]) -> str | None:
    """A sentence when the overall scores are means of different attributes, so hardly comparable."""
    if len({row.missing for row in scored(rows)}) < 2:
        return None
    return (
        "The overall scores leave out different attributes (see each map's report), so they are means of "
        "different things and hardly comparable."
    )


def not_computable(rows: Sequence[Row]) -> list[tuple[list[str], str]]:
    """Map names and the sentence they share, for each dash in the table."""
    sentences = [
        (row.name, f"{attribute.replace('_', ' ')} is not computable: {row.reason(attribute)}.")
        for attribute in shown_attributes(rows)
        for row in scored(rows)
        if row.score(attribute) is None
    ]
    return _shared(sentences)


def shared_findings(rows: Sequence[Row]) -> list[tuple[str, list[str], str]]:
    """Level, map names and sentence of every finding, the gravest first; one entry where maps share it."""
    entries = []
    for level in LEVELS:
        sentences = [
            (row.name, finding_sentence(finding))
            for row in scored(rows)
            for finding in row.document.get("findings", ())
            if finding["level"] == level
        ]
        entries += [(level, names, sentence) for names, sentence in _shared(sentences)]
    return entries


def sorted_findings(findings: Sequence[Document]) -> list[Document]:
    """Findings with the gravest first, otherwise in their order."""
    return sorted(findings, key=lambda finding: LEVELS.index(finding["level"]))


def finding_sentence(finding: Document) -> str:
    """What is odd and the option that mends it."""
    option = finding.get("option")
    return f"{sentence(finding['text'])} Option: {clean(option)}" if option else clean(finding["text"])


def _shared(sentences: Sequence[tuple[str, str]]) -> list[tuple[list[str], str]]:
    order = list(dict.fromkeys(sentence for _, sentence in sentences))
    by_sentence = sorted(sentences, key=lambda entry: order.index(entry[1]))
    return [
        (list(dict.fromkeys(name for name, _ in group)), sentence)
        for sentence, group in itertools.groupby(by_sentence, key=lambda entry: entry[1])
    ]
