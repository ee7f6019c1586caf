"""The pages for people: one per map with everything in it, and an index that ranks several maps.

Both are made from the report document alone, so a page can be made again from report.json and overlay.svg.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from fidmap.report.json_line import ATTRIBUTE_ORDER, Document
from fidmap.report.losses import A_TIE, better_than_next, doubt, sizes_warning
from fidmap.report.overlay_style import STYLES
from fidmap.report.rows import Row, comparison_warning, scored, shown_attributes, sorted_findings
from fidmap.report.states import State
from fidmap.report.wording import (
    ATTRIBUTE_MEANINGS,
    attribute_title,
    bounds,
    clean,
    degrees,
    metres,
    percent,
    sentence,
)
from fidmap.uncertainty.compare import SURE

UNITS = {"_deg": "°", "_m": " m", "seconds": " s"}
DETECTIONS_UP_TO = 500  # more is noise, and would make the page heavy; points.csv has them all


def report_page(document: Document, drawing: str) -> str:
    """One self-contained HTML page about one map.

    Args:
        document: the report document.
        drawing: SVG text of the overlay, from `draw_overlay`.
    """
    detections, provenance = document["detections"], dict(document["provenance"])
    return _environment().get_template("report.html.j2").render(
        report=document,
        drawing=Markup(drawing),  # noqa: S704 made and escaped by draw_overlay
        attributes=_attribute_rows(document),
        findings=sorted_findings(document["findings"]),
        parts=document["parts"],
        groups=list(_pair_rows(document["groups"])),
        detections=detections[:DETECTIONS_UP_TO],
        more_detections=max(0, len(detections) - DETECTIONS_UP_TO),
        has_global=any(part.get("global_error_m") is not None for part in document["parts"]),
        settings=list(_settings_rows(provenance.pop("settings"))),
        provenance=list(_spoken_rows(provenance)),
        registration=list(_spoken_rows(document["registration"])),
        styles={state.value: STYLES[state] for state in State},
    )  # fmt: skip


def index_page(rows: Sequence[Row]) -> str:
    """The page that ranks several maps: a table with links, then the maps that could not be used."""
    good = scored(rows)
    told = better_than_next([row.document for row in good])
    return _environment().get_template("index.html.j2").render(
        rows=rows,
        doubts=[doubt(one) for one in told] + ["-"] * (len(rows) - len(good)),
        a_tie=A_TIE if any(one is not None and one < SURE for one in told) else "",
        scored=len(good),
        attributes=shown_attributes(rows),
        warnings=[w for w in (comparison_warning(rows), sizes_warning([row.document for row in good])) if w],
        measured_by=list(dict.fromkeys((row.document["arena"], row.document["profile"]) for row in good)),
    )  # fmt: skip


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("fidmap.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_finalize,
    )
    environment.filters |= {
        "percent": percent,
        "metres": metres,
        "degrees": degrees,
        "sentence": sentence,
        "title_of": attribute_title,
        "address": lambda folder: quote(str(folder)),
    }
    return environment


def _finalize(value: Any) -> Any:
    """What Jinja prints: names are cleaned wherever they stand; autoescape follows."""
    if isinstance(value, Markup):
        return value
    if value is None:
        return "–"
    return clean(value) if isinstance(value, str) else value


def _attribute_rows(document: Document) -> list[Document]:
    """One row per attribute, classes of groups below consistency, overall last."""
    rows = []
    for name in (*ATTRIBUTE_ORDER, "overall"):
        entry = document["attributes"][name]
        rows.append(_attribute_row(attribute_title(name), entry, ATTRIBUTE_MEANINGS[name], ""))
        for group_class, value in entry.get("classes", {}).items():
            meaning = f"groups of the class “{group_class}”"
            rows.append(_attribute_row(group_class, value, meaning, "class"))
    rows[-1]["kind"] = "overall"
    return rows


def _attribute_row(title: str, entry: Document, meaning: str, kind: str) -> Document:
    intervals = {
        name: {
            "text": bounds(entry.get(f"{prefix}low"), entry.get(f"{prefix}high")),
            "reason": entry.get(f"{prefix}low_reason"),
        }
        for name, prefix in (("measurement", ""), ("population", "population_"))
    }
    said = {"title": title, "meaning": meaning, "kind": kind}
    return {**said, "value": entry["value"], "reason": entry.get("reason"), **intervals}


def _pair_rows(groups: Sequence[Document]) -> Iterator[Document]:
    """Groups as table rows; a larger group is followed by its pairs."""
    blank = dict.fromkeys(("distance_m", "expected_m", "error_m", "loss"))
    for group in groups:
        yield {**blank, **group, "label": group["id"], "kind": "group"}
        for pair in group.get("pairs", ()):
            yield {**pair, "label": " – ".join(pair["parts"]), "class": "", "kind": "pair"}


def _settings_rows(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Settings under the names that a profile file gives them, nested ones dotted."""
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _settings_rows(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", _short(value)


def _spoken_rows(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Other values in words: the unit moves from the key to the number, a null shows its reason."""
    for key, value in values.items():
        if key.endswith("_reason"):
            continue
        ending = next((ending for ending in UNITS if key.endswith(ending)), "")
        name = prefix + (key.removesuffix(ending) or "computing time").replace("_", " ")
        if isinstance(value, Mapping):
            yield from _spoken_rows(value, f"{name}: ")
        elif value is None:
            yield name, f"not known ({values.get(f'{key}_reason', 'no reason given')})"
        else:
            yield name, _short(value) + UNITS.get(ending, "")


def _short(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return ", ".join(map(_short, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)
