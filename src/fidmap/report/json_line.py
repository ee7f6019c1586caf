"""The report as plain JSON values, key by key as docs and schemas promise it.

Degrees and percent-free fractions, full precision, never NaN, infinity or -0.0. What was not computed is null
with `<key>_reason` beside it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from fidmap.model import (
    Assignment,
    BarrelPart,
    Finding,
    GroupResult,
    Interval,
    PairResult,
    PartResult,
    Report,
    StartPose,
    Value,
)
from fidmap.report.states import State, part_states
from fidmap.scoring import clipped_loss

Document = dict[str, Any]

ATTRIBUTE_ORDER = ("coverage", "global_accuracy", "relative_accuracy", "consistency", "resolution_quality")
UPPER_BOUND_REASON = "not certified: the quick search (--fast) leaves the proof out"
FEW_PARTS_REASON = "fewer than three parts are assigned"


def report_document(
    report: Report,
    settings_document: Mapping[str, Any],
    seconds: float,
    inputs: Mapping[str, Any] | None = None,
) -> Document:
    """One line of `fidmap score --json`.

    Args:
        report: what the evaluation found.
        settings_document: the settings in the words of a profile file.
        seconds: what this map took; the only value that differs between two runs.
        inputs: what else is needed to make the report again (a points file's hash, overridden thresholds);
            goes into the provenance as it is.

    Returns:
        Plain dicts, lists, strings and numbers in the promised order.
    """
    document = {
        "fidmap_report": 1,
        "map": report.map.name,
        "arena": report.arena.name,
        "profile": report.settings.profile,
        "attributes": _attributes(report),
        "parts": _parts(report),
        "groups": [_group(group) for group in report.attributes.groups],
        "registration": _registration(report),
        "detections": _detections_with_parts(report),
        "findings": [finding_document(finding) for finding in report.findings],
        "provenance": _provenance(report, settings_document, seconds, inputs or {}),
    }
    return _plain_dict(document)


def detect_document(map_name: str, radius_m: float, detections: Iterable[BarrelPart], seconds: float) -> Document:
    """One line of `fidmap detect --json`."""
    arcs = [_detection(arc) for arc in detections]
    return _plain_dict({"map": map_name, "radius_m": radius_m, "detections": arcs, "seconds": seconds})


def error_document(map_name: str, code: str, text: str, findings: Iterable[Finding] = ()) -> Document:
    """The line of a map that could not be used; findings where something could be found out all the same."""
    told = [finding_document(finding) for finding in findings]
    return {"map": map_name, "error": {"code": code, "text": text}, **({"findings": told} if told else {})}


def error_line(map_name: str, code: str, text: str) -> str:
    """The line of a map that could not be used, as text."""
    return json_line(error_document(map_name, code, text))


def json_line(document: Mapping[str, Any]) -> str:
    """One line of JSON Lines, in ASCII so that no terminal or pipe can spoil a name."""
    return json.dumps(document, allow_nan=False)


def finding_document(finding: Finding) -> Document:
    """A finding; `option` only where one mends it."""
    document: Document = {"level": finding.level, "code": finding.code, "text": finding.text}
    return document if finding.option is None else {**document, "option": finding.option}


def _value(value: Value | None) -> Document:
    if value is None:
        return {"value": None, "reason": "this version does not compute it"}
    if value.value is None:
        return {"value": None, "reason": value.reason or "not computable"}
    return {"value": value.value} if value.interval is None else {"value": value.value, **_interval(value.interval)}


def _interval(interval: Interval) -> Document:
    """Both intervals, measurement first; bounds that are not known with their reason."""
    found: Document = {}
    for prefix, span in (("", interval.measurement), ("population_", interval.population)):
        for key, bound in (("low", span.low), ("high", span.high)):
            found |= _or_reason(prefix + key, bound, span.reason or "not computable")
    return found


def _attributes(report: Report) -> Document:
    found = report.attributes
    document = {name: _value(found.by_name.get(name)) for name in ATTRIBUTE_ORDER}
    document["consistency"]["classes"] = {name: _value(value) for name, value in found.classes.items()}
    return {**document, "overall": {**_value(found.overall), "missing": list(found.missing)}}


def _or_reason(key: str, value: Any, reason: str) -> Document:
    """A key with its value, or null with the reason beside it."""
    return {key: value} if value is not None else {key: None, f"{key}_reason": reason}


def _parts(report: Report) -> list[Document]:
    states = part_states(report)
    return [_part(part, states[part.id], report) for part in report.attributes.parts]


def _part(part: PartResult, state: State, report: Report) -> Document:
    if part.barrel is None:
        reason = _no_transform_reason(report)
        return {
            "id": part.id,
            "assigned": False,
            **_or_reason("expected_x_m", part.expected_x_m, reason),
            **_or_reason("expected_y_m", part.expected_y_m, reason),
            "state": state.value,
        }
    by_name = report.attributes.by_name
    reasons = {
        name: value.reason or "not computable" if (value := by_name.get(name)) else "not computable"
        for name in ("relative_accuracy", "global_accuracy")
    }
    return {
        "id": part.id,
        "assigned": True,
        "x_m": part.barrel.x_m,
        "y_m": part.barrel.y_m,
        **_or_reason("sigma_m", part.barrel.sigma_m, "not given"),
        **_or_reason("relative_error_m", part.relative_error_m, reasons["relative_accuracy"]),
        **_or_reason("global_error_m", part.global_error_m, reasons["global_accuracy"]),
        "state": state.value,
        "n": part.barrel.n,
        **_losses(part, report),
    }


def _losses(part: PartResult, report: Report) -> Document:
    """What a part's errors cost, in [0, 1]: with them reports are compared later."""
    found = {}
    for name, error in (("relative", part.relative_error_m), ("global", part.global_error_m)):
        if error is not None:
            radius, settings = report.arena.radius_m, report.settings
            d_max = settings.d_max(f"{name}_accuracy", radius)
            found[f"{name}_loss"] = float(clipped_loss(np.array(error), settings.rounding, radius, d_max))
    return found


def _group(group: GroupResult) -> Document:
    """A group of two parts carries its one distance itself; larger ones list their pairs."""
    head = {"id": group.id, "class": group.group_class}
    if len(group.pairs) == 1:
        return {**head, **_pair(group.pairs[0]), "parts": list(group.pairs[0].parts)}
    loss = _or_reason("loss", group.loss, "no part was assigned")
    pairs = [{"parts": list(pair.parts), **_pair(pair)} for pair in group.pairs]
    return {**head, **loss, "pairs": pairs}


def _pair(pair: PairResult) -> Document:
    reason = "neither part was assigned" if pair.loss is None else "one of the two parts was not assigned"
    return {
        **_or_reason("distance_m", pair.distance_m, reason),
        "expected_m": pair.expected_m,
        **_or_reason("error_m", pair.error_m, reason),
        **_or_reason("loss", pair.loss, reason),
    }


def _no_transform_reason(report: Report) -> str:
    if not report.arena.has_positions:
        return "the arena has no positions"
    return "nothing was assigned"


def _runner_up(assignment: Assignment) -> Document | None:
    found = assignment.runner_up
    return None if found is None else {"value": found.value, "upper_bound": found.upper_bound}


def _no_runner_up_reason(report: Report) -> str:
    """A registration that was proven has a runner-up unless it has too few parts."""
    return _no_bound_reason(report) if report.assignment.upper_bound is None else FEW_PARTS_REASON


def _no_bound_reason(report: Report) -> str:
    return UPPER_BOUND_REASON if report.arena.has_positions else _no_transform_reason(report)


def _registration(report: Report) -> Document:
    found = report.assignment.transform
    reason = _no_transform_reason(report)
    return {
        **_or_reason("rotation_deg", None if found is None else wrapped_degrees(found.rotation), reason),
        **_or_reason("translation_m", None if found is None else [found.tx_m, found.ty_m], reason),
        **_or_reason("scale", None if found is None else found.scale, reason),
        **_or_reason("mirrored", None if found is None else found.mirrored, reason),
        "value": report.assignment.value,
        **_or_reason("upper_bound", report.assignment.upper_bound, _no_bound_reason(report)),
        **_or_reason("runner_up", _runner_up(report.assignment), _no_runner_up_reason(report)),
    }


def _detections_with_parts(report: Report) -> list[Document]:
    part_of = {part.barrel.n: part.id for part in report.attributes.parts if part.barrel is not None}
    return [{**_detection(arc), "part": part_of.get(arc.n)} for arc in report.detections]


def _detection(arc: BarrelPart) -> Document:
    drawn_deg = math.degrees(arc.drawn)
    no_facing = "drawn over 300 degrees or more" if drawn_deg >= 300 - 1e-9 else "not given"
    facing_deg = None if arc.facing is None else wrapped_degrees(arc.facing)
    return {
        "n": arc.n,
        "x_m": arc.x_m,
        "y_m": arc.y_m,
        **_or_reason("facing_deg", facing_deg, no_facing),
        "drawn_deg": drawn_deg,
        **_or_reason("sigma_m", arc.sigma_m, "not given"),
        "confidence": arc.confidence,
    }


def wrapped_degrees(angle: float) -> float:
    """Radians to degrees in (-180, 180]; an angle already in range keeps its last digit."""
    turned = math.degrees(angle)
    return turned if -180 < turned <= 180 else 180 - (180 - turned) % 360


def _provenance(
    report: Report, settings_document: Mapping[str, Any], seconds: float, inputs: Mapping[str, Any]
) -> Document:
    start = {} if report.start_pose is None else {"start_pose": _start_pose(report.start_pose)}
    return {
        "version": report.version,
        "map_sha256": report.map.sha256,
        "arena_sha256": report.arena.sha256,
        "settings": dict(settings_document),
        **start,
        **inputs,
        "seconds": seconds,
    }


def _start_pose(start: StartPose) -> Document:
    return {
        "x_m": start.pose.x_m,
        "y_m": start.pose.y_m,
        "yaw_deg": wrapped_degrees(start.pose.yaw),
        "sigma_m": start.sigma_m,
        "sigma_deg": math.degrees(start.sigma_yaw),
    }


def _plain_dict(values: Mapping[str, Any]) -> Document:
    """Python's own types all the way down; a number that JSON does not know becomes null with its reason."""
    document: Document = {}
    for key, value in values.items():
        document[str(key)] = plain = _plain(value)
        if plain is None and value is not None:
            document[f"{key}_reason"] = "not a finite number"
    return document


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return _plain_dict(value)
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return value + 0.0 if math.isfinite(value) else None  # + 0.0 turns -0.0 into 0.0
    return value
