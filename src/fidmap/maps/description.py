"""The YAML half of a map_server map: its keys, checked completely, with all faults told at once.

PyYAML reads YAML 1.1, where `25e-3`, `-4e-17` and `-nan` are text; the map_server reads them as numbers, and
so does this module.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
import yaml

from fidmap.maps.cells import MODES, Meaning, Mode
from fidmap.maps.files import READABLE, fault, printable
from fidmap.maps.overrides import MAX_RESOLUTION_M, MIN_RESOLUTION_M, Overrides, is_resolution
from fidmap.model import MapFileError, Pose2

MAX_YAML_BYTES = 65_536
MAX_ALIASES = 16
MAX_DEPTH = 20
KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")

T = TypeVar("T")


@dataclass(frozen=True)
class Description:
    """A checked YAML file: the image it names, as it names it, and how to read that."""

    image: str
    meaning: Meaning


class _KeyFaultError(Exception):
    """What is wrong with one key; collected, never seen outside."""


def parse(data: bytes, subject: object, overrides: Overrides) -> Description:
    """Check every key of a YAML file.

    Raises:
        MapFileError: one sentence with all faults.
    """
    description, faults = understood(data, subject, overrides)
    if faults:
        raise refusal(subject, faults)
    return description


def refusal(subject: object, faults: list[str]) -> MapFileError:
    """The one sentence that names all faults of a YAML file."""
    return fault(subject, f"is not a valid map_server YAML: {'; '.join(faults)}; correct the file")


def understood(data: bytes, subject: object, overrides: Overrides) -> tuple[Description, list[str]]:
    """What a YAML file says, and its faults; a key at fault counts as if it had the value of a plain image.

    An override stands for its key, which may then be missing or wrong.

    Raises:
        MapFileError: it is no YAML of a map at all.
    """
    document = load(data, subject)
    faults: list[str] = []
    said = {
        "resolution": overrides.resolution_m,
        "origin": overrides.origin,
        "free_thresh": overrides.free_thresh,
        "occupied_thresh": overrides.occupied_thresh,
    }
    missing = [key for key in KEYS if key not in document and said.get(key) is None]
    if missing:
        faults.append(f"lacks {', '.join(missing)}")

    def value(key: str, read: Callable[[Any], T], fallback: T) -> T:
        if said.get(key) is not None:
            return said[key]  # type: ignore[return-value]  # an override has its key's type
        try:
            return read(document[key]) if key in document else fallback
        except _KeyFaultError as error:
            faults.append(f"{key} {error}")
            return fallback

    description = Description(
        value("image", _image, ""),
        Meaning(
            value("resolution", _resolution, 1.0),
            value("origin", _origin, Pose2()),
            value("negate", _negate, False),
            value("free_thresh", _threshold, 0.196),
            value("occupied_thresh", _threshold, 0.65),
            value("mode", _mode, "trinary"),
            overrides.flavour or "nav2",
        ),
    )
    corner = overrides.corner(description.meaning.origin, description.meaning.resolution_m)
    return replace(description, meaning=replace(description.meaning, origin=corner)), faults


def load(data: bytes, subject: object) -> dict[str, Any]:
    """Parse untrusted YAML into its keys; few aliases and levels are allowed, since they can explode.

    Raises:
        MapFileError: not YAML, not a mapping, or plainly another kind of file.
    """
    try:
        _screen(data, subject)
        document = yaml.safe_load(data)
    except yaml.MarkedYAMLError as error:
        where = f" in line {error.problem_mark.line + 1}" if error.problem_mark else ""
        problem = printable(error.problem, 150)
        raise fault(subject, f"is not valid YAML{where} ({problem}); correct that line") from None
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError):
        raise fault(subject, f"is no map of a known format; expected {READABLE}") from None
    return _mapping(document, subject)


def _screen(data: bytes, subject: object) -> None:
    """Refuse what is valid YAML and made to exhaust its reader, as soon as the first excess shows.

    PyYAML's time grows with the square of the nesting: 64 kB of brackets would keep it busy for an hour.
    """
    aliases = depth = 0
    for event in yaml.parse(data, Loader=yaml.SafeLoader):
        aliases += isinstance(event, yaml.AliasEvent)
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if aliases > MAX_ALIASES or depth > MAX_DEPTH:
            excess = f"more than {MAX_ALIASES} aliases" if aliases > MAX_ALIASES else f"over {MAX_DEPTH} levels"
            raise fault(subject, f"holds {excess} of YAML; a map file needs none, so write its values out plainly")


def _mapping(document: Any, subject: object) -> dict[str, Any]:
    """Tell other files of the house, and what is no map at all, apart from a faulty map."""
    if not isinstance(document, dict):
        raise fault(subject, f"is no map of a known format; expected {READABLE}")
    for key, kind, option in (
        ("fidmap_arena", "an arena", "--arena"),
        ("fidmap_profile", "a profile", "--profile"),
    ):
        if key in document:
            raise fault(subject, f"is {kind} file, not a map; give it with {option} and name a map here")
    if not set(KEYS) & set(map(str, document)):
        raise fault(subject, f"is YAML but no map: it has none of the keys {', '.join(KEYS)}; expected {READABLE}")
    return {key: item for key, item in document.items() if isinstance(key, str)}


def _shown(value: Any) -> str:
    """A value for a sentence; containers only by their kind, since aliases may have made them huge."""
    if isinstance(value, list | dict | set | tuple):
        return f"a {type(value).__name__}"
    return repr(printable(value, 40)) if isinstance(value, str) else printable(value, 40)


def _number(value: Any) -> float:
    """A finite number, also where YAML 1.1 made text of it."""
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        raise _KeyFaultError(f"is {_shown(value)}, expected a number") from None
    if not math.isfinite(number):
        raise _KeyFaultError(f"is {_shown(value)}, expected a finite number")
    return number


def _threshold(value: Any) -> float:
    """As far as float32 goes, in which thresholds are compared."""
    most = float(np.finfo(np.float32).max)
    return max(-most, min(most, _number(value)))


def _resolution(value: Any) -> float:
    try:
        number = _number(value)
    except _KeyFaultError:
        number = math.nan
    if not is_resolution(number):
        raise _KeyFaultError(
            f"is {_shown(value)}, expected metres per cell from {MIN_RESOLUTION_M:g} to {MAX_RESOLUTION_M:g}"
        )
    return number


def _origin(value: Any) -> Pose2:
    if not isinstance(value, list) or len(value) != 3:
        kind = f"a list of {len(value)}" if isinstance(value, list) else _shown(value)
        raise _KeyFaultError(f"is {kind}, expected exactly three numbers [x_m, y_m, yaw_rad]")
    numbers = []
    for name, item in zip(("x", "y", "yaw"), value, strict=True):
        try:
            numbers.append(_number(item))
        except _KeyFaultError as error:
            raise _KeyFaultError(f"has a {name} that {error}") from None
    return Pose2(*numbers)


def _negate(value: Any) -> bool:
    """0, 1, another integer, or a truth value in any of YAML's spellings, quoted or not."""
    if isinstance(value, int):
        return bool(value)
    text = str(value).strip().lower() if isinstance(value, str) else ""
    if text in {"1", "y", "yes", "true", "on"}:
        return True
    if text in {"0", "n", "no", "false", "off"}:
        return False
    raise _KeyFaultError(f"is {_shown(value)}, expected 0 or 1")


def _mode(value: Any) -> Mode:
    for mode in MODES:
        if isinstance(value, str) and value.lower() == mode:
            return mode
    raise _KeyFaultError(f"is {_shown(value)}, expected {', '.join(MODES[:-1])} or {MODES[-1]}")


def _image(value: Any) -> str:
    if not isinstance(value, str) or not value.strip():
        raise _KeyFaultError(f"is {_shown(value)}, expected the name of an image file")
    return value
