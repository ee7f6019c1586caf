"""Images without a YAML: in greys, or in the colours of rescue maps; placed by tags, a world file or options."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

from fidmap.maps import images
from fidmap.maps.cells import Meaning, code_table, to_grid
from fidmap.maps.files import MAX_IMAGE_BYTES, fault, read_bytes
from fidmap.maps.georeference import Georeference, from_tags, from_world_file
from fidmap.maps.oddities import oddities
from fidmap.maps.overrides import Overrides
from fidmap.maps.robocup import read as robocup
from fidmap.model import Grid, Pose2, Source


def read(file: Path, name: str, overrides: Overrides) -> Grid:
    """Read an image: white is free, black is occupied, thresholds as ROS map savers write them; or a rescue map.

    Raises:
        MapFileError: broken, or of unknown scale.
    """
    data = read_bytes(file, name, MAX_IMAGE_BYTES, "an image")
    picture = images.load(data, name)
    digest = hashlib.sha256(data).hexdigest()
    del data
    place = None if overrides.resolution_m is not None else _place(picture, file, name)
    scaled = place is not None or overrides.resolution_m is not None
    if (drawn := robocup.recognised(picture, scaled)) is not None:
        del picture  # a colour image takes four bytes a pixel, which the map needs now
        return robocup.read(drawn, place, overrides, Source(name, digest, "robocup"))
    resolution_m = overrides.resolution_m or (None if place is None else place.pixel_m)
    if resolution_m is None:
        raise fault(
            name, "is an image without a YAML beside it that names it; give its scale with --resolution M_PER_CELL"
        )
    meaning = _meaning(overrides, resolution_m)
    raster = images.in_greys(picture, meaning.channels)
    if overrides.origin is None:
        meaning = _placed(meaning, place, len(raster.grey), overrides)
    table = code_table(meaning, raster.parts)
    source = Source(name, digest, "image" if place is None else "geotiff", oddities(raster, meaning, table))
    return to_grid(raster, meaning, table, source)


def _place(picture: images.Picture, file: Path, name: str) -> Georeference | None:
    """Tags win over a world file: they cannot be lost or mixed up."""
    tags = getattr(picture.image, "tag_v2", None)
    place = None if tags is None else from_tags(tags, name)
    return place or from_world_file(file, name)


def _meaning(overrides: Overrides, resolution_m: float) -> Meaning:
    plain = Meaning(resolution_m)
    return Meaning(
        resolution_m,
        overrides.corner(overrides.origin or plain.origin, resolution_m),
        False,
        plain.free_thresh if overrides.free_thresh is None else overrides.free_thresh,
        plain.occupied_thresh if overrides.occupied_thresh is None else overrides.occupied_thresh,
        flavour=overrides.flavour or plain.flavour,
    )


def _placed(meaning: Meaning, place: Georeference | None, height: int, overrides: Overrides) -> Meaning:
    """The meaning with its origin where the georeference puts the lower left corner."""
    pose = Pose2() if place is None else place.pose(0, height)
    return replace(meaning, origin=overrides.corner(pose, meaning.resolution_m))
