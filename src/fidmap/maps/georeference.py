"""Where a picture lies in the world: GeoTIFF tags, or a world file beside it.

Sources: OGC 19-008r4 (GeoTIFF 1.1) for the tags; Esri's description of world files for their six lines.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from fidmap.maps.files import exists, fault, printable, read_bytes
from fidmap.maps.overrides import is_resolution
from fidmap.model import Pose2

PIXEL_SCALE, TIEPOINT, TRANSFORMATION, GEO_KEYS = 33550, 33922, 34264, 34735
MODEL_TYPE, RASTER_TYPE, GEOGRAPHIC, POINT = 1024, 1025, 2, 2
MAX_WORLD_FILE_BYTES = 4096


@dataclass(frozen=True)
class Georeference:
    """East and north of continuous pixel coordinates, (0, 0) being the picture's upper left corner.

    east = east_m + pixel_m (cos yaw * column + sin yaw * row), north = north_m + pixel_m (sin yaw * column - cos yaw *
    row): square pixels, not mirrored. origin: what it was read from.
    """

    pixel_m: float
    east_m: float
    north_m: float
    yaw: float
    source: Literal["tags", "world file", "world file, y upwards"]

    def at(self, column: float, row: float) -> tuple[float, float]:
        """East and north of a place in the picture."""
        c, s = self.pixel_m * math.cos(self.yaw), self.pixel_m * math.sin(self.yaw)
        return self.east_m + c * column + s * row, self.north_m + s * column - c * row

    def pose(self, column: float, row: float) -> Pose2:
        """The pose of a grid whose lower-left corner lies there and whose rows run up the picture."""
        return Pose2(*self.at(column, row), self.yaw)


def from_tags(tags: Mapping[int, Any], subject: object) -> Georeference | None:
    """The georeference of a GeoTIFF; None for a TIFF without such tags.

    Raises:
        MapFileError: tags that say nothing useful for a map in metres.
    """
    if TRANSFORMATION in tags:
        m = _numbers(tags[TRANSFORMATION], 16, subject)
        matrix = m[0], m[1], m[3], m[4], m[5], m[7]
    elif PIXEL_SCALE in tags and TIEPOINT in tags:
        scale, tie = _numbers(tags[PIXEL_SCALE], 2, subject), _numbers(tags[TIEPOINT], 6, subject)
        east, north = tie[3] - scale[0] * tie[0], tie[4] + scale[1] * tie[1]
        matrix = scale[0], 0.0, east, 0.0, -scale[1], north
    else:
        return None
    keys = _geo_keys(tags.get(GEO_KEYS, ()))
    if keys.get(MODEL_TYPE) == GEOGRAPHIC:
        raise fault(
            subject, "is a GeoTIFF in degrees, expected metres; give its scale with --resolution M_PER_CELL instead"
        )
    shift = 0.5 if keys.get(RASTER_TYPE) == POINT else 0.0
    return _square(matrix, shift, "tags", subject)


def from_world_file(image: Path, subject: object) -> Georeference | None:
    """The georeference that a world file beside an image gives; None without one.

    Its last two lines are the centre of the upper left pixel. A fourth line that is positive means rows that run
    up; as crosbot writes it, they run down all the same and the last two lines are the picture's upper left corner.

    Raises:
        MapFileError: a world file that is broken.
    """
    path = _beside(image)
    if path is None:
        return None
    name = f"{printable(subject)}: its world file {printable(path.name)}"
    words = read_bytes(path, name, MAX_WORLD_FILE_BYTES, "a world file").split()
    try:
        a, d, b, e, east, north = (float(word) for word in words)
    except ValueError:
        raise fault(name, "is broken; expected six numbers, so correct it or give --resolution M_PER_CELL") from None
    if a * e - b * d > 0:
        return _square((a, -b, east, d, -e, north), 0.0, "world file, y upwards", name)
    return _square((a, b, east, d, e, north), 0.5, "world file", name)


def _beside(image: Path) -> Path | None:
    """`map.tfw` for `map.tif` and the like, `map.tifw`, or `map.wld`, in lower or upper case."""
    suffix = image.suffix.lower().lstrip(".")
    for ending in (f"{suffix[:1]}{suffix[-1:]}w", f"{suffix}w", "wld"):
        for word in (ending, ending.upper()):
            if exists(path := image.with_suffix(f".{word}")):
                return path
    return None


def _square(matrix: tuple[float, ...], shift: float, source: Any, subject: object) -> Georeference:
    """Check that pixels are square and not mirrored; the matrix holds for places `shift` from a pixel's corner."""
    a, b, east, d, e, north = matrix
    size = math.hypot(a, d)
    skew = max(abs(a + e), abs(b - d))  # of a turned square, e = -a and b = d
    if not all(map(math.isfinite, matrix)) or not is_resolution(size) or skew > 1e-3 * size:
        shown = ", ".join(f"{value:g}" for value in matrix)
        raise fault(
            subject,
            f"is georeferenced by {shown}; expected square pixels of {1e-5:g} to 1000 m that are not mirrored, so "
            "give its scale with --resolution M_PER_CELL",
        )
    return Georeference(size, east - shift * (a + b), north - shift * (d + e), math.atan2(d, a), source)


def _numbers(value: Any, least: int, subject: object) -> tuple[float, ...]:
    try:
        numbers = tuple(float(item) for item in value)
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) < least:
        raise fault(subject, "has broken GeoTIFF tags; give its scale with --resolution M_PER_CELL")
    return numbers


def _geo_keys(directory: Any) -> dict[int, int]:
    """Keys whose value stands in the directory itself."""
    try:
        words = [int(word) for word in directory]
    except (TypeError, ValueError):
        return {}
    return {words[k]: words[k + 3] for k in range(4, len(words) - 3, 4) if words[k + 1] == 0}
