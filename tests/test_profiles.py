"""Profiles: presets, files, faults, and the way back."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from fidmap.model import ATTRIBUTES, CONTINUOUS, DISTANCE_ATTRIBUTES, SSRR2011, Settings, SettingsError
from fidmap.profiles import names, profile, profile_document, read_profile


def read(folder: Path, text: str) -> Settings:
    path = folder / "strict.yaml"
    path.write_text(text, encoding="utf-8")
    return read_profile(path)


def fault(folder: Path, text: str) -> str:
    with pytest.raises(SettingsError) as told:
        read(folder, text)
    assert "\n" not in str(told.value)
    return str(told.value).removeprefix(f"{folder / 'strict.yaml'}: ")


def test_presets_are_known_by_name() -> None:
    """`continuous` is the default, `ssrr2011` the paper's experiment: the same, rounded to radii (III)."""
    assert names() == ("continuous", "ssrr2011")
    assert profile("continuous") == read_profile("continuous") == Settings()
    assert profile("ssrr2011") == read_profile("ssrr2011") == SSRR2011
    assert replace(CONTINUOUS, profile="ssrr2011", rounding="nearest") == SSRR2011


def test_unknown_names_are_told() -> None:
    """The known names are listed."""
    with pytest.raises(SettingsError) as told:
        profile("ssrr2012")
    assert str(told.value) == "no profile is called 'ssrr2012', known are continuous, ssrr2011"
    with pytest.raises(SettingsError) as told:
        read_profile("ssrr2012")
    assert str(told.value) == "ssrr2012: neither a profile (continuous, ssrr2011) nor a file"


def test_an_empty_profile_is_its_base(tmp_path: Path) -> None:
    """What is absent comes from the base; the name is the file's."""
    assert read(tmp_path, "fidmap_profile: 1") == replace(CONTINUOUS, profile="strict.yaml")
    assert read(tmp_path, "fidmap_profile: 1\nbase: ssrr2011\nname: x") == replace(SSRR2011, profile="x")


def test_every_setting_is_read(tmp_path: Path) -> None:
    """Degrees become radians, fractions numbers, metres take the place of radii."""
    text = """
fidmap_profile: 1
base: ssrr2011
name: strict
d_max_radii: {relative_accuracy: 2}
d_max_m: {consistency: 0.5}
rounding: down
min_opening: 3/4
min_confidence: 0.25
long_if_walking_pallets_over: 4.5
transform: similarity
scale_range: [0.8, 1.25]
mirror: true
facing_tolerance_deg: 45
survey_sigma_m: 0.005
weights: {coverage: 2, consistency: 0, room: 0.5}
"""
    assert read(tmp_path, text) == Settings(
        profile="strict",
        d_max_radii={"global_accuracy": 4.0, "relative_accuracy": 2.0},
        d_max_m={"consistency": 0.5},
        rounding="down",
        min_opening=0.75,
        min_confidence=0.25,
        long_if_walking_pallets_over=4.5,
        transform="similarity",
        scale_range=(0.8, 1.25),
        mirror=True,
        facing_tolerance=math.pi / 4,
        survey_sigma_m=0.005,
        weights={**CONTINUOUS.weights, "coverage": 2.0, "consistency": 0.0, "room": 0.5},
    )


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ("min_opening: 0.49", "min_opening: must be at least 0.5, not 0.49"),
        ("min_opening: 1/3", "min_opening: must be at least 0.5, not 1/3"),
        ("min_opening: 3/2", "min_opening: must be at most 1, not 3/2"),
        ("min_opening: 2/0", "min_opening: must be a number or a fraction like 2/3, not '2/0'"),
        ("min_opening: two thirds", "min_opening: must be a number or a fraction like 2/3, not 'two thirds'"),
        ("rounding: nearst", "rounding: must be 'none', 'nearest', 'down' or 'up', not 'nearst'"),
        ("roundin: none", "roundin: unknown key (did you mean rounding?)"),
        ("base: ssrr", "base: must be 'continuous' or 'ssrr2011', not 'ssrr'"),
        ("mirror: 1", "mirror: must be true or false, not 1"),
        ("facing_tolerance_deg: 0", "facing_tolerance_deg: must be greater than 0, not 0"),
        ("facing_tolerance_deg: 181", "facing_tolerance_deg: must be at most 180, not 181"),
        ("scale_range: [1]", "scale_range: must have at least 2, not 1"),
        ("scale_range: [1.1, 0.9]", "scale_range: must rise, not fall from 1.1 to 0.9"),
        ("d_max_radii: {coverage: 4}", "d_max_radii.coverage: unknown key, known are global_accuracy, "
         "relative_accuracy, consistency"),
        ("d_max_m: {consistency: 0}", "d_max_m.consistency: must be greater than 0, not 0"),
        ("d_max_m: {consistency: 1}\nd_max_radii: {consistency: 4}",
         "d_max_m.consistency: is given in radii too, give one of them"),
        ("weights: {coverage: -1}", "weights.coverage: must be at least 0, not -1"),
        ("weights: {coverage: .inf}", "weights.coverage: must be a finite number, not .inf"),
        ("weights: {overall: 1}", "weights.overall: is the weighted mean itself, leave it out"),
        ("weights: {coverage: 0, relative_accuracy: 0, consistency: 0}",
         "weights: at least one must be greater than 0"),
        ("name: ssrr2011", "name: 'ssrr2011' is a preset with other values, choose another name"),
        ("mirror: 1\nrounding: x\nweights: {room: y}",
         "rounding: must be 'none', 'nearest', 'down' or 'up', not 'x'; mirror: must be true or false, "
         "not 1; weights.room: must be a number, not 'y'"),
    ],
)  # fmt: skip
def test_a_fault_is_told_with_its_place(tmp_path: Path, lines: str, told: str) -> None:
    """One sentence with all faults of the file."""
    assert fault(tmp_path, f"fidmap_profile: 1\n{lines}\n") == told


def test_the_version_must_be_there(tmp_path: Path) -> None:
    """A file of another kind is told apart from a profile."""
    expected = "fidmap_profile: is missing, write 'fidmap_profile: 1' on top of a profile file"
    assert fault(tmp_path, "mirror: true") == expected
    assert fault(tmp_path, "fidmap_profile: 3") == "fidmap_profile: must be 1, the only version so far, not 3"


def test_a_directory_is_no_profile(tmp_path: Path) -> None:
    """One sentence, no traceback."""
    with pytest.raises(SettingsError) as told:
        read_profile(tmp_path)
    assert str(told.value) == f"{tmp_path}: is a directory, expected a profile file, so name the file inside it"


@pytest.mark.parametrize("name", names())
def test_presets_survive_being_shown(tmp_path: Path, name: str) -> None:
    """`fidmap profile show` gives a file that reads back as the preset, in YAML and in JSON."""
    shown = profile_document(profile(name))
    assert read(tmp_path, yaml.safe_dump(shown)) == profile(name)
    assert read(tmp_path, json.dumps(shown)) == profile(name)
    assert shown["facing_tolerance_deg"] == 60


_FACTOR = st.floats(1e-3, 1e3)
_PROFILES = st.fixed_dictionaries(
    {"fidmap_profile": st.just(1)},
    optional={
        "name": st.text("abcxyz0189-_. ü", min_size=1).filter(lambda word: word == word.strip()),
        "base": st.sampled_from(["continuous", "ssrr2011"]),
        "d_max_radii": st.dictionaries(st.sampled_from(DISTANCE_ATTRIBUTES[:2]), _FACTOR),
        "d_max_m": st.dictionaries(st.sampled_from(DISTANCE_ATTRIBUTES[2:]), _FACTOR),
        "rounding": st.sampled_from(["none", "nearest", "down", "up"]),
        "min_opening": st.floats(0.5, 1),
        "min_confidence": st.floats(0, 1),
        "long_if_walking_pallets_over": st.floats(0, 100),
        "transform": st.sampled_from(["rigid", "similarity"]),
        "scale_range": st.lists(st.floats(0.01, 100), min_size=2, max_size=2).map(sorted),
        "mirror": st.booleans(),
        "facing_tolerance_deg": st.floats(0.01, 180),
        "survey_sigma_m": st.floats(0, 1),
        "weights": st.dictionaries(st.sampled_from([*ATTRIBUTES[3:], "room", "1"]), st.floats(0, 9)),
    },
)


@settings(derandomize=True, deadline=None, max_examples=150)
@given(_PROFILES)
def test_settings_survive_being_shown(tmp_path_factory: pytest.TempPathFactory, document: dict[str, Any]) -> None:
    """Whatever a profile file says, the report's settings say it again, to the last bit."""
    folder = tmp_path_factory.getbasetemp()
    read_once = read(folder, json.dumps(document))
    assert read(folder, json.dumps(profile_document(read_once))) == read_once
