"""The shipped JSON Schemas: they hold what the documentation promises, and refuse what it does not."""

from __future__ import annotations

import copy
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import pytest
import yaml
from jsonschema import Draft202012Validator

from fidmap.profiles import names, profile, profile_document
from fidmap.schemas import NAMES, generated, schema
from real_data import real_data

ARENA = """
fidmap_arena: 1
name: A2
radius_m: 0.30
frame: relative            # or 'map'
pallet_m: 1.2              # optional
parts:
  - {id: 1A, x_m: 5.975, y_m: 5.413, facing_deg: 180, opening_deg: 180, sigma_m: 0.005}
groups:
  - {id: "1", parts: [1A, 1B], class: long}
  - {id: "7", parts: [7A, 7B], walking_pallets: 3, distance_m: 0.05}
"""
PROFILE = """
fidmap_profile: 1
base: continuous                       # or ssrr2011
d_max_radii: {global_accuracy: 4, relative_accuracy: 4, consistency: 4}     # or d_max_m
rounding: none                         # nearest | down | up
min_opening: 2/3                       # a fraction or a number, >= 0.5
min_confidence: 0.5
long_if_walking_pallets_over: 6
transform: rigid                       # similarity, with scale_range: [0.9, 1.1]
mirror: false
facing_tolerance_deg: 60
survey_sigma_m: 0.02                   # for parts without sigma_m
weights: {coverage: 1, relative_accuracy: 1, consistency: 1, global_accuracy: 0, resolution_quality: 0}
"""
REPORT = """
{"fidmap_report": 1, "map": "maps/m28.yaml", "arena": "A2", "profile": "continuous",
 "attributes": {"coverage": {"value": 0.93},
   "global_accuracy": {"value": null, "reason": "the arena's frame is relative"},
   "relative_accuracy": {"value": 0.97, "low": 0.95, "high": 0.98,
     "population_low": 0.9, "population_high": 0.99},
   "consistency": {"value": 0.965, "classes": {"short": {"value": 0.98}, "long": {"value": 0.95}}},
   "resolution_quality": {"value": 0.9}, "overall": {"value": 0.98, "missing": ["global_accuracy"]}},
 "parts": [
   {"id": "1A", "assigned": true, "x_m": 3.1, "y_m": 2.2, "sigma_m": 0.01, "relative_error_m": 0.03,
    "global_error_m": null},
   {"id": "1B", "assigned": true, "x_m": 3.3, "y_m": 3.4, "sigma_m": 0.01, "relative_error_m": 0.02,
    "global_error_m": null},
   {"id": "4A", "assigned": false, "expected_x_m": 6.3, "expected_y_m": 2.3}],
 "groups": [
   {"id": "1", "class": "long", "distance_m": 1.24, "expected_m": 1.22, "error_m": 0.02, "loss": 0.017},
   {"id": "4", "class": "short", "distance_m": null, "expected_m": 0.02, "error_m": null, "loss": 1.0}],
 "registration": {"rotation_deg": 12.0, "translation_m": [3.43, 2.62], "scale": 1.0, "mirrored": false,
   "value": 12.6, "upper_bound": 12.6, "runner_up": {"value": 9.1, "upper_bound": 9.2}},
 "detections": [{"n": 1, "x_m": 3.1, "y_m": 2.2, "facing_deg": 170.0, "drawn_deg": 165, "sigma_m": 0.01,
   "confidence": 0.97, "part": "1A"}],
 "findings": [{"level": "warning", "code": "unknown-loads-as-free", "text": "...",
   "option": "--free-thresh 0.196"}],
 "provenance": {"version": "0.1.0", "map_sha256": "...", "arena_sha256": "...", "settings": {},
   "seconds": 0.12}}
"""
DETECT = """
{"map": "m.yaml", "radius_m": 0.3, "seconds": 0.05, "detections": [{"n": 1, "x_m": 3.1, "y_m": 2.2,
 "facing_deg": null, "facing_deg_reason": "drawn over 300 degrees or more", "drawn_deg": 350, "sigma_m": 0.01,
 "confidence": 0.97}]}
"""
INSPECT = """
{"map": "m.yaml", "format": "map_server", "width": 289, "height": 449, "resolution_m": 0.05, "origin": [0, 0, 0],
 "share": {"free": 0.5, "unknown": 0.4, "occupied": 0.1}, "findings": []}
"""
ERROR = {"map": "m.yaml", "error": {"code": "map-file", "text": "m.yaml: no such file"}}

GOOD = {name: yaml.safe_load(text) for name, text in zip(NAMES, (ARENA, PROFILE, REPORT, DETECT, INSPECT), strict=True)}


def faults(name: str, document: object) -> list[str]:
    """The places of all violations."""
    return [error.json_path for error in Draft202012Validator(schema(name)).iter_errors(document)]


@pytest.mark.parametrize("name", NAMES)
def test_schemas_are_schemas(name: str) -> None:
    """Draft 2020-12, all of them."""
    Draft202012Validator.check_schema(schema(name))
    assert schema(name)["$schema"].endswith("2020-12/schema")


@pytest.mark.parametrize("name", ["arena", "profile"])
def test_generated_schemas_are_up_to_date(name: str) -> None:
    """After a change of the file models: `python -m fidmap.schemas`."""
    shipped = files("fidmap.schemas") / f"{name}.schema.json"
    assert generated()[name] == shipped.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_documented_examples_are_good(name: str) -> None:
    """What the interface shows is what the schema takes."""
    assert faults(name, GOOD[name]) == []


@pytest.mark.parametrize("name", ["report", "detect", "inspect"])
def test_error_lines_are_good(name: str) -> None:
    """A map that could not be used has a line too."""
    assert faults(name, ERROR) == []
    assert faults(name, {**ERROR, "arena": "A2"})
    assert faults(name, {"map": "m.yaml", "error": {"code": "Map File", "text": ""}})


@pytest.mark.parametrize("name", names())
def test_shown_profiles_are_good(name: str) -> None:
    """`fidmap profile show` gives a document of the schema."""
    assert faults("profile", profile_document(profile(name))) == []


def test_groups_of_many_parts_list_their_pairs() -> None:
    """Three parts and more have no single distance."""
    report = copy.deepcopy(GOOD["report"])
    pair = {"parts": ["a", "b"], "distance_m": 1.0, "expected_m": 1.0, "error_m": 0.0, "loss": 0.0}
    report["groups"] = [{"id": "r", "class": "room", "loss": 0.5, "pairs": [pair, pair, pair]}]
    assert faults("report", report) == []
    report["groups"][0]["pairs"] = [pair]
    assert faults("report", report)


def test_what_was_not_computed_is_null_with_its_reason() -> None:
    """A bound that is missing says why; a reason beside a number is refused."""
    report = copy.deepcopy(GOOD["report"])
    report["registration"] |= {"upper_bound": None, "runner_up": None}
    assert faults("report", report) == ["$.registration"] * 2
    report["registration"] |= {"upper_bound_reason": "not certified", "runner_up_reason": "not kept"}
    assert faults("report", report) == []
    report["registration"]["upper_bound"] = 12.6
    assert faults("report", report) == ["$.registration.upper_bound"]


Change = Callable[[Any], Any]


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("arena", lambda d: d.pop("radius_m")),
        ("arena", lambda d: d.update(radius=0.3)),
        ("arena", lambda d: d.update(fidmap_arena=2)),
        ("arena", lambda d: d["parts"][0].update(opening_deg=361)),
        ("arena", lambda d: d["groups"][0].update(parts=["1A"])),
        ("profile", lambda d: d.update(min_opening=0.4)),
        ("profile", lambda d: d.update(rounding="nearst")),
        ("profile", lambda d: d["weights"].update(room=-1)),
        ("profile", lambda d: d["d_max_radii"].update(coverage=4)),
        ("report", lambda d: d.pop("registration")),
        ("report", lambda d: d.update(extra=1)),
        ("report", lambda d: d["attributes"]["coverage"].update(value=93)),
        ("report", lambda d: d["attributes"]["coverage"].update(value=None)),
        ("report", lambda d: d["attributes"]["coverage"].update(reason="a reason beside a number")),
        ("report", lambda d: d["attributes"]["consistency"].pop("classes")),
        ("report", lambda d: d["attributes"]["overall"].pop("missing")),
        ("report", lambda d: d["parts"][0].update(assigned=False)),
        ("report", lambda d: d["parts"][0].update(global_error_m="0.1")),
        ("report", lambda d: d["detections"][0].update(facing_deg=None)),
        ("report", lambda d: d["detections"][0].pop("part")),
        ("report", lambda d: d["findings"][0].update(level="fatal")),
        ("report", lambda d: d["provenance"].pop("seconds")),
        ("detect", lambda d: d["detections"][0].update(part="1A")),
        ("detect", lambda d: d.pop("radius_m")),
    ],
)
def test_bad_documents_are_refused(name: str, change: Change) -> None:
    """Missing and unknown keys, wrong types, numbers out of range, nulls without a reason."""
    document = copy.deepcopy(GOOD[name])
    change(document)
    assert faults(name, document)


def test_real_arena_files_are_good() -> None:
    """Every arena file beside the real maps is of the schema."""
    for path in sorted(real_data().rglob("*arena.yaml")):
        assert faults("arena", yaml.safe_load(path.read_text(encoding="utf-8"))) == [], path
