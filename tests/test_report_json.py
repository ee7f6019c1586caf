"""The report document: its keys and their order, degrees, reasons beside every null, nothing JSON forbids."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from fidmap.model import Assignment, GroupResult, PairResult, Pose2, StartPose, Value
from fidmap.report.json_line import (
    detect_document,
    error_line,
    json_line,
    report_document,
    wrapped_degrees,
)
from sample_report import SETTINGS_DOCUMENT, sample_detections, sample_report


def document(**changes: object) -> dict:
    return report_document(replace(sample_report(), **changes), SETTINGS_DOCUMENT, 0.25)


def nulls(value: object, path: str = "") -> list[tuple[str, dict]]:
    """Every key whose value is null, with the dict that it is in."""
    if isinstance(value, dict):
        found = [(f"{path}.{key}", value) for key, inner in value.items() if inner is None]
        return found + [entry for key, inner in value.items() for entry in nulls(inner, f"{path}.{key}")]
    if isinstance(value, list):
        return [entry for inner in value for entry in nulls(inner, path)]
    return []


def test_keys_come_in_the_promised_order() -> None:
    found = document()

    assert list(found) == [
        "fidmap_report", "map", "arena", "profile", "attributes", "parts", "groups", "registration",
        "detections", "findings", "provenance",
    ]  # fmt: skip
    assert list(found["attributes"]) == [
        "coverage", "global_accuracy", "relative_accuracy", "consistency", "resolution_quality", "overall",
    ]  # fmt: skip
    assert list(found["parts"][0])[:6] == ["id", "assigned", "x_m", "y_m", "sigma_m", "relative_error_m"]
    assert list(found["groups"][0]) == ["id", "class", "distance_m", "expected_m", "error_m", "loss", "parts"]
    assert list(found["registration"])[:5] == ["rotation_deg", "translation_m", "scale", "mirrored", "value"]
    assert list(found["detections"][0]) == [
        "n", "x_m", "y_m", "facing_deg", "drawn_deg", "sigma_m", "confidence", "part",
    ]  # fmt: skip
    assert list(found["provenance"]) == ["version", "map_sha256", "arena_sha256", "settings", "seconds"]


def test_every_null_has_its_reason_beside_it() -> None:
    """An unassigned detection's part is the one null that is an answer, not a gap."""
    found = document(assignment=Assignment((None,) * 8, (False,) * 8, None, 0.0))

    for path, holder in nulls(found):
        key = path.rsplit(".", 1)[-1]
        if path == ".detections.part":
            continue
        reason = holder["reason" if key == "value" and path.startswith(".attributes") else f"{key}_reason"]
        assert isinstance(reason, str), path
        assert reason, path


def test_bounds_are_null_unless_they_are_certified() -> None:
    found = document()["registration"]

    assert found["upper_bound"] is None
    assert found["upper_bound_reason"].startswith("not certified: ")
    assert found["runner_up"] is None
    assert found["runner_up_reason"].startswith("not certified: ")


def test_angles_are_degrees() -> None:
    found = document()

    assert found["registration"]["rotation_deg"] == pytest.approx(10)
    assert found["detections"][0]["facing_deg"] == 180.0
    assert found["detections"][0]["drawn_deg"] == pytest.approx(170)


@pytest.mark.parametrize(
    ("radians", "expected"),
    [
        (math.pi, 180),
        (-math.pi, 180),
        (3 * math.pi, 180),
        (-math.pi / 2, -90),
        (2 * math.pi, 0),
        (7.0, 41.07),
    ],
)
def test_directions_are_wrapped(radians: float, expected: float) -> None:
    assert wrapped_degrees(radians) == pytest.approx(expected, abs=0.01)


def test_attributes_carry_reason_classes_and_what_is_missing() -> None:
    found = document()["attributes"]

    assert found["coverage"] == {"value": 0.625}
    assert found["global_accuracy"] == {"value": None, "reason": "the arena's frame is relative"}
    assert found["consistency"]["classes"] == {"short": {"value": 0.496}, "long": {"value": 0.45}}
    assert found["overall"] == {"value": 0.648, "missing": ["global_accuracy"]}


def test_parts_say_what_became_of_them() -> None:
    found = {part["id"]: part for part in document()["parts"]}

    assert {name: part["state"] for name, part in found.items()} == {
        "1A": "assigned", "1B": "assigned", "2A": "doubtful", "2B": "fixed", "3A": "assigned",
        "3B": "missing", "4A": "missing", "4B": "missing",
    }  # fmt: skip
    assert found["3B"] == {
        "id": "3B", "assigned": False, "expected_x_m": 9.1, "expected_y_m": 1.0, "state": "missing",
    }  # fmt: skip


def test_a_larger_group_lists_its_pairs() -> None:
    attributes = sample_report().attributes
    pairs = tuple(PairResult(pair, 1.0, 1.1, 0.1, 0.08) for pair in [("1A", "1B"), ("1A", "2A"), ("1B", "2A")])
    found = document(attributes=replace(attributes, groups=(GroupResult("room", "room", pairs, 0.08),)))

    (group,) = found["groups"]
    assert group["loss"] == 0.08
    assert [pair["parts"] for pair in group["pairs"]] == [["1A", "1B"], ["1A", "2A"], ["1B", "2A"]]


def test_detections_name_their_part_or_null() -> None:
    assert [arc["part"] for arc in document()["detections"]] == ["1A", "1B", "2A", "2B", "3A", None, None]


def test_findings_have_an_option_only_where_one_helps() -> None:
    note, warning, _ = document()["findings"]

    assert "option" not in note
    assert warning["option"] == "--free-thresh 0.196"


def test_provenance_carries_the_start_pose_and_other_inputs() -> None:
    report = replace(sample_report(), start_pose=StartPose(Pose2(1.0, 2.0, math.pi / 2)))
    found = report_document(report, SETTINGS_DOCUMENT, 0.25, inputs={"points_sha256": "ef"})["provenance"]

    assert found["start_pose"] == pytest.approx(
        {"x_m": 1.0, "y_m": 2.0, "yaw_deg": 90.0, "sigma_m": 0.5, "sigma_deg": 10.0}
    )
    assert found["points_sha256"] == "ef"
    assert found["settings"] == SETTINGS_DOCUMENT


def test_numbers_json_lacks_become_null_with_a_reason_and_minus_zero_zero() -> None:
    first, *rest = sample_detections()
    odd = replace(first, x_m=np.float64(-0.0), sigma_m=float("inf"), confidence=float("nan"))
    found = document(detections=(odd, *rest))["detections"][0]

    assert str(found["x_m"]) == "0.0"
    assert found["sigma_m"] is None
    assert found["sigma_m_reason"] == "not a finite number"
    assert found["confidence"] is None


def test_the_same_report_gives_the_same_line() -> None:
    assert json_line(document()) == json_line(document())


def test_values_survive_json_to_the_last_bit() -> None:
    found = json.loads(json_line(document()))

    assert found["parts"][1]["x_m"] == 2.1 - 0.03


def test_a_class_without_a_value_has_its_reason() -> None:
    attributes = replace(sample_report().attributes, classes={"short": Value(None, "no group is assigned")})

    found = document(attributes=attributes)["attributes"]["consistency"]["classes"]
    assert found == {"short": {"value": None, "reason": "no group is assigned"}}


def test_detect_line_has_no_parts() -> None:
    found = detect_document("m.yaml", 0.3, sample_detections(), 0.05)

    assert list(found) == ["map", "radius_m", "detections", "seconds"]
    assert "part" not in found["detections"][0]
    assert found["detections"][5]["facing_deg_reason"] == "drawn over 300 degrees or more"


def test_error_line_is_ascii_whatever_the_name() -> None:
    line = error_line("mäp\udcff.yaml", "map-file", "mäp: no image.")

    assert line.isascii()
    assert json.loads(line)["error"] == {"code": "map-file", "text": "mäp: no image."}
