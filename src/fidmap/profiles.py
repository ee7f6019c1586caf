"""Profiles: the presets, profile files, and the way back from settings to a profile file's words."""

from __future__ import annotations

import math
import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationError, WithJsonSchema
from pydantic_core import PydanticCustomError

from fidmap.angles import degrees_of
from fidmap.file_schema import FileModel, Length, PositiveLength, Version, Word, faults_of
from fidmap.model import CONTINUOUS, SSRR2011, Rounding, Settings, SettingsError
from fidmap.text_file import FilePath, one_sentence, quoted
from fidmap.yaml_file import WrittenFloat, load_yaml

PRESETS = {preset.profile: preset for preset in (CONTINUOUS, SSRR2011)}


def _opening_share(value: object) -> object:
    """`2/3` as a number; numbers pass. Below one half two arcs could claim one part, so it is refused."""
    if isinstance(value, str):
        fraction = re.fullmatch(r"\s*([0-9]{1,6})\s*/\s*([0-9]{1,6})\s*", value)
        if not fraction or int(fraction[2]) == 0:
            raise PydanticCustomError("share", f"must be a number or a fraction like 2/3, not {quoted(value)}")
        share = WrittenFloat(int(fraction[1]) / int(fraction[2]))
        share.written = value
        return share
    return value


OpeningShare = Annotated[
    float,
    Field(ge=0.5, le=1),
    BeforeValidator(_opening_share),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "number", "minimum": 0.5, "maximum": 1},
                {"type": "string", "pattern": "^\\s*[0-9]{1,6}\\s*/\\s*[0-9]{1,6}\\s*$"},
            ]
        }
    ),
]
Scale = Annotated[float, Field(gt=0, le=100)]
Share = Annotated[float, Field(ge=0, le=1)]
Factor = Annotated[float, Field(gt=0, le=1e6)]


class RadiiPerAttribute(FileModel):
    """d_max of the distance attributes in radii."""

    global_accuracy: Factor | None = None
    relative_accuracy: Factor | None = None
    consistency: Factor | None = None


class MetresPerAttribute(FileModel):
    """d_max of the distance attributes in metres."""

    global_accuracy: PositiveLength | None = None
    relative_accuracy: PositiveLength | None = None
    consistency: PositiveLength | None = None


class ProfileFile(FileModel):
    """A whole profile file; what is absent comes from `base`."""

    fidmap_profile: Version
    name: Word | None = Field(None, description="shown in reports; the file's name unless given")
    base: Literal["continuous", "ssrr2011"] = "continuous"
    d_max_radii: RadiiPerAttribute = RadiiPerAttribute()
    d_max_m: MetresPerAttribute = MetresPerAttribute()
    rounding: Rounding | None = None
    min_opening: OpeningShare | None = None
    min_confidence: Share | None = None
    long_if_walking_pallets_over: Annotated[float, Field(ge=0, le=1e6)] | None = None
    transform: Literal["rigid", "similarity"] | None = None
    scale_range: Annotated[list[Scale], Field(min_length=2, max_length=2)] | None = None
    mirror: bool | None = None
    facing_tolerance_deg: Annotated[float, Field(gt=0, le=180)] | None = None
    survey_sigma_m: Length | None = None
    weights: dict[Word, Annotated[float, Field(ge=0, le=1e6)]] = Field(default_factory=dict)


def names() -> tuple[str, ...]:
    """The names of the presets."""
    return tuple(PRESETS)


def profile(name: str) -> Settings:
    """A preset: `continuous` (default) or `ssrr2011` (the paper's experiment, SSRR 2011, III).

    Raises:
        SettingsError: there is no such preset.
    """
    if name not in PRESETS:
        raise SettingsError(f"no profile is called {quoted(name)}, known are {', '.join(PRESETS)}")
    return PRESETS[name]


def read_profile(name_or_path: FilePath) -> Settings:
    """A preset by its name, or a profile file.

    Raises:
        SettingsError: all faults of the file in one sentence, each with its place.
    """
    if name_or_path in PRESETS:
        return PRESETS[str(name_or_path)]
    if not os.path.exists(name_or_path):  # noqa: PTH110 - Path.exists raises for a name that is too long
        known = ", ".join(PRESETS)
        raise SettingsError(one_sentence(name_or_path, [f"neither a profile ({known}) nor a file"]))
    document, _ = load_yaml(name_or_path, "a profile file", SettingsError)
    faults = []
    if "fidmap_profile" not in document:
        faults.append("fidmap_profile: is missing, write 'fidmap_profile: 1' on top of a profile file")
    try:
        file = ProfileFile.model_validate(document)
    except ValidationError as problems:
        told = faults_of(problems, document, ProfileFile)
        faults += [fault for fault in told if fault != "fidmap_profile: is missing"]
        raise SettingsError(one_sentence(name_or_path, faults)) from None
    settings = _settings(file, Path(name_or_path).name)
    if faults := _cross_faults(file, settings):
        raise SettingsError(one_sentence(name_or_path, faults))
    return settings


def _given(model: FileModel) -> dict[str, float]:
    return {key: float(value) for key, value in model.model_dump().items() if value is not None}


def _settings(file: ProfileFile, file_name: str) -> Settings:
    """The base with what the file says laid over it; metres take the place of radii."""
    base = PRESETS[file.base]
    in_metres = {**base.d_max_m, **_given(file.d_max_m)}
    in_radii = {**base.d_max_radii, **_given(file.d_max_radii)}
    numbers = ("min_opening", "min_confidence", "long_if_walking_pallets_over", "survey_sigma_m")
    said: dict[str, Any] = {key: float(v) for key in numbers if (v := getattr(file, key)) is not None}
    said |= {key: v for key in ("rounding", "transform", "mirror") if (v := getattr(file, key)) is not None}
    if file.scale_range is not None:
        said["scale_range"] = (float(file.scale_range[0]), float(file.scale_range[1]))
    if file.facing_tolerance_deg is not None:
        said["facing_tolerance"] = math.radians(file.facing_tolerance_deg)
    return replace(
        base,
        profile=file.name or file_name,
        d_max_m=in_metres,
        d_max_radii={key: value for key, value in in_radii.items() if key not in in_metres},
        weights={**base.weights, **{key: float(value) for key, value in file.weights.items()}},
        **said,
    )


def _cross_faults(file: ProfileFile, settings: Settings) -> list[str]:
    """Faults between the values of a profile file."""
    twice = _given(file.d_max_radii).keys() & _given(file.d_max_m)
    faults = [f"d_max_m.{attribute}: is given in radii too, give one of them" for attribute in sorted(twice)]
    low, high = settings.scale_range
    if low > high:
        faults.append(f"scale_range: must rise, not fall from {low:g} to {high:g}")
    if "overall" in settings.weights:
        faults.append("weights.overall: is the weighted mean itself, leave it out")
    if not any(settings.weights.values()):
        faults.append("weights: at least one must be greater than 0")
    if settings.profile in PRESETS and settings != PRESETS[settings.profile]:
        faults.append(f"name: '{settings.profile}' is a preset with other values, choose another name")
    return faults


def profile_document(settings: Settings) -> dict[str, Any]:
    """Settings in a profile file's words (degrees, lists), complete, ready for YAML or JSON.

    Reading the document as a profile file gives the same settings back.
    """
    return {
        "fidmap_profile": 1,
        "name": settings.profile,
        "d_max_radii": {k: v for k, v in settings.d_max_radii.items() if k not in settings.d_max_m},
        "d_max_m": dict(settings.d_max_m),
        "rounding": settings.rounding,
        "min_opening": settings.min_opening,
        "min_confidence": settings.min_confidence,
        "long_if_walking_pallets_over": settings.long_if_walking_pallets_over,
        "transform": settings.transform,
        "scale_range": list(settings.scale_range),
        "mirror": settings.mirror,
        "facing_tolerance_deg": degrees_of(settings.facing_tolerance),
        "survey_sigma_m": settings.survey_sigma_m,
        "weights": dict(settings.weights),
    }


def profile_json_schema() -> dict[str, Any]:
    """The JSON Schema of a profile file (what a schema can say; `read_profile` checks more)."""
    return ProfileFile.model_json_schema(by_alias=True)
