"""Reports read back, for ranking: checked as any file from outside, since people edit and mail them."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn

from fidmap.model import ReportFileError
from fidmap.report.files import REPORT
from fidmap.report.json_line import ATTRIBUTE_ORDER, Document
from fidmap.report.rows import LEVELS, Row, scored

LARGEST_BYTES = 64 * 1024 * 1024


def read_report(path: Path) -> Document:
    """Read a report document from report.json or from the folder that holds it.

    What ranks and tables rely on is checked; the rest is taken as it is.

    Raises:
        ReportFileError: no such file, or not a report; one sentence says what was expected.
    """
    file = path / "report.json" if path.is_dir() else path
    document = _load(file)
    fault = _fault(document)
    if fault is not None:
        raise ReportFileError(f"{file}: {fault}; expected a report.json that fidmap score --out wrote.")
    assert isinstance(document, dict)
    return document


def reports_in(directory: Path) -> list[Row]:
    """The reports that lie in the folders of a directory; what is none is passed over, since it is not ours."""
    found = []
    for file in sorted(directory.glob(f"*/{REPORT}")):
        with suppress(ReportFileError):
            found.append(Row(read_report(file), folder=file.parent.name))
    return found


def identity(document: Document) -> tuple[str, Any]:
    """What makes two reports those of one map: its path and the hash of its content."""
    return os.path.normpath(document["map"]), _provenance(document).get("map_sha256")


def comparable(earlier: Sequence[Row], rows: Sequence[Row]) -> list[Row]:
    """Those of earlier reports that rank beside `rows`: other maps, the same arena, the same settings."""
    names, folders = {row.document["map"] for row in rows}, {row.folder for row in rows}
    alike = [_yardstick(row.document) for row in scored(rows)]
    return [
        row
        for row in earlier
        if row.folder not in folders and row.document["map"] not in names and _yardstick(row.document) in alike[:1]
    ]


def _yardstick(document: Document) -> tuple[Any, Any]:
    provenance = _provenance(document)
    return provenance.get("arena_sha256"), provenance.get("settings")


def _provenance(document: Document) -> Document:
    """Where a report came from; nothing where it does not say."""
    found = document.get("provenance")
    return found if isinstance(found, dict) else {}


def _load(file: Path) -> Any:
    try:
        if not file.is_file():
            raise ReportFileError(f"{file}: no such report; expected a report.json or the folder that holds it.")
        size = file.stat().st_size
        if size > LARGEST_BYTES:
            raise ReportFileError(f"{file}: {size:,} bytes is no report; at most {LARGEST_BYTES:,} are read.")
        return json.loads(file.read_bytes(), parse_constant=_refuse)
    except OSError as error:
        raise ReportFileError(f"{file}: cannot be read ({error.strerror}).") from error
    except (ValueError, RecursionError) as error:
        why = "nested too deeply" if isinstance(error, RecursionError) else error
        raise ReportFileError(
            f"{file}: not JSON ({why}); expected a report.json that fidmap score --out wrote."
        ) from error


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is not a number")


def _fault(document: Any) -> str | None:
    """What is wrong with a document, None for a report of this version."""
    if not isinstance(document, dict) or "fidmap_report" not in document:
        return "not a fidmap report"
    if document["fidmap_report"] != 1:
        return f"report version {document['fidmap_report']!r} is unknown to this fidmap, which reads version 1"
    if not isinstance(document.get("map"), str):
        return "its map is not a text"
    attributes = document.get("attributes")
    if not isinstance(attributes, dict):
        return "it has no attributes"
    faults = (_value_fault(name, attributes.get(name)) for name in (*ATTRIBUTE_ORDER, "overall"))
    return next((fault for fault in faults if fault), None) or _findings_fault(document.get("findings", []))


def _value_fault(name: str, entry: Any) -> str | None:
    if not isinstance(entry, dict) or "value" not in entry:
        return f"its {name} has no value"
    value = entry["value"]
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    if value is not None and not (is_number and 0 <= value <= 1):
        return f"its {name} is {str(value)[:40]!r}, neither null nor a fraction from 0 to 1"
    missing = entry.get("missing", [])
    if not isinstance(missing, list) or not all(isinstance(word, str) for word in missing):
        return f"its {name} names what is missing in no list of texts"
    return None


def _findings_fault(findings: Any) -> str | None:
    if not isinstance(findings, list):
        return "its findings are no list"
    for finding in findings:
        if not isinstance(finding, dict) or finding.get("level") not in LEVELS or "text" not in finding:
            return "one of its findings has no level or no text"
    return None
